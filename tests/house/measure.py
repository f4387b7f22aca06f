"""Lines of code by room, calls that ask for the kind of a sweep, and names by preposition."""

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
SIZES = Path(__file__).with_name("sizes.toml")
_KIND = re.compile(r"\b(sweep_kind|require_kind|require_one_scene|map_scenes|parts_of)\(")
_PREPOSITION = re.compile(
    r"_?(of|on|in|at|with|by|from|to|under|about|for|as|beside|beyond|between|within|without|into)"
    r"(_|$)"
)


@cache
def measured():
    """Sizes of today, by table and name."""
    sources = {
        path.relative_to(ROOT): path.read_text(encoding="utf-8")
        for package in ("tribo", "pipeline")
        for path in sorted((ROOT / package).rglob("*.py"))
    }
    trees = {path: ast.parse(source) for path, source in sources.items()}
    lines, names, calls = {}, {}, 0
    for path, tree in trees.items():
        room = ".".join(path.parts[:2]) if len(path.parts) > 2 else path.parts[0]
        lines[room] = lines.get(room, 0) + code_lines(sources[path], tree)
        package = path.parts[0]
        names[package] = names.get(package, 0) + sum(map(begins_with_preposition, ast.walk(tree)))
        calls += len(_KIND.findall(re.sub(r"\bdef \w+\(", "", sources[path])))
    scripts = (ROOT / "pipeline").rglob("*.js")
    lines["javascript"] = sum(path.read_text(encoding="utf-8").count("\n") for path in scripts)
    return {
        "lines of code": lines,
        "functions named by a preposition": names,
        "calls that ask for a kind": {"pipeline": calls},
    }


def code_lines(source, tree):
    """Lines that are neither blank, comment, docstring nor import."""
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


def begins_with_preposition(node):
    """True of a function whose name begins with a preposition, such as `of_x`."""
    is_function = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    return is_function and bool(_PREPOSITION.match(node.name))


def written(sizes):
    """Sizes as text of the file."""
    tables = (
        "\n".join([f'["{name}"]', *(f'"{key}" = {size}' for key, size in sorted(table.items()))])
        for name, table in sizes.items()
    )
    return "\n\n".join(tables) + "\n"
