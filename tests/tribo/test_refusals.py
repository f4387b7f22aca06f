"""All refusals of tribo: what causes each, and what its message says."""

import ast
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import STEEL, last, small_scene
from tribo import (
    Ball,
    Bulk,
    Corrections,
    Criterion,
    Crowned,
    Cylinder,
    ElasticHalfSpace,
    Fidelity,
    Grid,
    MeasuredLoad,
    MeasuredRoughness,
    Motion,
    Oil,
    Ramp,
    RunningIn,
    Stem,
    TriboError,
    Wear,
    partition_heat,
    simulate,
    solve_contact,
)
from tribo.analytic import hertz_ellipse, moving_band_rise, rolling_sliding_rise
from tribo.contact import elastic_influence
from tribo.numerics import Convolution
from tribo.simulation import moment_of, start
from tribo.surface.topography import block_average
from tribo.thermal import (
    ConductingHalfSpace,
    Rule,
    contact_quantiles,
    rise_exceeded,
    with_bulk_ratio,
)
from tribo.wear import RollingWear
from tribo.wear.laws import require_wear, wear_over

GRID, FREE = Grid((6, 5), (1e-6, 1e-6)), Grid((6, 5), (1e-6, 1e-6), (False, False))
ZERO, ON = np.zeros(GRID.shape), np.ones(GRID.shape, bool)
WHITE = Oil((313.15, 373.15), (32e-6, 5e-6), 866.0, (20e-9, 15e-9))
RIG = tribo.critical_temperature_rig()
INFINITE = math.inf


def scene(**parts):
    return replace(small_scene(), **parts)


def solved(**change):
    arguments = {"separation": ZERO, "normal_load": 1e-3, "hardness": 1e9} | change
    return solve_contact(ElasticHalfSpace(GRID, 115e9), **arguments)


def divided(flux=ZERO + 1.0, on=ON, grid=GRID, time=1.0, **options):
    pin, disk = (ConductingHalfSpace(g, STEEL, 0.0, time) for g in (GRID, grid))
    return partition_heat(pin, disk, flux, on, **options)


def conducting(velocity=1.0, time=1.0, nodes=10, length=INFINITE, grid=FREE):
    return ConductingHalfSpace(grid, STEEL, velocity, time, nodes, length)


def judged(rise):
    rule = Rule("rise_quantile", rise, "own", "own")
    return Criterion("own", rule=rule).rise({"rise_quantile": np.linspace(0, 1, 30)})


class Flat:
    """A surface of a user's own."""

    def __init__(self, heights):
        self.given = heights

    def heights(self, pixels):
        return self.given if isinstance(self.given, np.ndarray) else 1 / 0


class Law:
    """A wear law of a user's own."""

    pattern = "swept"

    def over(self, begin, end):
        return 1.0


def gone_on(fidelity):
    state = next(iter(simulate(small_scene(), 300.0, 1.0)))
    return list(simulate(scene(fidelity=fidelity), 300.0, 1.0, trunk=state))


def off_trunk():
    return list(simulate(small_scene(), 300.0, 1.0, trunk=last(small_scene(), 100.0, 1.0)))


