"""A page that shows a sweep in a browser: Python tabulates its rises, the scripts join them."""
