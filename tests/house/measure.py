"""Lines of code by room, without blank lines, comments, docstrings and imports."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]


def lines_by_room():
    """Lines of code by package and folder."""
    rooms = {}
    for package in ("tribo", "pipeline"):
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).parts
            room = ".".join(parts[:2]) if len(parts) > 2 else package
            rooms[room] = rooms.get(room, 0) + _code_lines(path.read_text(encoding="utf-8"))
    return rooms


def _code_lines(source):
    skipped = set()
    for node in ast.walk(ast.parse(source)):
        is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if isinstance(node, ast.Import | ast.ImportFrom) or (
            is_text and isinstance(node.value.value, str)
        ):
            skipped |= set(range(node.lineno, node.end_lineno + 1))
    return sum(
        1
        for number, line in enumerate(source.splitlines(), 1)
        if number not in skipped and line.strip() and not line.strip().startswith("#")
    )
