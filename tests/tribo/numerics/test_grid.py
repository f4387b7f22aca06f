import pytest

from tribo import Grid, InputError


def test_size_and_area_follow_from_shape_and_spacing():
    grid = Grid((240, 240), (1.632e-6, 1.9e-6))
    assert grid.size == pytest.approx((391.68e-6, 456e-6))
    assert grid.area == pytest.approx(240 * 240 * grid.element_area)


@pytest.mark.parametrize("name", ["shape", "spacing", "periodic"])
def test_a_grid_has_two_axes(name):
    sizes = {"shape": (4, 4), "spacing": (1.0, 1.0), "periodic": (False, True)}
    for count in (1, 3):
        wrong = (2 * sizes[name])[:count]
        with pytest.raises(InputError, match=f"^{name} is .*; it must hold two values"):
            Grid(**sizes | {name: wrong})


def test_coordinates_are_centred():
    grid = Grid((5, 4), (2.0, 3.0))
    assert grid.coordinates(0).tolist() == [-4.0, -2.0, 0.0, 2.0, 4.0]
    assert grid.coordinates(1).tolist() == [-4.5, -1.5, 1.5, 4.5]


@pytest.mark.parametrize(
    ("shape", "spacing"),
    [
        ((0, 4), (1.0, 1.0)),
        ((4, 2.5), (1.0, 1.0)),
        ((4, 4), (-1.0, 1.0)),
        ((4, 4), (1.0, float("nan"))),
        ((4, 4), (2e-6, 1e302)),
        ((4, 4), (2.1, 2e-6)),
    ],
)
def test_impossible_grids_are_refused(shape, spacing):
    with pytest.raises(InputError, match="must be"):
        Grid(shape, spacing)
