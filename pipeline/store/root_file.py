"""Reading the root of a store, which is checked before it is believed."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import PurePath
from typing import Any

from pipeline.paths import path_hint
from pipeline.scene.resume import misfits
from pipeline.scene.stored_text import SweepTextError, parse_sweep
from pipeline.store.arrays import Document, array_documents, open_arrays
from pipeline.store.files import PARTIAL
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
from pipeline.store.root import CONSOLIDATED, Root, TestLayout, digest_of
from pipeline.store.schema import (
    ABOUT,
    DIM,
    FORMAT,
    INPUTS,
    inputs_variable,
    is_coordinate,
    split_arrays,
)
from pipeline.sweep.model import Sweep
from pipeline.sweep.points_of_tests import NO_TEST, Slot
from tribo.loading.ramp import MOST_STEPS
from tribo.types import Array

_ELSEWHERE = "restore it from a backup, or run the scene into another store"


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
    is_no_folder = isinstance(place, Folder) and place.path.exists() and not place.path.is_dir()
    if is_no_folder or not all(map(_is_left_over, keys)):
        raise StoreError(f"{place} is no store: {_what_it_is(place, keys)}")
    return None


def _what_it_is(place: StorePlace, keys: set[str]) -> str:
    """What a path leads to that is no store, and what to do."""
    if not keys:
        suffix = PurePath(str(place)).suffix
        if suffix == ".toml":
            return "it is a scene; compute it by irg run, and give the store that this makes"
        return "it is no folder; give the folder that irg run has made"
    if f"{ABOUT}/{ROOT}" in keys:
        return f"it has lost its {ROOT}; {_ELSEWHERE}"
    if inner := sorted(key for key in keys if key.endswith(f"/{ABOUT}/{ROOT}")):
        return f"it is a folder of stores; give one of them, such as {inner[0].split('/')[0]}"
    return "it is a folder with other files; give the folder that irg run has made, or a new one"


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
        if ABOUT not in metadata and "scene" not in document["attributes"]:
            fault = "that of another program; give a store that irg run has made"
        if "scene" in document["attributes"] and ABOUT not in metadata:
            fault = "that of a copy by xarray, which is no store"
        found = metadata[ABOUT]["attributes"]
        version = found["format"]
        is_own = version == FORMAT and found["digest"] == digest_of(found)
        if is_own and _are_facts(found):
            facts = found
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    if version != FORMAT:
        fault = (
            f"of another version of this program: of format {version}, and not {FORMAT}; run the "
            "scene into another store, or read it by the version that made it"
        )
    # From here on only errors that speak of the store: a fault of this program is not damage.
    if facts:
        tests = facts["tests"]
        try:
            root = Root(
                sweep=parse_sweep(facts["scene"], _read_inputs(place, facts["inputs"])),
                text=facts["scene"],
                axes=facts["axes"],
                block=facts["points_per_chunk"],
                field_block=facts["points_per_field_chunk"],
                history=facts["history"],
                layout=tests and TestLayout([Slot(*slot) for slot in tests[0]], *tests[1:]),
                found=document,
            )
            if _fit_axes(root):
                return root
        except (SweepTextError, DamagedError) as error:
            fault = f"{fault} ({error})"
    is_damaged = "damaged" in fault
    raise StoreError(f"{place}: its {ROOT} is {fault}" + f"; {_ELSEWHERE}" * is_damaged)


def _are_facts(facts: Any) -> bool:
    """True if `facts` have the types that `Root.documents` writes."""
    axes, sizes = facts["axes"].values(), [*facts["inputs"].values()]
    for name in ("points_per_chunk", "points_per_field_chunk"):
        sizes += facts[name].values()
    return (
        all(isinstance(one, list) for one in [*axes, facts["history"]])
        and all(isinstance(one, str | int | float) for labels in axes for one in labels)
        and all(isinstance(one, int) for one in sizes)
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
    numbers = range(NO_TEST, len(root.sweep.tests))
    if root.layout and not all(slot.test in numbers for slot in root.layout.slots):
        return False
    return needed <= root.axes.keys() <= names and root.block.keys() == root.field_block.keys() == {
        *dims
    }


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
    if differing := [*misfits(root.sweep, sweep, root.goal)]:
        advice = "give it what the store has, or write to another store"
        raise StoreMismatchError(
            "\n  ".join([f"{place} belongs to another scene; {advice}", *differing])
        )


def find_sweep(path: PathLike) -> Sweep | None:
    """Read the sweep of a store; None for an empty place, `StoreError` for other content."""
    root = find_root(place_of(path))
    return root.sweep if root else None
