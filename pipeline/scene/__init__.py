"""Scene files: TOML with units, read into a sweep."""
