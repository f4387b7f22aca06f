"""Measure speed as ratios of CPU times within one run, and print them as a table.

    python -m tests.benchmarks.speed

A contact is compared with other solvers at equal residual, a point with its bare transforms, a
start with the imports of its libraries, and a goal with its points. `make bench` installs the other
solvers; the table leaves out those that are not installed.
"""

import contextlib
import importlib
import math
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.fft

import pipeline
from pipeline.sweep import plan
from tests.helpers.points import run_point
from tribo import Grid
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.simulation import RampCache
from tribo.surface import self_affine

CONTACT_MODULUS = 115.385e9
SIDE = 512  # elements along each axis
RESIDUAL = 1e-6  # that each solver reaches, with the loosest of its tolerances that does
TOLERANCES = [10.0**-digits for digits in range(5, 14)]
REPEATS, LONG = 3, 1.0  # contacts that take longer [s] are not repeated
LIBRARIES = "import numpy, scipy.special, pandas, xarray, zarr"
GOAL_SCENE, GOAL = "first_try", "5%"
HEADS = "| computation | CPU time | compared with | ratio |\n|---|---|---|---|"


class Contact(NamedTuple):
    """Contact problem: a rigid shape pressed into a half-space."""

    name: str
    grid: Grid
    separation: np.ndarray
    normal_load: float

    def solid(self):
        """The half-space; if periodic, with the spectrum 2/(E*|q|) of the other solvers."""
        solid = ElasticHalfSpace(self.grid, CONTACT_MODULUS)
        if not all(self.grid.periodic):
            return solid
        (nx, ny), (dx, dy) = self.grid.shape, self.grid.spacing
        q = 2 * np.pi * np.hypot(np.fft.fftfreq(nx, dx)[:, None], np.fft.rfftfreq(ny, dy))
        q[0, 0] = math.inf
        return solid.replace_spectrum(2 / (CONTACT_MODULUS * q))

    def residual(self, pressure):
        """Largest violation of a condition of the contact problem by a pressure.

        For the gap it is relative to the displacement of one element under the largest pressure.
        For the load and the bound 0 it is relative.
        """
        solid = self.solid()
        gap = solid(np.ascontiguousarray(pressure)) + self.separation
        gap -= gap[pressure > 0].mean()
        unit = solid.self_influence * pressure.max()
        load = pressure.sum() * self.grid.element_area
        return max(
            np.abs(gap[pressure > 0]).max() / unit,
            -gap[pressure <= 0].min(initial=0.0) / unit,
            abs(load / self.normal_load - 1),
            -pressure.min() / pressure.max(),
        )


def periodic_contact():
    """Contact of a periodic rough surface."""
    grid = Grid((SIDE, SIDE), (1e-6, 1e-6), (True, True))
    heights = self_affine(grid, 0.3e-6, 0.8, 20e-6, 0)
    load = 5.6e-3 * CONTACT_MODULUS * grid.area
    return Contact("periodic, rough", grid, -heights, load)


def line_contact():
    """Contact of a cylinder with a rough surface at 600 N, as in the paper."""
    grid = Grid((SIDE, SIDE), (0.765e-6, 0.95e-6), (False, True))
    separation = grid.coordinates(0)[:, None] ** 2 / (2 * 2e-3)
    separation = separation - self_affine(grid, 0.27e-6, 0.8, 4e-6, 0)
    return Contact("line, rough", grid, separation, 600.0 * grid.size[1] / 3.4e-3)


def ball_contact():
    """Contact of a smooth ball on a patch 3 contact radii wide."""
    radius, load = 10e-3, 10.0
    contact_radius = (3 * load * radius / (4 * CONTACT_MODULUS)) ** (1 / 3)
    grid = Grid((SIDE, SIDE), (3 * contact_radius / SIDE,) * 2, (False, False))
    x, y = grid.coordinates(0)[:, None], grid.coordinates(1)
    return Contact("ball, smooth", grid, (x**2 + y**2) / (2 * radius), load)


