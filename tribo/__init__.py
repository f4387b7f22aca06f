"""Simulation of one point of the transition diagram: contact, wear and heat of rough bodies."""

from tribo.contact.elasticity import ElasticHalfSpace, elastic_influence
from tribo.contact.solver import ContactSolution, solve_contact
from tribo.convolution import Convolution
from tribo.errors import ConvergenceError, InputError, InvariantError, RangeError, TriboError
from tribo.files import read_heights, read_load
from tribo.grid import Grid
from tribo.inverse import (
    AISI_316,
    CriticalTemperature,
    Transition,
    WearRate,
    critical_temperature,
    critical_temperature_rig,
    rig_heating,
    specific_wear_rate,
)
from tribo.loading.ramp import Ramp, Station
from tribo.loading.record import MeasuredLoad
from tribo.material import Material, contact_modulus
from tribo.simulation.fidelity import PRESETS, Fidelity
from tribo.simulation.heating import heat
from tribo.simulation.kernels import forget_kernels
from tribo.simulation.scene import Ball, Cylinder, MeasuredRoughness, Scene, SelfAffineRoughness
from tribo.simulation.state import Heat, State
from tribo.simulation.steps import advance, measures, simulate, start, warnings
from tribo.simulation.warning import PointWarning, WarningKind
from tribo.thermal.conduction import ConductingHalfSpace
from tribo.thermal.duhamel import Conductor, HeatHistory, partition_with_history
from tribo.thermal.partition import HeatPartition, partition_heat
from tribo.thermal.quantiles import QUANTILES, contact_quantiles, failed_share
from tribo.topography import (
    average_roughness,
    block_average,
    rms_height,
    rms_slope,
    self_affine,
)
from tribo.wear import WEAR_SCHEMES, Wear

__all__ = [
    "AISI_316",
    "PRESETS",
    "QUANTILES",
    "WEAR_SCHEMES",
    "Ball",
    "ConductingHalfSpace",
    "Conductor",
    "ContactSolution",
    "ConvergenceError",
    "Convolution",
    "CriticalTemperature",
    "Cylinder",
    "ElasticHalfSpace",
    "Fidelity",
    "Grid",
    "Heat",
    "HeatHistory",
    "HeatPartition",
    "InputError",
    "InvariantError",
    "Material",
    "MeasuredLoad",
    "MeasuredRoughness",
    "PointWarning",
    "Ramp",
    "RangeError",
    "Scene",
    "SelfAffineRoughness",
    "State",
    "Station",
    "Transition",
    "TriboError",
    "WarningKind",
    "Wear",
    "WearRate",
    "advance",
    "average_roughness",
    "block_average",
    "contact_modulus",
    "contact_quantiles",
    "critical_temperature",
    "critical_temperature_rig",
    "elastic_influence",
    "failed_share",
    "forget_kernels",
    "heat",
    "measures",
    "partition_heat",
    "partition_with_history",
    "read_heights",
    "read_load",
    "rig_heating",
    "rms_height",
    "rms_slope",
    "self_affine",
    "simulate",
    "solve_contact",
    "specific_wear_rate",
    "start",
    "warnings",
]
