"""The contact while the load grows (pipeline/figures/fields.py)."""

import itertools

import numpy as np
import pytest
from PIL import Image, ImageChops

from pipeline.figures.fields import save_animation
from pipeline.figures.plot import plot
from pipeline.store.schema import PENDING
from tests.helpers import synthetic
from tribo import InputError

LOADS = (200.0, 400.0, 750.0)


@pytest.fixture(scope="module")
def sweep():
    status = {(400.0, 2.0): PENDING}
    return synthetic.sweep(loads=LOADS, velocities=(1.0, 2.0), status=status, fields=True)


@pytest.fixture(scope="module")
def film(sweep, tmp_path_factory):
    """The file of an animation and its figures, of which the last one alone is too hot."""
    out, figures = tmp_path_factory.mktemp("film") / "ramp.gif", []

    def kept(pictures, *arguments):
        figures.extend(pictures)
        return save_animation(pictures, *arguments)

    hottest = 298.15 + 0.1 * sweep["rise"].sel(velocity=1.0).max(("x", "y")).values
    critical = (hottest[1] + hottest[2]) / 2
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pipeline.figures.plot.save_animation", kept)
        options = {"velocity": 1.0, "critical_temperature": critical}
        assert plot(sweep, "animation", out, width="8.5 cm", **options) == out
    return out, figures


def meshes(figure):
    return [axes.collections[0] for axes in figure.axes[:3]]


def test_each_load_that_is_done_has_a_picture_on_the_same_scales(sweep):
    figures = plot(sweep, "animation", velocity=2.0)
    for figure, load in zip(figures, (200.0, 750.0), strict=True):
        assert f"{load:g}\N{NO-BREAK SPACE}N, 2\N{NO-BREAK SPACE}m/s" in figure.get_suptitle()
        here = sweep.sel(load=load, velocity=2.0)
        temperatures = meshes(figure)[1].get_array()
        np.testing.assert_allclose(temperatures, (25.0 + 0.1 * here["rise"]).T)
    scales = [[mesh.get_clim() for mesh in meshes(figure)] for figure in figures]
    assert scales[0] == scales[1]
    rises = sweep["rise"].sel(velocity=2.0, load=[200.0, 750.0]).values
    assert scales[0][1] == pytest.approx((25.0 + 0.1 * rises.min(), 25.0 + 0.1 * rises.max()))


def test_only_pictures_that_cross_the_critical_temperature_have_an_outline(film):
    _, figures = film
    assert [len(figure.axes[1].collections) for figure in figures] == [1, 1, 2]
    assert len({figure.axes[1].child_axes[0].get_xlabel() for figure in figures}) == 1


def test_panels_stay_where_they_are(film):
    first, *others = (
        [axes.get_position().bounds for axes in figure.axes[:3]] for figure in film[1]
    )
    for other in others:
        np.testing.assert_allclose(other, first, atol=0.002)  # of the figure: under a pixel


def test_the_file_shows_one_picture_after_the_other_at_the_width_asked_for(film):
    with Image.open(film[0]) as image:
        frames = []
        for number in range(image.n_frames):
            image.seek(number)
            frames.append(image.convert("RGB"))
        assert image.width == int(8.5 / 2.54 * 100)
        assert image.info["loop"] == 0
    assert len(frames) >= len(LOADS)
    for one, other in itertools.pairwise(frames[: len(LOADS)]):
        assert ImageChops.difference(one, other).getbbox() is not None


def test_an_animation_is_a_gif_of_stored_fields(sweep, tmp_path):
    with pytest.raises(InputError, match=r"the suffix must be \.gif"):
        plot(sweep, "animation", tmp_path / "ramp.png")
    with pytest.raises(InputError, match="holds no fields"):
        plot(synthetic.sweep(), "animation", tmp_path / "ramp.gif")
