"""A root that was lost or damaged, made again from its scene and from what lies beside it.

The coordinates and the metadata of each array have files of their own. The rest is the scene's, and
whether that scene made the store is told by the checksums of its points, of which each includes the
hash of what was simulated.
"""

from __future__ import annotations

import json
import time
from typing import Any

from pipeline.store.attributes import root_attributes
from pipeline.store.layout import arrays_of
from pipeline.store.lock import held
from pipeline.store.place import (
    ROOT,
    PathLike,
    Place,
    StoreError,
    StoreMismatchError,
    place_of,
    reads,
    writes,
)
from pipeline.store.root import LostRootError, Root, find_root, require_likely, root_document
from pipeline.store.schema import is_coordinate, variables_of
from pipeline.store.verify import examined
from pipeline.store.write import Store
from pipeline.sweep.model import Sweep


def restore_root(path: PathLike, sweep: Sweep) -> bool:
    """Make a root that is lost again, and return whether it was.

    Raise a `StoreMismatchError`, and write nothing, if the sweep did not make the store.
    """
    place = place_of(path)
    try:
        find_root(place)
    except LostRootError as error:
        with held(place):
            root = _remade(place, sweep, error)
            with writes(place):
                place.put({ROOT: root_document(root.attributes, root.arrays)})
        return True
    return False


def _remade(place: Place, sweep: Sweep, lost: StoreError) -> Root:
    """The root as the sweep says, if the points of the store agree."""
    with_fields = place.read(f"pressure/{ROOT}") is not None
    try:
        arrays = {name: _metadata(place, name) for name in variables_of(sweep, with_fields)}
        opened = arrays_of(place, arrays, read_only=True)
        axes = {name: _values(place, name, opened) for name in arrays if is_coordinate(name)}
        stations = json.loads(arrays["step"]["attributes"]["stations"])
    except (ValueError, KeyError, TypeError, StoreError) as error:
        raise StoreError(f"{lost}; it cannot be made again: {error}") from error
    sweep = sweep.changed(stations=stations)
    status = opened["status"]
    attributes = root_attributes(sweep, None) | {
        "axes": axes,
        "stations": stations,
        "points_per_chunk": dict(zip(status.metadata.dimension_names, status.chunks, strict=True)),
        "generation": int(time.time()),  # whoever opened it before opens it again
    }
    root = Root(json.loads(json.dumps(attributes)), arrays)
    require_likely(place, root)
    try:
        verification = examined(Store(place, root, is_damaged=True), repair=False)
        agrees = verification.done > 0 or not verification.damaged
    except KeyError:  # of values that the sweep does not have
        agrees = False
    if not agrees:
        raise StoreMismatchError(
            f"{place} has lost its {ROOT}, and its points are not those of this scene; give the "
            "scene that made it, with all its values, or write to another store"
        )
    return root


def _metadata(place: Place, name: str) -> Any:
    content = place.read(f"{name}/{ROOT}")
    if content is None:
        raise KeyError(f"{name}/{ROOT} is lost")
    return json.loads(content)


def _values(place: Place, name: str, arrays: dict[str, Any]) -> list[Any]:
    with reads(place, name):
        return [*map(_plain, arrays[name][:].tolist())]


def _plain(value: Any) -> Any:
    return value if isinstance(value, int | float) else str(value)
