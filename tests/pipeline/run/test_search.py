"""The search of boundaries in closed form finds each crossing with few points."""

import itertools

import numpy as np
import pytest

from pipeline.run.line_search import Line
from pipeline.run.search import Goal
from tests.helpers.kept import assert_as_kept, some
from tests.helpers.plane_model import LOADS, PlaneModel, Verdict
from tests.helpers.search_in_memory import Told
from tribo import Conditions

VELOCITIES = np.linspace(0.25, 6.0, 40)
X = np.log(VELOCITIES)
LIMIT = 1200.0
SCATTER = 0.02  # of ln(rise), from realization to realization


def log_rise_ratio(load, x, generator):
    """Return ln(rise/limit): increasing, curved, and slightly rough."""
    slope, bend, level = generator.uniform([0.4, -0.06, -0.6], [0.9, 0.06, 0.6])
    middle = np.log(1.5)
    waves = sum(0.001 * np.sin(k * 9.0 * x + generator.uniform(0, 7)) for k in (1, 2))
    return level + 0.58 * load + slope * (x - middle) + bend * (x - middle) ** 2 + waves


class Specimen:
    """Rises of realizations in closed form, for a search."""

    def __init__(self, seed, loads=10, scatter=SCATTER, velocities=VELOCITIES, failing=()):
        self.shape = int(np.random.default_rng([0, seed]).integers(2**31))
        self.loads, self.stated = np.geomspace(200.0, 800.0, loads), scatter
        self.offsets = np.random.default_rng([7, seed]).normal(0.0, scatter, 256)
        self.failing, self.velocities, self._few = {*failing}, velocities, velocities
        self.batches = []  # of the last search that was run

    def y(self, load, x, realization=None):
        """ln(rise/limit) of a realization or of the mean of all."""
        log_ratio = log_rise_ratio(np.log(load / 400.0), x, np.random.default_rng(self.shape))
        return log_ratio + (0.0 if realization is None else self.offsets[realization])

    def search(self, accuracy, promised=0.0, realizations=256, **more):
        conditions = Conditions(0.1, 298.15, 418.15)
        freedom = more.pop("freedom", 7.0)
        goal = Goal(accuracy, realizations, **more)
        return Told(self.loads, self._few, conditions, promised, goal, freedom)

    def rise(self, point):
        if point[1:] in self.failing:
            return np.nan
        load, x = self.loads[point.load], np.log(self.velocities[point.velocity])
        return LIMIT * np.exp(self.y(load, x, point.realization))

    def run(self, search, known=None):
        """Return all requested points in order, or the first batch with a point not in `known`."""
        points, self.batches = [], []
        while batch := search.ask():
            self.batches.append(batch)
            if known is not None and not known.issuperset(batch):
                return batch
            assert not search.asked[tuple(np.array(batch).T)].any()  # nothing twice
            points += batch
            self.velocities = search.velocities
            rises = np.array([self.rise(point) for point in batch])
            search.tell(batch, rises, np.full(len(batch), self.stated))
        return points

    def critical(self, load):
        """Critical velocity at a load; NaN for none among the velocities."""
        fine = np.linspace(X[0], X[-1], 20001)
        k = int(np.argmax(self.y(load, fine) > 0))
        return np.exp(fine[k]) if k else np.nan


def test_the_crossing_is_found_at_every_load_that_is_searched():
    count = point_count = 0
    for seed in range(2):
        specimen = Specimen(seed, loads=5, scatter=0.0)
        search = specimen.search(0.02, realizations=1)
        point_count += len(specimen.run(search))
        for number in np.flatnonzero(search.asked[0].any(axis=1)):
            expected = specimen.critical(specimen.loads[number])
            assert search.critical[number] == pytest.approx(expected, rel=0.01, nan_ok=True)
            count += np.isfinite(expected)
    assert count > 5
    assert point_count < 2 * search.asked.size * 0.1


@pytest.mark.parametrize("accuracy", [0.05, 0.02])
def test_the_stated_error_is_below_the_goal_and_holds(accuracy):
    missed, count, points = 0, 0, []
    for seed in range(3):
        specimen = Specimen(seed, loads=4)
        search = specimen.search(accuracy, promised=0.4 * accuracy)
        points.append(len(specimen.run(search)))
        errors = np.sqrt((search.errors**2).sum(axis=0))
        for load, critical, error in zip(specimen.loads, search.critical, errors, strict=True):
            expected = specimen.critical(load)
            if np.isfinite(expected) and np.isfinite(critical):
                assert error <= accuracy
                missed += abs(critical / expected - 1) > error
                count += 1
    assert count > 7
    assert missed <= 0.05 * count
    assert np.mean(points) < 0.5 / accuracy**1.3 + 40


def test_a_smaller_goal_takes_more_realizations_and_rougher_loads_more():
    counts = []
    for accuracy, scatter in ((0.05, 0.02), (0.02, 0.02), (0.02, 0.04)):
        specimen = Specimen(3, loads=4, scatter=scatter)
        specimen.run(search := specimen.search(accuracy, 0.01))
        counts.append(search.asked.any(axis=2).sum(axis=0).max())
    assert counts == sorted(set(counts))