def tribo_solver(contact):
    """Function from a tolerance to the pressure [Pa], by this project."""
    solid = contact.solid()
    return lambda tolerance: (
        solve_contact(solid, contact.separation, contact.normal_load, tolerance=tolerance).pressure
    )


def tamaas_solver(contact):
    """Function from a tolerance to the pressure [Pa], by Tamaas; None for a line contact."""
    tamaas = importlib.import_module("tamaas")
    grid = contact.grid
    if grid.periodic[0] != grid.periodic[1]:
        return None
    tamaas.set_log_level(tamaas.LogLevel.error)
    model = tamaas.ModelFactory.createModel(
        tamaas.model_type.basic_2d, list(grid.size), list(grid.shape)
    )
    model.E, model.nu = CONTACT_MODULUS, 0.0
    if not any(grid.periodic):
        tamaas.ModelFactory.registerNonPeriodic(model, "free")
    heights = np.ascontiguousarray(-contact.separation)

    def solve(tolerance):
        model.traction[...] = 0.0
        model.displacement[...] = 0.0
        solver = tamaas.PolonskyKeerRey(model, heights, tolerance)
        if not any(grid.periodic):
            solver.setIntegralOperator("free")
        solver.max_iter = 100_000
        solver.solve(contact.normal_load / grid.area)
        return np.array(model.traction).reshape(grid.shape)

    return solve


def contact_mechanics_solver(contact):
    """Function from a tolerance to the pressure [Pa], by ContactMechanics."""
    package = importlib.import_module("ContactMechanics")
    optimization = importlib.import_module("ContactMechanics.Optimization")
    surfaces = importlib.import_module("SurfaceTopography")
    grid = contact.grid
    kinds = {
        (True, True): package.PeriodicFFTElasticHalfSpace,
        (False, False): package.FreeFFTElasticHalfSpace,
        (False, True): package.SemiPeriodicFFTElasticHalfSpace,
    }
    half_space = kinds[grid.periodic](grid.shape, CONTACT_MODULUS, grid.size)
    topography = surfaces.Topography(-contact.separation, grid.size)

    def solve(tolerance):
        result = optimization.constrained_conjugate_gradients(
            half_space,
            topography,
            external_force=contact.normal_load,
            pentol=tolerance * 1e-6,
            forcetol=tolerance * contact.normal_load,
            thermotol=1e-12,
        )
        return np.asarray(result.jac) / grid.element_area

    return solve


PEERS = {"Tamaas": tamaas_solver, "ContactMechanics": contact_mechanics_solver}


def contact_rows():
    """Rows of contacts beside the solvers that are installed."""
    for contact in (periodic_contact(), line_contact(), ball_contact()):
        seconds = time_at_residual(contact, tribo_solver(contact))
        for name, solver_of in PEERS.items():
            try:
                solver = solver_of(contact)
            except ImportError as error:
                report(f"{name} is left out: {error}; `make bench` installs it")
                continue
            if solver is None:
                report(f"{name} solves no contact of the kind '{contact.name}'")
                continue
            if (peer_seconds := time_at_residual(contact, solver)) is None:
                report(f"{name} does not reach a residual of {RESIDUAL:g}: {contact.name}")
                continue
            label = f"contact: {contact.name}, {SIDE}²"
            yield row(label, seconds, name, peer_seconds / seconds)


def time_at_residual(contact, solve):
    """CPU time [s] of a solver at its loosest tolerance that reaches the residual, or None."""
    for tolerance in TOLERANCES:
        began = time.process_time()
        pressure = solve(tolerance)
        seconds = time.process_time() - began
        if contact.residual(pressure) <= RESIDUAL:
            repeats = REPEATS - 1 if seconds < LONG else 0
            return min([seconds, *(shortest(partial(solve, tolerance), 1) for _ in range(repeats))])
    return None


def point_rows():
    """Rows of points beside the transforms that they compute."""
    for preset in ("standard", "fine"):
        sweep = pipeline.load_scene("irg_transition", preset)
        points = [point for point in plan.points(sweep) if point.velocity == 2.0]

        def run_points(sweep=sweep, points=points):
            ramp_cache = RampCache()
            for point in points:
                run_point(sweep, point, ramp_cache)

        run_points()  # computes kernels and roughness before timing
        seconds = shortest(run_points, REPEATS)
        with counted_transforms() as transforms:
            run_points()
        label = f"point: `{preset}`, 2 m/s, mean of {len(points)} loads"
        yield row(
            label, seconds / len(points), "its bare transforms", seconds / bare_time(transforms)
        )


