"""Choice of a fidelity where the readings of every probe are given: errors computed by hand."""

from dataclasses import replace

import pytest

from pipeline.store.create import writing
from pipeline.sweep.model import Point
from pipeline.sweep.stages import Progress
from pipeline.sweep.variants import surfaces
from pipeline.tradeoff import choose
from pipeline.tradeoff.choose import choose_accuracy, choose_fidelity, measure_error
from pipeline.tradeoff.probe import YARDSTICK, OwnError, Probe, Reading, Yardstick
from tests.helpers import synthetic, tiny
from tests.helpers.accuracy_scenes import SCENES
from tribo import PRESETS, ConvergenceError, Fidelity, Grid, InputError

WORN, UNWORN = (
    SCENES[name].changed(
        loads=loads,
        velocities=tuple(0.1 * k for k in range(1, 41)),
        pixels=Grid((96, 48), (4e-6, 4e-6)),
    )
    for name, loads in (("low loads", (60.0, 100.0, 180.0)), ("no wear", (200.0, 400.0, 750.0)))
)
SEVERAL = 60.0, 70.0, 80.0, 90.0, 100.0, 110.0, 120.0, 180.0
FEW = (0.5, 1.0)


def reading(rise, nodes=5000):
    return Reading(rise, nodes)


class Rig:
    """Probes that err as told, by a function of the fidelity and the number of the point.

    Rises grow with the velocity itself, so that the boundary errs as they do.
    """

    def __init__(self):
        self.err, self.nodes, self.own = lambda fidelity, number: 0.02, 5000, OwnError(0, 0)
        self.exponents, self.judged, self.said, self.takes = {}, [], [], 1.0

    def near_the_boundary(self, sweep, places):
        points = tuple(Point(place.load, 1.0, place.variant) for place in places)
        return points, tuple(self.exponents.get(place.load, 1.0) for place in places)

    def measured(self, sweep, points, exponents, progress):
        readings = (reading(1000.0, self.nodes + 1),) * (len(points) - 1)
        readings += (reading(1000.0, self.nodes),)
        return Yardstick(tuple(points), tuple(exponents), readings, 300.0)

    def own_error(self, sweep, points, exponents, readings):
        assert len(points) == len(exponents) == len(readings)
        self.judged = list(points)
        return self.own

    def probe(self, sweep, fidelity, points):
        rises = [1000.0 / (1 + self.err(fidelity, number)) for number in range(len(points))]
        return Probe(fidelity, tuple(map(reading, rises)), 30.0)

    def choose(self, sweep, accuracy, points=None):
        self.said.clear()
        return choose_fidelity(sweep, accuracy, points, self.said.append)


@pytest.fixture
def rig(monkeypatch):
    rig = Rig()
    for name in ("near_the_boundary", "measured", "own_error", "probe"):
        monkeypatch.setattr(choose, name, getattr(rig, name))
    monkeypatch.setattr(choose, "probing_time", lambda sweep, tries: rig.takes)
    return rig


def alternating(fidelity, number):
    return 0.02 if number % 2 else -0.02


@pytest.mark.parametrize(
    ("sweep", "err", "nodes", "expected"),
    [
        # Both sides of each load: what the largest is, times 1.1, or 1.5 where few touch.
        (WORN, alternating, 400, 0.022 + 0.1 / 400),
        (WORN, alternating, 399, 0.03 + 0.1 / 399),
        # Some loads: 1.3 times the largest, or the mean and 2.5 standard deviations.
        (WORN.changed(velocities=FEW), lambda *_: 0.02, 5000, 0.026 + 2e-5),
        (WORN.changed(velocities=FEW), lambda _, k: 0.02 - 0.01 * k, 5000, 0.01 + 0.025 + 2e-5),
        (WORN.changed(velocities=FEW), lambda _, k: 0.01 * k - 0.02, 5000, 0.01 + 0.025 + 2e-5),
        # Of two loads no deviation is known.
        (WORN.changed(velocities=FEW, loads=(60.0, 180.0)), alternating, 5000, 0.026 + 2e-5),
        # Four of eight loads at both sides: 8 errors of either sign deviate by √(8/7) of them.
        (WORN.changed(loads=SEVERAL), alternating, 5000, 0.05 * (8 / 7) ** 0.5 + 2e-5),
    ],
)
def test_the_error_of_a_fidelity_is_that_at_any_load(rig, sweep, err, nodes, expected):
    rig.err, rig.nodes = err, nodes
    rig.own = OwnError(0.004, 0.003)
    kept = rig.choose(sweep, None)
    assert kept.error == pytest.approx(expected + 0.004 + 0.002 + 0.003, rel=1e-9)
    assert (kept.name, kept.accuracy, len(kept.trials)) == ("the scene's own fidelity", None, 1)
    assert kept.fidelity == sweep.scene.fidelity
    assert kept.exact_seconds == 300.0
    assert kept.trials[0].seconds == 30.0
    past = sweep.changed(fidelity=replace(sweep.scene.fidelity, heat_model="history"))
    assert rig.choose(past, None).error == pytest.approx(kept.error - 0.003, rel=1e-9)
    rig.own = replace(rig.own, scatters=True)
    assert rig.choose(sweep, None).error == pytest.approx(kept.error, rel=1e-9)