def test_a_realization_that_states_too_large_a_deviation_refuses_no_goal():
    specimen = Specimen(3, loads=2, scatter=0.01)
    specimen.stated = 0.08
    specimen.run(search := specimen.search(0.01, freedom=1.0))
    assert np.sqrt((search.errors**2).sum(axis=0)).max() <= 0.01


def test_an_error_of_one_realization_that_exceeds_the_goal_does_not_end_the_search():
    specimen = Specimen(13, loads=2, scatter=0.0003)
    specimen.run(search := specimen.search(0.0009))
    assert search.asked.any(axis=2).sum(axis=0).min() > 1


@pytest.mark.parametrize("accuracy", [0.1, 0.03])
def test_a_goal_takes_further_realizations_if_one_does_not_state_how_they_differ(accuracy):
    specimen = Specimen(4, loads=4)
    specimen.stated = np.nan
    specimen.run(search := specimen.search(accuracy, freedom=0.0))
    errors = np.sqrt((search.errors**2).sum(axis=0))
    is_critical = np.isfinite(search.critical)
    assert is_critical.sum() > 1
    assert (errors[is_critical] <= accuracy).all()
    assert search.specimen.realizations[is_critical].min() >= 3
    expected = np.array([specimen.critical(load) for load in specimen.loads])[is_critical]
    assert (np.abs(search.critical[is_critical] / expected - 1) <= errors[is_critical]).all()


def test_a_load_gets_a_second_realization_before_any_other():
    specimen = Specimen(4, loads=4)
    specimen.stated = np.nan
    specimen.run(specimen.search(0.03, freedom=0.0))
    further = {}
    for batch in specimen.batches:
        numbers = {
            load: {point.realization for point in batch if point.load == load}
            for load in {point.load for point in batch if point.realization}
        }
        further = numbers | further
    assert len(further) > 1
    assert all(numbers - {0} == {1} for numbers in further.values())


