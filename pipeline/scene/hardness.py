"""Hardness: from the scales of Vickers, Brinell and Rockwell to the pressure that a solid carries.

A Vickers number is a pressure already, in kgf/mm² on the faces of the impression. Brinell and
Rockwell C numbers are converted to it by Table 1 of ASTM E140, which holds for steels that are not
austenitic; between its lines linearly. Such a conversion is good to a few per cent at best.
"""

from __future__ import annotations

import re
from decimal import Decimal

import numpy as np

from tribo import InputError

_KGF_PER_MM2 = Decimal("9.80665e6")  # Pa
_SCALE = re.compile(r"(HV)[\d.]*|(HB)W?(?: ?[\d.]+/\d+)?|(HRC)")

# ASTM E140, Table 1: Vickers numbers of 20 to 68 HRC, and Brinell numbers (3000 kgf, ball of
# tungsten carbide) of 20 to 65 HRC. Compared row by row with a reprint of it (Phase II, manual of
# the PHT-2000; 35 to 68 HRC), which differs by one Vickers number at 62 HRC alone, and with Table 2
# of ASTM A370 (20 to 68 HRC), which differs by one Brinell number at 47, 49, 50 and 63 HRC.
_VICKERS = (
    238, 243, 248, 254, 260, 266, 272, 279, 286, 294, 302, 310, 318, 327, 336, 345, 354, 363, 372,
    382, 392, 402, 412, 423, 434, 446, 458, 471, 484, 498, 513, 528, 544, 560, 577, 595, 613, 633,
    653, 674, 697, 720, 746, 772, 800, 832, 865, 900, 940,
)  # fmt: skip
_BRINELL = (
    226, 231, 237, 243, 247, 253, 258, 264, 271, 279, 286, 294, 301, 311, 319, 327, 336, 344, 353,
    362, 371, 381, 390, 400, 409, 421, 432, 443, 455, 469, 481, 496, 512, 525, 543, 560, 577, 595,
    615, 634, 654, 670, 688, 705, 722, 739,
)  # fmt: skip
_OF_STEEL = {
    "HRC": (tuple(range(20, 69)), _VICKERS),
    "HB": (_BRINELL, _VICKERS[: len(_BRINELL)]),
}


def hardness_pressure(number: Decimal, unit: str) -> Decimal | None:
    """Pressure that a hardness number stands for [Pa]; None if the unit is not one of hardness.

    Units are HV, HB, HBW and HRC; HV and HBW also with a test load, as in HV10 or HBW 10/3000.
    """
    match = _SCALE.fullmatch(unit.strip())
    if match is None:
        return None
    scale = str(match[match.lastindex or 0])
    if scale == "HV":
        return number * _KGF_PER_MM2
    numbers, vickers = _OF_STEEL[scale]
    if not numbers[0] <= number <= numbers[-1]:
        raise InputError(
            f"is outside the conversion of ASTM E140 for steel, {numbers[0]} to {numbers[-1]} "
            f"{scale}; give it in HV, or as a pressure"
        )
    return Decimal(float(np.interp(float(number), numbers, vickers))) * _KGF_PER_MM2