@pytest.mark.parametrize(
    ("sweep", "velocities", "places", "is_thorough"),
    [
        # Steps of 25 up to three loads, five times; against half of 100 and one for each load.
        (WORN, 4, 3, False),  # 5 · (9 + 14 + 25) = 240 > 206
        (WORN, 5, 3, True),  # 240 < 257.5
        (WORN.changed(loads=SEVERAL), 5, 4, False),  # 5 · (9 + 12 + 16 + 25) = 310 > 270
        (WORN.changed(loads=SEVERAL), 6, 4, True),  # 310 < 324
        # Without wear each load is a single step.
        (UNWORN, 9, 3, False),  # 5 · 3 = 15 > 13.5
        (UNWORN, 10, 3, True),  # 15 = 15
        # Surfaces have their turns, at six places.
        (WORN.changed(variants=surfaces((3, 4, 5))), 1, 6, False),
    ],
)
def test_both_sides_of_the_boundary_are_probed_where_that_takes_few_steps(
    rig, sweep, velocities, places, is_thorough
):
    sweep = sweep.changed(velocities=tuple(0.5 + k for k in range(velocities)))
    points = rig.choose(sweep, None).points
    assert len(rig.judged) == places  # one at each, for the error of the steps themselves
    assert len({(point.load, point.variant) for point in rig.judged}) == places
    if is_thorough:
        apart = [pytest.approx(side) for side in (0.951229, 1.051271)]  # exp(±0.05)
        assert [velocity for _, velocity in points] == apart * places
        assert {load for load, _ in points[:2]} == {points[0][0]}
    else:
        assert [velocity for _, velocity in points] == [1.0] * places


NAMES = [
    "draft", "standard", "fine", "fine, one grid, solved more tightly", "reference",
    "reference, 2 times the steps", "reference, 4 times the steps",
]  # fmt: skip


@pytest.mark.parametrize("nodes", [100, 5000])
def test_choices_are_tried_from_draft_to_the_reference(rig, nodes):
    rig.err, rig.nodes, rig.own = lambda *_: 0.5, nodes, OwnError(0.8, 0.0)
    picked = rig.choose(WORN, 0.01)
    assert [trial.name for trial in picked.trials] == NAMES
    tried = [name for name in NAMES if not name.startswith("reference")]
    assert rig.said == [
        Progress("the boundary by the preset standard"),
        Progress("the error of these steps themselves"),
        *(
            Progress(f"choice {k} of at most {len(tried)}: {name}", k - 1, len(tried))
            for k, name in enumerate(tried, 1)
        ),
    ]
    by_name = {trial.name: trial.fidelity for trial in picked.trials}
    for preset in ("draft", "standard", "fine", "reference"):
        assert by_name[preset] == PRESETS[preset]
    finest = by_name["fine, one grid, solved more tightly"]
    assert finest.history_coarsening == 1
    assert finest.contact_tolerance < by_name["fine"].contact_tolerance
    assert finest.increments > by_name["fine"].increments
    # What steps of the yardstick err, 25 of them, falls as their number grows.
    assert [(one.fidelity.increments, one.error, one.seconds) for one in picked.trials[-3:]] == [
        (100, pytest.approx(0.202), 4 * 300.0),
        (200, pytest.approx(0.102), 8 * 300.0),
        (400, pytest.approx(0.052), 16 * 300.0),
    ]
    assert "reference, 4 times the steps" in str(picked)
    assert "more than asked for" in str(picked)


@pytest.mark.parametrize(
    ("own", "accuracy", "names"),
    [
        (OwnError(0.8, 0.0), 0.103, NAMES[:6]),  # is enough
        (OwnError(0.0, 0.0), 1e-3, NAMES[:5]),  # would not help
        (OwnError(0.8, 0.0, scatters=True), 1e-3, NAMES[:5]),
    ],
)
def test_steps_are_refined_until_they_are_enough_or_do_not_help(rig, own, accuracy, names):
    rig.err, rig.own = lambda *_: 5.0, own
    assert [trial.name for trial in rig.choose(WORN, accuracy).trials] == names


@pytest.mark.parametrize(("error", "name"), [(0.00209, "standard"), (0.00212, NAMES[4])])
def test_where_none_is_enough_the_cheapest_is_taken_that_errs_no_more_than_the_finest(
    rig, error, name
):
    """The reference errs by 0.2 %, and what errs by no more than a twentieth over it will do."""

    def err(fidelity, number):
        is_it = fidelity.increments == PRESETS["standard"].increments
        return (error - 0.002 - 2e-5) / 1.1 if is_it else 0.5

    rig.err = err
    picked = rig.choose(WORN, 0.001)
    assert picked.name == name
    assert picked.trials[-1].name == name


