"""A page that shows a sweep in a browser: Python tabulates rises, scripts judge them."""
