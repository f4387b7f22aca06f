"""The root of a store: its sweep, facts of the store, and metadata for other programs.

It is replaced atomically, and has a hash of its facts.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from pipeline.paths import path_hint
from pipeline.scene.resume import misfits
from pipeline.scene.stored_text import SweepTextError, file_contents, parse_sweep
from pipeline.store.arrays import Document, array_documents, open_arrays
from pipeline.store.files import PARTIAL
from pipeline.store.inputs import DIM, inputs_variable, split_arrays
from pipeline.store.layout import Axes, grown_axes, made_coordinates
from pipeline.store.lock import holder_of
from pipeline.store.place import (
    LOCK,
    ROOT,
    DamagedError,
    Folder,
    PathLike,
    StoreError,
    StoreMismatchError,
    StorePlace,
    io_errors,
    place_of,
    read_errors,
)
from pipeline.store.schema import (
    ABOUT,
    AT_ENDS,
    FORMAT,
    INPUTS,
    OF_TESTS,
    SCENE_ID,
    VARIABLES,
    Variable,
    is_coordinate,
    path_of,
    variables_of,
)
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import points
from pipeline.sweep.points_of_tests import (
    NO_TEST,
    TEST_POINT,
    Slot,
    slot_point,
    sweep_of_tests,
)
from tribo.loading.ramp import MOST_STEPS
from tribo.types import Array

CONSOLIDATED = "consolidated_metadata"
"""Key of all arrays' metadata in a root; without ``kind``, read from each array's own document."""
_COPY = "that of a copy by xarray, which can be read, but not verified or resumed"
_ELSEWHERE = "restore it from a backup, or run the scene into another store"
_TESTS_IN_A_CHUNK = 32
_FACTS = ("format", "axes", "points_per_chunk", "history", "inputs", "scene", "ids", "tests")
"""Attributes of the group ``about``, beside the hash; xarray may drop those of the root."""


@dataclass(frozen=True, kw_only=True)
class Group:
    """A group of points: what determines the arrays of these points, and their metadata.

    `ids` are the scene ids of the variants, and `block` the number of points in a chunk along each
    dimension.
    """

    sweep: Sweep
    axes: Axes
    ids: list[int]  # scene ids of the sweep's variants, in the order of the table
    block: dict[str, int]  # points in a chunk along each dimension
    history: list[str]  # versions of the programs that computed

    prefix: ClassVar[str] = ""
    """Path of the group in the store, with a slash; empty for the plane of points."""

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """Variables of the group by name."""
        return variables_of(self.sweep)

    @cached_property
    def arrays(self) -> dict[str, Document]:
        """Zarr metadata of the arrays, by name."""
        return array_documents(self.variables, self._sizes(), self.block)

    def _sizes(self) -> dict[str, int]:
        return {name: len(values) for name, values in self.axes.items()}

    def coordinates(self) -> dict[str, Any]:
        """Values of coordinates by name."""
        return self.axes | made_coordinates(self.sweep, self.axes, self.variables, self.ids)

    @property
    def points(self) -> Sequence[Point]:
        """Points that the sweep asks for."""
        return points(self.sweep)

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the dataset."""
        return {}

    @property
    def tests(self) -> Group | None:
        """The points of tests; None if there are none."""
        return None

    def scene_hash(self, point: Point) -> str:
        """SHA-256 of the scene that is simulated at a point."""
        return self.sweep.scene_hash(point)

    def in_words(self, point: Point) -> str:
        """Write a point as text, with entries as in the scene file, such as ``2 mm``."""
        written = self.sweep.variants.written(point.variant)
        return str(point._replace(variant=tuple(written.items())))

    def paths(self) -> dict[str, Document]:
        """Zarr metadata of the arrays, by path in the store."""
        return {self.prefix + path_of(name): array for name, array in self.arrays.items()}


