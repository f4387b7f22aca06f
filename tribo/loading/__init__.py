"""Load as a function of time: ramps and records."""
