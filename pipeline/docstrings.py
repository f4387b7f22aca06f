"""What a docstring says on parameters, of which entries of a scene and options have their words."""

from __future__ import annotations

import inspect
import re


def first_sentences(docstring: str) -> dict[str, str]:
    """First sentence on each parameter of a numpydoc docstring, without its full stop."""
    section = inspect.cleandoc(docstring).partition("Parameters\n----------\n")[2]
    entries = re.findall(r"^(\w+) : .*\n((?:    .*(?:\n|\Z))+)", section, flags=re.MULTILINE)
    return {name: re.split(r"\.(?: |$)", " ".join(text.split()))[0] for name, text in entries}
