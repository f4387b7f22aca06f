"""Lines of code by room, without blank lines, comments, docstrings and imports; code's hash."""

import ast
import hashlib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def lines_by_room():
    """Lines of code by package and folder."""
    rooms = {}
    for package in ("tribo", "pipeline"):
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).parts
            folder = ".".join(parts[:2]) if len(parts) > 2 else package
            rooms[folder] = rooms.get(folder, 0) + _code_lines(path.read_text(encoding="utf-8"))
    return rooms


def code_digest(*rooms):
    """Hash of the code in some folders, 8 digits; comments and docstrings do not count."""
    digest = hashlib.sha256()
    for path in sorted(path for folder in rooms for path in (ROOT / folder).rglob("*.py")):
        lines = path.read_text(encoding="utf-8").splitlines()
        skipped = _without_code("\n".join(lines))
        code = [line for number, line in enumerate(lines, 1) if number not in skipped]
        digest.update("\n".join([str(path.relative_to(ROOT)), *code]).encode())
    return digest.hexdigest()[:8]


def _without_code(source):
    """Numbers of the lines that are blank, or have a comment, a docstring or an import."""
    skipped = set()
    for node in ast.walk(ast.parse(source)):
        is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if isinstance(node, ast.Import | ast.ImportFrom) or (
            is_text and isinstance(node.value.value, str)
        ):
            skipped |= set(range(node.lineno, node.end_lineno + 1))
    for number, line in enumerate(source.splitlines(), 1):
        if not line.strip() or line.strip().startswith("#"):
            skipped.add(number)
    return skipped


def _code_lines(source):
    return len(source.splitlines()) - len(_without_code(source))