@pytest.mark.parametrize(("of_heat", "is_past"), [(0.0139, False), (0.0142, True)])
def test_all_the_past_is_taken_where_the_present_heat_errs_by_most_of_the_accuracy(
    rig, of_heat, is_past
):
    rig.err, rig.own = lambda *_: 0.5, OwnError(0.0, of_heat)
    trials = rig.choose(WORN, 0.02).trials
    assert {trial.fidelity.heat_model for trial in trials} == {"history" if is_past else "elapsed"}
    if is_past:
        assert all(trial.name.endswith(", with all heat so far") for trial in trials)
        assert {trial.fidelity.history_coarsening for trial in trials} == {1}
        assert [trial.fidelity.increments for trial in trials] == [50] * (len(trials) - 1) + [100]
        assert trials[-1].error == pytest.approx(0.002)
    else:
        assert trials[-1].error == pytest.approx(0.002 + of_heat)


def test_a_choice_that_does_not_converge_is_passed_over_unless_it_is_the_scene_s_own(rig):
    def err(fidelity, number):
        if fidelity.increments == PRESETS["draft"].increments:
            raise ConvergenceError("the contact did not converge", None)
        return 0.001

    rig.err = err
    picked = rig.choose(WORN, 0.02)
    assert [trial.name for trial in picked.trials] == ["standard"]
    with pytest.raises(ConvergenceError):
        rig.choose(WORN.changed(fidelity=PRESETS["draft"]), None)


def test_points_that_are_asked_for_are_judged_by_the_exponents_of_their_loads(rig):
    """Rises that err by 2 % at an exponent of 1/2 let the velocity err by 1.02² − 1."""
    rig.exponents = {60.0: 1.0, 180.0: 0.5}
    points = Point(60.0, 2.0), Point(180.0, 0.7), Point(180.0, 0.9)
    rig.err = lambda _, number: 0.02 if number == 2 else 0.0
    kept = rig.choose(WORN, None, points)
    assert kept.points == ((60.0, 2.0), (180.0, 0.7), (180.0, 0.9))
    assert rig.judged == [*points]
    assert kept.error == pytest.approx(1.1 * 0.0404 + 0.002 + 2e-5, rel=1e-9)
    rig.err = lambda _, number: 0.0 if number else 0.02
    assert rig.choose(WORN, None, points).error == pytest.approx(0.022 + 0.002 + 2e-5, rel=1e-9)


def test_a_still_point_among_others_has_no_error(rig):
    with pytest.raises(InputError, match="velocity is 0, so there is no heat"):
        rig.choose(WORN, None, [Point(60.0, 1.0), Point(60.0, 0.0)])


@pytest.mark.parametrize("accuracy", [0.08, 0.02])
def test_a_choice_that_is_a_preset_gives_the_scene_its_name(rig, accuracy):
    steps = PRESETS["draft"].increments
    rig.err = lambda fidelity, _: 0.05 if fidelity.increments == steps else 0.001
    changed = choose_accuracy(WORN, accuracy)
    name = "draft" if accuracy == 0.08 else "standard"
    assert (changed.about.selection.name, changed.about.preset) == (name, name)
    assert changed.scene.fidelity == changed.about.selection.fidelity


def test_a_store_whose_choice_errs_by_the_accuracy_goes_on(tmp_path):
    sweep = tiny.sweep(selection=synthetic.selection(error=0.05))
    with writing(tmp_path / "a.zarr", sweep):
        pass
    assert choose_accuracy(tiny.sweep(), 0.05, store=tmp_path / "a.zarr").about.preset == "fine"


def test_the_error_of_an_own_fidelity_is_measured(rig, tmp_path):
    own = WORN.changed(fidelity=Fidelity(increments=30))
    measured = measure_error(own, tmp_path / "new.zarr", rig.said.append)
    assert measured.changed(selection=None) == own
    assert measured.about.selection.name == "the scene's own fidelity"
    assert rig.said[0] == Progress("the boundary by the preset standard")


def test_the_error_of_an_own_fidelity_is_that_of_its_store(rig, tmp_path):
    selection = synthetic.selection(accuracy=None, name="the scene's own fidelity")
    with writing(tmp_path / "a.zarr", tiny.sweep(selection=selection)):
        pass
    again = measure_error(tiny.sweep(), tmp_path / "a.zarr", rig.said.append)
    assert again.about.selection == selection
    assert rig.said == []


def test_a_long_probe_says_before_how_long_it_takes(rig):
    rig.takes = 42.0
    rig.choose(WORN, 0.05)
    assert rig.said[0] == Progress("takes roughly 42 s")


def test_more_steps_than_the_yardstick_s_err_less_unless_they_scatter():
    own = OwnError(0.04, 0.01)
    twice = replace(YARDSTICK, increments=50)
    assert own.of(YARDSTICK) == pytest.approx(0.04 + 0.002 + 0.01)
    assert own.of(twice) == pytest.approx(0.02 + 0.002 + 0.01)
    assert own.of(replace(twice, heat_model="history")) == pytest.approx(0.02 + 0.002)
    assert replace(own, scatters=True).of(twice) == pytest.approx(0.04 + 0.002 + 0.01)
