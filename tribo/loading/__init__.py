"""Load as a function of time: ramps and records."""

from tribo.loading.ramp import Ramp, Station
from tribo.loading.record import MeasuredLoad

__all__ = ["MeasuredLoad", "Ramp", "Station"]