@dataclass(frozen=True, kw_only=True)
class TestGroup(Group):
    """The points of tests, which lie in a group of their own."""

    slots: Sequence[Slot]

    prefix: ClassVar[str] = f"{OF_TESTS}/"

    @classmethod
    def of(cls, sweep: Sweep, layout: TestLayout, history: list[str]) -> TestGroup:
        """The group of the tests of a sweep, as a store lays it out."""
        own = sweep_of_tests(sweep, layout.slots, layout.judges_hold)
        axes = grown_axes({"step": [*range(1 - layout.steps, 1)]}, own, own)
        axes = {name: values for name, values in axes.items() if name in variables_of(own)}
        ids = [
            int.from_bytes(bytes.fromhex(one.scene_hash[:8]), signed=True) for one in layout.slots
        ]
        block = {TEST_POINT: _TESTS_IN_A_CHUNK}
        return cls(sweep=own, axes=axes, ids=ids, block=block, history=history, slots=layout.slots)

    @property
    def points(self) -> Sequence[Point]:
        """Points that the tests of the present scene ask for."""
        return [slot_point(k, slot) for k, slot in enumerate(self.slots) if slot.is_wanted]

    def scene_hash(self, point: Point) -> str:
        """SHA-256 of the scene that is simulated at a point, also if no test asks for it."""
        return self._slot(point).scene_hash

    def in_words(self, point: Point) -> str:
        """Write a point as text, such as "400 N, 2 m/s, test 1", tests counted from 1."""
        return f"{point._replace(variant=())}, test {self._slot(point).test + 1}"

    def _slot(self, point: Point) -> Slot:
        return self.slots[int(point.variant[0][1])]


class TestLayout(NamedTuple):
    """Layout of the points of tests: their slots, and how many steps of each are stored."""

    slots: list[Slot]
    steps: int
    judges_hold: bool  # True if a hold is judged at each step


@dataclass(frozen=True, kw_only=True)
class Root(Group):
    """Content of a store's root document, which determines the metadata of all arrays.

    `found` is the document as it was read.
    """

    text: str  # of the sweep
    layout: TestLayout | None = None  # of the points of tests, if there are any
    found: Document  # the document as it was read, with additions of users; empty if it is new

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """Variables of the store by name."""
        return variables_of(self.sweep) | inputs_variable(self._inputs)

    @cached_property
    def tests(self) -> TestGroup | None:
        """The points of tests; None if the store never had any."""
        return TestGroup.of(self.sweep, self.layout, self.history) if self.layout else None

    @cached_property
    def _inputs(self) -> dict[str, int]:
        """Number of values of each array that was read from the scene's files, by SHA-256."""
        return {digest: array.size for digest, array in file_contents(self.sweep).items()}

    def _sizes(self) -> dict[str, int]:
        return {**super()._sizes(), DIM: sum(self._inputs.values())}

    def coordinates(self) -> dict[str, Any]:
        """Values of coordinates, and of the arrays from the scene's files, by name."""
        values = super().coordinates()
        if arrays := file_contents(self.sweep):
            values[INPUTS] = np.concatenate([array.ravel() for array in arrays.values()])
        return values

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the dataset: texts for people, and the sweep and its scene ids as JSON."""
        return {
            "Conventions": "CF-1.11",
            "title": self.sweep.title,
            "source": "simulated by irg-transition",
            "history": "\n".join(self.history),
            "license": "BSD-3-Clause for the program; the data are their author's",
            "scene": self.text,
            SCENE_ID: json.dumps(self.ids),
        }

    @property
    def found_metadata(self) -> dict[str, Document]:
        """Zarr metadata, by path, of all arrays and groups that the store had when it was read.

        Those added by users are included. A new store has none.
        """
        return dict(self.found[CONSOLIDATED]["metadata"]) if self.found else {}

    def documents(self) -> dict[str, bytes]:
        """JSON documents of all groups by key; the last is the root document, with all metadata.

        They are not made by Zarr, which would write the root document in two steps. The other
        documents repeat parts of it, for programs that consolidate the metadata again.
        """
        values = (
            FORMAT, self.axes, self.block, self.history, self._inputs, self.text, self.ids,
            self.layout,
        )  # fmt: skip
        facts = dict(zip(_FACTS, values, strict=True))
        arrays = self.paths()
        facts["digest"] = _digest(facts, arrays)
        places = {ABOUT: _group(facts), AT_ENDS: _group({})}
        if self.tests:
            places |= {OF_TESTS: _group({}), f"{self.tests.prefix}{ABOUT}": _group({})}
            arrays |= self.tests.paths()
        own = places | arrays
        others = self.found_metadata
        whole = others | {path: with_others(others.get(path), own[path]) for path in own}
        # Zarr finds the members of a group only where they stand side by side.
        metadata = {path: whole[path] for path in sorted(whole, key=lambda p: p.rpartition("/")[0])}
        consolidated = {"kind": "inline", "must_understand": False, "metadata": metadata}
        root = with_others(self.found, _group(self.attributes)) | {CONSOLIDATED: consolidated}
        groups = {f"{name}/{ROOT}": whole[name] for name in places} | {ROOT: root}
        return {key: json.dumps(one, allow_nan=False).encode() for key, one in groups.items()}


def _group(attributes: Document) -> Document:
    return {"zarr_format": 3, "node_type": "group", "attributes": attributes}


def with_others(found: Any, new: Document) -> Document:
    """Copy of document `new` with the attributes that users added to its old version, `found`."""
    others = found.get("attributes") if isinstance(found, dict) else None
    return new | {"attributes": {**(others or {}), **new["attributes"]}}


def _digest(facts: Document, arrays: Document) -> str:
    """SHA-256 of the facts and the arrays' metadata, without texts and users' additions."""
    names = [INPUTS, *(name for name in VARIABLES if not is_coordinate(name))]
    numbers = [arrays.get(path_of(name), {}) | {"attributes": {}} for name in names]
    said = [facts[name] for name in _FACTS], numbers
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()


def read_root(place: StorePlace) -> Root:
    """Read a store's root document; `StoreError` if missing, damaged or of another version."""
    if root := find_root(place):
        return root
    if holder := holder_of(place):
        raise StoreError(f"{place} is being made by {holder}; try again in a few seconds")
    near = path_hint(place.path) if isinstance(place, Folder) and not place.path.exists() else ""
    raise StoreError(f"there is no store at {place}{near}; run a scene into it, or give another")


