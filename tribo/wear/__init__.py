"""Wear of the pin: Archard's law in steps, and user-defined laws with a rate for each step."""

from tribo.wear.archard import WEAR_PATTERNS as WEAR_PATTERNS
from tribo.wear.archard import WEAR_SCHEMES as WEAR_SCHEMES
from tribo.wear.archard import RollingWear as RollingWear
from tribo.wear.archard import Stage as Stage
from tribo.wear.archard import Wear as Wear
from tribo.wear.archard import WearLaw as WearLaw
from tribo.wear.archard import WearPattern as WearPattern
from tribo.wear.archard import WearScheme as WearScheme
from tribo.wear.archard import evaluate_wear as evaluate_wear
from tribo.wear.archard import require_wear as require_wear

WEAR_LAWS: dict[str, type[Wear | WearLaw]] = {"Archard": Wear}
"""Classes of wear laws, by the form of the table ``[wear]`` that has their parameters."""
