"""Solvers of normal contact behind one face: ours, and others' where they are installed."""

import importlib
import math
import sys
import types
from dataclasses import dataclass

import numpy as np

from tribo import Grid
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.numerics import padded_shape
from tribo.surface import self_affine

CONTACT_MODULUS = 115.385e9
HARDNESS = 6.6e9


@dataclass(frozen=True)
class Case:
    """Contact problem: a rigid shape pressed into a half-space."""

    name: str
    grid: Grid
    separation: np.ndarray
    normal_load: float
    hardness: float = math.inf

    def solid(self):
        """The half-space of a case; if periodic, with the spectrum 2/(E*|q|) of the peers."""
        solid = ElasticHalfSpace(self.grid, CONTACT_MODULUS)
        if not all(self.grid.periodic):
            return solid
        (nx, ny), (dx, dy) = self.grid.shape, self.grid.spacing
        q = 2 * np.pi * np.hypot(np.fft.fftfreq(nx, dx)[:, None], np.fft.rfftfreq(ny, dy))
        q[0, 0] = math.inf
        return solid.replace_spectrum(2 / (CONTACT_MODULUS * q))


def rough(name, n, normal_load, hardness=math.inf):
    """Case of a periodic self-affine surface on n × n elements."""
    pixels = Grid((512, 512), (1e-6, 1e-6), (True, True))
    heights = self_affine(pixels, 0.3e-6, 0.8, 20e-6, 0)
    block = 512 // n
    means = heights.reshape(n, block, n, block).mean(axis=(1, 3))
    return Case(
        name, Grid((n, n), (block * 1e-6,) * 2, (True, True)), -means, normal_load, hardness
    )


def sphere(name, n):
    """Case of Hertz's contact of a sphere, on a patch 3 contact radii wide."""
    radius, normal_load = 10e-3, 10.0
    contact_radius = (3 * normal_load * radius / (4 * CONTACT_MODULUS)) ** (1 / 3)
    grid = Grid((n, n), (3 * contact_radius / n,) * 2, (False, False))
    x, y = grid.coordinates(0)[:, None], grid.coordinates(1)
    return Case(name, grid, (x**2 + y**2) / (2 * radius), normal_load)


def line(name, n, hardness=math.inf):
    """Case of the paper's rough line contact at 600 N."""
    pixels = Grid((480, 480), (0.816e-6, 0.95e-6), (False, True))
    heights = self_affine(pixels, 0.27e-6, 0.8, 4e-6, 0)
    block = 480 // n
    means = heights.reshape(n, block, n, block).mean(axis=(1, 3))
    grid = Grid((n, n), (block * 0.816e-6, block * 0.95e-6), (False, True))
    z = grid.coordinates(0)[:, None] ** 2 / (2 * 2e-3) - means
    return Case(name, grid, z, 600.0 * grid.size[1] / 3.4e-3, hardness)


class Ours:
    name = "tribo"

    def __init__(self, case):
        self.case = case
        self.displacement = case.solid()

    def solve(self, tolerance):
        contact = solve_contact(
            self.displacement,
            self.case.separation,
            self.case.normal_load,
            self.case.hardness,
            tolerance,
        )
        return contact.pressure

    @staticmethod
    def solves(case):
        return True


class Tamaas:
    name = "Tamaas"

    def __init__(self, case):
        tamaas = importlib.import_module("tamaas")
        tamaas.set_log_level(tamaas.LogLevel.error)
        grid = case.grid
        model = tamaas.ModelFactory.createModel(
            tamaas.model_type.basic_2d, list(grid.size), list(grid.shape)
        )
        model.E, model.nu = CONTACT_MODULUS, 0.0
        if not any(grid.periodic):
            tamaas.ModelFactory.registerNonPeriodic(model, "free")
        self._tamaas, self._model, self.case = tamaas, model, case
        self._heights = np.ascontiguousarray(-case.separation)

    def displacement(self, pressure):
        if all(self.case.grid.periodic):
            return self.case.solid()(pressure)  # same kernel as the peer's, which is private
        out = np.zeros_like(pressure)
        self._model.operators["free"].apply(pressure, out)
        return out

    def solve(self, tolerance):
        self._model.traction[...] = 0.0
        self._model.displacement[...] = 0.0
        solver = self._tamaas.PolonskyKeerRey(self._model, self._heights, tolerance)
        if not any(self.case.grid.periodic):
            solver.setIntegralOperator("free")
        solver.max_iter = 100_000
        solver.solve(self.case.normal_load / self.case.grid.area)
        return np.array(self._model.traction).reshape(self.case.grid.shape)

    @staticmethod
    def solves(case):
        # Its solver with a pressure limit takes some 10 000 iterations.
        return case.hardness == math.inf and case.grid.periodic[0] == case.grid.periodic[1]


