"""Whether the tests notice a fault: they are run on code with one small change at a time."""
