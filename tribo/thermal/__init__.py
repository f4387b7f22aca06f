"""Flash temperature, heat partition, and the temperature over the contact."""

from tribo.thermal.circuit import circuit_rise
from tribo.thermal.conduction import ConductingHalfSpace, HeatedLength, settling_time
from tribo.thermal.duhamel import Conductor, HeatHistory, conducted_spectrum, partition_with_history
from tribo.thermal.partition import DIRECT_MEMORY, HeatPartition, partition_heat
from tribo.thermal.quantiles import (
    BULK_RATIOS,
    QUANTILES,
    at_bulk_ratio,
    bulk_ratio_quantiles,
    contact_quantiles,
    failed_share,
    require_share,
    rise_exceeded,
)
from tribo.thermal.stem import stem_fraction
from tribo.thermal.track import track_warming

__all__ = [
    "BULK_RATIOS",
    "DIRECT_MEMORY",
    "QUANTILES",
    "ConductingHalfSpace",
    "Conductor",
    "HeatHistory",
    "HeatPartition",
    "HeatedLength",
    "at_bulk_ratio",
    "bulk_ratio_quantiles",
    "circuit_rise",
    "conducted_spectrum",
    "contact_quantiles",
    "failed_share",
    "partition_heat",
    "partition_with_history",
    "require_share",
    "rise_exceeded",
    "settling_time",
    "stem_fraction",
    "track_warming",
]
