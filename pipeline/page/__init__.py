"""A report on a sweep: one page without scripts, to read, print and pass on."""
