"""Laboratory files: logs of tests, traces of friction, spreadsheets and scans of surfaces."""
