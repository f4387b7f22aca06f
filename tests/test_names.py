"""Names say what they are: the share of placeholders, and one meaning for each name of a file."""

import ast
import re
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PLACEHOLDER = re.compile(
    r"alike|alone|again|asked|beside|each|found|given|gone|has|held|here|holds|kept|lacking|least"
    r"|made|mine|most|named|near|obj|of|ones?|others|own|places?|said|shown|some|taken|tells|that"
    r"|theirs|then|there|things?|told|wanted|way|what|whole"
)
LIBRARIES = {"da", "math", "np", "numpy", "pd", "scipy", "xr"}
"""Libraries with names of their own, such as `np.ones`."""
LIMITS = {"pipeline": 0.003, "tribo": 0.003, "tests": 0.01}
"""Largest share of names that are placeholders."""
OF_EACH_PACKAGE = {"__init__", "__main__", "constants"}
"""Names of files that several packages have, each for the same thing."""


def names(tree):
    """Each use of a name in a module: variables, parameters, attributes and definitions."""
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(value=ast.Name(id=library)) if library in LIBRARIES:
                continue
            case ast.Name(id=name) | ast.arg(arg=name) | ast.Attribute(attr=name):
                yield name
            case ast.keyword(arg=str(name)):
                yield name
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield name


def placeholder_share(sources):
    """Share of names that are placeholders in sources by file, and their number by file."""
    used = [(path, name) for path, text in sources.items() for name in names(ast.parse(text))]
    placeholders = [path for path, name in used if PLACEHOLDER.fullmatch(name.strip("_").lower())]
    return len(placeholders) / len(used), Counter(placeholders)


def repeated_names(paths):
    """Names of files, without their ends, that several of `paths` have."""
    counts = Counter(path.stem for path in paths)
    return sorted(
        name for name, count in counts.items() if count > 1 and name not in OF_EACH_PACKAGE
    )


def modules(*folders):
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


@pytest.mark.parametrize("package", LIMITS)
def test_few_names_are_placeholders(package):
    sources = {path: path.read_text(encoding="utf-8") for path in modules(package)}
    share, by_file = placeholder_share(sources)
    assert share <= LIMITS[package], by_file.most_common(5)


def test_a_name_of_a_file_stands_for_one_thing():
    assert repeated_names(modules("pipeline", "tribo", "workflows")) == []


def test_a_placeholder_and_a_repeated_name_of_a_file_are_noticed():
    source = "def mean(values):\n    found = sum(values)\n    return found / np.ones(2).sum()\n"
    share, by_file = placeholder_share({"mean.py": source})
    assert by_file == {"mean.py": 2}
    assert share == pytest.approx(2 / 8)
    assert share > max(LIMITS.values())
    twice = [*modules("pipeline"), ROOT / "pipeline" / "scene" / "units.py"]
    assert repeated_names(twice) == ["units"]
