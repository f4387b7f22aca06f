"""A page that shows a sweep in a browser: one file, which asks for nothing from anywhere.

``model.js`` computes what `pipeline.analysis` does, by the same interpolation; ``page.js`` shows
it; `content` says what they are given.
"""
