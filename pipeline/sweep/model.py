"""A scene, the points to simulate it at, and the conditions of severe wear."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple, Self

import numpy as np

from pipeline.sweep.conditions import Conditions
from pipeline.sweep.description import as_html, as_lines, on_conditions, on_plane, on_scene
from pipeline.sweep.over import Label, Over, Variant, combinations
from pipeline.sweep.samples import Samples
from pipeline.sweep.selection import Selection
from tribo import InputError, Oil, Ramp, Scene, SelfAffineRoughness, inseparable

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
class Measurement:
    """A test on a rig: a transition from mild to severe wear, or a point that was one of them.

    Attributes
    ----------
    normal_load : float
        Normal load on the whole pin [N].
    velocity : float
        Sliding velocity [m/s].
    friction : float or None
        Friction coefficient, if it was measured.
    load_scatter, velocity_scatter, friction_scatter : float or None
        Standard deviations of the three, if they are known [N, m/s, 1].
    bulk_temperature : float or None
        Bulk temperature of both bodies [K], where it was not the scene's.
    hold : float or None
        Duration at the full load [s], where it was not the scene's.
    outcome : {"mild", "severe"} or None
        Wear of the test; None at a transition.

    Examples
    --------
    >>> Measurement(normal_load=600.0, velocity=1.5, friction=0.1).as_dict()
    {'normal_load': 600.0, 'velocity': 1.5, 'friction': 0.1}
    """

    normal_load: float
    velocity: float
    friction: float | None = None
    load_scatter: float | None = None
    velocity_scatter: float | None = None
    friction_scatter: float | None = None
    bulk_temperature: float | None = None
    hold: float | None = None
    outcome: str | None = None

    @classmethod
    def of(cls, entry: Mapping[str, Any]) -> Measurement:
        """The test of an entry of a scene."""
        return cls(normal_load=entry["load"], **{k: v for k, v in entry.items() if k != "load"})

    def as_dict(self) -> dict[str, Any]:
        """Return all fields as plain data, of those after the friction only what is known."""
        data = asdict(self)
        always = ("normal_load", "velocity", "friction")
        return {k: v for k, v in data.items() if v is not None or k in always}


class FromLibrary(NamedTuple):
    """A number that a scene takes from the library: key path, value with unit, and its source."""

    key: str
    value: str
    source: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep(Scene):
    """A scene, the loads and velocities at which to simulate it, and on which surfaces.

    Attributes
    ----------
    name, title : str
        The file's name without ending; a line for people.
    loads : tuple of float
        Normal loads on the whole pin, ascending, each once [N].
    velocities : tuple of float
        Sliding velocities, ascending, each once [m/s].
    conditions : Conditions
        Friction, temperatures and failing share of the scene.
    realizations : tuple of int
        Seeds of the random surfaces on which to simulate every load and velocity, one after the
        other in place of the scene's own; none if the scene's own surface is all there is.
    samples : Samples or None
        Samples of the inputs that are not known exactly, to simulate one after the other in place
        of the scene itself; None if there are none.
    over : Over or None
        Entries with several values, all combinations of which to simulate in place of the scene
        itself; None if there are none.
    friction_band : tuple of float or None
        Lowest and highest friction coefficient measured.
    measured : tuple of Measurement
        Measured transitions, for comparison.
    tested : tuple of Measurement
        Tests that stayed mild or turned severe.
    oil : Oil or None
        Lubricant, to tell the regime of lubrication; no number of the simulation depends on it.
    wear_rates : tuple of float or None
        Lowest and highest specific wear rate for which the points are to answer, beside the
        scene's own [m²/N]; None for that alone.
    store_fields : bool
        True if the fields at the end of each point are kept.
    independent : bool
        True if each point is simulated from the start, not on from the next lower load.
    preset : str or None
        Name of the preset that the fidelity equals; None if it equals none.
    selection : Selection or None
        Why the fidelity is what it is, if it was picked for its accuracy.
    notes : tuple of str
        Assumptions made on reading the scene.
    library : tuple of FromLibrary
        Numbers that the scene takes from the library.
    chosen : collection of Point or None
        The points to simulate, if not all of them.
    arguments : tuple of str
        Arguments by which the command reads the scene: its file, preset and settings; none if it
        was not read from a file.

    Raises
    ------
    InputError
        If there are realizations, but the roughness is not a random one, or samples as well.

    Examples
    --------
    >>> from dataclasses import replace
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> scene.loads, len(scene.velocities)
    ((200.0, 400.0, 600.0, 750.0), 6)
    >>> replace(scene, loads=(600.0,)).loads
    (600.0,)
    """

    name: str
    title: str
    loads: tuple[float, ...]
    velocities: tuple[float, ...]
    conditions: Conditions
    realizations: tuple[int, ...] = ()
    samples: Samples | None = None
    over: Over | None = None
    friction_band: tuple[float, float] | None = None
    measured: tuple[Measurement, ...] = ()
    tested: tuple[Measurement, ...] = ()
    oil: Oil | None = None
    wear_rates: tuple[float, float] | None = None
    store_fields: bool = False
    independent: bool = False
    preset: str | None = None
    selection: Selection | None = None
    notes: tuple[str, ...] = ()
    library: tuple[FromLibrary, ...] = ()
    chosen: Collection[Point] | None = None
    arguments: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        Scene.__post_init__(self)  # a slotted dataclass has no super()
        if self.realizations and not isinstance(self.roughness, SelfAffineRoughness):
            raise InputError(
                "realizations are seeds of a random roughness, and that of the scene is not "
                "random; leave out sweep.realizations"
            )
        if self.realizations and self.samples:
            raise InputError(
                "sweep.realizations and sweep.samples exclude each other; make the surface an "
                'unknown input: "disk.roughness.seed" = [0, 1, 2, 3]'
            )
        if self.over and self.samples:
            raise InputError(
                "sweep.over and sweep.samples exclude each other; leave out one, or make the entry "
                'an unknown input: "pin.radius" = ["1 mm", "2 mm"] in [unknown]'
            )
        if fault := self._fault_of_wear_rates():
            raise InputError(f"sweep.wear_rates: {fault}")

    def _fault_of_wear_rates(self) -> str | None:
        """Reason why the points cannot answer for other wear rates, and what to do."""
        if self.wear_rates is None:
            return None
        low, high = (f"{1e9 * rate:g} mm³/(N m)" for rate in self.wear_rates)
        if self.wear is None or not self.wears:
            return "nothing wears; give [wear], or leave them out"
        usual = self.wear.specific_wear_rate
        if not self.wear_rates[0] <= usual <= self.wear_rates[1] or low == high:
            return (
                f"from {low} to {high} does not enclose the scene's own, {1e9 * usual:g} "
                "mm³/(N m); give a lower and a higher one"
            )
        if self.samples:
            return "samples draw what is not known themselves; leave out one or the other"
        if self.unequal_bulks:
            return "the bulk temperatures are unequal; give one, or leave them out"
        if not self.friction_heat:
            return "there is no friction, and so no heat; give friction.coefficient above 0"
        rates = (usual, *self.wear_rates)
        velocities = [speed * usual / rate for speed in self.velocities for rate in rates]
        if reason := inseparable(self, velocities):
            return f"{reason}; change that, or leave them out"
        return None

    def __repr__(self) -> str:
        return as_lines(f"{self.name}: {self.title}", self._rows())

    def _repr_html_(self) -> str:
        """Show the scene as a table in a notebook."""
        return as_html(f"{self.name}: {self.title}", self._rows())

    def _rows(self) -> list[tuple[str, str]]:
        """Description of the scene, a row for each subject."""
        several = [(f"{name}s", str(len(values))) for name, values in self.axes.items()]
        return [
            *on_scene(self),
            on_plane(self.loads, self.velocities),
            *several,
            ("fidelity", self.preset or "of its own"),
            *on_conditions(self.conditions),
        ]

    @property
    def rates(self) -> tuple[float, ...]:
        """Other wear rates than the scene's own, for which heat is taken on contacts [m²/N].

        They are ascending, and even in the logarithm; none if the own is all there is.
        """
        if self.wear is None or self.wear_rates is None:
            return ()
        low, high = self.wear_rates
        count = 1 + math.ceil(math.log(high / low) / math.log(_RATE_RATIO) - 1e-9)
        rates = (float(f"{rate:.12g}") for rate in np.geomspace(low, high, count))
        usual = self.wear.specific_wear_rate
        return tuple(rate for rate in rates if not math.isclose(rate, usual, rel_tol=1e-6))

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
    def variants(self) -> tuple[Variant, ...]:
        """Variants of the scene that the sweep simulates: one, ``()``, if it has no axes."""
        return combinations(self.axes)

    @property
    def ramps(self) -> int:
        """Number of ramps that are simulated, each at one velocity through all loads."""
        return len(self.variants) * (1 if self.samples else len(self.velocities))

    def variant(self, variant: Variant = ()) -> Self:
        """The sweep in one of its variants alone; without samples or `over` if none is given."""
        parts: dict[str, Any] = {}
        if self.over and (entries := variant[: len(self.over.axes)]):
            parts |= self.over.parts[entries]
        names = dict(variant)
        if "sample" in names:
            parts |= self._parts_of_sample(int(names["sample"]))
        is_one = self.samples is None and self.over is None
        sweep = self if is_one else replace(self, samples=None, over=None, **parts)
        return sweep.on_surface(int(names["realization"])) if "realization" in names else sweep

    def _parts_of_sample(self, sample: int) -> dict[str, Any]:
        """Fields in which a sample differs from the sweep."""
        if self.samples is None or not sample < len(self.samples):
            held = f"it has 0 to {len(self.samples) - 1}" if self.samples else "it has no samples"
            raise InputError(f"sample is {sample}, which the sweep does not have; {held}")
        return dict(self.samples.parts[sample])

    def contact_of(self, point: Point) -> tuple[float, Variant]:
        """Velocity and variant whose ramp of contacts leads through a point."""
        if self.over and point.variant:
            entries = point.variant[: len(self.over.axes)]
            return point.velocity, self.over.leads[entries] + point.variant[len(entries) :]
        if self.samples is None or not point.variant:
            return point[1:]
        ((name, sample),) = point.variant
        if point.velocity != self.samples.velocities[int(sample)]:
            return point[1:]  # the scene with the inputs of a sample, at another velocity
        number = self.samples.lead(int(sample))
        return self.samples.velocities[number], ((name, number),)

    def held(self, duration: float) -> Self:
        """The sweep with another duration at the full load [s]; not if the load is a record."""
        if not isinstance(self.loading, Ramp):
            raise InputError(
                f"hold is {duration:g} s, but the load follows a record, which ends when it ends; "
                "leave out the hold, or give a loading with rate and reference_load"
            )
        return replace(self, loading=replace(self.loading, hold=duration, hold_steps=None))

    def on_surface(self, seed: int | None) -> Self:
        """The sweep on the random surface of a seed alone; itself if None."""
        if seed is None:
            return self
        if not isinstance(self.roughness, SelfAffineRoughness):
            raise InputError(
                f"realization is {seed}, the seed of a random roughness, and that of the scene is "
                "not random; leave it out"
            )
        return replace(self, roughness=replace(self.roughness, seed=seed), realizations=())
