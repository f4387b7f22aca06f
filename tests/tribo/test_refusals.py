"""All refusals of tribo: what causes each; tests/kept has what it says."""

import math
from dataclasses import fields, replace

import numpy as np

import tribo
from tests.helpers.refusals import refusal_tests
from tests.helpers.scenes import STEEL, small_scene
from tribo import (
    Ball,
    Crowned,
    Cylinder,
    Disc,
    Fidelity,
    Grid,
    MeasuredLoad,
    MeasuredRoughness,
    Motion,
    Oil,
    Ramp,
    Stages,
    Track,
    Wear,
    simulate,
)
from tribo.analytic import rolling_sliding_rise
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.inverse import specific_wear_rate
from tribo.numerics import Convolution
from tribo.simulation import stages_of, start, state_rises, widen_window
from tribo.simulation.verdict import allowable_rise
from tribo.surface import self_affine
from tribo.surface.areal import remove_form
from tribo.surface.topography import block_average
from tribo.thermal import ConductingHalfSpace, contact_quantiles, partition_heat, rise_exceeded
from tribo.wear import RollingWear
from tribo.wear.archard import evaluate_wear, require_wear
from workflows.paper.rig import critical_temperature_rig

GRID, FREE = Grid((6, 5), (1e-6, 1e-6)), Grid((6, 5), (1e-6, 1e-6), (False, False))
ZERO, ON = np.zeros(GRID.shape), np.ones(GRID.shape, bool)
WHITE = Oil((32e-6, 5e-6), 866.0, 20e-9)
RIG = critical_temperature_rig()
INFINITE = math.inf


TRACK = Track(0.3, 3e-3, 1.0, 1e-5, 4e6, 1e-2)


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


class Flat:
    """A user's own surface with given heights."""

    def __init__(self, heights):
        self._heights = heights

    def heights(self, pixels):
        return self._heights if isinstance(self._heights, np.ndarray) else 1 / 0


class Law:
    """A user's own wear law, which returns a wrong type."""

    pattern = "swept"

    def mean_wear(self, begin, end, pressure, velocity):
        return 1.0


