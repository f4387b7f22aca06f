"""Viscosities by the index of an oil (pipeline/scene/viscosity.py)."""

import pytest

from pipeline.scene.viscosity import viscosity_index, warm_viscosity


@pytest.mark.parametrize("cold", [22e-6, 46e-6, 220e-6, 680e-6])
@pytest.mark.parametrize("index", [40.0, 95.0, 100.0, 160.0, 250.0])
def test_the_viscosity_at_100_degrees_has_the_index(cold, index):
    """The equations of D2270 join within 0.2 % of L and H at the ends of their ranges."""
    warm = warm_viscosity(cold, index)
    assert viscosity_index(cold, warm) == pytest.approx(index, abs=0.5)
    assert warm < warm_viscosity(cold, index + 5)


@pytest.mark.parametrize(
    ("warm", "L", "H"),
    # Of Table 1 of ASTM D2270, as printed by programs and pages that reprint it.
    [(4e-6, 25.32, 19.56), (10e-6, 147.7, 82.87), (20e-6, 493.2, 229.5)],
)
def test_the_index_is_0_and_100_at_the_viscosities_of_the_standard(warm, L, H):
    assert viscosity_index(1e-6 * L, warm) == pytest.approx(0, abs=1)
    assert viscosity_index(1e-6 * H, warm) == pytest.approx(100, abs=1)
