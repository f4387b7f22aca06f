"""A report of a sweep for people without the tool: one document of HTML."""