REFUSALS = {
    # materials, grids, closed forms
    "poisson": (lambda: replace(STEEL, poisson_ratio=0.6), "poisson_ratio is 0.6"),
    "soft": (lambda: replace(STEEL, hardness=0.0), "hardness is 0.0"),
    **{
        name: (lambda name=name: replace(STEEL, **{name: -1.0}), f"{name} is -1.0")
        for name in ("elastic_modulus", "thermal_conductivity", "density", "specific_heat")
    },
    "oil rises": (lambda: replace(WHITE, temperatures=(373.0, 313.0)), "they must rise"),
    "oil falls": (lambda: replace(WHITE, viscosities=(5e-6, 32e-6)), "must fall with temperature"),
    "oil thin": (lambda: replace(WHITE, viscosities=(1e-6, 1e-7)), "at least 3.1e-07"),
    "oil alpha": (lambda: Oil((313.0, 373.0), (3e-5, 5e-6), 866.0).pressure_coefficient(300.0),
                  "no pressure-viscosity coefficient"),
    "film": (lambda: tribo.lubrication_regime(math.nan), "film_parameter is nan"),
    "two axes": (lambda: Grid((4, 4, 4), (1.0, 1.0)), "it must hold two values"),
    "no pixels": (lambda: Grid((0, 4), (1.0, 1.0)), "nx is 0; it must be an integer of at least 1"),
    "no side": (lambda: Grid((4, 4), (1.0, -1.0)), "dy is -1.0"),
    "elongated": (lambda: Grid((4, 4), (2.1, 2e-6)), "one side must be at most"),
    "spectrum": (lambda: Convolution(GRID, np.ones((4, 4))), "the spectrum has shape (4, 4)"),
    "backwards": (lambda: rolling_sliding_rise(0.1, 1e5, 2e-4, (-1.0, 2.0), 1e4),
                  "both must be at least 0"),
    "ellipse": (lambda: hertz_ellipse(1.0, 0.0, 1.0, 1e9), "radius_x is 0.0"),
    "band": (lambda: moving_band_rise(0.0, 1.0, 1.0, 0.0, 45.0, 1e-5), "velocity is 0.0"),
    # surfaces, wear, loading
    "hurst": (lambda: tribo.self_affine(GRID, 1e-7, 1.2, 1e-6, 0), "hurst_exponent is 1.2"),
    "single": (lambda: tribo.self_affine(Grid((1, 1), (1.0, 1.0)), 1e-7, 0.8, 1e-6, 0),
               "a single element has no roughness"),
    "seed": (lambda: tribo.self_affine(GRID, 1e-7, 0.8, 1e-6, -1), "seed is -1"),
    "blocks": (lambda: block_average(ZERO, 4), "6 × 5 pixels cannot be averaged 4 × 4"),
    "few heights": (lambda: tribo.fit_self_affine(ZERO, (1.0, 1.0)), "6 × 5 heights are too few"),
    "one row": (lambda: MeasuredRoughness(np.zeros(3)), "must be a two-dimensional array"),
    "text": (lambda: MeasuredRoughness(np.array([["a"]])), "must hold real numbers"),
    "hole": (lambda: MeasuredRoughness([[1.0], [math.inf]]), "1 of 2 places, the first at (1, 0)"),
    "other pixels": (lambda: scene(roughness=MeasuredRoughness(ZERO)), "has (6, 5) pixels"),
    "own shape": (lambda: scene(roughness=Flat(ZERO)), "its heights have the shape (6, 5)"),
    "own nan": (lambda: scene(roughness=Flat(np.full((48, 16), math.nan))),
                "height is nan at pixel (0, 0)"),
    "own fault": (lambda: scene(roughness=Flat(None)), "ZeroDivisionError: division by zero"),
    "rate": (lambda: Wear(-1.0), "specific_wear_rate is -1.0"),
    "pattern": (lambda: Wear(1.0, "round"), "allowed are local, swept"),
    "swept": (lambda: Wear(1.0, "swept").yielding(ElasticHalfSpace(FREE, 1e9), 1.0),
              "use the pattern 'local'"),
    "share worn": (lambda: RollingWear(1.0, "local", 0.0), "window_share is 0.0"),
    "running in": (lambda: RunningIn(-1.0, 0.0, 1.0), "initial_rate is -1.0"),
    "no distance": (lambda: RunningIn(1.0, 0.0, 0.0), "distance is 0.0"),
    "own wear": (lambda: wear_over(Law(), 0.0, 1.0), "it must be a tribo.Wear"),
    "no law": (lambda: require_wear(1.0), "has no pattern, over; see tribo.WearLaw"),
    "hold": (lambda: Ramp(1.0, 1.0, hold=-1.0), "hold is -1.0 s"),
    "hold steps": (lambda: Ramp(1.0, 1.0, 1.0, 10**7), "hold_steps is 10000000"),
    "steps": (lambda: list(Ramp(150.0, 750.0, hold=1e6).stations(600.0, 100)),
              "at most 1000000 are allowed"),
    "no load": (lambda: list(Ramp(1.0, 1.0).stations(0.0, 9)), "normal_load is 0.0"),
    "no numbers": (lambda: MeasuredLoad(["a", "b"], [0.0, 1.0]), "must hold real numbers"),
    "columns": (lambda: MeasuredLoad([0.0, 1.0], [1.0]), "two columns of equal length"),
    "row": (lambda: MeasuredLoad([0.0, 0.0], [0.0, 1.0]), "row 1 (counted from 0): time 0 s"),
    "no rise": (lambda: MeasuredLoad([0.0, 1.0], [5.0, 5.0]), "begins at 5 N and reaches 5 N"),
    "record": (lambda: list(MeasuredLoad([0.0, 1.0], [0.0, 1.0]).stations(1.0, 9, 0.5)),
               "points of a record share no trunk"),
    # contact
    "load": (lambda: solved(normal_load=1.0), "the most at a hardness of 1e+09 Pa"),
    "no hardness": (lambda: solved(hardness=0.0), "hardness is 0.0"),
    "beyond doubles": (lambda: solved(normal_load=1e300, hardness=INFINITE), "double precision"),
    "no array": (lambda: solved(separation=[[0.0, 1.0], [2.0]]), "separation is not an array"),
    "shape": (lambda: solved(initial_pressure=np.zeros((2, 2))), "must be (6, 5), like the grid"),
    "stop": (lambda: solved(criterion="epsilon"), "allowed are gap, pressure-change"),
    "kernel": (lambda: elastic_influence(GRID, 1.0, "leakage"), "allowed are periodic, nearest"),
    "one axis": (lambda: elastic_influence(FREE, 1.0, "nearest-image"), "along one axis"),
    "modulus": (lambda: ElasticHalfSpace(GRID, 0.0), "contact_modulus is 0.0"),
    # heat
    "bulk": (lambda: Bulk(-1.0, 1.0), "capacity is -1.0"),
    "no bulk": (lambda: Bulk(), "capacity and loss are both 0"),
    "stem": (lambda: Stem(1.0, -1.0), "settling_time is -1.0"),
    "no stem": (lambda: Stem(0.0), "resistance is 0.0"),
    "speed": (lambda: conducting(velocity=math.nan), "velocity is nan"),
    "time": (lambda: conducting(time=-1.0), "time is -1.0"),
    "nodes": (lambda: conducting(nodes=0), "quadrature_nodes is 0"),
    "image": (lambda: conducting(length="nearest-image"), "periodic along y"),
    "length": (lambda: conducting(length=0.0), "length is 0.0; it must be positive"),
    "criterion": (lambda: Criterion("blok"), "allowed are share, highest, mean"),
    "own rises": (lambda: judged(lambda *_: np.zeros(2)), "one for each row of quantiles"),
    "own beyond": (lambda: judged(lambda *_: np.float64(2.0)), "beyond the lowest and highest"),
    "own rule": (lambda: judged(lambda *_: 1 / 0), "criterion own: ZeroDivisionError"),
    "equal bulks": (lambda: with_bulk_ratio({"mean_rise": 1.0}, 2.0), "set unequal_bulks"),
    "no contact": (lambda: contact_quantiles(ZERO, ~ON), "no element is in contact"),
    "share": (lambda: rise_exceeded(ZERO, 1.0), "share is 1.0; it must be at least 0"),
    "stored": (lambda: rise_exceeded(np.ones(2), 0.1, (0.0, 0.5)), "quantiles allow from 0.5"),
    "bodies": (lambda: divided(grid=FREE), "they must be the same"),
    "flux": (lambda: divided(flux=np.ones(3)), "both must be (6, 5), like the grid"),
    "mask": (lambda: divided(on=ZERO), "it must hold bool"),
    "flux nan": (lambda: divided(flux=ZERO * math.nan), "a NaN or an infinity"),
    "difference": (lambda: divided(bulk_difference=np.inf), "a NaN or an infinity"),
    "outside": (lambda: divided(on=~ON), "not 0 everywhere outside the contact"),
    "method": (lambda: divided(method="blok"), "method is 'blok'"),
    "tolerance": (lambda: divided(tolerance=0.0), "tolerance is 0.0; it must be from 1e-14"),
    "no friction": (lambda: divided(ZERO, method="uniform", bulk_difference=1.0), "there is none"),
    "no time": (lambda: divided(time=0.0, bulk_difference=1.0), "no time to conduct"),
    # scenes and their points
    "choice": (lambda: Fidelity(kernel="none"), "kernel is 'none'; allowed are"),
    "heat tolerance": (lambda: Fidelity(heat_tolerance=1.0), "heat_tolerance is 1.0"),
    "history": (lambda: Fidelity(heat_model="history", history_coarsening=2), "so it must be 1"),
    "motions": (Motion, "exactly one of them must be given"),
    "both motions": (lambda: Motion(slide_roll_ratio=0.5, entrainment_velocity=2.0),
                     "exactly one of them must be given"),
    "motion": (lambda: Motion(entrainment_velocity=INFINITE), "entrainment_velocity is inf"),
    "rolling": (lambda: Motion(slide_roll_ratio=0.0), "bodies that roll have no sliding velocity"),
    "track": (lambda: Motion(slide_roll_ratio=1.0, track_length=0.0), "track_length is 0.0"),
    "short track": (lambda: scene(motion=Motion(slide_roll_ratio=1.0, track_length=3e-4)),
                    "track_length is 0.0003 m"),
    "cylinder": (lambda: Cylinder(1.0, 0.0, STEEL), "length is 0.0"),
    "no ball": (lambda: Ball(0.0, STEEL), "radius is 0.0"),
    "crown": (lambda: Crowned(1.0, -1.0, STEEL), "crown_radius is -1.0"),
    "divisor": (lambda: scene(fidelity=Fidelity(pixels_per_element=5)), "choose a common divisor"),
    "x": (lambda: scene(pixels=Grid((48, 16), (8e-6, 8e-6), (True, True))), "periodic along x"),
    "ball": (lambda: scene(pin=Ball(1e-3, STEEL)), "under a ball pin both axes must be free"),
    "images": (lambda: small_scene("local", periodic=(False, False), kernel="nearest-image"),
               "the kernel 'nearest-image' needs a patch"),
    "ends": (lambda: small_scene("local", periodic=(False, False), heat_kernel="endless"),
             "the heat_kernel 'endless' needs a patch"),
    "own law rolls": (lambda: scene(wear=RunningIn(2e-15, 1e-15, 1.0),
                                    motion=Motion(slide_roll_ratio=1.0)), "needs a pin at rest"),
    "uniform": (lambda: replace(small_scene(partition="uniform"), unequal_bulks=True),
                "divides frictional heat alone"),
    "velocity": (lambda: list(simulate(small_scene(), 300.0, math.nan)), "velocity is nan"),
    "carries": (lambda: list(simulate(small_scene(), 1e9, 1.0)), "the window carries at most"),
    "trunk": (off_trunk, "cannot go on to 300 N from the state at 100 N"),
    "heat model": (lambda: gone_on(small_scene(heat_model="history").fidelity),
                   "cannot go on from a state of the other one"),
    "frictions": (lambda: Corrections(friction=((2.0, 1.0), (1.0, 1.0))), "above 0 and ascending"),
    "factor": (lambda: Corrections(friction=((1.0, -1.0),)), "each must be finite and ≥ 0"),
    "oxide": (lambda: Corrections(film_resistance=-1.0), "film_resistance is -1.0"),
    "no heat": (lambda: moment_of(RIG, start(RIG), None), "ended without a temperature"),
    "transitions": (lambda: tribo.critical_temperature(RIG, [], 298.0), "at least one is needed"),
    "bulks": (lambda: tribo.critical_temperature(RIG, [(1.0, 1.0, 0.1)], math.nan),
              "both must be finite"),
    "rolls": (lambda: tribo.specific_wear_rate(scene(motion=Motion(slide_roll_ratio=1.0)),
                                               3e-4, 600.0, 1.25), "makes its contact no wider"),
    "width": (lambda: tribo.specific_wear_rate(RIG, 1.0, 10.0, 0.065), "it must lie between"),
}  # fmt: skip

