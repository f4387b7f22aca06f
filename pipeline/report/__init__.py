"""A report of a sweep for people without the tool: one file of HTML."""
