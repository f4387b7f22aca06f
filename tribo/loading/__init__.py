"""Load as a function of time: ramps and records."""

from tribo.loading.ramp import Ramp as Ramp
from tribo.loading.ramp import Station as Station
from tribo.loading.record import MeasuredLoad as MeasuredLoad
