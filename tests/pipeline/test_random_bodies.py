"""Points of random scenes with bodies that warm, holds, and friction by temperature."""

import json

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.cli import main

SMALL = {
    "window.pixels": [48, 24],
    "fidelity.preset": "draft",
    "fidelity.fewest_elements": 0,
    "fidelity.increments": 4,
}
WINDOWS = {
    "first_try": ["12 um", "19 um"],
    "ball_on_disk": ["13 um", "26 um"],
    "twin_disc": ["40 um", "19 um"],
}


class Draw:
    """Entries of a scene at random."""

    def __init__(self, seed):
        self.rng = np.random.default_rng([seed, 68])
        self.base = self.one_of([*WINDOWS])

    def one_of(self, choices):
        return choices[self.rng.integers(len(choices))]

    def chance(self, share):
        return self.rng.uniform() < share

    def text(self, low, high, unit):
        value = np.exp(self.rng.uniform(np.log(low), np.log(high)))
        return f"{value:.4g} {unit}"

    def entries(self):
        """Entries in the order in which they are drawn."""
        entries = SMALL | {"window.pixel_size": WINDOWS[self.base]}
        for body in ("pin", "disk"):
            entries |= self.body(body)
        if self.chance(0.7):
            entries["loading.hold"] = self.text(0.01, 3000, "s")
        if self.base != "twin_disc" and self.chance(0.3):
            entries["pin.stem"] = {"length": self.text(1, 50, "mm"), "area": "13 mm^2"}
        if self.chance(0.3):
            entries["disk.film"] = {
                "thickness": self.text(1, 1000, "nm"),
                "thermal_conductivity": "2 W/(m K)",
            }
        return entries | self.friction() | self.temperature() | self.wear()

    def body(self, body):
        """A disc, a plate, or what the scene has."""
        turns = body == "disk" or self.base == "twin_disc"
        if self.base == "twin_disc":
            names = {"bore": "30 mm", "rim_loss": self.text(1, 1e4, "W/(m^2 K)")}
            names |= {"face_loss": self.text(1, 1e3, "W/(m^2 K)"), "shaft_loss": "5 W/K"}
            return {f"{body}.{k}": v for k, v in names.items() if self.chance(0.5)}
        if turns and self.chance(0.4):
            return {f"{body}.diameter": self.text(40, 300, "mm"), f"{body}.width": "12 mm"}
        plate = {"capacity": self.text(0.05, 1000, "J/K"), "loss": self.text(0.01, 100, "W/K")}
        plate |= {"track_length": self.text(50, 1000, "mm")} if turns else {}
        return {f"{body}.{k}": v for k, v in plate.items() if self.chance(0.5)}

    def friction(self):
        """A coefficient, and curves that rise or fall."""
        entries = {"friction.coefficient": self.one_of([0.0, 0.02, 0.1, 0.1, 0.4])}
        for name, nodes in (
            ("velocity", ["0.3 m/s", "1 m/s", "3 m/s"]),
            ("temperature", ["30 degC", "90 degC", "200 degC"]),
        ):
            if entries["friction.coefficient"] and self.chance(0.5):
                values = self.rng.uniform(0.02, 0.3, len(nodes)).round(4).tolist()
                rows = zip(nodes, values, strict=True)
                entries[f"friction.by_{name}"] = [{name: x, "coefficient": y} for x, y in rows]
        return entries

    def temperature(self):
        """One bulk temperature or two, and a criterion."""
        entries = {"temperature.criterion": self.one_of(["share", "highest", "mean"])}
        if entries["temperature.criterion"] == "share":
            entries["temperature.failing_share"] = self.one_of([0, 0.1, 0.5])
        if self.chance(0.2):
            entries["temperature.bulk"] = {
                "pin": "40 degC",
                "disk": self.one_of(["25 degC", "90 degC"]),
            }
        return entries

    def wear(self):
        """Mostly wear, of all sizes."""
        return {
            "wear.specific_wear_rate": self.one_of(
                ["0 mm^3/(N m)", self.text(1e-9, 1e-5, "mm^3/(N m)")]
            )
        }

    def point(self):
        """Load [N] and velocity [m/s]."""
        loads = {"first_try": (50, 750), "ball_on_disk": (5, 300), "twin_disc": (500, 8000)}
        load = float(np.exp(self.rng.uniform(*np.log(loads[self.base]))))
        return round(load, 3), self.one_of([0.0, 0.01, 0.3, 1.0, 3.0, 20.0])


def toml(value):
    """A value as a scene file has it."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {toml(one)}" for name, one in value.items()) + " }"
    return f"[{', '.join(map(toml, value))}]" if isinstance(value, list) else json.dumps(value)


def fail(name):
    raise AssertionError(f"{name} in a document")


def judged(base, entries, load, velocity):
    """Verdict of the library on a point of a scene."""
    sweep = pipeline.load_scene(base, overrides=entries)
    known = sweep.conditions
    conditions = tribo.Conditions(
        friction=known.friction,
        bulk_temperature=known.bulk_temperature,
        disk_temperature=known.disk_temperature,
        critical_temperature=known.critical_temperature,
        corrections=known.corrections,
        criterion=known.decisive,
    )
    return tribo.judge(sweep.scene, load, velocity, conditions)


@pytest.mark.parametrize("seed", range(6))
def test_the_library_and_the_command_give_one_verdict(seed, capsys):
    draw = Draw(seed)
    entries, (load, velocity) = draw.entries(), draw.point()
    settings = [f"--set={path}={toml(value)}" for path, value in entries.items()]
    place = f"--load={load} N", f"--velocity={velocity} m/s"
    code = main(["point", draw.base, *place, *settings, "--json"])
    printed = capsys.readouterr()
    try:
        found = judged(draw.base, entries, load, velocity)
    except tribo.TriboError as error:
        refusal = str(error)
    else:
        refusal = ""
    if refusal:
        assert code == 2
        assert refusal.split(";")[0].split("\n")[0] in printed.err
        return
    assert code == 0
    (row,) = json.loads(printed.out, parse_constant=fail)
    decisive = row["decisive temperature [°C]"] + 273.15
    assert decisive == pytest.approx(found.decisive_temperature, rel=1e-9)
    if "failed share [%]" in row:  # friction by temperature is solved where it decides alone
        assert row["failed share [%]"] == pytest.approx(100 * found.failed_fraction, abs=1e-7)
    assert found.decisive_temperature >= found.bulk_temperature
