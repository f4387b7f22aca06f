"""The root of a store: its sweep, facts of the store, and metadata for other programs.

It is replaced atomically, and has a hash of its facts.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from pipeline.scene.stored_text import file_contents
from pipeline.store.arrays import Document, array_documents
from pipeline.store.layout import Axes, grown_axes, made_coordinates
from pipeline.store.place import ROOT
from pipeline.store.schema import (
    ABOUT,
    AT_END,
    AT_ENDS,
    DIM,
    FORMAT,
    INPUTS,
    OF_TESTS,
    Variable,
    inputs_variable,
    path_of,
    variables_of,
)
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import points
from pipeline.sweep.points_of_tests import TEST_POINT, Slot, sweep_of_tests
from pipeline.sweep.variants import Variant

CONSOLIDATED = "consolidated_metadata"
"""Key of all arrays' metadata in a root; without ``kind``, read from each array's own document."""
_TESTS_IN_A_CHUNK = 32
GOAL = "run with --accuracy "
"""Begin of a line in the history of a store."""
_FACTS = (
    "format", "axes", "points_per_chunk", "points_per_field_chunk", "history", "inputs", "scene",
    "tests",
)  # fmt: skip
"""Attributes of the group ``about``, beside the hash; xarray may drop those of the root."""


@dataclass(frozen=True, kw_only=True)
class Group:
    """A group of points: what determines the arrays of these points, and their metadata.

    `ids` are the scene ids of the variants. `block` is the number of points in a chunk along each
    dimension, and `field_block` that in a chunk of a field.
    """

    sweep: Sweep
    axes: Axes
    block: dict[str, int]  # points in a chunk along each dimension
    field_block: dict[str, int]  # the same for fields, whose points are far larger
    history: list[str]  # versions of the programs that computed, and accuracies asked for

    prefix: ClassVar[str] = ""
    """Path of the group in the store, with a slash; empty for the plane of points."""

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """Variables of the group by name."""
        return variables_of(self.sweep)

    @cached_property
    def arrays(self) -> dict[str, Document]:
        """Zarr metadata of the arrays, by name."""
        fields = {name: one for name, one in self.variables.items() if name in AT_END}
        others = {name: one for name, one in self.variables.items() if name not in AT_END}
        return array_documents(others, self._sizes(), self.block) | array_documents(
            fields, self._sizes(), self.field_block
        )

    def _sizes(self) -> dict[str, int]:
        return {name: len(values) for name, values in self.axes.items()}

    def coordinates(self) -> dict[str, Any]:
        """Values of coordinates by name."""
        return self.axes | made_coordinates(self.sweep, self.axes, self.variables)

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
        if point.variant not in self._scene_hashes:
            scene = self.sweep.case(point.variant).scene
            self._scene_hashes[point.variant] = self.sweep._hash_scene(scene)
        return self._scene_hashes[point.variant]

    @cached_property
    def _scene_hashes(self) -> dict[Variant, str]:
        """Hashes of scenes by variant, as far as they are known: a large sweep asks often."""
        return {}

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
        block = {TEST_POINT: _TESTS_IN_A_CHUNK}
        return cls(
            sweep=own,
            axes=axes,
            block=block,
            field_block=block,
            history=history,
            slots=layout.slots,
        )

    @property
    def points(self) -> Sequence[Point]:
        """Points that the tests of the present scene ask for."""
        return [
            Point(slot.load, slot.velocity, ((TEST_POINT, k),))
            for k, slot in enumerate(self.slots)
            if slot.is_wanted
        ]

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
        }

    @property
    def goal(self) -> str:
        """Option of the last new accuracy that the store was run for; empty without one."""
        goals = [line for line in self.history if line.startswith(GOAL)]
        return goals[-1].removeprefix("run with ") if goals else ""

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
            FORMAT, self.axes, self.block, self.field_block, self.history, self._inputs, self.text,
            self.layout,
        )  # fmt: skip
        facts = dict(zip(_FACTS, values, strict=True))
        arrays = self.paths()
        facts["digest"] = digest_of(facts)
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


def digest_of(facts: Document) -> str:
    """SHA-256 of the facts, from which the arrays' metadata follow."""
    said = [facts[name] for name in _FACTS]
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()
