"""Share of promises of `--accuracy` and the presets that hold, on scenes nobody tuned them to."""