ELSEWHERE = {
    "record.read_load": "loading/test_record.py, with files",
    "record._header": "loading/test_record.py, with files",
    "record._numbers": "loading/test_record.py, with files",
    "heights.read_heights": "surface/test_heights.py, with files",
    "heights._read_npy": "surface/test_heights.py, with files",
    "heights._read_csv": "surface/test_heights.py, with files",
    "errors.require_file": "loading/test_record.py and surface/test_heights.py, with files",
    "invariants.check_contact": "simulation/test_invariants.py, by solvers that are wrong",
    "invariants.check_wear": "simulation/test_invariants.py, by wear that is wrong",
    "invariants.check_heat": "simulation/test_invariants.py, by solvers that are wrong",
    "invariants.within_range": "simulation/test_invariants.py and test_extremes.py",
    "invariants._require_finite": "simulation/test_invariants.py, by solvers that are wrong",
    "solver.solve_contact": "contact/test_solver.py, as no convergence",
    "partition.partition_heat": "thermal/test_partition.py, as no convergence",
    "solver._check": "simulation/test_extremes.py, as steps that are too long",
    "inverse._crossing": "no width within the window needs so high a rate",
    "inverse.rig_heating": "the rig always touches; for the type checker",
    "errors.of_law": "passes an error of tribo on as it is",
}
"""Functions with a refusal that is not in the table, and where it is tested, or why it is not."""


