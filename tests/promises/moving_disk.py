"""Rises under a moving disk, of a loop that shares no averaging with the simulation.

    python -m tests.promises.moving_disk [--scenes N] [--minutes M]

In each of many short steps the disk lies at a random position along x, and the pin wears by the
mean along y of the pressure there. Such a pin keeps an imprint of its last positions, which can
make it several percent too hot: so the worn profile is the mean of eight loops. At the end the
contact is solved at the positions at which the simulation averages the temperature.

Scenes without a lay come first; then grooves along, across
and oblique to sliding, and a measured-like surface; then scenes of the families on which presets
are judged, as far as a load that only grows wears a pin at rest. Errors are appended to
``results/moving_disk.jsonl``, from which a later run continues.
"""

import argparse
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import pipeline
from tests.helpers.campaigns import commit, compute, conclude, read, table
from tests.promises.families import case_of
from tribo import MeasuredRoughness, SelfAffineRoughness, Wear, contact_modulus, simulate
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.simulation import fit_elements, heat
from tribo.thermal import rise_exceeded

STEPS, STEP_TOLERANCE, LOOPS = 384, 0.05, 8
MAX_MEAN, MAX_ISOTROPIC_MEAN = 0.01, 0.003
"""Largest mean errors of the rise, of a lay and of surfaces without one."""
POINTS = (100.0, 4.0), (150.0, 3.0), (600.0, 1.5), (750.0, 1.25)
"""Loads [N] and velocities [m/s]."""
_WINDOW = {"window.pixels": [288, 240], "window.pixel_size": ["1.632 um", "1.9 um"]}
_LENGTHS = {
    "without a lay, 4 µm": (4e-6, 4e-6),
    "without a lay, 8 µm": (8e-6, 8e-6),
    "grooves along sliding": (96e-6, 18e-6),
    "grooves across sliding, 40 µm": (4e-6, 40e-6),
    "grooves across sliding, 150 µm": (4e-6, 150e-6),
}
_ANGLES = {"grooves at 45°": 45.0, "grooves at −45°": -45.0, "grooves at 20°": 20.0}
FAMILIES = "shipped", "lay", "measured", "tops", "coarse pixels"
KINDS = *_LENGTHS, *_ANGLES, "worn peaks across sliding"
HEADS = "surface", "load", "scenes", "mean error [%]", "±", "of a scene", "at the first position"
FILE = Path("results/moving_disk.jsonl")


def positions(scene, state):
    """Rises Θ₁₀ [K] that the simulation averages, at even shifts of the disk."""
    fitted = fit_elements(scene, state.normal_load)
    velocity = state.sliding_distance / state.time
    contacts = [replace(state, pressure=p, passing=()) for p in (state.pressure, *state.passing)]
    return np.array([decisive(heat(fitted, contact, velocity)) for contact in contacts])


def moving_disk(scene, load, velocity, count, steps=STEPS, loops=LOOPS):
    """Rises Θ₁₀ [K] at `count` even positions of the disk, of a pin that a moving disk has worn."""
    scene = fit_elements(scene, load)
    fine = _Disk(scene, 1)
    coarse = _Disk(scene, 2 if scene.fidelity.history_coarsening > 1 else 1)
    profiles = [worn_profile(scene, coarse, load, velocity, steps, seed) for seed in range(loops)]
    block = fine.shape[0] // coarse.shape[0]
    x = (np.arange(fine.shape[0]) + 0.5) / block - 0.5
    profile = np.interp(x, np.arange(coarse.shape[0]), np.mean(profiles, axis=0))[:, None]
    *_, end = simulate(replace(scene, wear=None), load, velocity)
    rises = []
    for position in range(count):
        gap = fine.gap(round(position * fine.shape[0] / count)) + profile
        window_load = load / scene.pin.windows(scene.grid)
        contact = solve_contact(fine.solid, gap, window_load, scene.hardness, 0.03)
        state = replace(end, pressure=contact.pressure, time=load / scene.loading.rate, passing=())
        rises.append(decisive(heat(replace(scene, wear=None), state, velocity)))
    return np.array(rises)


def worn_profile(scene, disk, load, velocity, steps, seed):
    """Worn depth along x [m] after `steps` steps, each at another random position of the disk."""
    rng, wear = np.random.default_rng(seed), Wear(scene.wear.specific_wear_rate)
    distance = velocity * load / scene.loading.rate / steps
    yielding = wear.yielding(disk.solid, distance)
    worn = np.zeros(disk.shape)
    for step in range(steps):
        gap = disk.gap(int(rng.integers(disk.shape[0]))) + worn
        window_load = load * (step + 0.5) / steps / scene.pin.windows(scene.grid)
        contact = solve_contact(yielding, gap, window_load, scene.hardness, STEP_TOLERANCE)
        worn = worn + wear.depth(contact.pressure, distance)
    return worn[:, 0]


class _Disk:
    """Disk of a scene on elements longer by a factor, which can be moved along x."""

    def __init__(self, scene, factor):
        block = factor * scene.fidelity.pixels_per_element
        fidelity = replace(scene.fidelity, pixels_per_element=block, history_coarsening=1)
        scene = replace(scene, fidelity=fidelity)
        self.shape = scene.grid.shape
        self.solid = ElasticHalfSpace(scene.grid, contact_modulus(scene.pin.material, scene.disk))
        self._profile = scene.pin.profile(scene.grid)
        self._heights = self._profile - scene.separation(scene.heights())

    def gap(self, shift):
        """Separation from the unworn pin [m], with the disk moved by elements along x."""
        return self._profile - np.roll(self._heights, shift, axis=0)


