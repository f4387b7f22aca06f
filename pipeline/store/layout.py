"""What a store holds, which follows from its sweep: axes, variables, chunks and metadata.

The group ``about`` has the sweep as data, with a digest. It alone is read; the other documents are
for other programs.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import PurePath
from typing import Any

import numpy as np
import xarray as xr

from pipeline.paths import path_hint
from pipeline.store.arrays import KEYS, Document, array_document, open_arrays, read_document
from pipeline.store.lock import holder_of
from pipeline.store.place import (
    LOCK,
    NEW,
    ROOT,
    Bucket,
    Folder,
    StoreError,
    StorePlace,
    io_errors,
    read_errors,
)
from pipeline.store.schema import (
    ABOUT,
    AT_ENDS,
    DIM,
    FIELDS,
    FORMAT,
    INPUTS,
    OF_TESTS,
    PLANE,
    TEST_STEP,
    Variable,
    inputs_variable,
    is_coordinate,
    is_of_points,
    path_of,
    split_arrays,
    variables_of,
)
from pipeline.sweep.case import TEST
from pipeline.sweep.case_table import CaseName, in_order
from pipeline.sweep.plan import choose_stations
from pipeline.sweep.points_of_tests import (
    NO_TEST,
    TEST_POINT,
    judges_holds,
    sweep_of_tests,
)
from pipeline.sweep.stations import ramp_of
from pipeline.sweep.stored import plain_sweep, sweep_of_plain
from pipeline.sweep.sweep import Point, Sweep
from tribo import QUANTILES, TriboError
from tribo.types import Array, Indices, Mask

Axes = dict[str, list[Any]]
"""Values along each dimension, and values of coordinates that lie along another dimension."""
Slices = tuple[slice, ...]

_LARGEST, _MOST = 2**22, 1024  # bytes of a chunk, and points in it, at most
GOAL = "run with --accuracy "
"""Begin of a line in the history of a store."""
FACTS = f"{ABOUT}/{ROOT}"
"""Key of the document that says what a store is; it is written last."""
_COPY = "consolidated_metadata"
_SOURCE = "simulated by irg-transition"
_ELSEWHERE = "restore it from a backup, or run the scene into another store"


@dataclass(frozen=True, eq=False)
class Group:
    """A group of points, of a plane or of tests: all else follows from the sweep.

    `prefix` is the path of the group in the store, with a slash; empty for the plane. `inputs` has
    the arrays that were read from the scene's files, by SHA-256.
    """

    sweep: Sweep
    inputs: Mapping[str, Array] = field(default_factory=dict)  # read from the scene's files
    prefix: str = ""
    keys: str = KEYS[0]  # encoding of the keys of chunks

    @property
    def step(self) -> str:
        """Name of the dimension of steps."""
        return TEST_STEP if self.prefix else "step"

    @cached_property
    def axes(self) -> Axes:
        """Values along each dimension, and of the columns of the table of cases."""
        sweep, stations = self.sweep, choose_stations(self.sweep)
        rows = {name: in_order(values) for name, values in sweep.case_table.axes.items()}
        # A column that a dimension determines has a value for each label, in the same order.
        rows |= {
            column.name: [values[label] for label in rows[column.along]]
            for column, values in sweep.case_table.coordinates.items()
        }
        scenes = [case.scene for case in sweep._on_first_surface]
        if self.prefix:
            kept = (
                stations.kept(sweep.case(name).scene, load, velocity)
                for load, velocity, name in self._points
            )
        else:
            ramps = {ramp_of(scene): scene for scene in scenes}.values()
            kept = (stations.kept(*one) for one in itertools.product(ramps, sweep.loads))
        values = {
            "load": [*sweep.loads],
            "velocity": [*sweep.velocities],
            **rows,
            self.step: [*range(1 - max(map(len, kept)), 1)],
            "cooler_share": [*QUANTILES],
            "x": scenes[0].grid.coordinates(0).tolist(),
            "y": scenes[0].grid.coordinates(1).tolist(),
        }
        return {name: one for name, one in values.items() if name in variables_of(sweep)}

    @cached_property
    def _points(self) -> list[Point]:
        """Points of a group of tests: each row has its own load and velocity."""
        return [
            Point(float(row["load"]), float(row["velocity"]), name)
            for name, row in self.sweep.case_table.by_name.items()
        ]

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """Variables of the group by name."""
        return variables_of(self.sweep) | inputs_variable(sizes_of(self.inputs))

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Lengths of the dimensions."""
        lengths = {name: len(values) for name, values in self.axes.items()}
        return lengths | {DIM: sum(sizes_of(self.inputs).values())}

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the points."""
        return self.variables["status"].dims

    @cached_property
    def _seeds(self) -> list[int]:
        """Places in `dims` of the seeds of random surfaces."""
        return [place for place, dim in enumerate(self.dims) if dim in self.seeds]

    @cached_property
    def seeds(self) -> frozenset[str]:
        """Dimensions of surface realizations, of which one alone has fields."""
        return frozenset(one.name for one in self.sweep.case_table.columns if one.is_seed)

    @cached_property
    def field_index(self) -> int:
        """Index of the surface realization whose points have fields: one for all cases."""
        kept = self.sweep.field_surface
        places = (self.axes[dim].index(kept) for dim in self.seeds if kept is not None)
        return max(places, default=0)

    def have_fields(self, where: Indices) -> Mask:
        """True for points with fields: those on one surface of each case.

        `where` has an index along each of `dims` for each point, shape (n, n_dim).
        """
        on_it: Mask = (where[:, self._seeds] == self.field_index).all(axis=1)
        return on_it & bool(self.sweep.fields)

    def field_places(self, where: Indices) -> Indices:
        """Indices of points along the dimensions of fields, which lack those of surfaces."""
        return np.delete(where, self._seeds, axis=1)

    @cached_property
    def arrays(self) -> dict[str, Document]:
        """Zarr metadata of the arrays, by name."""
        one_each, block = dict.fromkeys(self.dims, 1), self._block()
        return {
            name: array_document(
                one,
                self.sizes,
                {}
                if is_coordinate(name) or name == "status"
                else one_each
                if name in FIELDS
                else block,
                self.keys,
            )
            for name, one in self.variables.items()
        }

    def _block(self) -> dict[str, int]:
        """Number of points in a chunk along each dimension; a field is a chunk of its own."""
        most = max(
            8 * math.prod(self.sizes[dim] for dim in one.dims if not is_of_points(dim))
            for name, one in self.variables.items()
            if not (name in FIELDS or is_coordinate(name))
        )
        return chunk_sizes({dim: self.sizes[dim] for dim in self.dims}, most)

    def paths(self) -> dict[str, Document]:
        """Zarr metadata of the arrays, by path in the store."""
        return {self.prefix + path_of(name): array for name, array in self.arrays.items()}

    @cached_property
    def coordinates(self) -> dict[str, Any]:
        """Values of coordinates, and of the arrays from the scene's files, by name."""
        values: dict[str, Any] = self.axes | _made_coordinates(self)
        if self.inputs:
            values[INPUTS] = np.concatenate([array.ravel() for array in self.inputs.values()])
        return values

    def points_at(self, where: Sequence[Indices]) -> list[Point]:
        """Points at some indices; `where` has an array for each of `dims`, as from `nonzero`."""
        names, columns = [*PLANE, *self.sweep.case_table.axes], []
        for name in names:
            numbers = where[self.dims.index(self.variables[name].dims[0])]
            columns.append([self.axes[name][number] for number in numbers.tolist()])
        return [
            Point(load, velocity, tuple(zip(names[2:], labels, strict=True)))
            for load, velocity, *labels in zip(*columns, strict=True)
        ]

    def scene_hash(self, point: Point) -> str:
        """SHA-256 of the scene that is simulated at a point."""
        return self.sweep._scene_hashes[point.case]

    def in_words(self, point: Point) -> str:
        """Write a point as text, such as "400 N, 2 m/s, pin.radius 2 mm", or "…, test 1"."""
        if self.prefix:
            number = int(self.sweep.case_table.by_name[point.case][TEST])
            test = "an earlier test" if number == NO_TEST else f"test {number + 1}"
            return f"{point._replace(case=())}, {test}"
        words = self.sweep.case_table.in_words(point.case)
        return str(point._replace(case=tuple(words.items())))