class ContactMechanics:
    name = "ContactMechanics"

    def __init__(self, case):
        package = importlib.import_module("ContactMechanics")
        optimization = importlib.import_module("ContactMechanics.Optimization")
        surfaces = importlib.import_module("SurfaceTopography")
        grid = case.grid
        kinds = {
            (True, True): package.PeriodicFFTElasticHalfSpace,
            (False, False): package.FreeFFTElasticHalfSpace,
            (False, True): package.SemiPeriodicFFTElasticHalfSpace,
        }
        self._half_space = kinds[grid.periodic](grid.shape, CONTACT_MODULUS, grid.size)
        self._solve = optimization.constrained_conjugate_gradients
        self._topography = surfaces.Topography(-case.separation, grid.size)
        self.case = case

    def displacement(self, pressure):
        padded = np.zeros(self._half_space.nb_subdomain_grid_pts)
        nx, ny = pressure.shape
        padded[:nx, :ny] = -pressure * self.case.grid.element_area
        return self._half_space.evaluate_disp(padded)[:nx, :ny]

    def solve(self, tolerance):
        area, capped = self.case.grid.element_area, self.case.hardness < math.inf
        result = self._solve(
            self._half_space,
            self._topography,
            external_force=self.case.normal_load,
            hardness=self.case.hardness * area if capped else None,
            pentol=tolerance * 1e-6,
            forcetol=tolerance * self.case.normal_load,
            thermotol=1e-12,
        )
        return np.asarray(result.jac) / area

    @staticmethod
    def solves(case):
        return True


class Slippy:
    name = "slippy"

    def __init__(self, case):
        # Its surfaces import a function that SciPy no longer has; its contact solver needs none.
        sys.modules.setdefault("scipy.misc", types.SimpleNamespace(derivative=None))
        importlib.import_module("slippy").CUDA = False
        self._core = importlib.import_module("slippy.core")
        solid, grid = case.solid(), case.grid
        spectrum = np.fft.fft2(np.fft.irfft2(solid.spectrum, s=padded_shape(grid)))
        self.displacement = self._core.plan_convolve(
            np.zeros(grid.shape), spectrum, None, circular=grid.periodic, fft_im=True
        )
        self.case = case

    def solve(self, tolerance):
        grid = self.case.grid
        _, pressure, _ = self._core.polonsky_and_keer(
            self.displacement,
            np.ones(grid.shape),
            self.case.separation,
            self.case.normal_load,
            grid.spacing,
            tolerance,
            10_000,
        )
        return pressure

    @staticmethod
    def solves(case):
        return case.hardness == math.inf


class Aspher:
    name = "ASPHER"

    def __init__(self, case):
        self._solve = importlib.import_module("aspher").solve_nested
        self.case, self.displacement = case, case.solid()
        self._gap = np.ascontiguousarray(case.separation).ravel()

    def solve(self, tolerance):
        # Its fastest backend and preconditioner on these cases; each has an exact kernel.
        grid = self.case.grid
        result = self._solve(
            grid_size=grid.shape[0],
            gap=self._gap,
            p_nominal=self.case.normal_load / grid.area,
            domain_size=grid.size[0],
            E_star=CONTACT_MODULUS,
            tol=tolerance,
            backend="periodic" if all(grid.periodic) else "fft",
            precond_engine="fft",
        )
        return np.array(result.pressure).reshape(grid.shape)

    @staticmethod
    def solves(case):
        # It solves only squares of 64 · 2ᵏ square elements.
        return case.hardness == math.inf and case.grid.periodic[0] == case.grid.periodic[1]


def residual(solver, pressure):
    """Largest violation of any condition of the contact problem by a pressure.

    For the gap it is relative to the displacement of one element under the largest pressure, by
    the solver's own operator. For load and bounds it is relative.
    """
    case = solver.case
    gap = solver.displacement(pressure) + case.separation
    free = (pressure > 0) & (pressure < case.hardness)
    gap = gap - gap[free].mean()
    unit = case.solid().self_influence * pressure.max()
    load = pressure.sum() * case.grid.element_area
    return max(
        np.abs(gap[free]).max() / unit,
        -gap[pressure <= 0].min(initial=0.0) / unit,
        gap[pressure >= case.hardness].max(initial=0.0) / unit,
        abs(load / case.normal_load - 1),
        -pressure.min() / pressure.max(),
        pressure.max() / case.hardness - 1,
    )


SOLVERS = [Ours, Aspher, Slippy, ContactMechanics, Tamaas]
