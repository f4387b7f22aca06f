"""What is wrong in a file that is not valid TOML, by its line, and what to write there."""

from __future__ import annotations

import re
from collections.abc import Iterator

_TEXT = r'"(?:\\.|[^"\\])*"|\'[^\']*\''
_QUANTITY = re.compile(
    rf"({_TEXT})|(?<![\w.\"'#])([-+±]?\s?\d[\d.,]*(?:e[-+]?\d+)? ?(?:[^\W\d]|[°%])[^,\]}}#=]*)"
)
_WORD = re.compile(r"=\s*([^\W\d][\w .+-]*?)\s*(?:#.*)?$")
_DECIMAL_COMMA = re.compile(r"=\s*[-+]?\d+,\d+\s*(?:#.*)?$")
_LONGEST = 60


def explain_slip(text: str, error: Exception) -> str:
    """Say what is wrong in a `text` at which the reader of TOML raised an `error`."""
    reason, lines = str(error), text.splitlines()
    place = re.search(r" \(at (?:line (\d+)|end of document).*", reason)
    if place is None:
        return f"is not valid TOML: {reason}"
    number = int(place[1]) if place[1] else len(lines)
    line = lines[min(number, len(lines)) - 1].strip() if lines else ""
    shown = line if len(line) <= _LONGEST else f"{line[:_LONGEST]} ..."
    if twice := _stands_twice(lines, number, reason):
        return twice
    said = _slip_in(line, reason) or f"is not valid TOML: {reason[: place.start()]}"
    return f"line {number}: {shown}: {said}"


def _slip_in(line: str, reason: str) -> str:
    """Words on the usual slips that a line may have; empty if it has none of them."""
    line = re.sub(rf"({_TEXT})|#.*", r"\1", line).strip()
    for match in _QUANTITY.finditer(line):
        if match[2]:
            return f'a quantity stands in quotes; write "{match[2].strip()}"'
    if _DECIMAL_COMMA.search(line):
        return "a number has a decimal point, not a comma"
    if "Unterminated" in reason or line.count('"') % 2:
        return "a quotation mark is missing"
    if bare := _WORD.search(line):
        word = bare[1]
        if word.lower() in ("true", "false"):
            return f"write {word.lower()}, without a capital"
        return f'text stands in quotes; write "{word}"'
    if "Unclosed array" in reason or ("end of document" in reason and "=" not in line):
        return "a comma or a bracket is missing"
    if line.endswith("="):
        return "a value is missing"
    if "=" not in line and not line.startswith("["):
        return 'an entry is a key, "=" and a value, such as radius = "2 mm"'
    if line.count("{") > line.count("}"):
        return "a table in braces ends in its line; close it, or write it as [table]"
    if line.count("[") != line.count("]"):
        return "a bracket is missing"
    return ""


def _stands_twice(lines: list[str], number: int, reason: str) -> str:
    """Words on a key or table that stands in two lines; empty if the fault is another."""
    if not re.match("Cannot (overwrite|declare|mutate)|Duplicate", reason):
        return ""
    named = [*_names(lines[:number])]
    if not named:
        return ""
    line, name = named[-1]
    first = next((earlier for earlier, other in named if other == name), line)
    if first == line:
        return f"line {line}: {name} is given already, as a value or in another table; keep one"
    return f"{name} is given twice, in lines {first} and {line}; keep one"


def _names(lines: list[str]) -> Iterator[tuple[int, str]]:
    """Yield the number of each line with a table or key, and its name, such as "pin.radius"."""
    table = ""
    for number, line in enumerate(lines, 1):
        if header := re.match(r"\s*\[\s*([\w.\"' -]+?)\s*\]", line):
            table = header[1]
            yield number, f"[{table}]"
        elif header := re.match(r"\s*\[\[\s*([\w.\"' -]+?)\s*\]\]", line):
            table = f"{header[1]} (line {number})"  # each such table has keys of its own
        elif key := re.match(r"\s*([\w.\"'-]+)\s*=", line):
            yield number, f"{table}.{key[1]}".lstrip(".")