REFUSALS = {
    # materials, grids, closed forms
    "poisson": lambda: replace(STEEL, poisson_ratio=0.6),
    "poisson of -1": lambda: replace(STEEL, poisson_ratio=-1.0),
    "soft": lambda: replace(STEEL, hardness=0.0),
    **{
        name: lambda name=name: replace(STEEL, **{name: -1.0})
        for name in ("elastic_modulus", "thermal_conductivity", "density", "specific_heat")
    },
    "oil falls": lambda: replace(WHITE, viscosities=(5e-6, 32e-6)),
    "oil thin": lambda: replace(WHITE, viscosities=(1e-6, 1e-7)),
    "oil solid": lambda: replace(WHITE, viscosities=(32e-6, 0.0)),
    "oil density": lambda: replace(WHITE, density=0.0),
    "oil coefficient": lambda: replace(WHITE, pressure_coefficient=0.0),
    "oil below 0 K": lambda: WHITE.viscosity(-1.0),
    "film": lambda: tribo.lubrication_regime(math.nan),
    "text for distances": lambda: tribo.analytic.hertz_pressure("1 mm", 1e-4, 1e9),
    "text for a number": lambda: Cylinder("2 mm", 1.0, STEEL),
    "no material": lambda: Ball(1e-3, 45.0),
    "no pair": lambda: Grid(4, (1.0, 1.0)),
    "no flags": lambda: replace(GRID, periodic=True),
    "no stages": lambda: Stages(5.0, (1.0,), 1.0),
    "no pin": lambda: scene(pin=2e-3),
    "no surface": lambda: scene(roughness=1e-7),
    "two axes": lambda: Grid((4, 4, 4), (1.0, 1.0)),
    "float pixels": lambda: Grid((4.0, 4), (1.0, 1.0)),
    "tiny": lambda: Grid((4, 4), (1e-200, 1e-200)),
    "vast": lambda: Grid((2**600, 2**600), (1.0, 1.0)),
    "elongated": lambda: Grid((4, 4), (2.1, 2e-6)),
    "spectrum": lambda: Convolution(GRID, np.ones((11, 5))),
    "backwards": lambda: rolling_sliding_rise(0.1, 1e5, 2e-4, (-1.0, 2.0), 1e4),
    # surfaces, wear, loading
    "hurst": lambda: self_affine(GRID, 1e-7, 1.2, 1e-6, 0),
    "hurst of 0": lambda: self_affine(GRID, 1e-7, 0.0, 1e-6, 0),
    "single": lambda: self_affine(Grid((1, 1), (1.0, 1.0)), 1e-7, 0.8, 1e-6, 0),
    "ra": lambda: self_affine(GRID, 0.0, 0.8, 1e-6, 0),
    **{
        f"length {axis}": lambda lengths=lengths: self_affine(GRID, 1e-7, 0.8, lengths, 0)
        for axis, lengths in (("x", (0.0, 1e-6)), ("y", (1e-6, 0.0)))
    },
    "seed": lambda: self_affine(GRID, 1e-7, 0.8, 1e-6, -1),
    "blocks": lambda: block_average(ZERO, 4),
    "one row": lambda: MeasuredRoughness(np.zeros(3)),
    "text": lambda: MeasuredRoughness(np.array([["a"]])),
    "hole": lambda: MeasuredRoughness([[1.0], [math.inf]]),
    "other pixels": lambda: scene(roughness=MeasuredRoughness(ZERO)),
    "own shape": lambda: scene(roughness=Flat(ZERO)),
    "own nan": lambda: scene(roughness=Flat(np.full((48, 16), math.nan))),
    "own fault": lambda: scene(roughness=Flat(None)),
    "rate": lambda: Wear(-1.0),
    "pattern": lambda: Wear(1.0, "round"),
    "swept": lambda: Wear(1.0, "swept").yielding(ElasticHalfSpace(FREE, 1e9), 1.0),
    "share worn": lambda: RollingWear(1.0, "local", 0.0),
    "own wear": lambda: evaluate_wear(Law(), 0.0, 1.0, 1e9, 1.0),
    "no law": lambda: require_wear(1.0),
    "ramp rate": lambda: Ramp(0.0, 1.0),
    "no increments": lambda: list(Ramp(1.0, 1.0).load_steps(1.0, 0)),
    "hold": lambda: Ramp(1.0, 1.0, hold=-1.0),
    "stages that do not rise": lambda: Stages((2.0, 2.0), (1.0, 1.0), 1.0),
    "stages without hold": lambda: Stages((1.0, 2.0), (1.0,), 1.0),
    "no stage": lambda: list(Stages((1.0,), (1.0,), 1.0).load_steps(2.0, 4)),
    "many stages": lambda: [*Stages((1.0,), (1.0,), 1.0).load_steps(1.0, 100_000)],
    "stages on a measured surface": lambda: widen_window(scene(
        loading=Stages((400.0,), (60.0,), 150.0), roughness=MeasuredRoughness(np.ones((48, 16))),
    ), 4.0),
    "no heights": lambda: remove_form(np.full((6, 5), np.nan), (1e-6, 1e-6)),
    "a plane for a surface": lambda: remove_form(np.ones((6, 5)), (1e-6, 1e-6)),
    "zeros for a surface": lambda: remove_form(np.zeros((6, 5)), (1e-6, 1e-6)),
    "stage at an edge": lambda: stages_of(scene(
        loading=Stages((400.0,), (60.0,), 150.0), roughness=None), 400.0, 4.0),
    "steps": lambda: list(Ramp(1.0, 1e-9).load_steps(600.0, 100)),
    "no numbers": lambda: MeasuredLoad(["a", "b"], [0.0, 1.0]),
    "columns": lambda: MeasuredLoad([0.0, 1.0], [1.0]),
    "a single reading": lambda: MeasuredLoad([0.0], [1.0]),
    "row": lambda: MeasuredLoad([0.0, 0.0], [0.0, 1.0]),
    "reading": lambda: MeasuredLoad([0.0, 1.0, INFINITE], [0.0, 1.0, 2.0]),
    "no rise": lambda: MeasuredLoad([0.0, 1.0], [5.0, 5.0]),
    "record load": lambda: list(MeasuredLoad([0.0, 1.0], [0.0, 1.0]).load_steps(0.0, 9)),
    # contact
    "load": lambda: solved(normal_load=1.0),
    "no hardness": lambda: solved(hardness=0.0),
    "beyond doubles": lambda: solved(normal_load=1e300, hardness=INFINITE),
    "never stops": lambda: solved(tolerance=0.0),
    "no iterations": lambda: solved(max_iterations=0),
    "no array": lambda: solved(separation=[[0.0, 1.0], [2.0]]),
    "shape": lambda: solved(initial_pressure=np.zeros((2, 2))),
    "kernel": lambda: ElasticHalfSpace(GRID, 1.0, "leakage"),
    "one axis": lambda: ElasticHalfSpace(FREE, 1.0, "nearest-image"),
    "modulus": lambda: ElasticHalfSpace(GRID, 0.0),
    # heat
    "speed": lambda: conducting(velocity=math.nan),
    "time": lambda: conducting(time=-1.0),
    "nodes": lambda: conducting(nodes=0),
    "image": lambda: conducting(length="nearest-image"),
    "length": lambda: conducting(length=0.0),
    "share below 0": lambda: tribo.Conditions(0.1, 298.0, critical_area_fraction=-0.1),
    "no share": lambda: tribo.Conditions(0.1, 298.0, critical_area_fraction=1.0),
    "no contact": lambda: contact_quantiles(ZERO, ~ON),
    "stored": lambda: rise_exceeded(np.ones(2), 0.1, (0.0, 0.5)),
    "bodies": lambda: divided(grid=FREE),
    "flux": lambda: divided(flux=np.ones(3)),
    "mask": lambda: divided(on=ZERO),
    "flux nan": lambda: divided(flux=np.where(np.eye(6, 5), math.nan, 1.0)),
    "outside": lambda: divided(on=~ON),
    "tolerance": lambda: divided(tolerance=0.0),
    "no time": lambda: divided(time=0.0, bulk_difference=1.0),
    # scenes and their points
    "contact tolerance": lambda: Fidelity(contact_tolerance=0.0),
    "loose contact tolerance": lambda: Fidelity(contact_tolerance=1.1),
    "infinite imprint": lambda: Fidelity(imprint=INFINITE),
    **{
        name: lambda name=name: Fidelity(**{name: -1})
        for name in ("pixels_per_element", "increments", "fewest_elements", "history_coarsening",
                     "parts", "imprint")
    },
    **{
        f"track {name}": lambda name=name: replace(TRACK, **{name: 0.0})
        for name in (field.name for field in fields(Track))
        if name != "disc"
    },
    "added rise": lambda: tribo.Conditions(
        friction=0.1, bulk_temperature=298.0, added_rise_fraction=-1.0
    ),
    "friction of conditions": lambda: tribo.Conditions(friction=-0.1, bulk_temperature=298.0),
    "bulk of conditions": lambda: tribo.Conditions(friction=0.1, bulk_temperature=0.0),
    "rise of conditions": lambda: tribo.Conditions(0.1, 298.0, added_rise_fraction=np.nan),
    "critical": lambda: tribo.Conditions(friction=0.1, bulk_temperature=298.0,
                                          critical_temperature=298.0),
    "no limit": lambda: allowable_rise(tribo.Conditions(friction=0.1, bulk_temperature=298.0)),
    "disc diameter": lambda: Disc(diameter=0.0, width=1.0),
    "motion": lambda: Motion(slide_roll_ratio=INFINITE),
    "rolling": lambda: Motion(slide_roll_ratio=0.0),
    "track": lambda: Motion(slide_roll_ratio=1.0, disk_track_length=0.0),
    "short track": lambda: scene(motion=Motion(slide_roll_ratio=1.0, pin_track_length=3e-4)),
    "cylinder": lambda: Cylinder(1.0, 0.0, STEEL),
    "long relief": lambda: Cylinder(1.0, 1.0, STEEL, tribo.Relief(2e-6, 0.6)),
    "flat relief": lambda: Cylinder(1.0, 1.0, STEEL, tribo.Relief(0.0, 0.1)),
    "ends": lambda: scene(pixels=Grid((48, 16), (8e-6, 8e-6), (False, False))),
    "no ends": lambda: scene(pin=Cylinder(2e-3, 1e-3, STEEL, tribo.Relief(2e-6, 1e-4))),
    "no ball": lambda: Ball(0.0, STEEL),
    "crown": lambda: Crowned(1.0, -1.0, STEEL),
    "divisor": lambda: scene(fidelity=Fidelity(pixels_per_element=5)),
    "x": lambda: scene(pixels=Grid((48, 16), (8e-6, 8e-6), (True, True))),
    "ball": lambda: scene(pin=Ball(1e-3, STEEL)),
    "own law rolls": lambda: scene(wear=Law(), motion=Motion(slide_roll_ratio=1.0)),
    "velocity": lambda: list(simulate(small_scene(), 300.0, math.nan)),
    "carries": lambda: list(simulate(small_scene(), 1e9, 1.0)),
    "no heat": lambda: state_rises(RIG, start(RIG), None),
    "rolls": lambda: specific_wear_rate(scene(motion=Motion(slide_roll_ratio=1.0)),
                                               3e-4, 600.0, 1.25),
    "width": lambda: specific_wear_rate(RIG, 1.0, 10.0, 0.065),
}  # fmt: skip

ELSEWHERE = {
    "invariants.check_contact InvariantError": "simulation/test_invariants.py, by wrong solvers",
    "invariants.check_wear InvariantError": "simulation/test_invariants.py, by wear that is wrong",
    "invariants.check_heat InvariantError": "simulation/test_invariants.py, by wrong solvers",
    "invariants.guard_range RangeError": "simulation/test_invariants.py and test_extremes.py",
    "invariants._require_finite InvariantError": "simulation/test_invariants.py, by wrong solvers",
    "solver._check_arguments InputError": "simulation/test_extremes.py, as steps that are too long",
    "solver.solve_contact ConvergenceError": "contact/test_solver.py",
    "partition.partition_heat ConvergenceError": "thermal/test_partition.py",
    "inverse._crossing InputError": "no width within the window needs so high a rate",
    "point._states InputError": "a point always touches; for the type checker",
}
"""Refusals, by function and class, that are not in the table: where they are tested, or why not."""


refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "../tribo", REFUSALS, ELSEWHERE
)
