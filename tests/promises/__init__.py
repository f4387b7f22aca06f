"""How often `--accuracy` and the presets keep what they promise, on scenes nobody tuned them to."""