@dataclass(frozen=True, eq=False)
class Root:
    """What a store holds: the points of its plane, and of its tests."""

    plane: Group
    tests: Group | None  # None without tests
    history: tuple[str, ...]  # versions of the programs that computed, and accuracies asked for
    plain: Any  # data of the sweep, for JSON

    @classmethod
    def of(
        cls, sweep: Sweep, history: Sequence[str], keys: str = KEYS[0], stored: Any = None
    ) -> Root:
        """The root of the store of a sweep, whose chunks have `keys`.

        `stored` has the sweep's plain data and arrays, if these were read from a store.
        """
        tests, (plain, arrays) = None, stored or plain_sweep(sweep)
        if sweep.tests or sweep.former:
            own = sweep_of_tests(sweep, judges_holds(sweep))
            tests = Group(own, prefix=f"{OF_TESTS}/", keys=keys)
        return cls(Group(sweep, arrays, keys=keys), tests, tuple(dict.fromkeys(history)), plain)

    @property
    def sweep(self) -> Sweep:
        """The sweep that the store is of."""
        return self.plane.sweep

    @property
    def groups(self) -> list[Group]:
        """The plane, and the tests if there are any."""
        return [self.plane, *([self.tests] if self.tests else [])]

    @property
    def goal(self) -> str:
        """Option of the last new accuracy that the store was run for; empty without one."""
        goals = [line for line in self.history if line.startswith(GOAL)]
        return goals[-1].removeprefix("run with ") if goals else ""

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the dataset: texts for people, of which nothing is read."""
        return {
            "Conventions": "CF-1.11",
            "title": self.sweep.title,
            "source": _SOURCE,
            "history": "\n".join(self.history),
            "license": "BSD-3-Clause for the program; the data are their author's",
            "scene": self.sweep.text,
            "stored_steps": choose_stations(self.sweep).steps,
        }

    def documents(self) -> dict[str, Document]:
        """Documents of all arrays and groups, by key; that of the group ``about`` is the last."""
        facts: Document = {
            "format": FORMAT,
            "history": [*self.history],
            "keys": self.plane.keys,
            "inputs": sizes_of(self.plane.inputs),
            "sweep": self.plain,
            "scene": self.sweep.text,
        }
        facts["digest"] = _digest(facts)
        found = {AT_ENDS: _group({})} if self.sweep.fields else {}
        for group in self.groups:
            found |= {f"{group.prefix}{ABOUT}": _group({}), **group.paths()}
        if self.tests:
            found[OF_TESTS] = _group({})
        found[ABOUT] = _group(facts)
        # Zarr finds the members of a group only where they stand side by side.
        members = {path: found[path] for path in sorted(found, key=lambda p: p.rpartition("/")[0])}
        whole = {"kind": "inline", "must_understand": False, "metadata": members}
        keys = {f"{path}/{ROOT}": one for path, one in found.items()}
        return {ROOT: _group(self.attributes) | {_COPY: whole}} | keys


def sizes_of(arrays: Mapping[str, Array]) -> dict[str, int]:
    """Number of values of each array."""
    return {digest: array.size for digest, array in arrays.items()}


def _group(attributes: Document) -> Document:
    return {"zarr_format": 3, "node_type": "group", "attributes": attributes}


def _digest(facts: Mapping[str, Any]) -> str:
    """SHA-256 of the facts without their own digest."""
    said = [facts[name] for name in ("format", "history", "inputs", "keys", "sweep")]
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()


# Reading


def read_root(place: StorePlace) -> Root:
    """Read what a store holds; `StoreError` if it is missing, damaged or of another version."""
    if root := find_root(place):
        return root
    if holder := holder_of(place):
        raise StoreError(f"{place} is being made by {holder}; try again in a few seconds")
    near = ""
    if isinstance(place, Folder) and not place.path.exists():
        if place.beside(NEW).path.exists():
            raise StoreError(f"a run was cut short as it made {place}; run its scene again")
        near = path_hint(place.path)
    raise StoreError(f"there is no store at {place}{near}; run a scene into it, or give another")


def find_root(place: StorePlace) -> Root | None:
    """Read what a store holds; None for an empty place, `StoreError` for other content."""
    with io_errors(place):
        content = read_document(place, FACTS)
        keys = place.keys() if content is None else set()
    if content is not None:
        return _parsed(place, content)
    is_file = isinstance(place, Folder) and place.path.exists() and not place.path.is_dir()
    if is_file or not (keys <= {LOCK} or _is_begun(place, keys)):
        raise StoreError(f"{place} is no store: {_what_it_is(place, keys)}")
    return None


def _is_begun(place: StorePlace, keys: set[str]) -> bool:
    """True for what a creation that was cut short may leave on an object store: no results."""
    try:
        source = json.loads(read_document(place, ROOT) or b"")["attributes"]["source"]
    except (ValueError, KeyError, TypeError):
        return False
    names = {key.rpartition("/")[0].rpartition("/")[2] for key in keys if not key.endswith(ROOT)}
    return (
        isinstance(place, Bucket)
        and source == _SOURCE
        and all(is_coordinate(name) or name == "status" for name in names)
    )


def _parsed(place: StorePlace, content: bytes) -> Root:
    """The root from its document. Whatever is wrong with it, a `StoreError` says so in a line."""

    def is_damaged(why: object) -> StoreError:
        return StoreError(f"{place}: its {FACTS} is damaged ({f'{why}'[:300]}); {_ELSEWHERE}")

    try:
        facts = json.loads(content)["attributes"]
        version, by = facts["format"], [str(line) for line in facts["history"]]
        plain, sizes, text = facts["sweep"], dict(facts["inputs"]), str(facts["scene"])
        keys = facts["keys"]
        is_whole = version == FORMAT and keys in KEYS and facts["digest"] == _digest(facts)
        is_whole &= all(type(size) is int and 0 < size < 2**40 for size in sizes.values())
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise is_damaged(f"{type(error).__name__} {error}") from error
    if version != FORMAT:
        raise StoreError(
            f"{place}: its {FACTS} is of format {version!r:.20}, and this program reads {FORMAT}; "
            "run the scene into another store, or read it by the version that made it"
            + f" ({by[-1]:.200})"
            * bool(by)
        )
    if not is_whole:
        raise is_damaged("it is not what was written")
    try:  # anybody can write such a document; other errors are faults of this program
        arrays = _read_inputs(place, sizes, keys)
        sweep = replace(sweep_of_plain(plain, arrays), text=text)
        root = Root.of(sweep, by, keys, (plain, arrays))
        for group in root.groups:
            _ = group.arrays, group.coordinates, group.field_index
    except StoreError:
        raise
    except (TriboError, ValueError, ArithmeticError) as error:
        raise is_damaged(error) from error
    return root


def _read_inputs(place: StorePlace, sizes: dict[str, int], keys: str) -> dict[str, Array]:
    """Contents of the scene's files by SHA-256; `sizes` has the number of values of each."""
    if not sizes:
        return {}
    (one,) = inputs_variable(sizes).values()
    document = array_document(one, {DIM: sum(sizes.values())}, {}, keys)
    array = open_arrays(place.zarr, {INPUTS: document})[INPUTS]
    with read_errors(place, INPUTS):
        return split_arrays(array[:], one.attributes)


