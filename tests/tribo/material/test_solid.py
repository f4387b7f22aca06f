import math

import pytest

from tribo import Material, contact_modulus

STEEL = {
    "elastic_modulus": 210e9,
    "poisson_ratio": 0.3,
    "hardness": 6.6e9,
    "thermal_conductivity": 45.0,
    "density": 7800.0,
    "specific_heat": 470.0,
}


def test_steel_has_the_paper_s_modulus_and_diffusivity():
    steel = Material(**STEEL)
    assert contact_modulus(steel, steel) == pytest.approx(115.385e9, rel=1e-5)
    assert steel.thermal_diffusivity == pytest.approx(1.2275e-5, rel=1e-4)


def test_a_rigid_body_leaves_the_other_s_modulus():
    rigid = Material(**STEEL | {"elastic_modulus": 1e30})
    assert contact_modulus(Material(**STEEL), rigid) == pytest.approx(210e9 / 0.91)


def test_no_hardness_is_purely_elastic():
    assert Material(210e9, 0.3, 45.0, 7800.0, 470.0).hardness == math.inf
