import math
from dataclasses import replace

import pytest

from tests.helpers.scenes import STEEL
from tribo import Material, contact_modulus


def test_a_rigid_body_leaves_the_other_s_modulus():
    rigid = replace(STEEL, elastic_modulus=1e30)
    assert contact_modulus(STEEL, rigid) == pytest.approx(210e9 / 0.91)


def test_no_hardness_is_purely_elastic():
    assert Material(210e9, 0.3, 45.0, 7800.0, 470.0).hardness == math.inf
