"""A scene, the points to simulate it at, and the conditions of severe wear."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple, Self

import numpy as np

from pipeline.sweep.about import About
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.description import as_html, as_lines, on_conditions, on_plane, on_scene
from pipeline.sweep.over import Label, Over, Variant, combinations
from pipeline.sweep.samples import Samples
from tribo import InputError, Ramp, Scene, SelfAffineRoughness, inseparable

# Ratio of neighbouring wear rates at which heat is taken, at most. On four contacts rises between
# them were off by up to 0.1 to 0.3 %, as with more of them: by the elements on which a quantile is.
_RATE_RATIO = 2.0


class Point(NamedTuple):
    """One place in the diagram, and in which variant of the scene.

    Attributes
    ----------
    load : float
        Normal load on the whole pin [N].
    velocity : float
        Sliding velocity [m/s].
    variant : tuple of (str, number or str)
        Dimensions in front of load and velocity, with the point's value of each: ``realization``
        (seed of the random surface), ``sample`` (its number), or the path of an entry.

    Examples
    --------
    >>> print(Point(600.0, 1.5), Point(600.0, 1.5, (("realization", 3),)), sep="; ")
    600 N, 1.5 m/s; 600 N, 1.5 m/s, surface 3
    """

    load: float
    velocity: float
    variant: Variant = ()

    def __str__(self) -> str:
        return ", ".join([f"{self.load:g} N, {self.velocity:g} m/s", *named(self.variant)])


def named(variant: Variant) -> list[str]:
    """Words for each value of a variant.

    Examples
    --------
    >>> named((("pin.radius", 0.002), ("realization", 3)))
    ['pin.radius 0.002', 'surface 3']
    """
    return [
        f"{'surface' if name == 'realization' else name} "
        + (f"{value:g}" if isinstance(value, float) else f"{value}")
        for name, value in variant
    ]


@dataclass(frozen=True, slots=True)
class Plane:
    """Loads and velocities at which to simulate a scene.

    Attributes
    ----------
    loads : tuple of float
        Normal loads on the whole pin, ascending, each once [N].
    velocities : tuple of float
        Sliding velocities, ascending, each once [m/s].
    independent : bool
        True if each point is simulated from the start, not on from the next lower load.
    chosen : collection of Point or None
        The points to simulate, if not all of them.
    """

    loads: tuple[float, ...]
    velocities: tuple[float, ...]
    independent: bool = False
    chosen: Collection[Point] | None = None


@dataclass(frozen=True, slots=True)
class Variants:
    """Variants of the scene to simulate in its place.

    Attributes
    ----------
    realizations : tuple of int
        Seeds of the random surfaces on which to simulate every load and velocity, one after the
        other in place of the scene's own; none if the scene's own surface is all there is.
    samples : Samples or None
        Samples of the inputs that are not known exactly, to simulate one after the other in place
        of the scene itself; None if there are none.
    over : Over or None
        Entries with several values, all combinations of which to simulate in place of the scene
        itself; None if there are none.
    wear_rates : tuple of float or None
        Lowest and highest specific wear rate for which the points are to answer, beside the
        scene's own [m²/N]; None for that alone.
    """

    realizations: tuple[int, ...] = ()
    samples: Samples | None = None
    over: Over | None = None
    wear_rates: tuple[float, float] | None = None

    @property
    def axes(self) -> dict[str, tuple[Label, ...]]:
        """Dimensions in front of load and velocity, with their values."""
        if self.samples:
            return {"sample": tuple(range(len(self.samples)))}
        axes: dict[str, tuple[Label, ...]] = {}
        if self.over:
            axes |= {axis.path: axis.values for axis in self.over.axes}
        return axes | ({"realization": self.realizations} if self.realizations else {})

    @property
    def entries(self) -> tuple[Variant, ...]:
        """Combinations of the entries with several values: one, ``()``, if there are none."""
        return tuple(self.over.parts) if self.over else ((),)

    @property
    def names(self) -> tuple[Variant, ...]:
        """Variants of the scene that the sweep simulates: one, ``()``, if it has no axes."""
        return combinations(self.axes)


@dataclass(frozen=True, slots=True)
class Record:
    """What is kept of each point.

    Attributes
    ----------
    fields : bool
        True if the fields at the end of each point are kept.
    """

    fields: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A scene, where to simulate it and in which variants, and how to judge the results.

    Attributes
    ----------
    scene : Scene
        What is simulated, with its numerical choices.
    plane : Plane
        Loads and velocities at which.
    conditions : Conditions
        Friction, temperatures and criterion, which act after the simulation.
    variants : Variants
        Variants of the scene to simulate in its place.
    record : Record
        What is kept of each point.
    about : About
        Names, tests, oil and sources.

    Raises
    ------
    InputError
        If there are realizations, but the roughness is not a random one, or samples as well.

    Examples
    --------
    >>> import pipeline
    >>> sweep = pipeline.load_scene("workflows/first_try.toml")
    >>> sweep.plane.loads, sweep.scene.pin.radius
    ((200.0, 400.0, 600.0, 750.0), 0.002)
    >>> sweep.changed(loads=(600.0,)).plane.loads
    (600.0,)
    """

    scene: Scene
    plane: Plane
    conditions: Conditions
    variants: Variants = field(default_factory=Variants)
    record: Record = field(default_factory=Record)
    about: About = field(default_factory=lambda: About(name="scene", title="A scene"))

    def __post_init__(self) -> None:
        if self.variants.realizations and not isinstance(self.scene.roughness, SelfAffineRoughness):
            raise InputError(
                "realizations are seeds of a random roughness, and that of the scene is not "
                "random; leave out sweep.realizations"
            )
        if self.variants.realizations and self.variants.samples:
            raise InputError(
                "sweep.realizations and sweep.samples exclude each other; make the surface an "
                'unknown input: "disk.roughness.seed" = [0, 1, 2, 3]'
            )
        if self.variants.over and self.variants.samples:
            raise InputError(
                "sweep.over and sweep.samples exclude each other; leave out one, or make the entry "
                'an unknown input: "pin.radius" = ["1 mm", "2 mm"] in [unknown]'
            )
        if fault := self._fault_of_wear_rates():
            raise InputError(f"sweep.wear_rates: {fault}")

    def _fault_of_wear_rates(self) -> str | None:
        """Reason why the points cannot answer for other wear rates, and what to do."""
        if self.variants.wear_rates is None:
            return None
        low, high = (f"{1e9 * rate:g} mm³/(N m)" for rate in self.variants.wear_rates)
        if self.scene.wear is None or not self.scene.wears:
            return "nothing wears; give [wear], or leave them out"
        usual = self.scene.wear.specific_wear_rate
        if not self.variants.wear_rates[0] <= usual <= self.variants.wear_rates[1] or low == high:
            return (
                f"from {low} to {high} does not enclose the scene's own, {1e9 * usual:g} "
                "mm³/(N m); give a lower and a higher one"
            )
        if self.variants.samples:
            return "samples draw what is not known themselves; leave out one or the other"
        if self.scene.unequal_bulks:
            return "the bulk temperatures are unequal; give one, or leave them out"
        if not self.scene.friction_heat:
            return "there is no friction, and so no heat; give friction.coefficient above 0"
        rates = (usual, *self.variants.wear_rates)
        velocities = [speed * usual / rate for speed in self.plane.velocities for rate in rates]
        if reason := inseparable(self.scene, velocities):
            return f"{reason}; change that, or leave them out"
        return None

    def __repr__(self) -> str:
        return as_lines(f"{self.about.name}: {self.about.title}", self._rows())

    def _repr_html_(self) -> str:
        """Show the scene as a table in a notebook."""
        return as_html(f"{self.about.name}: {self.about.title}", self._rows())

    def _rows(self) -> list[tuple[str, str]]:
        """Description of the scene, a row for each subject."""
        several = [(f"{name}s", str(len(values))) for name, values in self.variants.axes.items()]
        return [
            *on_scene(self.scene),
            on_plane(self.plane.loads, self.plane.velocities),
            *several,
            ("fidelity", self.about.preset or "of its own"),
            *on_conditions(self.conditions),
        ]

    @property
    def rates(self) -> tuple[float, ...]:
        """Other wear rates than the scene's own, for which heat is taken on contacts [m²/N].

        They are ascending, and even in the logarithm; none if the own is all there is.
        """
        if self.scene.wear is None or self.variants.wear_rates is None:
            return ()
        low, high = self.variants.wear_rates
        count = 1 + math.ceil(math.log(high / low) / math.log(_RATE_RATIO) - 1e-9)
        rates = (float(f"{rate:.12g}") for rate in np.geomspace(low, high, count))
        usual = self.scene.wear.specific_wear_rate
        return tuple(rate for rate in rates if not math.isclose(rate, usual, rel_tol=1e-6))

    @property
    def ramps(self) -> int:
        """Number of ramps that are simulated, each at one velocity through all loads."""
        return len(self.variants.names) * (
            1 if self.variants.samples else len(self.plane.velocities)
        )

    def variant(self, variant: Variant = ()) -> Self:
        """The sweep in one of its variants alone; without samples or `over` if none is given."""
        parts: dict[str, Any] = {}
        if self.variants.over and (entries := variant[: len(self.variants.over.axes)]):
            parts |= self.variants.over.parts[entries]
        names = dict(variant)
        if "sample" in names:
            parts |= self._parts_of_sample(int(names["sample"]))
        is_one = self.variants.samples is None and self.variants.over is None
        sweep = self if is_one else self.changed(samples=None, over=None, **parts)
        return sweep.on_surface(int(names["realization"])) if "realization" in names else sweep

    def _parts_of_sample(self, sample: int) -> dict[str, Any]:
        """Fields in which a sample differs from the sweep."""
        if self.variants.samples is None or not sample < len(self.variants.samples):
            held = (
                f"it has 0 to {len(self.variants.samples) - 1}"
                if self.variants.samples
                else "it has no samples"
            )
            raise InputError(f"sample is {sample}, which the sweep does not have; {held}")
        return dict(self.variants.samples.parts[sample])

    def contact_of(self, point: Point) -> tuple[float, Variant]:
        """Velocity and variant whose ramp of contacts leads through a point."""
        if self.variants.over and point.variant:
            entries = point.variant[: len(self.variants.over.axes)]
            return point.velocity, self.variants.over.leads[entries] + point.variant[len(entries) :]
        if self.variants.samples is None or not point.variant:
            return point[1:]
        ((name, sample),) = point.variant
        if point.velocity != self.variants.samples.velocities[int(sample)]:
            return point[1:]  # the scene with the inputs of a sample, at another velocity
        number = self.variants.samples.lead(int(sample))
        return self.variants.samples.velocities[number], ((name, number),)

    def held(self, duration: float) -> Self:
        """The sweep with another duration at the full load [s]; not if the load is a record."""
        if not isinstance(self.scene.loading, Ramp):
            raise InputError(
                f"hold is {duration:g} s, but the load follows a record, which ends when it ends; "
                "leave out the hold, or give a loading with rate and reference_load"
            )
        return self.changed(loading=replace(self.scene.loading, hold=duration, hold_steps=None))

    def on_surface(self, seed: int | None) -> Self:
        """The sweep on the random surface of a seed alone; itself if None."""
        if seed is None:
            return self
        if not isinstance(self.scene.roughness, SelfAffineRoughness):
            raise InputError(
                f"realization is {seed}, the seed of a random roughness, and that of the scene is "
                "not random; leave it out"
            )
        return self.changed(roughness=replace(self.scene.roughness, seed=seed), realizations=())

    def changed(self, **values: Any) -> Self:
        """The sweep with other values of some fields of its parts, by the names of the fields."""
        if unknown := values.keys() - PART_OF.keys():
            raise TypeError(f"a sweep has no {', '.join(sorted(unknown))}")
        parts: dict[str, dict[str, Any]] = {}
        for name, value in values.items():
            parts.setdefault(PART_OF[name], {})[name] = value
        whole = parts.pop("", {})
        return replace(
            self, **{k: replace(getattr(self, k), **new) for k, new in parts.items()}, **whole
        )

    def get(self, name: str) -> Any:
        """Value of a field of one of the parts."""
        part = PART_OF[name]
        return getattr(getattr(self, part) if part else self, name)


_PARTS = {"scene": Scene, "plane": Plane, "variants": Variants, "record": Record, "about": About}
PART_OF = {
    "conditions": "",
    **{entry.name: part for part, kind in _PARTS.items() for entry in fields(kind)},
}
"""Part of a sweep that has a field; empty for the sweep itself."""
