"""A turning disc or ring that is heated around its rim and conducts heat throughout."""

from __future__ import annotations

import functools
import math
from dataclasses import asdict, dataclass

import numpy as np
import scipy

from tribo.errors import InputError, require_positive
from tribo.types import Array

_ROOTS = 120
# Value of κt/(a − b)² below which the rim counts as a curved half-space: there the series needs
# more roots than are kept, and the half-space is wrong by less than 1e-4.
_EARLY = 4e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class Disc:
    """A disc or a ring, which loses heat in proportion to its rise above its starting temperature.

    Parameters
    ----------
    diameter, width : float
        Diameter of the rim, and width of the disc across the track [m].
    bore : float
        Diameter of the hole [m]; 0 without a hole.
    rim_loss, face_loss : float
        Heat loss of the rim, and of each of the two faces, per unit area and kelvin [W/(m² K)].
    shaft_loss : float
        Heat loss to the shaft per kelvin [W/K]: at the bore, or evenly over a disc without a bore.

    Examples
    --------
    >>> print(Disc(diameter=0.1, width=0.01, bore=0.03, shaft_loss=5.0))
    100 × 10 mm, bore 30 mm, shaft 5 W/K
    """

    diameter: float
    width: float
    bore: float = 0.0
    rim_loss: float = 0.0
    face_loss: float = 0.0
    shaft_loss: float = 0.0

    def __post_init__(self) -> None:
        require_positive(diameter=self.diameter, width=self.width)
        for name in ("bore", "rim_loss", "face_loss", "shaft_loss"):
            if not 0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name} is {getattr(self, name)!r}; it must be finite and ≥ 0")
        if not self.bore < self.diameter:
            raise InputError(
                f"bore is {self.bore:g} m; it must be smaller than the diameter, {self.diameter:g} "
                "m"
            )

    def __str__(self) -> str:
        parts = [f"{1e3 * self.diameter:.4g} × {1e3 * self.width:.4g} mm"]
        parts += [f"bore {1e3 * self.bore:.3g} mm"] if self.bore else []
        losses = (self.rim_loss, "rim", "W/(m² K)"), (self.face_loss, "faces", "W/(m² K)")
        for loss, place, unit in (*losses, (self.shaft_loss, "shaft", "W/K")):
            parts += [f"{place} {loss:.3g} {unit}"] if loss else []
        return ", ".join(parts)

    def rim_response(self, age: Array, diffusivity: float, heat_capacity: float) -> Array:
        """Impulse response of the temperature of the rim [1/m], one value for each age.

        Heat Q per area [J/m²] that is spread over the rim at once warms the rim, after the time t,
        by Q/(ρc) times the response. This is a sum over the modes φₙ of a cylinder or a ring
        (Carslaw & Jaeger, *Conduction of Heat in Solids*, 2nd ed., 1959, §7.7, §7.9 and §7.10),

            1/a Σ φₙ(1)²/∫φₙ² x dx exp(−βₙ² κt/a²),   φₙ = J₀(βₙx) + cₙY₀(βₙx).

        Here a is the radius of the rim, and x the radius divided by a. The integral goes from the
        bore to the rim, x = 1. The heat losses h per area at rim and bore determine βₙ and cₙ by
        φₙ' + (ha/K) φₙ = 0 there, with the outward slope φₙ' and the conductivity K. Without a bore
        cₙ is 0.

        A loss h of the faces multiplies the sum by exp(−2ht/(ρcB)), with the width B. The shaft
        takes its heat at the bore, or evenly from a disc without a bore.

        At early times the response is 1/√(πκt), as of a half-space, corrected for the curvature and
        the loss of the rim.

        Parameters
        ----------
        age : ndarray
            Times t since the heat was spread over the rim, above 0 [s].
        diffusivity, heat_capacity : float
            Thermal diffusivity κ [m²/s], and heat capacity per volume ρc [J/(m³ K)].

        Examples
        --------
        A disc of 100 × 10 mm, after a tenth of a second and when it has one temperature:

        >>> disc = Disc(diameter=0.1, width=0.01)
        >>> disc.rim_response(np.array([0.1, 600.0]), 1.2275e-5, 3.666e6).round(1).tolist()
        [519.4, 40.0]
        """
        radius, conductivity = self.diameter / 2, diffusivity * heat_capacity
        biot, shaft = self.rim_loss * radius / conductivity, 0.0
        decay = 2 * self.face_loss / (heat_capacity * self.width)
        if self.bore:
            area = math.pi * self.bore * self.width
            shaft = self.shaft_loss / area * radius / conductivity
        else:
            volume = math.pi * radius**2 * self.width
            decay += self.shaft_loss / (heat_capacity * volume)
        inner = self.bore / self.diameter
        roots, weights = _modes(inner, biot, shaft)
        fourier = diffusivity * age / radius**2
        early = fourier < _EARLY * (1 - inner) ** 2
        late = np.where(early, 1.0, fourier)[..., None]
        series = (weights * np.exp(-(roots**2) * late)).sum(axis=-1)
        lost, root = biot - 0.5, np.sqrt(np.where(early, fourier, 1.0))
        short = 1 / (math.sqrt(math.pi) * root) - lost * scipy.special.erfcx(lost * root)
        left: Array = np.where(early, short, series) * np.exp(-decay * age) / radius
        return left

    def as_dict(self) -> dict[str, float]:
        """Return the sizes and losses by name, without those that are 0."""
        return {name: value for name, value in asdict(self).items() if value}