def _what_it_is(place: StorePlace, keys: set[str]) -> str:
    """What a path leads to that is no store, and what to do."""
    if not keys:
        suffix = PurePath(str(place)).suffix
        if suffix == ".toml":
            return "it is a scene; compute it by irg run, and give the store that this makes"
        return "it is no folder; give the folder that irg run has made"
    if inner := sorted(key for key in keys if key.endswith(f"/{FACTS}")):
        return f"it is a folder of stores; give one of them, such as {inner[0].split('/')[0]}"
    if ROOT in keys:
        return f"it is of another program, or has lost its {FACTS}; {_ELSEWHERE}"
    return "it is a folder with other files; give the folder that irg run has made, or a new one"


def stale_documents(place: StorePlace, root: Root) -> dict[str, Document]:
    """Documents that are not as the root has them, by key, as they ought to be.

    Attributes and arrays that users added stay. On an object store only those of the whole are
    compared, since each is a request.
    """
    stale = dict[str, Document]()
    for key, right in root.documents().items():
        if isinstance(place, Bucket) and key not in (ROOT, FACTS):
            continue
        try:
            whole = _with_additions(found := json.loads(read_document(place, key) or b"{}"), right)
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            found, whole = {}, right
        if whole != found:
            stale[key] = whole
    return stale


