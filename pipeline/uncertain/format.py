"""Scene entries for inputs that are not known exactly, and the forms of a distribution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated as A
from typing import Any, NamedTuple

from pipeline.scene.declare import ByPath, Declared, Entry, Example, List, Table
from pipeline.scene.faults import Faults, quoted
from pipeline.scene.kinds import Flag, Kind, Number, Scalar, UnfitError, Whole
from pipeline.sweep.tables import Entries, entry_at

MOST_SAMPLES = 100_000  # reading each as a scene takes 1 ms


class StatedDistribution(NamedTuple):
    """Distribution of an input, as stated in a scene file."""

    form: str  # kind of distribution, or "list"
    parameters: tuple[Any, ...]  # of the distribution, with units; the values of a list
    varies: bool  # from specimen to specimen
    correlated: Mapping[str, float]  # coefficients of correlation, by the path of the other input


@dataclass(frozen=True)
class Distribution(Kind):
    """Kind of scene entry: a distribution, as a table with one of several sets of keys, or a list.

    `forms` are the tables, such as that of a normal distribution; `listed` reads a list of equally
    likely values.
    """

    forms: tuple[Table, ...]
    listed: Kind

    @property
    def leaf_keys(self) -> set[str]:
        """Keys that the table of a distribution may have, whichever distribution it is."""
        return {key for table in self.forms for key in table.keys}

    def __str__(self) -> str:
        pairs = [" and ".join(table.needed) for table in self.forms]
        return f"a table with {', or '.join(pairs)}; or {self.listed}"

    def _read(self, value: Any, place: str, faults: Faults) -> StatedDistribution | None:
        if isinstance(value, list):
            items = self.listed.read(value, place, faults)
            return items and StatedDistribution("list", items, False, {})
        keys = set(value) if isinstance(value, dict) else set()
        fits = (table for table in self.forms if set(table.needed) <= keys <= set(table.keys))
        table = next(fits, None)
        if table is None:
            words = f"a table with {', '.join(value)}" if isinstance(value, dict) else quoted(value)
            raise UnfitError(f"{words} is not a distribution")
        *parameters, varies, correlated = table._read(value, place, faults).values()
        if None in (varies, correlated, *parameters):
            return None
        return StatedDistribution(table.form, tuple(parameters), varies, correlated)


# fmt: off
_GIVEN = Entry(Scalar(), is_needed=True)
_ALWAYS = {
    "varies": Entry(Flag(), default=False),
    "correlated": Entry(ByPath(Number(above=-1, below=1), "paths of other inputs"), default={}),
}
UNKNOWN = ByPath(Distribution(
    forms=(
        Table({"mean": _GIVEN, "sd": _GIVEN, **_ALWAYS}, form="normal"),
        Table({"median": _GIVEN, "factor": Entry(Number(above=1), is_needed=True), **_ALWAYS},
            form="log-normal"),
        Table({"from": _GIVEN, "to": _GIVEN, **_ALWAYS}, form="uniform"),
    ),
    listed=List(Scalar(), distinct=True),  # equally likely values
), "paths of entries")

class Inputs(Declared):
    unknown: A[dict[str, Any] | None, UNKNOWN,
        "Inputs that are not known exactly, by their paths. A table is normal (mean and standard "
        "deviation), log-normal (median, and the factor within which two thirds lie) or uniform; a "
        "list has equally likely values. `--set`, or an entry of a scene that extends this one, "
        "fixes an input. `correlated` gives correlations with other inputs, between normal scores: "
        "values of normal inputs, logarithms of log-normal ones. `varies = true`: it differs "
        "from part to part, so that no test narrows it; a seed always does.",
        Example({"temperature.critical": {"mean": "145 degC", "sd": "8 K"}})] = None

class Samples(Declared):
    samples: A[int | None, Whole(at_least=1, at_most=MOST_SAMPLES),
        "Number of samples of the `unknown` inputs, each at its own velocity. `irg check` says if "
        "fewer are drawn because more would share their contacts."] = None
    sample_seed: A[int | None, Whole(at_least=0), "Seed of the samples; by default 0."] = None
# fmt: on

ENTRIES = {"": Inputs, "sweep": Samples}
"""Classes of the entries that samples add to a scene, by the path of their table."""
FORMS: tuple[type, ...] = ()


def find(entries: Entries) -> list[str]:
    """Paths of the scene's entries for unknown inputs; empty if it has none."""
    paths = "unknown", "sweep.samples", "sweep.sample_seed"
    return [path for path in paths if entry_at(entries, path) is not None]