def test_a_search_that_was_stopped_asks_for_the_same_points_again():
    specimen = Specimen(5, loads=3)
    uninterrupted = specimen.run(specimen.search(0.05))
    generator, done = np.random.default_rng(1), set()
    for _ in range(len(uninterrupted)):
        batch = specimen.run(specimen.search(0.05), done)
        missing = [point for point in batch if point not in done]
        if not missing:
            break
        chosen = generator.permutation(len(missing))[: 1 + len(missing) // 2]
        done |= {missing[k] for k in chosen}
    assert done == {*uninterrupted}


def test_few_velocities_become_more_where_the_goal_needs_them():
    """Loads of a specimen share their surfaces, so their misses come together."""
    missed = found_count = 0
    for seed, count in itertools.product(range(2), (4, 6)):
        few = np.geomspace(0.25, 6.0, count)
        specimen = Specimen(seed, loads=4, velocities=few)
        search = specimen.search(0.01, promised=0.0055)
        specimen.run(search)
        assert {*few} <= {*search.velocities}
        errors = np.sqrt((search.errors**2).sum(axis=0))
        for load, critical, error in zip(specimen.loads, search.critical, errors, strict=True):
            if np.isfinite(critical):
                assert error <= 0.01
                missed += abs(critical / specimen.critical(load) - 1) > error
                found_count += 1
    assert found_count > 12
    assert missed <= 0.1 * found_count


FEW = np.geomspace(0.25, 6.0, 5)
FAILING = [(1, 12), (1, 13), (2, 5), *itertools.product([0], range(99))]  # load and velocity
SEARCHES = {  # seed, accuracy, the specimen, and the search
    "one realization": (0, 0.02, {"scatter": 0.0}, {"realizations": 1}),
    "several realizations": (3, 0.02, {"loads": 4}, {"promised": 0.01}),
    "surfaces that are given": (
        4,
        0.02,
        {"loads": 3},
        {"realizations": 3, "counts_surface": False},
    ),
    "few velocities": (1, 0.01, {"loads": 4, "velocities": FEW}, {"promised": 0.0055}),
    "velocities close together": (
        2,
        0.01,
        {"loads": 9, "scatter": 0.0, "velocities": np.array([1.4, 1.5, 1.6])},
        {"realizations": 1},
    ),
    "a velocity": (4, 0.02, {"loads": 3, "velocities": np.array([1.5])}, {}),
    "a load": (4, 0.03, {"loads": 1}, {}),
    "points that fail": (4, 0.02, {"loads": 4, "failing": FAILING}, {"promised": 0.01}),
    "an accuracy out of reach": (5, 0.01, {"loads": 3}, {"promised": 0.02}),
    "too few realizations": (5, 0.005, {"loads": 3}, {"realizations": 4}),
}


def test_the_points_of_searches_and_their_ends_are_kept():
    texts = {}
    for name, (seed, accuracy, options, more) in SEARCHES.items():
        specimen = Specimen(seed, **options)
        specimen.run(search := specimen.search(accuracy, **more))
        rows = [
            " ".join("/".join(map(str, point)) for point in batch) for batch in specimen.batches
        ]
        velocities, critical, errors = map(
            some, (search.velocities, search.critical, np.sqrt((search.errors**2).sum(axis=0)))
        )
        texts[name] = "\n".join([*rows, velocities, critical, errors])
    assert_as_kept("searches", texts)


@pytest.mark.parametrize(("sign", "neighbour"), [(1, 1), (-1, 3)])
def test_a_point_at_the_limit_is_followed_by_its_neighbour_beyond_the_limit(sign, neighbour):
    y = np.array([np.nan, np.nan, sign * 1e-7, np.nan, np.nan])
    assert Line(np.arange(5.0), y).next_velocity(0.0, 0.01) == neighbour


def test_without_a_crossing_the_search_ends_after_few_points():
    specimen = Specimen(0)
    for level, end in ((0.01, len(VELOCITIES) - 1), (100.0, 0)):
        search = specimen.search(0.02)
        specimen.rise = lambda point, k=level: k * LIMIT * VELOCITIES[point.velocity] ** 0.6
        points = specimen.run(search)
        assert len(points) <= 15  # three at each of five loads
        assert end in {point.velocity for point in points}  # the end that decides is simulated
        assert np.isnan(search.critical).all()


@pytest.mark.parametrize("seed", [2, 3])
def test_a_boundary_between_loads_that_are_mild_and_severe_at_all_velocities_is_searched(seed):
    specimen = Specimen(seed, loads=17, scatter=0.0, velocities=np.array([1.4, 1.5, 1.6]))
    at_ends = [specimen.y(specimen.loads, np.log(velocity)) for velocity in (1.4, 1.6)]
    crosses = (at_ends[0] < 0) & (at_ends[1] > 0)
    assert crosses.sum() == 1
    specimen.run(search := specimen.search(0.01, realizations=1))
    assert np.isfinite(search.critical).tolist() == crosses.tolist()
    assert np.sqrt((search.errors[:, crosses] ** 2).sum()) < 0.01


def test_surfaces_that_are_given_are_all_taken_and_left_out_of_the_goal():
    specimen = Specimen(4)
    search = specimen.search(0.02, realizations=3, counts_surface=False)
    specimen.run(search)
    surface_counts = search.asked.any(axis=2).sum(axis=0)
    assert {*surface_counts[np.isfinite(search.critical) & (surface_counts > 0)]} == {3}
    assert np.nanmax(search.reducible) < 0.02


def test_a_load_whose_points_fail_is_given_up_and_others_go_on():
    specimen = Specimen(4, loads=5, failing=itertools.product([2], range(99)))
    search = specimen.search(0.02)
    specimen.run(search)
    assert search.asked[:, 2].sum() == 3
    expected = np.array([specimen.critical(load) for load in specimen.loads])
    others = [0, 1, 3, 4]
    np.testing.assert_array_equal(
        np.isfinite(search.critical)[others], np.isfinite(expected)[others]
    )


def test_one_load_or_two_are_searched_to_all_their_crossings():
    for loads in (1, 2):
        specimen = Specimen(4, loads=loads)
        specimen.run(search := specimen.search(0.03))
        expected = [specimen.critical(load) for load in specimen.loads]
        assert search.critical == pytest.approx(expected, rel=0.03, nan_ok=True)


PLANES = {
    "as irg_transition": (12, 0.02, {}, 65),
    "independent loads": (5, 0.02, {"correlation": 0.0}, 75),
    "nearly equal realizations at all loads": (5, 0.02, {"correlation": 0.9}, 55),
    "a flat boundary": (5, 0.03, {"steepness": 0.4}, 45),
    "a steep boundary": (5, 0.03, {"steepness": 1.5}, 45),
    "realizations that drift along velocity": (12, 0.02, {"drift": 10.0}, 75),
    "few loads": (4, 0.01, {}, 150),
    "small deviations": (5, 0.01, {"scale": 0.4}, 70),
}  # loads, accuracy, what differs, and points at most


@pytest.mark.parametrize("name", PLANES)
def test_loads_of_a_plane_share_realizations_and_keep_the_errors_that_they_state(name):
    load_count, accuracy, options, max_points = PLANES[name]
    verdicts = []
    for seed in range(3):
        model = PlaneModel(LOADS[load_count], seed, **options)
        verdicts.append(Verdict.of(model, model.search(accuracy, 0.5 * accuracy)))
    assert all(verdict.stated <= accuracy for verdict in verdicts)
    assert np.mean([verdict.points for verdict in verdicts]) <= max_points
    for is_held in (verdict.is_held_at for verdict in verdicts):
        assert is_held.mean() > 0.7  # errors of the loads of a plane are correlated
    held = [np.append(verdict.is_held_at, verdict.is_held_between) for verdict in verdicts]
    assert np.mean(held) >= 0.9


def test_more_loads_between_the_same_two_take_hardly_more_points():
    points = [PlaneModel(LOADS[count], 1).search(0.02, 0.011).asked.sum() for count in (12, 30)]
    assert points[1] < 1.3 * points[0]
