"""The contact at one moment of a simulation."""

from __future__ import annotations

from dataclasses import dataclass

from tribo.thermal.duhamel import HeatHistory
from tribo.types import Array

__all__ = ["Heat", "State"]


@dataclass(frozen=True, slots=True, eq=False)
class Heat:
    """Temperature of the contact, per unit friction coefficient.

    Attributes
    ----------
    rise : ndarray, shape (nx, ny)
        Temperature rise of the pin's surface above bulk [K].
    rise_quantile : ndarray, shape (len(QUANTILES),)
        Quantiles of the rise over the contact area [K].
    max_rise, mean_rise : float
        Largest and mean rise over the contact area [K].
    pin_heat_share : float
        Share of the friction heat that goes into the pin.
    iterations : int
        Iterations of the heat partition, each one convolution.
    """

    rise: Array
    rise_quantile: Array
    max_rise: float
    mean_rise: float
    pin_heat_share: float
    iterations: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """The contact at one moment of the loading.

    Attributes
    ----------
    pressure : ndarray, shape (nx, ny)
        Contact pressure [Pa].
    wear_depth : ndarray, shape (nx, ny)
        Depth that the pin has lost since the start [m].
    normal_load : float
        Load on the whole pin [N].
    time : float
        Time since the start [s].
    sliding_distance : float
        Distance slid since the start [m].
    impulse : float
        Integral of the load over the time since the start, ∫F dt [N s].
    on_trunk : bool
        Whether the simulation of a higher load passes through this state.
    index : int
        Steps of the loading that lead here.
    iterations : int
        Convolutions that the contact took, on all grids.
    work : int
        Convolutions of the contact times the elements of their grids.
    residual : float
        Residual of the contact, see `ContactSolution`.
    previous_pressure : ndarray, shape (nx, ny)
        Contact pressure one station before [Pa]; the next pressure is extrapolated from it.
    previous_load : float
        The load at that station [N].
    displacement, previous_displacement : ndarray, shape (nx, ny), or None
        Elastic ones under both pressures [m], from the datum of the solid, where they are known.
    heat : Heat or None
        Temperature of the contact, where it was asked for.
    history : State or None
        The same moment on the coarser grid of the history, where there is one; it is from there
        that the ramp goes on.
    heat_history : HeatHistory or None
        Heat that has flowed so far, where the temperature depends on it.
    """

    pressure: Array
    wear_depth: Array
    normal_load: float
    time: float
    sliding_distance: float
    impulse: float
    on_trunk: bool
    index: int
    iterations: int
    residual: float
    previous_pressure: Array
    previous_load: float
    displacement: Array | None = None
    previous_displacement: Array | None = None
    work: int = 0
    heat: Heat | None = None
    history: State | None = None
    heat_history: HeatHistory | None = None
