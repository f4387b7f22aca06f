"""Arrays with named dimensions: what becomes a dataset, for those who do not need one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    import xarray as xr


class Variable(NamedTuple):
    """An array, the names of its dimensions, and what it is."""

    dims: tuple[str, ...]
    values: Any
    attrs: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Labelled:
    """Variables and coordinates by their names.

    Examples
    --------
    >>> load = Variable(("load",), np.array([400.0, 600.0]), {"units": "N"})
    >>> velocity = Variable(("load",), np.array([2.2, 1.5]), {"units": "m/s"})
    >>> found = Labelled({"critical_velocity": velocity}, {"load": load}, {})
    >>> found.at(load=1)["critical_velocity"].item()
    1.5
    >>> found.as_dataset()["critical_velocity"].sel(load=600).item()
    1.5
    """

    variables: Mapping[str, Variable]
    coordinates: Mapping[str, Variable]
    attrs: Mapping[str, Any]

    def __getitem__(self, name: str) -> Any:
        """Values of a variable or coordinate."""
        return (self.variables.get(name) or self.coordinates[name]).values

    def __contains__(self, name: str) -> bool:
        return name in self.variables or name in self.coordinates

    @property
    def sizes(self) -> dict[str, int]:
        """Length of each dimension."""
        return {
            name: length
            for each in self.variables.values()
            for name, length in zip(each.dims, np.shape(each.values), strict=True)
        }

    def at(self, **index: int) -> Labelled:
        """Take one entry along some dimensions."""

        def picked(each: Variable) -> Variable:
            key = tuple(index.get(name, slice(None)) for name in each.dims)
            return each._replace(
                dims=tuple(name for name in each.dims if name not in index),
                values=np.asarray(each.values)[key],
            )

        return Labelled(
            {name: picked(each) for name, each in self.variables.items()},
            {name: picked(each) for name, each in self.coordinates.items()},
            self.attrs,
        )

    def as_dataset(self) -> xr.Dataset:
        """The same as a dataset."""
        import xarray as xr  # takes 0.5 s, and only who works on with it needs it

        return xr.Dataset(dict(self.variables), dict(self.coordinates), self.attrs)


def stacked(
    parts: Sequence[Labelled], name: str, along: Variable, attrs: Mapping[str, Any]
) -> Labelled:
    """Put parts one after the other along a new dimension."""
    return Labelled(
        {
            key: Variable((name, *each.dims), np.stack([part[key] for part in parts]), each.attrs)
            for key, each in parts[0].variables.items()
        },
        {**parts[0].coordinates, name: along},
        attrs,
    )
