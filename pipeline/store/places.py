"""The points of a store: their places along its dimensions, and which the last run asked for."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.store.chunks import Place
from pipeline.store.identity import simulated_inputs
from pipeline.store.variables import LEADING, chosen_of
from pipeline.sweep.model import Point
from pipeline.sweep.unknown import first_alike
from tribo.types import Indices, Mask


class Places:
    """Where the points of a store lie.

    Parameters
    ----------
    attributes : dict
        Attributes of the store's root group.
    axes : dict of list
        Values along each dimension, in the order of the store.
    """

    def __init__(self, attributes: dict[str, Any], axes: dict[str, list[float]]) -> None:
        self.attributes, self.axes = attributes, axes
        self._places = {
            name: {value: index for index, value in enumerate(axes[name])}
            for name in (*LEADING, "load", "velocity")
            if name in axes
        }

    @property
    def axes_of_points(self) -> dict[str, list[float]]:
        """Values along the dimensions that tell points apart."""
        return {name: self.axes[name] for name in self._places}

    def asked(self) -> list[Point]:
        """Points of the scene that was run last."""
        chosen = chosen_of(self.attributes)
        if chosen is not None:
            return list(chosen)
        name, _ = self._leading
        variants = self.attributes.get("realizations") or [None]
        if name == "sample":
            variants = list(dict.fromkeys(self._simulations()))
        loads, velocities = self.attributes["loads"], self.attributes["velocities"]
        places = itertools.product(variants, velocities, loads)
        return [Point(load, velocity, **{name: each}) for each, velocity, load in places]

    def asked_places(self) -> Mask:
        """Whether each place is a point of the scene that was run last."""
        name, leading = self._leading
        chosen = chosen_of(self.attributes)
        if chosen is not None:
            variants = [Point(0.0, 0.0, **{name: each})[2:] for each in leading]
            among = chosen.over(variants, self.axes["load"], self.axes["velocity"])
            return among.reshape(self._shape)
        asked = np.zeros(self._shape, bool)
        asked_for = self.attributes.get("realizations") or leading
        if name == "sample":
            asked_for = self._simulations()
        wanted = {
            name: asked_for,
            "load": self.attributes["loads"],
            "velocity": self.attributes["velocities"],
        }
        along = [[index[value] for value in wanted[axis]] for axis, index in self._places.items()]
        asked[np.ix_(*(np.array(each, int) for each in along))] = True
        return asked

    def points_at(self, where: Sequence[Indices]) -> list[Point]:
        """Points at places that are given by their indices along each dimension."""
        name, _ = self._leading
        axes = [np.array(self.axes[axis], dtype=object) for axis in self._places]
        *leading, loads, velocities = (
            axis[along].tolist() for axis, along in zip(axes, where, strict=True)
        )
        if not leading:
            return list(map(Point, loads, velocities))
        others = itertools.repeat(None)
        surfaces, samples = (leading[0], others) if name == "realization" else (others, leading[0])
        return list(map(Point, loads, velocities, surfaces, samples))

    def places(self) -> list[Point]:
        """Every point that the store has room for."""
        return self.points_at(np.nonzero(np.ones(self._shape, bool)))

    def index(self, point: Point) -> Place:
        """Place of a point along the leading dimensions."""
        return tuple(index[getattr(point, name)] for name, index in self._places.items())

    def _simulations(self) -> tuple[int, ...]:
        """See `Samples.simulations`."""
        count = self.attributes["samples"]
        paths = simulated_inputs(self.attributes)
        return first_alike(count, [self.axes[path][:count] for path in paths])

    @property
    def _shape(self) -> Place:
        return tuple(len(self.axes[name]) for name in self._places)

    @property
    def _leading(self) -> tuple[str, list[Any]]:
        """Name and values of what leads the dimensions of points; nothing but None if none does."""
        return next(
            ((name, self.axes[name]) for name in LEADING if name in self.axes), (LEADING[0], [None])
        )
