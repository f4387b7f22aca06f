"""Words of an option's help that a docstring says: ``{run_sweep.workers}`` stands for them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from pipeline.docstrings import first_sentences

_REFERENCE = re.compile(r"\{(\w+)\.(\w+)\}")
_ROOT = Path(__file__).parents[1]


def expand_help(text: str) -> str:
    """Put what the docstring says in place of each ``{function.parameter}`` of the package."""
    return _REFERENCE.sub(lambda match: parameter_help(match[1], match[2]), text)


@cache
def parameter_help(function: str, parameter: str) -> str:
    """First sentence of a public function's docstring on a parameter, as a help begins."""
    if parameter not in (said := _sentences(function)):
        raise LookupError(f"the docstring of pipeline.{function} has no parameter {parameter}")
    words = said[parameter].replace("``", "").replace("%", "%%").removeprefix("True to ")
    return words[0].lower() + words[1:]


@cache
def _sentences(function: str) -> dict[str, str]:
    """Sentences on the parameters of a public function, from its file: an import takes a second."""
    stub = (_ROOT / "__init__.pyi").read_text("utf-8")
    module = re.search(rf"^from \.(\S+) import {function} as", stub, re.M)
    if module is None:
        raise LookupError(f"pipeline has no function {function}")
    source = _ROOT.joinpath(*module[1].split(".")).with_suffix(".py").read_text("utf-8")
    found = re.search(rf'^def {function}\(.*?^    """(.*?)"""', source, re.M | re.S)
    return first_sentences(found[1]) if found else {}
