"""References of pages: scene file, dataset, commands and Python, from what they describe.

    python -m tests.sources.reference

writes each below the text of its page.
"""

import math
import re
from pathlib import Path

import tribo
from pipeline.kinds import Quantity
from pipeline.messages import quoted
from pipeline.scene.table_kinds import List, TableKind, number_in
from pipeline.store import schema
from pipeline.units import typeset
from tests.helpers.campaigns import table
from tests.sources.command_reference import commands
from tests.sources.python_reference import api
from tests.sources.sections import sections

_HEADS = "key", "value", "meaning"
_SHORT = (
    (r'an? [a-z -]+? above 0, such as ("[^"]+")', r"\1"),  # the page states this limit once
    (r'an? [a-z -]+? (of at least 0), such as ("[^"]+")', r"\2, \1"),
    (r'a temperature, such as ("[^"]+")', r"\1"),
    (r"\bof at least\b", "at least"),
    (r"(,| and) at most \d{4,}", ""),  # limits of memory
    (r"\ban? (share|number|whole number)\b", r"\1"),
    (r"\bwithout a unit, ", ""),
    (r"\btext in quotes", "text"),
    (r"\ba list of 2 values, each ", "2 values: "),
    (r"\ba list of values, each ", "list of "),
    (r"\bshare such as ", ""),
    (r"(step or count), each .*", r"\1"),
    (r"a table whose keys are (paths) of other entries, each with .*", r"a table by \1 of entries"),
)
"""Patterns of what a message says of an allowed value, and their shorter forms in a table."""
_VARIABLES = {
    "Coordinates": schema.COORDINATES,
    "Variables of each point": schema.RECORDS,
    "Variables at each step": schema.COLUMNS,
    "Sampling errors of each point": schema.SAMPLING,
    "Oil film of each point": schema.FILM,
    "Ends of the pin at each point, with `pin.ends`": schema.ENDS,
    "Fields at the end of each point": schema.FIELDS,
}


def new_keys(section, seen):
    """Keys of a section that no earlier one has with the same meaning, and sentences on the others.

    The keys are grouped by the form of the table that has them, such as "random surface". `seen`
    maps each key and its meaning to the header of the section that has it, and gets the new ones.
    """
    new, known = {}, {}
    for key, (entry, form) in section.keys().items():
        if header := seen.get((key, entry.meaning)):
            known.setdefault(header, []).append(f"`{key}`")
        else:
            new.setdefault(form, {})[key] = entry
            seen[key, entry.meaning] = section.header
    return new, [f" As in `{header}`: {', '.join(keys)}." for header, keys in known.items()]


def scene():
    """Markdown tables of all entries of a scene file."""
    parts, seen = [], {}
    for section in sections():
        title = f"`{section.header}`" if section.path else "Top of the file"
        need = "" if section.entry.is_needed else " Optional."
        keys_by_form, also = new_keys(section, seen)
        parts.append(f"## {title}\n\n{section.entry.meaning}{need}{''.join(also)}\n")
        for form, keys in keys_by_form.items():
            parts += [f"**{form.capitalize()}:**\n"] if len(keys_by_form) > 1 else []
            rows = [
                [
                    f"`{key}`",
                    _kind_cell(entry) + _default(section, key, entry),
                    _meaning(section, entry, seen),
                ]
                for key, entry in keys.items()
            ]
            parts.append(_table(_HEADS, rows))
    return "\n".join(parts)


def dataset():
    """Markdown tables of all variables of a dataset."""
    return "\n".join(_variables(title, table) for title, table in _VARIABLES.items())


def _variables(title, variables):
    """Section with the variables of a table, and the dimensions that all of them have."""
    shared = min((variable.dims for variable in variables.values()), key=len)
    dims = f"Dimensions: {', '.join(shared)}.\n\n" if shared else ""
    rows = []
    for name, variable in variables.items():
        further = f" (along {', '.join(rest)})" if (rest := variable.dims[len(shared) :]) else ""
        further = "" if rest == (name,) else further
        rows.append([f"`{name}`", variable.units or "", f"{variable.long_name}{further}"])
    return f"## {title}\n\n{dims}" + _table(("variable", "unit", "meaning"), rows)


def _table(heads, rows):
    """A Markdown table as text, followed by an empty line."""
    escaped = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    return table(heads, escaped) + "\n"


def _kind_cell(entry):
    """Table cell with the allowed and the usual values of an entry."""
    kind, words = number_in(entry.kind), str(entry.kind)
    for pattern, short in _SHORT:
        words = re.sub(pattern, short, words)
    if not kind or not kind.usual:
        return words
    low, high = (f"{end:g}" for end in kind.usual)
    return f"{words}; usually {low} to {high} {typeset(kind.unit)}".rstrip()


def _meaning(section, entry, seen):
    """Meaning of an entry, and of the keys of a table as its value that are not in `seen`.

    `seen` gets these keys, as in `new_keys`.
    """
    tables = (kind for kind in getattr(entry.kind, "kinds", ()) if isinstance(kind, TableKind))
    keys = {key: inner.meaning for table in tables for key, inner in table.keys.items()}
    new = {key: meaning for key, meaning in keys.items() if (key, meaning) not in seen}
    seen |= dict.fromkeys(new.items(), section.header)
    return " ".join([entry.meaning, *(f"`{key}`: {meaning}" for key, meaning in new.items())])


def _default(section, key, entry):
    """End of the cell of a value: its default, or that the entry is needed."""
    if entry.is_needed:
        return "; **needed**"
    if section.path == "fidelity" and entry.default is None:
        values = [_written(getattr(preset, key)) for preset in tribo.PRESETS.values()]
        return f"; default {', '.join(values)} by preset"
    usual = _written(entry.default, entry.kind)
    return f"; default `{usual}`" if usual else ""


def _written(value, kind=None):
    """Default value as a scene file writes it; empty for None."""
    if value in (None, (), {}, math.inf):
        return ""
    match kind:
        case List(item_kind) if isinstance(value, tuple):
            return f"[{', '.join(_written(item, item_kind) for item in value)}]"
        case Quantity(example=example) if "degC" in example:
            return f'"{value - 273.15:g} degC"'
    return f"{value:g}" if isinstance(value, float) else quoted(value)


PAGES = {"SCENE": scene, "DATASET": dataset, "COMMANDS": commands, "API": api}
"""Functions that write the reference of each page, which ends with it."""


def written(page, text):
    """Text of a page with its reference written again, below the first heading of the reference."""
    reference = PAGES[page]()
    (heading,) = re.findall(r"\A## .*\n", reference)
    return text.partition(heading)[0] + reference


if __name__ == "__main__":
    for page in PAGES:
        path = Path(__file__).parents[2] / "workflows" / f"{page}.md"
        path.write_text(written(page, path.read_text(encoding="utf-8")), encoding="utf-8")
