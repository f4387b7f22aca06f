"""What laboratories write: logs of tests, traces, spreadsheets, scans of surfaces."""