@pytest.mark.parametrize("name", REFUSALS)
def test_what_is_refused_is_named(name):
    build, said = REFUSALS[name]
    with pytest.raises(TriboError) as caught:
        build()
    assert said in str(caught.value)


def raised(build):
    """Places in the code, as file and line, that an error and its causes have passed."""
    try:
        build()
    except TriboError as error:
        cause = error
        while cause is not None:
            step = cause.__traceback__
            while step is not None:
                yield Path(step.tb_frame.f_code.co_filename).resolve(), step.tb_lineno
                step = step.tb_next
            cause = cause.__context__


def statements(file):
    """Lines of each raise of a file, with the name of its function."""
    tree = ast.parse(file.read_text("utf-8"))
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            for node in ast.walk(function):
                if isinstance(node, ast.Raise):
                    yield function.name, node.lineno, node.end_lineno


def test_the_table_has_every_refusal():
    reached = {place for build, _ in REFUSALS.values() for place in raised(build)}
    missing = [
        f"{file}:{first} in {name}"
        for file in sorted(Path(tribo.__file__).resolve().parent.rglob("*.py"))
        for name, first, end in statements(file)
        if f"{file.stem}.{name}" not in ELSEWHERE
        and not any((file, line) in reached for line in range(first, end + 1))
    ]
    assert missing == []