@functools.lru_cache(maxsize=256)
def _modes(inner: float, rim: float, bore: float) -> tuple[Array, Array]:
    """Roots βₙ of a ring from x = `inner` to 1, and the weights φₙ(1)²/∫φₙ² x dx of its modes.

    x is the radius divided by the rim's radius. `rim` and `bore` are the losses at rim and bore as
    Biot numbers ha/K. The modes φₙ are those of `Disc.rim_response`.
    """
    j0, j1, y0, y1 = (getattr(scipy.special, name) for name in ("j0", "j1", "y0", "y1"))

    def mode(beta: Array, x: float) -> tuple[Array, Array]:
        """Values and slopes at `x` of thermal modes, one mode for each wavenumber in `beta`.

        `x` is the radius divided by the rim's radius, and slopes are derivatives by `x`. Each mode
        satisfies the heat-loss condition at the bore; at the rim, only if its wavenumber is a root
        of `rim_function`.
        """
        if not inner:
            return j0(beta * x), -beta * j1(beta * x)
        first, second = (
            -beta * slope(beta * inner) - bore * value(beta * inner)
            for value, slope in ((j0, j1), (y0, y1))
        )
        return (
            second * j0(beta * x) - first * y0(beta * x),
            beta * (first * y1(beta * x) - second * j1(beta * x)),
        )

    def rim_function(beta: Array) -> Array:
        value, slope = mode(beta, 1.0)
        return slope + rim * value

    # Neighbours are about π/(1 − inner) apart; a small loss has a small first root.
    step = math.pi / (1 - inner)
    scan = np.concatenate(
        [np.geomspace(1e-6, 0.1, 60) * step, np.arange(0.15, _ROOTS, 0.05) * step]
    )
    signs = np.sign(rim_function(scan))
    places = np.flatnonzero(signs[:-1] * signs[1:] < 0)[:_ROOTS]
    low, high = scan[places], scan[places + 1]
    for _ in range(60):
        middle = (low + high) / 2
        is_low = np.sign(rim_function(middle)) == signs[places]
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    roots = (low + high) / 2
    value, slope = mode(roots, 1.0)
    norm = (value**2 + (slope / roots) ** 2) / 2
    if inner:
        begin, begin_slope = mode(roots, inner)
        norm -= inner**2 * (begin**2 + (begin_slope / roots) ** 2) / 2
    weights = value**2 / norm
    if not rim and not bore:
        return np.append(0.0, roots), np.append(2 / (1 - inner**2), weights)
    return roots, weights
