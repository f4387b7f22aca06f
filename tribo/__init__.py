"""Simulation of one point of the transition diagram: contact, wear and heat of rough bodies.

Requires only NumPy and SciPy. Quantities are in SI::

    import tribo
    steel = tribo.Material(210e9, 0.3, 45.0, 7800.0, 470.0, hardness=6.6e9)
    scene = tribo.Scene(
        pixels=tribo.Grid((144, 120), (4e-6, 4e-6)),
        pin=tribo.Cylinder(2e-3, 3.4e-3, steel),
        disk=steel,
        roughness=tribo.SelfAffineRoughness(2.7e-7, 0.8, (8e-6, 8e-6)),
        loading=tribo.Ramp(150.0, 750.0),
        wear=tribo.Wear(1.2e-15),
    )
    oil = tribo.Conditions(0.1, bulk_temperature=298.0, critical_temperature=418.0)
    tribo.judge(scene, 600.0, 1.25, oil)

The public names, in the order of work:

- bodies: `Material`, `contact_modulus`, `Pin`, `Cylinder`, `Ball`, `Crowned`, `Relief`, `PINS`
- surface: `Grid`, `Surface`, `SelfAffineRoughness`, `MeasuredRoughness`
- load, motion and wear: `Ramp`, `Stages`, `MeasuredLoad`, `Motion`, `Wear`, `WearLaw`
- simulation: `Scene`, `Fidelity`, `PRESETS`, `simulate`, `State`, `measures`, `warnings`,
  `WarningKind`
- verdict: `Conditions`, `judge`, `Verdict`, `QUANTILES`
- effects that act after the simulation: `Corrections`, `Track`, `Disc`
- oil film: `Oil`, `lubrication_regime`
- closed forms: `analytic`
- errors: `TriboError`, `InputError`, `ConvergenceError`, `InvariantError`
"""

from . import analytic as analytic
from .errors import ConvergenceError as ConvergenceError
from .errors import InputError as InputError
from .errors import InvariantError as InvariantError
from .errors import TriboError as TriboError
from .loading import MeasuredLoad as MeasuredLoad
from .loading import Ramp as Ramp
from .loading import Stages as Stages
from .material import Material as Material
from .material import Oil as Oil
from .material import contact_modulus as contact_modulus
from .material import lubrication_regime as lubrication_regime
from .numerics import Grid as Grid
from .simulation import PINS as PINS
from .simulation import PRESETS as PRESETS
from .simulation import Ball as Ball
from .simulation import Conditions as Conditions
from .simulation import Corrections as Corrections
from .simulation import Crowned as Crowned
from .simulation import Cylinder as Cylinder
from .simulation import Fidelity as Fidelity
from .simulation import Motion as Motion
from .simulation import Pin as Pin
from .simulation import Relief as Relief
from .simulation import Scene as Scene
from .simulation import State as State
from .simulation import Track as Track
from .simulation import Verdict as Verdict
from .simulation import WarningKind as WarningKind
from .simulation import judge as judge
from .simulation import measures as measures
from .simulation import simulate as simulate
from .simulation import warnings as warnings
from .surface import MeasuredRoughness as MeasuredRoughness
from .surface import SelfAffineRoughness as SelfAffineRoughness
from .surface import Surface as Surface
from .thermal import QUANTILES as QUANTILES
from .thermal import Disc as Disc
from .wear import Wear as Wear
from .wear import WearLaw as WearLaw
