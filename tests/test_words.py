"""Phrases that are not used any more, in what the program prints and in its pages."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *(ROOT / "workflows").glob("*.md")]
SOURCES = [path for package in ("pipeline", "tribo") for path in (ROOT / package).rglob("*.py")]
UNUSED = re.compile(
    r"\b(anew|by the others|would decide it|judged at|takes \[%\]|turns? severe|not decided"
    r"|deciding temperature|failing share|doubts?|a preset promises|slips?|caveats?|variants?"
    r"|duty(?! cycle)|told|asked|patch(es)?)\b"
)


def printed(tree):
    """Texts of a module that are no docstrings."""
    docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    texts = (node for node in ast.walk(tree) if isinstance(node, ast.Constant))
    return [node.value for node in texts if isinstance(node.value, str) and id(node) not in docs]


@pytest.mark.parametrize("path", [*PAGES, *SOURCES], ids=lambda path: str(path.relative_to(ROOT)))
def test_no_page_or_message_has_a_phrase_that_is_not_used_any_more(path):
    text = path.read_text(encoding="utf-8")
    texts = [text] if path.suffix == ".md" else printed(ast.parse(text))
    assert [match[0] for part in texts for match in UNUSED.finditer(part)] == []
