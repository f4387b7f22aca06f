"""Tests read no private name, with the exceptions below."""

import ast

from tests.sources.measure import ROOT

_ALLOWED = {
    "cluster/wide.py _one_at_a_time": "points that only wait need no turn",
    "pipeline/run/test_cluster.py _hash_of_code": "a worker with other code is named by its hash",
    "pipeline/figures/test_style.py _suptitle": "matplotlib has no public name of it",
    "pipeline/store/test_s3.py _send": "requests are counted where they leave",
    "helpers/stores.py _digest": "a forged root has the right digest",
    "workflows/paper/test_reproduce.py _CHANGES": "a study runs with two of its changes",
    "workflows/paper/test_reproduce.py _fit": "a fit of known data shows that it fits",
}
"""Private names that a file of tests reads, and why."""

_PUBLIC = {"_exit", "_replace", "_repr_html_", "_repr_png_"}  # libraries document them as public


def _private(name):
    return name.startswith("_") and not name.startswith("__") and name not in _PUBLIC


def _read(file):
    """Private names that a file imports, or reads from another object."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            yield from (one.name for one in node.names if _private(one.name))
        elif isinstance(node, ast.Attribute) and _private(node.attr):
            is_own = getattr(node.value, "id", None) in ("self", "cls")
            yield from () if is_own else (node.attr,)


def test_tests_read_no_private_name_without_a_reason():
    tests = ROOT / "tests"
    # What modules of the package read of each other is private to the package alone.
    shared = {name for file in (ROOT / "pipeline").rglob("*.py") for name in _read(file)}
    found = {
        f"{file.relative_to(tests)} {name}"
        for file in tests.rglob("*.py")
        for name in _read(file)
        if name not in shared
    }
    assert found == _ALLOWED.keys(), sorted(found ^ _ALLOWED.keys())
