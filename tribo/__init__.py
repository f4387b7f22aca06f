"""Simulation of one point of the transition diagram: contact, wear and heat of rough bodies."""

from tribo.conduction import ConductingHalfSpace
from tribo.contact import ContactSolution, solve_contact
from tribo.convolution import Convolution
from tribo.elasticity import ElasticHalfSpace, elastic_influence
from tribo.errors import ConvergenceError, InputError, TriboError
from tribo.fidelity import PRESETS, Fidelity
from tribo.grid import Grid
from tribo.loading import Ramp, Station
from tribo.material import Material, contact_modulus
from tribo.partition import HeatPartition, partition_heat
from tribo.scene import Ball, Cylinder, MeasuredRoughness, Scene, SelfAffineRoughness
from tribo.simulation import Heat, State, advance, heat, measures, simulate, start, warnings
from tribo.topography import (
    average_roughness,
    block_average,
    read_heights,
    rms_height,
    rms_slope,
    self_affine,
)
from tribo.transition import QUANTILES, contact_quantiles, failed_share
from tribo.wear import Wear

__all__ = [
    "PRESETS",
    "QUANTILES",
    "Ball",
    "ConductingHalfSpace",
    "ContactSolution",
    "ConvergenceError",
    "Convolution",
    "Cylinder",
    "ElasticHalfSpace",
    "Fidelity",
    "Grid",
    "Heat",
    "HeatPartition",
    "InputError",
    "Material",
    "MeasuredRoughness",
    "Ramp",
    "Scene",
    "SelfAffineRoughness",
    "State",
    "Station",
    "TriboError",
    "Wear",
    "advance",
    "average_roughness",
    "block_average",
    "contact_modulus",
    "contact_quantiles",
    "elastic_influence",
    "failed_share",
    "heat",
    "measures",
    "partition_heat",
    "read_heights",
    "rms_height",
    "rms_slope",
    "self_affine",
    "simulate",
    "solve_contact",
    "start",
    "warnings",
]
