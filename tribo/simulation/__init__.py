"""One point of the diagram: loading with wear and friction heat."""

from tribo.simulation.cache import forget_contacts, forget_kernels
from tribo.simulation.contact_ramp import contacts, inseparable, leads_to, mechanics, wear_number
from tribo.simulation.fidelity import PRESETS, Fidelity
from tribo.simulation.loading_step import advance, start
from tribo.simulation.motion import Motion, Velocities
from tribo.simulation.pins import Ball, Crowned, Cylinder
from tribo.simulation.point import heated, simulate
from tribo.simulation.point_warnings import PointWarning, WarningKind, warnings
from tribo.simulation.roughness import MeasuredRoughness, SelfAffineRoughness
from tribo.simulation.scene import Scene
from tribo.simulation.state import Heat, State
from tribo.simulation.step_measures import measures
from tribo.simulation.temperature import heat

__all__ = [
    "PRESETS",
    "Ball",
    "Crowned",
    "Cylinder",
    "Fidelity",
    "Heat",
    "MeasuredRoughness",
    "Motion",
    "PointWarning",
    "Scene",
    "SelfAffineRoughness",
    "State",
    "Velocities",
    "WarningKind",
    "advance",
    "contacts",
    "forget_contacts",
    "forget_kernels",
    "heat",
    "heated",
    "inseparable",
    "leads_to",
    "measures",
    "mechanics",
    "simulate",
    "start",
    "warnings",
    "wear_number",
]