def find_root(place: StorePlace) -> Root | None:
    """Read a store's root document; None for an empty place, `StoreError` for other content."""
    with io_errors(place):
        content = place.read(ROOT)
        keys = place.keys() if content is None else set()
    if content is not None:
        return _parse(place, content)
    is_file = isinstance(place, Folder) and place.path.is_file()
    if is_file or not all(map(_is_left_over, keys)):
        raise StoreError(f"{place} is no store, or has lost its {ROOT}; {_ELSEWHERE}")
    return None


def _is_left_over(key: str) -> bool:
    """True if `key` is a file that may remain if creating a store was interrupted."""
    name, _, rest = key.removesuffix(PARTIAL).rpartition("/")
    return key == LOCK or rest == ROOT or (rest.startswith("c.") and is_coordinate(name))


def _parse(place: StorePlace, content: bytes) -> Root:
    """Read the JSON text of a root document; `StoreError` if it is not one of this version."""
    version: Any = FORMAT
    fault, facts = "damaged, or not that of a sweep", None
    try:
        document = json.loads(content)
        # Zarr drops consolidated metadata if a user adds an array and does not consolidate again.
        if not document.get(CONSOLIDATED):
            document[CONSOLIDATED] = {"metadata": read_metadata(place)}
        metadata = document[CONSOLIDATED]["metadata"]
        if "scene" in document["attributes"] and ABOUT not in metadata:
            fault = _COPY
        found = metadata[ABOUT]["attributes"]
        version = found["format"]
        if version == FORMAT and found["digest"] == _digest(found, metadata) and _are_facts(found):
            facts = found
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    if version != FORMAT:
        fault = f"of another version of this program: of format {version}, and not {FORMAT}"
    # From here on only errors that speak of the store: a fault of this program is not damage.
    if facts:
        try:
            root = Root(
                sweep=parse_sweep(facts["scene"], _read_inputs(place, facts["inputs"])),
                text=facts["scene"],
                axes=facts["axes"],
                ids=facts["ids"],
                block=facts["points_per_chunk"],
                history=facts["history"],
                layout=_layout_of(facts["tests"]),
                found=document,
            )
            if _fit_axes(root):
                return root
        except (SweepTextError, DamagedError) as error:
            fault = f"{fault} ({error})"
    raise StoreError(f"{place}: its {ROOT} is {fault}; {_ELSEWHERE}")


