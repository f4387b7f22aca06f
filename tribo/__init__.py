"""Simulation of one point of the transition diagram: contact, wear and heat of rough bodies.

Needs NumPy and SciPy alone.
"""

from . import analytic as analytic
from .errors import ConvergenceError as ConvergenceError
from .errors import InputError as InputError
from .errors import InvariantError as InvariantError
from .errors import TriboError as TriboError
from .loading import MeasuredLoad as MeasuredLoad
from .loading import Ramp as Ramp
from .material import Material as Material
from .material import Oil as Oil
from .material import contact_modulus as contact_modulus
from .material import lubrication_regime as lubrication_regime
from .numerics import Grid as Grid
from .simulation import FRICTIONS as FRICTIONS
from .simulation import PINS as PINS
from .simulation import PRESETS as PRESETS
from .simulation import Ball as Ball
from .simulation import Conditions as Conditions
from .simulation import Corrections as Corrections
from .simulation import Crowned as Crowned
from .simulation import Cylinder as Cylinder
from .simulation import Fidelity as Fidelity
from .simulation import Friction as Friction
from .simulation import Motion as Motion
from .simulation import Pin as Pin
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
from .thermal import CRITERIA as CRITERIA
from .thermal import QUANTILES as QUANTILES
from .thermal import Bulk as Bulk
from .thermal import Criterion as Criterion
from .thermal import Disc as Disc
from .thermal import Rule as Rule
from .thermal import Stem as Stem
from .wear import LAWS as LAWS
from .wear import RunningIn as RunningIn
from .wear import Wear as Wear
from .wear import WearLaw as WearLaw
