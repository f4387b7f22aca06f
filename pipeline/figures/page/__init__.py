"""A page that shows a sweep in a browser: one file, which asks for nothing from anywhere.

`content` tabulates the rises of a sweep, ``rise.js`` joins them by straight lines, and ``page.js``
shows what follows.
"""