def start_and_goal_rows():
    """Rows of a start beside its imports, and of a goal beside its points."""
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "goal.zarr"
        outcome = pipeline.run_sweep(GOAL_SCENE, store, accuracy=GOAL)
        sweep = pipeline.load_scene(GOAL_SCENE)
        ramp_cache, points = RampCache(), plan.points(sweep)
        run_point(sweep, points[0], ramp_cache)
        began = time.process_time()
        for point in points:
            run_point(sweep, point, ramp_cache)
        point_seconds = (time.process_time() - began) / len(points)
        label = f"goal: {GOAL_SCENE}, {GOAL}, {outcome.computed} points"
        yield row(
            label,
            outcome.cpu_time,
            f"{outcome.computed} points of its plane",
            outcome.cpu_time / (outcome.computed * point_seconds),
        )
        command = [sys.executable, "-m", "pipeline", "boundary", str(store)]
        starts, imports = [], []
        for _ in range(REPEATS):
            starts.append(cpu_time(command))
            imports.append(cpu_time([sys.executable, "-c", LIBRARIES]))
    label = "start: `irg boundary`"
    yield row(label, min(starts), "imports of its libraries", min(starts) / min(imports))


def cpu_time(command):
    """CPU time of a command [s], whose output is not shown."""
    before = os.times()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    return (
        after.children_user
        + after.children_system
        - (before.children_user + before.children_system)
    )


def shortest(run, rounds):
    """Shortest CPU time [s] of `rounds` calls of `run`."""
    times = []
    for _ in range(rounds):
        began = time.process_time()
        run()
        times.append(time.process_time() - began)
    return min(times)


_MODULES = {"numpy": np.fft, "scipy": scipy.fft}
_KINDS = ("rfft", "fft", "ifft", "irfft", "rfft2", "fft2", "ifft2", "irfft2")


@contextlib.contextmanager
def counted_transforms():
    """Context: count transforms by library, kind, array and arguments."""
    counts = Counter()
    originals = {
        (library, kind): getattr(module, kind)
        for library, module in _MODULES.items()
        for kind in _KINDS
    }

    def counting(name, transform):
        def wrapper(array, *args, out=None, **kwargs):
            array = np.asarray(array)
            in_place = out is not None and np.shares_memory(array, out)
            options = tuple(sorted(kwargs.items()))
            counts[*name, array.shape, array.dtype, args, options, in_place] += 1
            return transform(array, *args, **kwargs, **({} if out is None else {"out": out}))

        return wrapper

    for (library, kind), transform in originals.items():
        setattr(_MODULES[library], kind, counting((library, kind), transform))
    try:
        yield counts
    finally:
        for (library, kind), transform in originals.items():
            setattr(_MODULES[library], kind, transform)


def bare_time(counts):
    """CPU time [s] of the counted transforms alone, with reused buffers where possible."""
    return sum(count * _time_of(*transform) for transform, count in counts.items())


def _time_of(library, kind, shape, dtype, args, options, in_place):
    transform, array = getattr(_MODULES[library], kind), np.ones(shape, dtype)
    options = dict(options)
    if library == "numpy":
        options["out"] = array if in_place else transform(array, *args, **options)
    return shortest(lambda: transform(array, *args, **options), 30)


def row(computation, seconds, reference, ratio):
    """A row of the table."""
    time_text = f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"
    return f"| {computation} | {time_text} | {reference} | {ratio:.3g} |"


def report(message):
    """Print a message that is not part of the table."""
    print(message, file=sys.stderr)


def main():
    """Print the table."""
    print(HEADS)
    for rows in (contact_rows, point_rows, start_and_goal_rows):
        for line in rows():
            print(line, flush=True)


if __name__ == "__main__":
    main()
