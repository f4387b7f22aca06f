"""Lines of code by room, and their sums: the core of `pipeline`, and its extras."""

import ast
import tomllib
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
SUMS = Path(__file__).with_name("sums.toml")
_DATA = ("*.toml", "*.csv", "*.css", "*.html", "*.js", "*.mplstyle")


def allowed():
    """Largest allowed lines of code of core and extras."""
    return tomllib.loads(SUMS.read_text(encoding="utf-8"))


def sums():
    """Lines of code of the core of `pipeline` and of its extras."""
    extras = {room.parent.name for room in (ROOT / "pipeline").glob("*/commands.py")}
    total = {"core": 0, "extras": 0}
    for room, lines in lines_by_room().items():
        package, _, name = room.partition(".")
        if package == "pipeline":
            total["extras" if name in extras else "core"] += lines
    return total


@cache
def lines_by_room():
    """Lines of code by package and folder."""
    rooms = {}
    for package in ("tribo", "pipeline"):
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).parts
            room = ".".join(parts[:2]) if len(parts) > 2 else package
            source = path.read_text(encoding="utf-8")
            rooms[room] = rooms.get(room, 0) + code_lines(source, ast.parse(source))
    return rooms


def data_files():
    """Number of lines of data files beside the code, by path."""
    files = (path for kind in _DATA for path in (ROOT / "pipeline").rglob(kind))
    return {
        str(path.relative_to(ROOT)): path.read_text(encoding="utf-8").count("\n") for path in files
    }


def code_lines(source, tree):
    """Number of lines that are neither blank, comment, docstring nor import."""
    skipped = set()
    for node in ast.walk(tree):
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
