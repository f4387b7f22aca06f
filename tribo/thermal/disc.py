"""A turning disc that is heated around its rim and conducts the heat inwards."""

from __future__ import annotations

import functools
import math
from dataclasses import asdict, dataclass

import numpy as np
import scipy

from tribo.errors import require_positive
from tribo.types import Array

_ROOT_COUNT = 120
# Value of κt/a² below which the rim is computed as a curved half-space. Its error there is below
# 1e-4, while the series would need more than `_ROOT_COUNT` roots.
_EARLY_FOURIER = 4e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class Disc:
    """A disc that keeps all its heat.

    Parameters
    ----------
    diameter, width : float
        Diameter of the rim, and width of the disc across the track [m].

    Examples
    --------
    >>> print(Disc(diameter=0.1, width=0.01))
    100 × 10 mm
    """

    diameter: float
    width: float

    def __post_init__(self) -> None:
        require_positive(diameter=self.diameter, width=self.width)

    def __str__(self) -> str:
        return f"{1e3 * self.diameter:.4g} × {1e3 * self.width:.4g} mm"

    def rim_response(self, age: Array, diffusivity: float) -> Array:
        """Impulse response of the temperature of the rim [1/m], one value for each age.

        Heat Q per area [J/m²] that is spread over the rim at once warms the rim, after the time t,
        by Q/(ρc) times the response. This is a sum over the modes of a cylinder (Carslaw & Jaeger,
        *Conduction of Heat in Solids*, 2nd ed., 1959, §7.7),

            2/a Σ exp(−βₙ² κt/a²),   J₁(βₙ) = 0.

        Here a is the radius of the rim. At early times the response is 1/√(πκt), as of a
        half-space, corrected for the curvature of the rim.

        Parameters
        ----------
        age : ndarray
            Times t since the heat was spread over the rim, above 0 [s].
        diffusivity : float
            Thermal diffusivity κ [m²/s].

        Examples
        --------
        A disc of 100 × 10 mm, after a tenth of a second and when it has one temperature:

        >>> disc = Disc(diameter=0.1, width=0.01)
        >>> disc.rim_response(np.array([0.1, 600.0]), 1.2275e-5).round(1).tolist()
        [519.4, 40.0]
        """
        radius = self.diameter / 2
        fourier = diffusivity * age / radius**2
        is_early = fourier < _EARLY_FOURIER
        late_fourier = np.where(is_early, 1.0, fourier)[..., None]
        late_response = 2 * np.exp(-(_roots() ** 2) * late_fourier).sum(axis=-1)
        root = np.sqrt(np.where(is_early, fourier, 1.0))
        early_response = 1 / (math.sqrt(math.pi) * root) + 0.5 * scipy.special.erfcx(-0.5 * root)
        response: Array = np.where(is_early, early_response, late_response) / radius
        return response

    def as_dict(self) -> dict[str, float]:
        """Return the sizes by name."""
        return asdict(self)


@functools.cache
def _roots() -> Array:
    """Roots βₙ of J₁, beginning with 0."""
    return np.append(0.0, scipy.special.jn_zeros(1, _ROOT_COUNT))
