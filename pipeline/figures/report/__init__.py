"""A report of a sweep for people without the tool: one document, as HTML or PDF."""
