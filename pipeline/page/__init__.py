"""A page that shows a sweep in a browser: Python tabulates a plane, the scripts threshold it."""