def decisive(contact_heat):
    return float(rise_exceeded(contact_heat.rise_quantile, 0.1))


def errors(scene, load, velocity, **loop):
    """Relative errors of the rises of a simulated point, at each of its positions."""
    *_, state = simulate(scene, load, velocity)
    rises = positions(scene, state)
    return rises / moving_disk(scene, load, velocity, len(rises), **loop) - 1


def oblique_heights(pixels, angle, seed, lengths=(4e-6, 150e-6), ra=0.27e-6):
    """Heights [m] with grooves at an angle [°] to y."""
    (nx, ny), (dx, dy) = pixels.shape, pixels.spacing
    qx, qy = 2 * np.pi * np.fft.fftfreq(nx, dx)[:, None], 2 * np.pi * np.fft.rfftfreq(ny, dy)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    across, along = lengths[0] * (c * qx + s * qy), lengths[1] * (c * qy - s * qx)
    amplitude = (1 + across**2 + along**2) ** -0.9
    amplitude[0, 0] = 0.0
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal(pixels.shape))
    heights = np.fft.irfft2(noise * amplitude, pixels.shape)
    return heights * ra / np.abs(heights).mean()


def scene_of(kind, seed):
    """Scene of the paper's system on a smaller window, with a surface of a kind."""
    scene = pipeline.load_scene("first_try", "standard", _WINDOW).scene
    if kind in _LENGTHS:
        return replace(scene, roughness=SelfAffineRoughness(0.27e-6, 0.8, _LENGTHS[kind], seed))
    heights = oblique_heights(scene.pixels, _ANGLES.get(kind, 0.0), seed)
    if kind not in _ANGLES:  # summits have lost 40 % of their height
        heights = np.where(heights > 0, 0.6 * heights, heights)
    return replace(scene, roughness=MeasuredRoughness(heights))


def family_points(family, count):
    """Yield scene, highest load [N] and middle velocity [m/s] of `count` scenes of a family."""
    number = 1
    while count:
        with tempfile.TemporaryDirectory() as folder:
            sweep = case_of(family, number).sweep(Path(folder), "standard")
        if sweep.scene.wears_by_strips:
            count -= 1
            yield (
                sweep.scene,
                max(sweep.loads),
                sorted(sweep.velocities)[len(sweep.velocities) // 2],
            )
        number += 2


def tasks(count):
    """Surface, load [N], velocity [m/s] and number of `count` scenes of each, by their number.

    Scenes of a family have their own loads and velocities.
    """
    for number in range(count):
        for kind in KINDS:
            yield from ((kind, *point, number) for point in POINTS)
        yield from ((family, None, None, number) for family in FAMILIES)


def computed(task):
    """Row of the file of a scene."""
    surface, load, velocity, number = task
    began = time.process_time()
    if surface in FAMILIES:
        *_, point = family_points(surface, number + 1)
    else:
        point = scene_of(surface, number), load, velocity
    row = {"name": name_of(task), "errors": errors(*point).tolist()}
    return row | {"seconds": time.process_time() - began, "commit": commit()}


def name_of(task):
    surface, load, _, number = task
    return f"{surface}, {load:g} N, {number}" if load else f"family {surface}, {number}"


def summary(means):
    """Mean of the errors of scenes [%], its standard error, and standard deviation of a scene."""
    deviation = means.std(ddof=1) if len(means) > 1 else np.inf
    return 100 * means.mean(), 100 * deviation / np.sqrt(len(means)), 100 * deviation


def judged(surface, load, scene_errors):
    """Table row of a surface, and True if the mean of the errors may be within its limit."""
    mean, uncertainty, deviation = summary(np.array([np.mean(error) for error in scene_errors]))
    first = 100 * np.mean([error[0] for error in scene_errors])
    limit = 100 * (MAX_ISOTROPIC_MEAN if surface.startswith("without") else MAX_MEAN)
    cells = f"{mean:+.2f}", f"{uncertainty:.2f}", f"{deviation:.2f}", f"{first:+.2f}"
    return (surface, load, len(scene_errors), *cells), abs(mean) <= limit + 2 * uncertainty


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.moving_disk")
    parser.add_argument("--scenes", type=int, default=8, help="surfaces of each kind")
    parser.add_argument("--minutes", type=float, default=120.0, help="begin no scene later")
    options = parser.parse_args()
    rows = {row["name"]: row["errors"] for row in read(FILE)}
    missing = [task for task in tasks(options.scenes) if name_of(task) not in rows]
    compute(computed, missing, FILE, options.minutes)
    rows = {row["name"]: row["errors"] for row in read(FILE)}
    scene_errors = {}
    for task in tasks(options.scenes):
        if name_of(task) in rows:
            group = task[0], f"{task[1]:g} N" if task[1] else "highest"
            scene_errors.setdefault(group, []).append(rows[name_of(task)])
    verdicts = [judged(*group, group_errors) for group, group_errors in scene_errors.items()]
    lines, are_right = zip(*verdicts, strict=True)
    text = f"{table(HEADS, lines)}\n\n{conclusion(lines)}"
    return conclude("moving_disk", text, all(are_right))


def conclusion(lines):
    """The largest of the mean errors in the lines of the table, in a sentence."""
    surface, load, count, mean, uncertainty, *_ = max(lines, key=lambda line: abs(float(line[3])))
    counts = [line[2] for line in lines]
    return (
        f"{len(lines)} surfaces and loads, {min(counts)} to {max(counts)} scenes each: {mean} ± "
        f"{uncertainty} % ({surface}, {load}, {count} scenes)"
    )


if __name__ == "__main__":
    sys.exit(main())