def _with_additions(found: Document, right: Document) -> Document:
    """A document as it ought to be, with what users added to it, as it was `found`."""
    whole = found | right | {"attributes": found.get("attributes", {}) | right["attributes"]}
    if found and _COPY in right:  # Zarr drops its copy of all metadata if a user adds an array
        whole[_COPY], theirs = found.get(_COPY), (found.get(_COPY) or {}).get("metadata", {})
        if theirs:
            own = right[_COPY]["metadata"].items()
            merged = {path: _with_additions(theirs.get(path, {}), one) for path, one in own}
            whole[_COPY] = right[_COPY] | {"metadata": theirs | merged}
    return whole


# Coordinates and chunks


def _made_coordinates(group: Group) -> dict[str, Array]:
    """Time [s], load [N] and sliding distance [m] at each step, which follow from the scene.

    They are NaN at unused steps before the first step of a point.
    """
    sweep, axes, wanted = group.sweep, group.axes, group.variables
    stations, dims = choose_stations(sweep), wanted["time"].dims

    @functools.cache
    def known(name: CaseName, load: float, velocity: float | None) -> list[Any]:
        kept = stations.kept(sweep.case(name).scene, load, velocity)
        lacking = [(math.nan,) * 3] * (group.sizes[group.step] - len(kept))
        slid = [math.nan if one.slid is None else one.slid for one in kept]
        steps = zip(kept, slid, strict=True)
        return lacking + [(step.time, step.normal_load, way) for step, way in steps]

    def along(dims: Sequence[str], values: Any) -> Any:
        return xr.Variable(dims, np.reshape(values, [group.sizes[dim] for dim in dims]))

    own = TEST_POINT in axes  # a test may have stages of velocity
    sizes = [group.sizes[dim] if dim in dims else 1 for dim in group.dims]
    ramps = [
        known(point.case, point.load, point.velocity if own else None)
        for point in group.points_at(np.nonzero(np.ones(sizes)))
    ]
    time, normal_load, way = (along(dims, one) for one in np.moveaxis(np.array(ramps), -1, 0))
    speed: Any = xr.Variable(wanted["velocity"].dims, np.abs(axes["velocity"]))
    made = {
        "time": time,
        "normal_load": normal_load,
        "sliding_distance": way.where(way.notnull(), speed * time) if own else speed * time,
    }
    lengths = {name: {dim: group.sizes[dim] for dim in wanted[name].dims} for name in made}
    return {name: array.set_dims(lengths[name]).values for name, array in made.items()}


def chunk_sizes(sizes: Mapping[str, int], bytes_of_a_point: int) -> dict[str, int]:
    """Number of points in a chunk along each dimension: all loads, then velocities, then rows.

    `sizes` are the lengths of the dimensions, and `bytes_of_a_point` is for the largest variable.
    """
    room, block = min(max(_LARGEST // bytes_of_a_point, 1), _MOST), dict[str, int]()
    for dim in sorted(sizes, key=lambda dim: (dim != "load", dim != "velocity")):
        block[dim] = max(1, min(sizes[dim], room // math.prod(block.values())))
    return block


def blocks(mask: Mask, sizes: Sequence[int]) -> Iterator[tuple[tuple[int, ...], Slices]]:
    """Yield index and slices of each chunk with at least one point where `mask` is True.

    `sizes` are the numbers of points in a chunk along each dimension.
    """
    for chunk in np.ndindex(*(-(-n // size) for n, size in zip(mask.shape, sizes, strict=True))):
        block = tuple(slice(i * n, (i + 1) * n) for i, n in zip(chunk, sizes, strict=True))
        if mask[block].any():
            yield chunk, block
