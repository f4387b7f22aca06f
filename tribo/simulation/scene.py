"""A scene to simulate: two bodies, how one slides on the other, and numerical choices."""

from __future__ import annotations

import functools
import math
from collections.abc import Container, Iterator
from dataclasses import dataclass, field, replace

from tribo.constants import FEWEST_ELEMENTS, LOCAL_TOLERANCE
from tribo.errors import InputError, require_instance
from tribo.loading import LoadStep, MeasuredLoad, Ramp, Stages
from tribo.material import Material
from tribo.numerics import Grid
from tribo.simulation.fidelity import Fidelity
from tribo.simulation.motion import Motion, Velocities
from tribo.simulation.pins import Pin
from tribo.surface import (
    MeasuredRoughness,
    SelfAffineRoughness,
    Surface,
    UnknownHeights,
    block_average,
    block_sample,
    surface_heights,
)
from tribo.types import Array
from tribo.wear import Wear, WearLaw, WearPattern, require_wear


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A pin pressed onto a moving disk.

    Parameters
    ----------
    pin : Pin
        A `Cylinder`, a `Ball`, a `Crowned` roller or another `Pin`. It is smooth, and at rest
        unless the scene has a motion.
    disk : Material
        Material of the body that moves along +x.
    pixels : Grid
        The window of the contact, and the pixels on which the disk's roughness is given. Under a
        cylinder it repeats along y, or it is free and as long as the cylinder.
    loading : Ramp, Stages or MeasuredLoad
        Growth of the load with time.
    roughness : SelfAffineRoughness, MeasuredRoughness or Surface, optional
        Roughness of the disk, or a user-defined surface; smooth if not given.
    wear : Wear or WearLaw, optional
        Wear of the pin, or a user-defined law; none if not given.
    friction_heat : bool
        True if there is friction and its heat. If not, the rise is 0 and is not computed.
    motion : Motion, optional
        Motion of both bodies; the pin is at rest if not given.
    fidelity : Fidelity
        Numerical choices.

    Examples
    --------
    >>> import tribo
    >>> steel = tribo.Material(elastic_modulus=210e9, poisson_ratio=0.3, hardness=6.6e9,
    ...                        thermal_conductivity=45.0, density=7800.0, specific_heat=470.0)
    >>> pin = tribo.Cylinder(2e-3, 3.4e-3, steel)
    >>> scene = tribo.Scene(pin=pin, disk=steel, pixels=tribo.Grid((192, 2), (2e-6, 228e-6)),
    ...                     loading=tribo.Ramp(rate=150.0, reference_load=750.0))
    >>> scene.grid.shape
    (96, 1)
    """

    pin: Pin
    disk: Material
    pixels: Grid
    loading: Ramp | Stages | MeasuredLoad
    roughness: SelfAffineRoughness | MeasuredRoughness | Surface | None = None
    wear: Wear | WearLaw | None = None
    friction_heat: bool = True
    motion: Motion | None = None
    fidelity: Fidelity = field(default_factory=Fidelity)

    def __post_init__(self) -> None:
        self._require_types()
        require_wear(self.wear)
        block = self.fidelity.pixels_per_element
        if any(n % block for n in self.pixels.shape):
            raise InputError(
                f"pixels_per_element is {block}, which does not divide the {self.pixels.shape} "
                "pixels of the surface; choose a common divisor"
            )
        if self.pixels.periodic[0]:
            raise InputError("the window is periodic along x; under a round pin x must be free")
        if self.pin.length is None and self.pixels.periodic[1]:
            shape = type(self.pin).__name__.lower()
            raise InputError(
                f"the window is periodic along y; under a {shape} pin both axes must be free"
            )
        self._require_length()
        if not isinstance(self.roughness, SelfAffineRoughness | UnknownHeights):
            self.heights()
        if self.motion and self.wears_by_law:
            raise InputError(
                "a wear law of your own needs a pin at rest, and the scene has a motion; leave out "
                "one of them"
            )
        if self.motion and self.track_length < self.pixels.size[0] * (1 - 1e-9):
            raise InputError(
                f"pin_track_length is {self.track_length:g} m; it must be at least that of the "
                f"window along x, {self.pixels.size[0]:g} m"
            )

    def _require_length(self) -> None:
        """Raise an `InputError` if the window does not fit the ends of the pin."""
        length, side = self.pin.length, self.pixels.size[1]
        if length is None:
            return
        if self.pixels.periodic[1]:
            if getattr(self.pin, "relief", None):
                raise InputError(
                    "the pin has relieved ends, and the window repeats along y, without ends; give "
                    "a window that is free along y and as long as the pin"
                )
        elif abs(side / length - 1) > 1e-6:
            raise InputError(
                f"the window is free along y and {side:g} m long, the pin {length:g} m; give a "
                "window as long as the pin, or one that is periodic along y"
            )

    def _require_types(self) -> None:
        """Raise an `InputError` for the first part that is not of its type."""
        if missing := [
            name for name in ("radius", "material", "hertz") if not hasattr(self.pin, name)
        ]:
            raise InputError(f"pin is {f'{self.pin!r}'[:100]}, without {missing[0]}; see tribo.Pin")
        require_instance(Material, disk=self.disk)
        require_instance(Grid, pixels=self.pixels)
        require_instance((Ramp, Stages, MeasuredLoad), loading=self.loading)
        require_instance(Fidelity, fidelity=self.fidelity)
        if self.motion is not None:
            require_instance(Motion, motion=self.motion)
        if self.roughness is not None and not hasattr(self.roughness, "heights"):
            description = f"{self.roughness!r}"[:100]
            raise InputError(f"roughness is {description}, without heights; see tribo.Surface")

    def __repr__(self) -> str:
        parts = (self.pin, self.roughness, self.loading, self.wear, self.motion)
        names = ", ".join(type(part).__name__ for part in parts if part is not None)
        pixels = " × ".join(map(str, self.pixels.shape))
        return f"<Scene: {names}, {pixels} pixels, pin radius {self.pin.radius:g} m>"

    @property
    def track_length(self) -> float:
        """Length of the track around a pin that rolls [m]."""
        track_length = self.motion.pin_track_length if self.motion else None
        return 2 * math.pi * self.pin.radius if track_length is None else track_length

    def velocities_at(self, sliding: float) -> Velocities:
        """Velocities of pin and disk along x at a sliding velocity [m/s]."""
        return self.motion.velocities(sliding) if self.motion else Velocities(0.0, sliding)

    def windows_worn(self, sliding: float) -> float:
        """Length along x of the part of the pin that wears, divided by the length of the window.

        If the pin rolls at the `sliding` velocity [m/s], its whole track wears. If the pin is at
        rest, the result is 1.
        """
        if self.velocities_at(sliding).pin == 0:
            return 1.0
        return self.track_length / self.pixels.size[0]

    @property
    def wears_by_law(self) -> bool:
        """True if the pin wears by a law of a user, whose rate may differ in each step."""
        return self.wear is not None and not isinstance(self.wear, Wear)

    @property
    def contact_pattern(self) -> WearPattern | None:
        """Pattern of the wear by one solved contact; None without wear.

        It is the pattern of `wear` if y is periodic. If not, it is "local", even for swept wear:
        then the pin wears by contacts at many positions of the disk in turn, see `sweeps_over`.
        """
        if self.wear is None:
            return None
        return self.wear.pattern if self.pixels.periodic[1] else "local"

    @property
    def wears_locally(self) -> bool:
        """True if each point of the pin wears by the pressure on it in a single contact.

        False without wear, and if the pin wears by mean pressures: over y, or over contacts at many
        positions of the disk.
        """
        return self.contact_pattern == "local" and not self.sweeps_over

    @property
    def sweeps_over(self) -> bool:
        """True if the pin wears by contacts at many positions of the disk.

        This is so for swept wear if the disk is rough and y is not periodic.
        """
        swept = self.wear is not None and self.wear.pattern == "swept"
        return swept and not self.pixels.periodic[1] and self.roughness is not None

    @property
    def wears_by_strips(self) -> bool:
        """True if the pin wears by contacts with strips of the disk from several positions.

        This is so for swept wear if the disk is rough, y is periodic and the pin does not roll.
        """
        swept = self.wears and self.contact_pattern == "swept" and self.roughness is not None
        return swept and self.velocities_at(1.0).pin == 0

    @property
    def grid(self) -> Grid:
        """The grid of elements. An element is a block of n × n pixels, n = ``pixels_per_element``.

        If nothing depends on y (`is_plane`), an element is as long along y as the window.
        """
        return _element_grid(self.pixels, self.fidelity.pixels_per_element, self.is_plane)

    @property
    def is_plane(self) -> bool:
        """True if nothing depends on y: smooth bodies, a line contact and a periodic y."""
        is_smooth = self.roughness is None and self.pin.length is not None
        return is_smooth and self.pixels.periodic[1]

    @property
    def rows_per_element(self) -> int:
        """Number of blocks of n × n pixels along y that one element of `grid` covers.

        n is ``pixels_per_element``. An element is one block, unless nothing depends on y: then an
        element covers all blocks along y.
        """
        return self.pixels.shape[1] // self.fidelity.pixels_per_element if self.is_plane else 1

    @property
    def hardness(self) -> float:
        """Hardness of the softer body [Pa]."""
        return min(self.pin.material.hardness, self.disk.hardness)

    @property
    def nominal_area(self) -> float:
        """Area of the simulated window times the number of such windows on the pin [m²]."""
        return self.grid.area * self.pin.windows(self.grid)

    @property
    def greatest_load(self) -> float:
        """Load on the pin [N] at which the pressure on the whole nominal area is the hardness."""
        return self.hardness * self.nominal_area

    @property
    def wears(self) -> bool:
        """True if the pin loses any material, so that a state depends on earlier steps."""
        return self.wears_by_law or (
            isinstance(self.wear, Wear) and self.wear.specific_wear_rate > 0
        )

    @property
    def heated_length(self) -> float:
        """Length along y that is heated [m]; infinite without ends."""
        return math.inf if self.pin.length is None else self.pin.length

    @property
    def contact_tolerance(self) -> float:
        """Residual at which the contact solver stops: the fidelity's, or less for local wear."""
        tolerance = self.fidelity.contact_tolerance
        return min(tolerance, LOCAL_TOLERANCE) if self.wears_locally else tolerance

    def heights(self) -> Array | None:
        """Heights of the disk on the pixels [m], shape ``pixels.shape``; None if it is smooth."""
        if self.roughness is None:
            return None
        if isinstance(self.roughness, SelfAffineRoughness | MeasuredRoughness):
            return self.roughness.heights(self.pixels)
        return surface_heights(self.roughness, self.pixels)

    def separation(self, heights: Array | None) -> Array:
        """Distance of the unworn, undeformed surfaces [m], shape ``grid.shape``.

        `heights` are the disk's heights on the pixels, from `Scene.heights`; None if it is smooth.
        """
        profile = self.pin.profile(self.grid)
        if heights is None:
            return profile.copy()
        coarsen = block_sample if self.fidelity.averaging == "sample" else block_average
        return profile - coarsen(heights, self.fidelity.pixels_per_element)

    def load_steps(self, normal_load: float, requested: Container[int] = ()) -> Iterator[LoadStep]:
        """Times at which the contact must be solved, with loads, up to a load [N] and in its hold.

        Each is the end of a step. If the pin wears, all steps are yielded. Otherwise only the last
        step, the step in which a ramp reaches the load, onsets and ends of stages, and steps with
        an index in `requested`.
        """
        load_steps = self.all_load_steps(normal_load)
        if self.wears:
            yield from load_steps
            return
        is_ramp, last_index = isinstance(self.loading, Ramp), -1
        for load_step in load_steps:
            # Also at the start of a hold, since later warming depends on the load until then.
            reaches = is_ramp and load_step.normal_load == normal_load and not load_step.holding
            if load_step.index in requested or load_step.bounds_hold or reaches:
                yield replace(
                    load_step, on_trunk=load_step.on_trunk and load_step.index in requested
                )
                last_index = load_step.index
        if load_step.index != last_index:
            yield replace(load_step, on_trunk=False)

    def all_load_steps(self, normal_load: float) -> Iterator[LoadStep]:
        """Ends of all steps of the loading up to a load [N] and of its hold: times and loads."""
        fidelity, loading = self.fidelity, self.loading
        if isinstance(loading, Stages):
            return loading.load_steps(normal_load, fidelity.increments)
        return loading.load_steps(normal_load, fidelity.increments, fidelity.hold_increments)

    def ramp_increment(self, normal_load: float) -> float:
        """Increment [N] of the ramp to a load [N]; 0 for stages and for a recorded load.

        Loads with equal increments share a ramp.
        """
        if isinstance(self.loading, Ramp):
            return self.loading.increment(normal_load, self.fidelity.increments)
        return 0.0

    @property
    def coarsening(self) -> int:
        """Factor on the sides of elements in all steps before a point's last step.

        It is the largest number up to the fidelity's ``history_coarsening`` that divides the grid
        and leaves enough elements to resolve the wear. It is 1 if the wear is local.
        """
        if self.wears_locally:
            return 1
        nx, ny = self.grid.shape
        factors = (
            factor
            for factor in range(self.fidelity.history_coarsening, 1, -1)
            if nx % factor == ny % factor == 0 and nx // factor >= FEWEST_ELEMENTS
        )
        return next(factors, 1)

    def levels(self) -> Iterator[Scene]:
        """Yield the scene on ever finer grids for the last step of a point; its own grid is last.

        The first grid is that of all earlier steps. The sides of its elements are longer by the
        factor `coarsening`. From one grid to the next the sides shrink to a quarter or less; the
        last time a third or a half is enough. More grids would cost more time than they save.
        """
        factor = self.coarsening
        while factor > 1:
            block = self.fidelity.pixels_per_element * factor
            yield replace(
                self,
                fidelity=replace(self.fidelity, pixels_per_element=block, history_coarsening=1),
            )
            factor = next((n for n in range(factor // 4, 1, -1) if factor % n == 0), 1)
        yield self


@functools.lru_cache(maxsize=64)  # called a dozen times in each step
def _element_grid(pixels: Grid, block: int, is_plane: bool) -> Grid:
    """Grid of elements of ``block × block`` pixels; one along y if nothing depends on y."""
    (nx, ny), (dx, dy) = pixels.shape, pixels.spacing
    if is_plane:
        return Grid((nx // block, 1), (dx * block, dy * ny), pixels.periodic)
    return Grid((nx // block, ny // block), (dx * block, dy * block), pixels.periodic)
