"""`Results`: the results of a sweep as typed arrays, which every answer takes."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.columns import taken
from pipeline.analysis.dataset import (
    Layout,
    Origin,
    judged_sweep,
    name_at,
    require_kind,
    require_one_scene,
)
from pipeline.analysis.likelihood import Prior
from pipeline.analysis.results_of_tests import TestResults
from pipeline.store.place import StoreError
from pipeline.store.read import open_messages
from pipeline.store.schema import COORDINATES, DONE, FAILED, PENDING, PLANE
from pipeline.sweep.case import Test
from pipeline.sweep.conditions import DIMENSIONS, Conditions, changed_conditions
from pipeline.sweep.stations import load_that_counts
from pipeline.sweep.sweep import Point, Sweep
from pipeline.sweep.variants import VARIANT, Label, Variant
from tribo import InputError
from tribo.simulation.corrections import NEEDED
from tribo.simulation.severity import columns_needed, require_bulks, worst_rises
from tribo.types import Array, Mask

_UNNAMED = COORDINATES.keys() - {VARIANT, "realization"}


@dataclass(frozen=True, eq=False)
class Results:
    """Results of a sweep, or of one of its scenes, as arrays.

    A row is one combination of varied entries and surface.

    Attributes
    ----------
    stored : Sweep
        The whole sweep as it was stored, without changes by `pipeline.at`.
    judged : mapping
        Conditions that `pipeline.at` changed: new values in SI, by the path of their scene entry.
    kind : Layout
        Whether points form a grid of loads and velocities, or are listed pairs.
    front : tuple of str
        Names of the dimensions of rows: entries with several values, then surfaces.
    rows : Dataset
        Values of entries and surfaces that identify the rows, as coordinates.
    loads, velocities : ndarray
        Ascending loads [N] and velocities [m/s] of the points.
    cut : tuple of str
        The names "load" and "velocity", as far as they are scalars in the dataset.
    columns : mapping
        Variables by name. Their axes are those of `front`, then load and velocity, then those of
        three more that the variable has: step of the load, ``bulk_ratio`` (disk's − pin's bulk
        temperature, divided by friction [K]), and ``cooler_share`` (see `shares`).
    shares : ndarray
        Shares of the contact area that are cooler than the quantiles of the rise.
    tests : TestResults
        Results at the points of the scene's tests.
    rest : Dataset
        Variables that verdicts do not need, such as fields of the contact, which are read when
        shown; also the attributes and further coordinates of the dataset.
    """

    stored: Sweep
    judged: Mapping[str, Any]
    kind: Layout
    front: tuple[str, ...]
    rows: xr.Dataset
    loads: Array
    velocities: Array
    cut: tuple[str, ...]
    columns: Mapping[str, Array] = field(repr=False)
    shares: Array = field(repr=False)
    tests: TestResults = field(repr=False)
    rest: xr.Dataset = field(repr=False)
    store: str | None = field(repr=False)  # address of the store, which has the messages
    origin: Origin = field(repr=False)

    def __repr__(self) -> str:
        sizes = {name: self.rows.sizes[name] for name in self.front if name in self.rows.sizes}
        sizes |= {"load": len(self.loads), "velocity": len(self.velocities)}
        words = ", ".join(f"{name} {size}" for name, size in sizes.items())
        return f"Results: {self.stored.title} ({words})"

    @property
    def entry_dims(self) -> tuple[str, ...]:
        """Names of dimensions of varied entries, or of table rows, not of surfaces."""
        return tuple(name for name in self.front if name != "realization")

    @property
    def judged_dims(self) -> list[str]:
        """Names of dimensions of conditions for which `pipeline.at` was given several values."""
        columns = {column.name for column in self.stored.variants.columns}
        return [one for one in self.entry_dims if one in DIMENSIONS and one not in columns]

    @property
    def labels(self) -> dict[str, Label]:
        """Coordinates with a single value, by name: entries, seed of surface, row of a table."""
        found = {str(name): one for name, one in self.rows.coords.items() if not one.ndim}
        return {name: one.item() for name, one in found.items() if name not in _UNNAMED}

    @property
    def surface(self) -> Variant:
        """Tuple of the pair ("realization", seed) if one surface is selected; else empty."""
        return tuple((name, seed) for name, seed in self.labels.items() if name == "realization")

    @property
    def place(self) -> tuple[float, float] | None:
        """Load [N] and velocity [m/s] if a single pair of them is selected; else None.

        A grid with a dimension of load or velocity does not count, even if its size is 1.
        """
        is_row = self.kind is Layout.PLACES and not self.entry_dims
        if not (is_row or len(self.cut) == len(PLANE)):
            return None
        return float(self.loads[0]), float(self.velocities[0])

    @functools.cached_property
    def name(self) -> Variant:
        """Pairs (name, value) of all varied entries, if each has one value; else empty."""
        return name_at(self.stored.variants, self.rows)

    @property
    def entries(self) -> dict[str, Any]:
        """Values of the varied entries by dimension, as in a scene file, if each has one value.

        The result is empty if an entry has several values.
        """
        return self.stored.variants.in_words(self.name)

    @property
    def takes_tests(self) -> bool:
        """True unless the tests of the scene are to be left out."""
        return not self.rest.attrs.get("without_tests")

    @property
    def told_tests(self) -> tuple[Test, ...]:
        """Tests of the scene, none if they are to be left out."""
        return self.stored.tests if self.takes_tests else ()

    @property
    def prior(self) -> Prior:
        """How far the model may be off before any test, as the scene says."""
        return Prior(self.stored.base.model_bias, self.stored.base.model_scatter)

    @property
    def patches(self) -> int:
        """Number of random surfaces, which are patches of one specimen."""
        return self.rows.sizes.get("realization", 1)

    @functools.cached_property
    def sweep(self) -> Sweep:
        """Sweep restricted to the values in `entries`, under the conditions of `pipeline.at`."""
        columns, labels = {column.name for column in self.stored.variants.columns}, self.labels
        judged = {*labels} - columns
        own = {path: labels[name] for name, path in DIMENSIONS.items() if name in judged}
        return judged_sweep(self.origin, json.dumps({**self.judged, **own}), self.name)

    @functools.cached_property
    def conditions(self) -> Conditions:
        """Conditions to judge wear by; raises an `InputError` if the sweep lacks their data."""
        return self._require_computed(self.sweep.conditions)

    @property
    def plain_conditions(self) -> Conditions:
        """The sweep's conditions, but always with the criterion "share".

        So the code of a user's own criterion is not needed.
        """
        return self._require_computed(
            changed_conditions(self.sweep.conditions, {"criterion": "share"})
        )

    def _require_computed(self, conditions: Conditions) -> Conditions:
        """Return `conditions`; raise an `InputError` if the sweep cannot be judged by them."""
        require_bulks(self.columns, conditions)
        if conditions.friction and not self.sweep.scene.friction_heat:
            raise InputError(
                f"friction is {conditions.friction:g}, but the sweep was computed without friction "
                "and heat: run it again with friction, into another store"
            )
        return conditions

    @property
    def scenes(self) -> Iterator[Results]:
        """Results of each scene: one for each combination of values of the varied entries."""
        names = self.entry_dims
        for places in np.ndindex(*(self.rows.sizes[name] for name in names)):
            yield self.take(dict(zip(names, places, strict=True)))

    def take(self, places: Mapping[str, int]) -> Results:
        """Results at one index along each of the given dimensions; `places` has indices by name."""
        if not places:
            return self
        rows = self.rows.isel(places)
        at = tuple(places.get(name, slice(None)) for name in self.front)
        axes = {"load": self.loads, "velocity": self.velocities}
        if self.kind is Layout.PLACES:
            axes = {name: np.atleast_1d(rows[name].values) for name in PLANE}
        return replace(
            self,
            front=tuple(name for name in self.front if name not in places),
            rows=rows,
            loads=axes["load"],
            velocities=axes["velocity"],
            columns=taken(self.columns, lambda values: values[at]),
            rest=self.rest.isel(places, missing_dims="ignore"),
        )

    def take_surface(self, seed: int | None) -> Results:
        """Results on the surface with this seed of its roughness; on all surfaces if None.

        Raises an `InputError` unless the surface is one of several.
        """
        if seed is None:
            return self
        seeds = self.rows["realization"].values.tolist() if "realization" in self.front else []
        if seed not in seeds:
            others = ", ".join(map(str, seeds)) or "no others"
            raise InputError(f"realization is {seed}; the sweep has {others}")
        return self.take({"realization": seeds.index(seed)})

    def require_plane(self) -> None:
        """Raise an `InputError` unless figures over load and velocity can be drawn.

        They need results of one scene on a grid of loads and velocities, with the variables
        ``normal_load`` and ``rise_quantile``.
        """
        require_kind(self.kind, Layout.PLANE)
        require_one_scene(self.entry_dims)
        self.require_lists(*PLANE)
        self.require("normal_load", "rise_quantile")

    def take_row(self, seed: int | None) -> Results:
        """Select a single surface from the results of a single scene.

        `seed` is the seed of the surface's roughness; None selects the first surface. Raises an
        `InputError` if these are not results of one scene on a grid of loads and velocities.
        """
        self.require_plane()
        row = self.take_surface(seed)
        return row.take(dict.fromkeys(row.front, 0))

    def take_moving(self) -> Results:
        """Results at velocities above 0; all results if there are no such velocities.

        At velocity 0 there is no heat, and the rise cannot be a power of the velocity.
        """
        slides = self.velocities > 0
        if slides.all() or not slides.any():
            return self
        along = len(self.front) + 1
        columns = taken(self.columns, lambda values: np.compress(slides, values, axis=along))
        rest = self.rest.isel({"velocity": slides}, missing_dims="ignore")
        return replace(self, velocities=self.velocities[slides], columns=columns, rest=rest)

    def point(self, load: int, velocity: int) -> Point:
        """Point at the indices `load` and `velocity`, of results of one scene on one surface."""
        return Point(float(self.loads[load]), float(self.velocities[velocity]), self.surface)

    @functools.cached_property
    def messages(self) -> Any:
        """Warning or failure message of each point; "" for a point without a message.

        The axes are varied entries, surfaces (`Results.front`), load and velocity.
        """
        if "message" in self.columns:
            return self.columns["message"]
        found = np.full(self.columns["status"].shape, "", object)
        if self.store is None:
            return found
        stored = open_messages(self.store)
        axes = {"load": self.loads, "velocity": self.velocities} | dict(self.rows.coords)
        with suppress(KeyError):  # if the dataset has places that the store lacks
            texts = stored.sel({name: axes[name] for name in stored.dims if name in axes})
            texts = texts.expand_dims({name: self.rows[name] for name in self.judged_dims})
            texts = texts.transpose(*self.front, *PLANE, missing_dims="ignore")
            found = np.reshape(texts.values, found.shape)
        return found

    def values(self, name: str) -> Any:
        """Array of the variable `name`.

        The axes are varied entries, surfaces (`Results.front`), load and velocity, then
        others such as step. Axes that the variable lacks are left out.
        """
        if name in self.columns:
            return self.columns[name]
        return self.rest[name].transpose(*self.front, *PLANE, ..., missing_dims="ignore").values

    @property
    def variables(self) -> set[str]:
        """Names of all variables of the dataset."""
        return {*self.columns, *map(str, self.rest.variables)}

    def require(self, *names: str) -> None:
        """Raise an `InputError` if one of the variables `names` is missing."""
        if missing := [name for name in names if name not in self.columns]:
            raise InputError(f"the dataset has no {', '.join(missing)}; take all of its variables")

    def require_lists(self, *names: str) -> None:
        """Raise an `InputError` if the dataset has a scalar load or velocity, not a dimension.

        `names` are the axes to check: "load", "velocity" or both. A dimension of size 1 is allowed.
        """
        for name in names:
            if name in self.cut:
                value = (self.loads if name == "load" else self.velocities)[0]
                raise InputError(
                    f"the dataset has a single {name} and no such dimension; select a list with "
                    f"one value, such as ds.sel({name}=[{value:g}])"
                )

    @property
    def done(self) -> Mask:
        """Mask of points that are done.

        The axes are varied entries, surfaces (`Results.front`), load and velocity.
        """
        self.require("status")
        return np.asarray(self.columns["status"] == DONE)

    @property
    def missing(self) -> int:
        """Number of points to be computed that are pending or failed."""
        conditions = math.prod(self.rows.sizes[name] for name in self.judged_dims)
        return int(np.count_nonzero(self.asked & ~self.done)) // max(conditions, 1)

    @property
    def asked(self) -> Mask:
        """Mask of points that the last run was to compute, done or not.

        Points that a search of the boundary has left out are not among them.

        The axes are varied entries, surfaces (`Results.front`), load and velocity.
        """
        self.require("status")
        return np.isin(self.columns["status"], (DONE, FAILED, PENDING))

    @property
    def least_loads(self) -> Array:
        """Load from which on steps can decide, at each load (n_load,) [N]."""
        scene = self.stored.scene
        return np.array([load_that_counts(scene, load) for load in self.loads.tolist()])

    def rises(self, conditions: Conditions) -> Array:
        """Temperature rise [K] per unit friction coefficient at each point; NaN if it is not done.

        It is the rise of the temperature that the criterion compares with the critical temperature,
        at the worst step of the point. The axes are varied entries, surfaces
        (`Results.front`), load and velocity.
        """
        if self.place is None:
            self.require_lists(*PLANE)
        column = conditions.criterion.column
        self.require("status", "normal_load", column, *(NEEDED if conditions.corrections else ()))
        names = {"normal_load", column, *columns_needed(conditions)}
        columns: dict[str, Any] = {k: self.columns[k] for k in names if k in self.columns}
        columns["quantile"] = self.shares
        rises = worst_rises(columns, self.least_loads[:, None, None], conditions)
        if lost := np.count_nonzero(self.done & np.isnan(rises)):
            raise StoreError(
                f"{lost} of {np.count_nonzero(self.done)} done points have no values, as in a copy "
                "made during a run; irg verify with the store names them"
            )
        return np.where(self.done, rises, np.nan)
