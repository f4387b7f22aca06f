"""Tables of the pages on the scene file and the dataset, from the format and the variables.

    python -m tests.house.reference scene | dataset

writes one of them, as `make reference` puts it below the text of its page.
"""

import math
import sys

import tribo
from pipeline.scene.format import FidelityTable
from pipeline.scene.kinds import Quantity
from pipeline.scene.tables import List, table_of
from pipeline.store import schema
from pipeline.units import typeset
from pipeline.words import quoted
from tests.helpers.campaigns import table
from tests.house.sections import number_in, sections

_HEADS = "key", "give", "default", "meaning"
_VARIABLES = {
    "Coordinates": schema.COORDINATES | schema.MADE,
    "Variables of each point": schema.RECORDS,
    "Variables at each step": schema.COLUMNS,
    "Sampling errors of each point": schema.SAMPLING,
    "Fields at the end of each point": schema.FIELDS,
}


def new_keys(section, listed):
    """Keys of a list of tables, such as ``[[tested]]``, that are in no earlier list of tables.

    Returns these keys, as `Section.keys` does, and the header of an earlier list that has the other
    keys, or "" if all keys are new. A section that is not a list of tables keeps all its keys.
    `listed` maps each key to the header of the first list that has it, and gets the new keys.
    """
    keys = section.keys()
    if "." in section.path or not section.is_list:
        return keys, ""
    own = {key: entry for key, entry in keys.items() if key not in listed}
    like = next((listed[key] for key in keys if key in listed), "")
    listed |= dict.fromkeys(own, section.header)
    return own, like


def scene():
    """Markdown tables of all entries of a scene file."""
    parts, listed = [], {}
    for section in sections():
        title = f"`{section.header}`" if section.path else "Top of the file"
        need = "" if section.entry.is_needed else " Optional."
        keys, like = new_keys(section, listed)
        also = f" Keys as in `{like}`, and these:" if like else ""
        parts.append(f"## {title}\n\n{section.entry.meaning}{need}{also}\n")
        rows = [
            [f"`{key}`", _kind_cell(entry), _default_cell(section, entry, form), entry.meaning]
            for key, (entry, form) in keys.items()
        ]
        parts += [_table(_HEADS, rows)] if rows else []
    presets = [
        [f"`{key}`", *(_written(getattr(preset, key)) for preset in tribo.PRESETS.values())]
        for key in table_of(FidelityTable).keys
        if key != "preset"
    ]
    about = "Choices of each preset; [`CHOOSING.md`](CHOOSING.md) has their costs.\n"
    return "\n".join([*parts, "## Presets\n", about, _table(["", *tribo.PRESETS], presets)])


def dataset():
    """Markdown tables of all variables of a dataset."""
    heads = "variable", "dimensions", "unit", "meaning"
    return "\n".join(
        f"## {title}\n\n" + _table(heads, [
            [f"`{name}`", ", ".join(of.dims), of.units or "", of.long_name]
            for name, of in variables.items()
        ])
        for title, variables in _VARIABLES.items()
    )  # fmt: skip


def _table(heads, rows):
    """A Markdown table as text, followed by an empty line."""
    escaped = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    return table(heads, escaped) + "\n"


def _kind_cell(entry):
    """Table cell with the allowed and the usual values of an entry."""
    kind = number_in(entry.kind)
    if not kind or not kind.usual:
        return str(entry.kind)
    low, high = (f"{end:g}" for end in kind.usual)
    return f"{entry.kind}; usually {low} to {high} {typeset(kind.unit)}".rstrip()


def _default_cell(section, entry, form):
    if entry.is_needed:
        words = "needed"
    elif section.path == "fidelity" and entry.default is None:
        words = "the preset's"
    else:
        usual = _written(entry.default, entry.kind)
        words = f"`{usual}`" if usual else "–"
    return f"{words} ({form})" if form else words


def _written(value, kind=None):
    """Default value as a scene file writes it; empty for None."""
    if value in (None, (), {}, math.inf):
        return ""
    match kind:
        case List(of) if isinstance(value, tuple):
            return f"[{', '.join(_written(item, of) for item in value)}]"
        case Quantity(example=example) if "degC" in example:
            return f'"{value - 273.15:g} degC"'
    return f"{value:g}" if isinstance(value, float) else quoted(value)


if __name__ == "__main__":
    print({"scene": scene, "dataset": dataset}[sys.argv[1]](), end="")
