"""What a sweep has computed, as plain arrays: what the boundary and its like are found from.

An opened dataset gives them, and so does a store itself, for the commands that show a few numbers:
the libraries of labelled data would take most of their time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.interpolation import interpolated
from pipeline.store import DONE, Finished
from pipeline.store.identity import simulated_inputs
from pipeline.store.remote import Remote
from pipeline.store.variables import LEADING, RECORDS, chosen_of, is_coordinate
from pipeline.sweep import criterion
from pipeline.sweep.chosen import Chosen
from pipeline.sweep.criterion import Conditions, worst_moment
from pipeline.sweep.unknown import first_alike
from tribo import InputError
from tribo.thermal import rise_exceeded
from tribo.types import Array, Indices, Mask

if TYPE_CHECKING:
    import xarray as xr

    Source = xr.Dataset | str | PathLike[str] | Remote

_READ = 2**23  # [B] of rises that are read at a time
_ORDER = ("load", "velocity", "step", "bulk_ratio", "quantile")


@dataclass(frozen=True, eq=False)
class Results(Mapping[str, Any]):
    """Variables of a sweep on one surface, by name; of several, those of each of its `parts`.

    Each has the dimensions load, velocity, step, bulk_ratio and quantile, as far as it has them.

    Attributes
    ----------
    source : Dataset or path
        Where they come from.
    attrs : mapping
        Attributes of the sweep; see `pipeline.analysis.attributes.attributes_of`.
    loads : ndarray
        Normal loads on the whole pin, ascending [N].
    velocities : ndarray
        Sliding velocities, ascending [m/s].
    leading : str or None
        What there are several of: ``"realization"``, ``"sample"`` or nothing.
    places : tuple of mapping
        Of each surface or sample, in order: its seed or number, and inputs by their paths.
    names : collection of str
        Names of the variables.
    read : callable
        Called with a name and the numbers of some surfaces, None if there are no several; returns
        the variable, the surfaces first.
    size : float
        Size of the rises of one surface [B].
    """

    source: Source
    attrs: Mapping[Any, Any]
    loads: Array
    velocities: Array
    leading: str | None
    places: tuple[Mapping[str, Any], ...]
    names: Collection[str]
    read: Callable[[str, range | None], Any]
    size: float
    _kept: dict[str, Any] = field(default_factory=dict, repr=False)
    _chosen: list[Chosen | None] = field(default_factory=list, repr=False)

    @classmethod
    def of(cls, source: Source | Results) -> Results:
        """Results of a dataset of `pipeline.open_sweep`, or of a store.

        Raises
        ------
        StoreError
            If there is no readable store.
        """
        if isinstance(source, Results):
            return source
        if isinstance(source, str | PathLike | Remote):
            return _of_store(source)
        return _of_dataset(source)

    def __getitem__(self, name: str) -> Any:
        """Values of a variable; they are kept."""
        if name not in self._kept:
            self._kept[name] = self.read(name, None)
        return self._kept[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def parts(self) -> Iterator[Results]:
        """Each surface or sample alone; the sweep as it is if it has neither.

        What has steps is read for many at a time, and goes with them, so that there is memory for
        the next. To read it for each alone would take as long for each as to look at the root of
        the store.
        """
        if self.leading is None:
            yield self
            return
        step = max(1, int(_READ // max(self.size, 1)))
        for begin in range(0, len(self.places), step):
            numbers = range(begin, min(begin + step, len(self.places)))
            block: dict[str, Any] = {}
            yield from (self._part(number, numbers, block) for number in numbers)

    def _part(self, number: int, numbers: range, block: dict[str, Any]) -> Results:
        """One surface, of which a block has been read, or is to be."""
        every = range(len(self.places))

        def read(name: str, _: range | None) -> Any:
            if is_coordinate(name):
                return self[name]
            of_all = name in RECORDS and name != "message"  # those of all take much memory
            kept, rows = (self._kept, every) if of_all else (block, numbers)
            if name not in kept:
                kept[name] = self.read(name, rows)
            return kept[name][number - rows.start]

        return replace(self, leading=None, places=(self.places[number],), read=read, _kept={})

    @property
    def place(self) -> Mapping[str, Any]:
        """Seed or number of the one surface or sample, and its inputs by their paths."""
        return self.places[0]

    def on_surface(self, realization: int) -> Results:
        """The sweep on one of its surfaces.

        Raises
        ------
        InputError
            If the sweep does not hold that surface.
        """
        seeds = [place["realization"] for place in self.places if self.leading == "realization"]
        require_surface(realization, seeds)
        number = seeds.index(realization)
        return self._part(number, range(number, number + 1), {})

    def moving(self) -> Results:
        """The sweep without its points at velocity 0."""
        read, moves = self.read, self.velocities > 0

        def moving(name: str, numbers: range | None) -> Any:
            values = read(name, numbers)
            return values if is_coordinate(name) else values.compress(moves, 1 + bool(numbers))

        return replace(self, velocities=self.velocities[moves], read=moving, _kept={})

    def at(self, conditions: Conditions) -> Results:
        """One surface with the rises at the bulk temperatures of some conditions.

        Raises
        ------
        InputError
            If these are not equal, and the sweep was computed for equal ones.
        """
        if conditions.bulk_ratio == 0:
            return self
        return replace(
            self, _kept=self._kept | {"rise_quantile": criterion.at_bulks(self, conditions)}
        )

    def asked(self) -> Mask:
        """Which points of one surface the last run asked for: all of its scene, or those it chose.

        The other points in the store were asked for by an earlier run.
        """
        if not self._chosen:
            self._chosen.append(chosen_of(attributes_of(self)))
        names = ("realization", "simulation" if "simulation" in self.place else "sample")
        surface, sample = map(self.place.get, names)
        if (chosen := self._chosen[0]) is None:
            scene = attributes_of(self)
            loads = np.isin(self.loads, scene.get("loads", self.loads))
            velocities = np.isin(self.velocities, scene.get("velocities", self.velocities))
            on_surface = surface is None or surface in (scene.get("realizations") or [surface])
            return on_surface & loads[:, None] & velocities
        over = chosen.over([(surface, sample)], self.loads.tolist(), self.velocities.tolist())
        asked: Mask = over[0]
        return asked


class Plane(NamedTuple):
    """Decisive rises [K], shape (n_load, n_velocity), over loads [N] and velocities [m/s]."""

    loads: Array
    velocities: Array
    rises: Array

    def refined(self, resolution: int, continued: bool) -> Plane:
        """Interpolate; see `pipeline.analysis.boundary.decisive_rise`."""
        (loads, velocities, r), (first, last) = self, (0, -1)
        fine = np.linspace(velocities[first], velocities[last], resolution)
        r = np.array([interpolated(velocities, row, fine, continued) for row in r])
        velocities, fine = fine, np.linspace(loads[first], loads[last], resolution)
        r = np.array([interpolated(loads, column, fine) for column in r.T]).T
        return Plane(fine, velocities, r)


def decisive_plane(part: Results, share: float) -> Plane:
    """Decisive rise on one surface; see `pipeline.analysis.boundary.decisive_rise`."""
    rises = rise_exceeded(part["rise_quantile"], share, part["quantile"])
    rises = np.where(part["status"][..., None] == DONE, rises, np.nan)
    worst = worst_moment(rises, part["normal_load"], part.loads[:, None, None])
    r = np.take_along_axis(rises, worst[..., None], axis=-1)[..., 0]
    return Plane(part.loads, part.velocities, r)


def require_surface(realization: int, seeds: Sequence[int]) -> None:
    """Raise an `InputError` if a sweep over surfaces of these seeds does not hold one."""
    if realization not in seeds:
        held = f"it holds {', '.join(map(str, seeds))}" if seeds else "its scene gives no others"
        raise InputError(f"realization is {realization}, which the sweep does not hold; {held}")


def _of_dataset(ds: xr.Dataset) -> Results:
    name = next((each for each in LEADING if each in ds.dims), None)
    axes = {each: ds[each].values for each in (name, "load", "velocity") if each}
    order = _ascending(axes)
    dims = ((name,), ())
    own = {str(key): ds[key].values for key in ds.coords if ds[key].dims in dims}
    rows = order[name].tolist() if name else [0]
    places = (
        {key: values[row if values.ndim else ()].item() for key, values in own.items()}
        for row in rows
    )

    def read(variable: str, numbers: range | None) -> Any:
        found = ds[variable]
        index: dict[str, Any] = {at: order[at] for at in order if at in found.dims}
        if name in index and numbers is not None:
            index[name] = order[name][numbers]
        dims = (name, *_ORDER) if name else _ORDER
        return found.isel(index).transpose(*dims, missing_dims="ignore").values

    rises = ds.get("bulk_rise_quantile", ds["rise_quantile"])
    return Results(
        source=ds,
        attrs=ds.attrs,
        loads=axes["load"][order["load"]],
        velocities=axes["velocity"][order["velocity"]],
        leading=name,
        places=tuple(places),
        names={str(variable) for variable in ds.variables},
        read=read,
        size=rises.nbytes / len(rows),
    )


def _ascending(axes: Mapping[str, Array]) -> dict[str, Indices]:
    """Indices that sort the axes, which a store keeps in the order in which they grew."""
    return {name: np.argsort(values, kind="stable") for name, values in axes.items()}


def _of_store(source: str | PathLike[str] | Remote) -> Results:
    store = Finished(source)
    name = next((each for each in LEADING if each in store.axes), None)
    axes = {each: np.array(store.axes[each]) for each in (name, "load", "velocity") if each}
    order = _ascending(axes)
    places: list[dict[str, Any]] = [{}]
    shared: tuple[int, ...] = (0,)
    if name:
        dims = {each: metadata["dimension_names"] for each, metadata in store.metadata.items()}
        own = {each: values for each, values in store.axes.items() if dims[each] == [name]}
        numbers = order[name].tolist()
        places = [{each: values[at] for each, values in own.items()} for at in numbers]
        shared = tuple(range(len(places)))
    if name == "sample":
        columns = [[place[path] for place in places] for path in simulated_inputs(store.attributes)]
        if (alike := first_alike(len(places), columns)) != shared:
            places = [{**each, "simulation": at} for each, at in zip(places, alike, strict=True)]
            shared = alike

    def read(variable: str, numbers: range | None) -> Any:
        if is_coordinate(variable):
            return np.array(store.axes[variable])
        picks = [order["load"], order["velocity"]]
        if name and numbers is not None:
            picks = [order[name][np.array(shared)[numbers]], *picks]
        shape = store.shape(variable)
        return store.pick(variable, [*picks, *map(np.arange, shape[len(picks) :])])

    largest = "bulk_rise_quantile" if "bulk_rise_quantile" in store.metadata else "rise_quantile"
    return Results(
        source=source,
        attrs=store.attributes,
        loads=axes["load"][order["load"]],
        velocities=axes["velocity"][order["velocity"]],
        leading=name,
        places=tuple(places),
        names=store.metadata.keys(),
        read=read,
        size=8 * math.prod(store.shape(largest)) / len(places),
    )