def _layout_of(facts: Any) -> TestLayout | None:
    """Layout of the points of tests from its JSON."""
    if facts is None:
        return None
    slots, steps, judges_hold = facts
    return TestLayout([Slot(*slot) for slot in slots], steps, judges_hold)


def _are_facts(facts: Any) -> bool:
    """True if `facts` have the types that `Root.documents` writes."""
    axes, sizes = facts["axes"].values(), [*facts["points_per_chunk"].values()]
    sizes += facts["inputs"].values()
    return (
        all(isinstance(one, list) for one in [*axes, facts["ids"], facts["history"]])
        and all(isinstance(one, str | int | float) for labels in axes for one in labels)
        and all(isinstance(one, int) for one in [*sizes, *facts["ids"]])
        and all(isinstance(one, str) for one in [facts["scene"], *facts["history"]])
        and min(sizes) > 0
        and (facts["tests"] is None or _is_layout(*facts["tests"]))
    )


def _is_layout(slots: Any, steps: Any, judges_hold: Any) -> bool:
    """True if these are the facts of a `TestLayout`."""
    numbers = [one for slot in slots for one in slot[1:]]
    return (
        isinstance(judges_hold, bool)
        and isinstance(steps, int)
        and 0 < steps <= MOST_STEPS
        and all(len(slot) == len(Slot._fields) and isinstance(slot[0], str) for slot in slots)
        and all(isinstance(one, int | float) for one in numbers)
    )


def _fit_axes(root: Root) -> bool:
    """True if the axes are those of the variables; names of axes become names of files."""
    names, dims = root.variables.keys(), root.variables["status"].dims
    needed = {dim for one in root.variables.values() for dim in one.dims} - {DIM}
    if root.layout and not all(slot.test in _numbers_of(root.sweep) for slot in root.layout.slots):
        return False
    return needed <= root.axes.keys() <= names and root.block.keys() == {*dims}


def _numbers_of(sweep: Sweep) -> range:
    """Numbers that the test of a slot may have."""
    return range(NO_TEST, len(sweep.own_points))


def read_metadata(place: StorePlace) -> dict[str, Document]:
    """Read the Zarr metadata of the groups and arrays in a store from their own documents, by path.

    The root's own and damaged documents are left out.
    """
    found = {}
    with io_errors(place):
        for key in sorted(place.keys()):
            if key.endswith(f"/{ROOT}"):
                with suppress(ValueError):  # a damaged document
                    found[key[: -len(ROOT) - 1]] = json.loads(place.read(key) or b"{}")
    return found


def _read_inputs(place: StorePlace, sizes: dict[str, int]) -> dict[str, Array]:
    """Contents of the scene's files by SHA-256; `sizes` has the number of values of each."""
    if not sizes:
        return {}
    wanted, shape = inputs_variable(sizes), {DIM: sum(sizes.values())}
    array = open_arrays(place.zarr(), array_documents(wanted, shape, {}))[INPUTS]
    with read_errors(place, INPUTS):
        return split_arrays(array[:], array.attrs)


def require_same_scene(place: StorePlace, root: Root, sweep: Sweep) -> None:
    """Raise a `StoreMismatchError` unless a sweep can continue the store at `place`.

    `root` is the root document of the store.
    """
    if differing := [*misfits(root.sweep, sweep)]:
        advice = "give it what the store has, or write to another store"
        raise StoreMismatchError(
            "\n  ".join([f"{place} belongs to another scene; {advice}", *differing])
        )


def find_sweep(path: PathLike) -> Sweep | None:
    """Read the sweep of a store; None for an empty place, `StoreError` for other content."""
    root = find_root(place_of(path))
    return root.sweep if root else None
