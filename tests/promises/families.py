"""Scenes of twelve families on which the presets are chosen and judged, as text of a scene file.

Each family draws what its users vary: radius, load, roughness, wear, pixels. Scenes of an even
number are there to choose by, those of an odd number to judge by.
"""

import hashlib
import json
import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import pipeline

WORKFLOWS = Path(__file__).parents[2] / "workflows"
LOAD_SHARES = (0.3, 0.5, 0.75, 1.0)
"""Loads of a scene over its reference load."""
_VELOCITY_STEP = 2.0
_OMITTED = "sweep", "title", "tests", "fidelity", "oil"
STEEL = {
    "elastic_modulus": "210 GPa",
    "poisson_ratio": 0.3,
    "hardness": "6.6 GPa",
    "thermal_conductivity": "45 W/(m K)",
    "density": "7800 kg/m^3",
    "specific_heat": "470 J/(kg K)",
}
MATERIALS = {
    "steel": STEEL,
    "hard": STEEL | {"hardness": "8 GPa", "thermal_conductivity": "21 W/(m K)"},
    "soft": STEEL | {"hardness": "1.8 GPa", "thermal_conductivity": "50 W/(m K)"},
    "alumina": STEEL
    | {
        "elastic_modulus": "370 GPa",
        "poisson_ratio": 0.22,
        "hardness": "15 GPa",
        "thermal_conductivity": "25 W/(m K)",
        "density": "3900 kg/m^3",
        "specific_heat": "880 J/(kg K)",
    },
    "bronze": STEEL
    | {
        "elastic_modulus": "110 GPa",
        "poisson_ratio": 0.34,
        "hardness": "1.5 GPa",
        "thermal_conductivity": "60 W/(m K)",
        "density": "8800 kg/m^3",
        "specific_heat": "380 J/(kg K)",
    },
}


@dataclass(frozen=True)
class Case:
    """A scene of a campaign: its entries by path, and the files that it reads."""

    family: str
    number: int
    entries: dict[str, object]
    files: dict[str, Callable[[Path], None]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return f"{self.family} {self.number}"

    @property
    def loads(self) -> list[str]:
        return self.entries["sweep.loads"]

    @property
    def velocities(self) -> list[str]:
        return self.entries["sweep.velocities"]

    @property
    def digest(self) -> str:
        """Digest of the scene's entries, without its numerical choices."""
        text = json.dumps(self.entries, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    def sweep(self, folder: Path, preset: str = "reference", **fidelity):
        """Write the scene file and its files into a folder, and load the scene."""
        for name, write in self.files.items():
            write(folder / name)
        path = folder / "scene.toml"
        lines = [f"{key} = {json.dumps(value)}" for key, value in self.entries.items()]
        path.write_text("\n".join(lines), encoding="utf-8")
        return pipeline.load_scene(path, preset=preset, overrides=fidelity or None)


def cases(numbers=range(6)):
    """Scenes of all families with these numbers, the families in turn."""
    return [case_of(name, number) for number in numbers for name in FAMILIES]


def case_of(name, number):
    """The scene of a family with this number."""
    return Case(name, number, *_complete_entries(name, number))


def _complete_entries(name, number):
    """Entries of a scene, loads and velocities included, and its files."""
    rng = np.random.default_rng([number, *name.encode()])
    entries, velocity, files = FAMILIES[name](Draw(rng), number)
    reference = entries.get("loading.reference_load")
    if "sweep.loads" not in entries:
        value, unit = reference.split()
        entries["sweep.loads"] = [f"{float(value) * share:.5g} {unit}" for share in LOAD_SHARES]
    if "sweep.velocities" not in entries:
        steps = (velocity / _VELOCITY_STEP, velocity, velocity * _VELOCITY_STEP)
        entries["sweep.velocities"] = [f"{step:.3g} m/s" for step in steps]
    return entries, files


@dataclass
class Draw:
    """Random values, rounded as a user would give them."""

    rng: np.random.Generator

    def between(self, low, high):
        return float(f"{self.rng.uniform(low, high):.3g}")

    def log(self, low, high):
        return float(f"{math.exp(self.rng.uniform(math.log(low), math.log(high))):.3g}")

    def one_of(self, *values):
        return values[int(self.rng.integers(len(values)))]


def flattened(table, path=""):
    """Yield path and value of all entries of a nested document."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from flattened(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", value


def _shipped(name):
    """Entries of a shipped scene and of those it extends, without conditions, loads, velocities."""
    document = tomllib.loads((WORKFLOWS / f"{name}.toml").read_text(encoding="utf-8"))
    entries = _shipped(document.pop("extends")) if "extends" in document else {}
    without = document.pop("without", [])
    shipped = dict(flattened(document))
    entries = {
        key: value
        for key, value in entries.items()
        if not any(key == path or key.startswith(f"{path}.") for path in without)
    }
    return {k: v for k, v in (entries | shipped).items() if k.split(".")[0] not in _OMITTED}


def _system(draw, materials=("steel", "steel"), pin="cylinder", radius=2.0, length=3.4):
    """Entries of a pin on a disk; radius and length of the pin in mm."""
    pairs = zip(("pin", "disk"), materials, strict=True)
    entries = {f"{body}.material": f"{name}_{body}" for body, name in pairs}
    for body, name in zip(("pin", "disk"), materials, strict=True):
        for key, value in MATERIALS[name].items():
            entries[f"materials.{name}_{body}.{key}"] = value
    entries |= {"pin.shape": pin, "pin.radius": f"{radius:g} mm"}
    if pin == "cylinder":
        entries["pin.length"] = f"{length:g} mm"
    return entries | {
        "friction.coefficient": 0.1,
        "temperature.bulk": "25 degC",
        "temperature.critical": "145 degC",
    }


def _rough(draw, ra, lengths, hurst=None):
    """Entries of a random surface; Ra and correlation lengths in µm."""
    return {
        "disk.roughness.ra": f"{ra:g} um",
        "disk.roughness.hurst_exponent": hurst or draw.between(0.6, 0.9),
        "disk.roughness.correlation_length": [f"{length:.3g} um" for length in lengths],
        "disk.roughness.seed": int(draw.rng.integers(10_000)),
    }


def _line_width(radius, length, load, rate, velocity, duration, ra, modulus=115e9):
    """Estimated width [µm] of a worn, rough line contact; radius and length in mm, Ra in µm."""
    radius, length, ra = 1e-3 * radius, 1e-3 * length, 1e-6 * ra
    hertz = 2 * math.sqrt(4 * load * radius / (math.pi * length * modulus))
    area = 1e-9 * rate * velocity * load * duration / 2 / length  # rate in mm³/(N m)
    return 1e6 * math.sqrt(hertz**2 + (12 * radius * area) ** (2 / 3) + 8 * radius * 4 * ra)


def _window(width, pixels, sizes=None):
    """Entries of a window of a width along x [µm] and these numbers of pixels."""
    size = width / pixels[0]
    sizes = sizes or (size, size)
    return {
        "window.pixels": list(pixels),
        "window.pixel_size": [f"{size:.3g} um" for size in sizes],
    }


def _ramp(load, duration):
    return {
        "loading.rate": f"{load / duration:.3g} N/s",
        "loading.reference_load": f"{load:g} N",
    }


def _wear(rate, pattern="swept"):
    """Entries of wear; the rate is in mm³/(N m)."""
    return {"wear.specific_wear_rate": f"{rate:g} mm^3/(N m)", "wear.pattern": pattern}


def shipped(draw, number):
    """Entries of a shipped scene; all but the first two get narrower windows."""
    name = ("irg_transition", "twin_disc", "ball_on_disk", "oil_a", "oil_a_hot", "irg_transition")[
        number % 6
    ]
    entries = _shipped(name)
    loads = {"twin_disc": ("3 kN", "5 kN", "8 kN"), "ball_on_disk": ("50 N", "100 N", "200 N")}
    entries["sweep.loads"] = list(loads.get(name, ("200 N", "400 N", "750 N")))
    middle = {"twin_disc": 2.5, "ball_on_disk": 0.5, "oil_a": 4.0}.get(name, 2.0)
    if number < 2:
        entries["sweep.velocities"] = [f"{middle:g} m/s", f"{2 * middle:g} m/s"]
    elif name == "ball_on_disk":
        entries |= {"window.pixels": [256, 256], "window.pixel_size": ["2 um", "2 um"]}
        entries["sweep.velocities"] = ["0.4 m/s", "0.8 m/s"]
    else:
        entries["window.pixels"] = [1440, 44] if name == "twin_disc" else [576, 112]
    return entries, middle, {}


def lay(draw, number):
    """Entries of a disk that is ground along x or y."""
    radius, length, load = draw.log(1.5, 6), draw.log(2, 6), draw.log(150, 900)
    velocity, rate, ra = draw.log(0.5, 3), draw.log(1e-7, 5e-6), draw.log(0.1, 0.6)
    width = 1.35 * _line_width(radius, length, load, rate, 2 * velocity, 5, ra)
    short = draw.between(2.5, 6)
    long = short * draw.between(4, 15)
    pixels = draw.one_of((256, 224), (240, 160), (320, 160))
    size = width / pixels[0]
    lengths = [short * size, long * size] if number % 4 < 2 else [long * size, short * size]
    entries = _system(draw, radius=radius, length=length) | _ramp(load, draw.between(3, 8))
    entries |= _window(width, pixels) | _wear(rate) | _rough(draw, ra, lengths)
    return entries, velocity, {}


def twin_disc(draw, number):
    """Entries of two discs that roll and slide."""
    radius, length, load = draw.between(10, 40), draw.between(5, 10), draw.log(2e3, 8e3)
    velocity, ra, rate = draw.log(0.8, 4), draw.log(0.1, 0.4), draw.log(1e-7, 3e-6)
    width = 1.45 * _line_width(radius, length, load, 0, velocity, 10, ra / 3)
    pixels = draw.one_of((512, 96), (512, 120), (384, 160))
    size = width / pixels[0]
    length_of = size * draw.between(3, 6)
    entries = _system(draw, radius=radius, length=length) | _ramp(load, draw.between(8, 20))
    entries |= _window(width, pixels) | _wear(rate) | _rough(draw, ra, [length_of, length_of])
    entries |= {
        "motion.slide_roll_ratio": draw.one_of(0.3, 0.5, 1.0, -0.5),
        "pin.diameter": f"{4 * radius:g} mm",
        "pin.width": f"{length:g} mm",
        "temperature.bulk": "60 degC",
        "friction.coefficient": 0.06,
    }
    if number % 2:
        entries |= {"disk.diameter": f"{4 * radius:g} mm", "disk.width": f"{length:g} mm"}
    return entries, velocity, {}


def ball(draw, number):
    """Entries of a ball or a crowned roller, worn or not."""
    radius, load = draw.between(3, 12), draw.log(30, 250)
    velocity, ra = draw.log(0.3, 2), draw.log(0.03, 0.15)
    crowned = number % 3 == 2
    crown = radius * draw.between(1.2, 2.5) if crowned else radius
    half = (1.5 * load * math.sqrt(radius * crown) * 1e-3 / 2 / 115e9 * 2) ** (1 / 3) * 1e6
    rate = draw.one_of(0, 1e-7, 4e-7) if number % 2 else draw.one_of(1e-7, 3e-7)
    volume = 1e-9 * rate * load * 2 * velocity * 2.5
    worn = 1e6 * (64e-3 * radius * volume / math.pi) ** 0.25
    width = 1.3 * math.hypot(2 * half, worn) + 0.3 * math.sqrt(24e3 * radius * ra)
    pixels = draw.one_of((160, 160), (128, 128), (144, 144))
    size = width / pixels[0]
    y = size * ((crown / radius) ** 0.6)
    length = size * draw.between(2.5, 5)
    entries = _system(draw, radius=radius, pin="crowned" if crowned else "ball")
    if crowned:
        entries["pin.crown_radius"] = f"{crown:.3g} mm"
    entries |= _ramp(load, draw.between(2, 5)) | _window(width, pixels, (size, y))
    entries |= _rough(draw, ra, [length, length])
    if rate:
        entries |= _wear(rate)
    entries["sweep.velocities"] = [f"{velocity:g} m/s", f"{2 * velocity:g} m/s"]
    return entries, velocity, {}


def local(draw, number):
    """Entries of a disk with grooves along the track, which wear the pin locally."""
    radius, length, load = draw.log(1.5, 8), draw.log(2, 6), draw.log(100, 800)
    velocity, rate, ra = draw.log(0.5, 3), draw.log(1e-7, 1e-5), draw.log(0.1, 0.5)
    width = 1.35 * _line_width(radius, length, load, rate, 2 * velocity, 5, ra)
    pixels = draw.one_of((256, 160), (192, 192), (240, 120))
    size = width / pixels[0]
    long = size * draw.between(2.5, 6) * draw.one_of(1, 8)
    lengths = [long, size * draw.between(2.5, 6)]
    pair = draw.one_of(("steel", "steel"), ("soft", "steel"), ("alumina", "steel"))
    entries = _system(draw, pair, radius=radius, length=length) | _ramp(load, draw.between(3, 6))
    entries |= _window(width, pixels) | _wear(rate, "local") | _rough(draw, ra, lengths)
    return entries, velocity, {}


def hold(draw, number):
    """Entries of a load with a hold."""
    entries, velocity, _ = (local if number % 3 == 2 else lay)(draw, number)
    seconds = draw.log(5, 120)
    load = float(entries["loading.reference_load"].split()[0])
    entries["loading.hold"] = f"{seconds:g} s"
    entries["wear.specific_wear_rate"] = f"{draw.log(3e-8, 6e-7):g} mm^3/(N m)"
    entries["sweep.loads"] = [f"{load * share:.5g} N" for share in LOAD_SHARES[1::2]]
    return entries, velocity, {}


def record(draw, number):
    """Entries and file of a recorded load: rounded, with a dip, or with a jump."""
    entries, velocity, _ = lay(draw, number + 1)
    load = float(entries["loading.reference_load"].split()[0])
    duration, kind = draw.between(3, 8), number % 3
    if kind == 0:
        shares = [(t, min(1.0, t * t * (3 - 2 * t))) for t in np.linspace(0, 1, 25)]
    elif kind == 1:
        shares = [(0, 0), (0.4, 0.8), (0.6, draw.between(0.3, 0.6)), (1, 1)]
    else:
        shares = [(0, 0), (0.5, draw.between(0.4, 0.7)), (0.8, 0.7), (0.9, 1), (1, 1)]
    rows = [[round(duration * t, 4), round(load * share, 4)] for t, share in shares]
    text = "\n".join(["time [s],load [N]", *(f"{time},{load}" for time, load in rows)])
    del entries["loading.rate"], entries["loading.reference_load"]
    entries["loading.file"] = "record.csv"
    entries["sweep.loads"] = [f"{load * share:.5g} N" for share in LOAD_SHARES[1:]]
    entries["title"] = f"recorded load {rows}"
    return entries, velocity, {"record.csv": lambda path: path.write_text(text + "\n")}


def measured(draw, number):
    """Entries and file of a measured surface: scratched, with plateaus, turned, or oblique."""
    entries, velocity, _ = lay(draw, number)
    kind = ("scratched", "oblique", "plateaus", "turned", "oblique")[number % 5]
    return entries, velocity, measure(entries, kind)


def measure(entries, kind):
    """Replace the roughness of `entries` by a measured surface of a kind; return its file."""
    shape, seed = entries["window.pixels"], entries["disk.roughness.seed"]
    ra = float(entries["disk.roughness.ra"].split()[0])
    for key in [key for key in entries if key.startswith("disk.roughness")]:
        del entries[key]
    entries |= {"disk.roughness.file": "heights.npy", "disk.roughness.height_unit": "um"}
    entries["title"] = f"{kind} surface of seed {seed}, Ra {ra:g} µm"

    def write(path):
        np.save(path, measured_heights(shape, kind, seed, ra).T)  # rows of a scan are along x

    return {"heights.npy": write}


def measured_heights(shape, kind, seed, ra):
    """Heights [µm] like those of an instrument, x along the first axis."""
    rng = np.random.default_rng(seed)
    qx, qy = np.fft.fftfreq(shape[0])[:, None], np.fft.fftfreq(shape[1])[None, :]

    def noise(lx, ly, power):
        spectrum = (1 + (lx * 2 * np.pi * qx) ** 2 + (ly * 2 * np.pi * qy) ** 2) ** (-power / 2)
        field = np.fft.ifft2(np.fft.fft2(rng.standard_normal(shape)) * spectrum).real
        return field / field.std()

    if kind == "scratched":
        heights = noise(4, 4, 1.8) + 0.3 * noise(1.5, 1.5, 1.5) - 0.6 * np.abs(noise(40, 2, 2.2))
    elif kind == "plateaus":
        heights = np.minimum(noise(3, 12, 1.8), 0.6 + 0.15 * noise(3, 3, 1.8))
    elif kind == "oblique":  # grooves at an angle to y
        cosine, sine = np.cos(angle := np.radians((45, -45, 20)[seed % 3])), np.sin(angle)
        across, along = cosine * qx + sine * qy, cosine * qy - sine * qx
        spectrum = (1 + (6 * np.pi * across) ** 2 + (80 * np.pi * along) ** 2) ** -0.9
        heights = np.fft.ifft2(np.fft.fft2(rng.standard_normal(shape)) * spectrum).real
    elif kind == "honed":  # crossing scratches below a plateau
        scratches = noise(30, 1.5, 2.2) + noise(1.5, 30, 2.2)
        heights = 0.25 * noise(2, 2, 1.6) - np.abs(scratches) ** 1.5
    elif kind == "stepped":
        heights = np.round(1.5 * noise(6, 6, 2.0)) + 0.1 * noise(2, 2, 1.6)
    elif kind == "needles":
        heights = np.exp(1.2 * noise(2.5, 2.5, 2.0))
    elif kind == "two scales":
        heights = noise(20, 20, 3.0) + 0.3 * noise(1.5, 1.5, 1.8)
    elif kind == "grooves":  # along the track
        y = np.arange(shape[1]) * (max(3, shape[1] // 12) / shape[1])
        heights = np.cos(2 * np.pi * y) + 0.2 * noise(3, 3, 1.8)
    else:
        x = np.arange(shape[0])[:, None] * (max(3, shape[0] // 18) / shape[0])
        heights = np.abs((x % 1) - 0.5) * 3.5 + 0.35 * noise(3, 3, 1.7)
        heights = np.broadcast_to(heights, shape).copy()
    heights -= heights.mean()
    return ra * heights / np.abs(heights).mean()


def tops(draw, number):
    """Entries and file of a surface with tops of an own shape, judged by several area fractions."""
    entries, velocity, _ = (local if number % 4 == 3 else lay)(draw, number)
    pixels = [number // 2 % 2 * 32 + 128, 64]
    scale = entries["window.pixels"][0] / pixels[0]
    sizes = [float(size.split()[0]) * scale for size in entries["window.pixel_size"]]
    entries |= {"window.pixels": pixels, "window.pixel_size": [f"{size:.3g} um" for size in sizes]}
    kind = ("honed", "stepped", "needles", "two scales", "grooves")[number % 5]
    entries["temperature.critical_area_fraction"] = (0.5, 0.01, 0.3, 0.05, 0.0, 0.2)[
        number // 2 % 6
    ]
    return entries, velocity, measure(entries, kind)


def stages(draw, number):
    """Entries of a specimen whose load rises in stages."""
    entries, velocity, _ = (local if number % 3 == 2 else lay)(draw, number)
    shape = entries["window.pixels"] = [96, 64]
    load = float(entries.pop("loading.reference_load").split()[0])
    seconds = draw.log(2, 20)
    levels = [f"{load * share:.5g} N" for share in LOAD_SHARES]
    entries["loading.stages"] = [[level, f"{seconds:g} s"] for level in levels]
    rate = draw.log(3e-8, 6e-7)
    width = 1.3 * _line_width(
        float(entries["pin.radius"].split()[0]), float(entries["pin.length"].split()[0]),
        load, rate, 4 * velocity, 8 * seconds, draw.between(0.1, 0.3),
    )  # fmt: skip
    size = width / shape[0]
    lengths = [f"{size * draw.between(2.5, 5):.3g} um" for _ in "xy"]
    entries["disk.roughness.correlation_length"] = lengths
    entries["window.pixel_size"] = [f"{size:.3g} um"] * 2
    entries["wear.specific_wear_rate"] = f"{rate:g} mm^3/(N m)"
    entries["sweep.loads"] = levels
    return entries, velocity, {}


def coarse_pixels(draw, number):
    """Entries of a scene whose pixels are large beside the contact or its summits."""
    radius, length, load = draw.log(1.5, 6), draw.log(2, 6), draw.log(100, 700)
    velocity, rate, ra = draw.log(0.5, 3), draw.log(1e-7, 4e-6), draw.log(0.05, 0.25)
    width = 1.5 * _line_width(radius, length, load, rate, 2 * velocity, 5, ra)
    pixels = draw.one_of((64, 64), (96, 64), (80, 80))
    size = width / pixels[0]
    lengths = [size * draw.between(2, 3.5) for _ in "xy"]
    entries = _system(draw, radius=radius, length=length) | _ramp(load, draw.between(3, 8))
    entries |= _window(width, pixels) | _wear(rate, draw.one_of("swept", "swept", "local"))
    entries |= _rough(draw, ra, lengths, hurst=draw.between(0.5, 0.8))
    return entries, velocity, {}


def wide_summits(draw, number):
    """Entries of discs with summits a few pixels wide; half of the contact decides."""
    radius, length, load = draw.between(15, 30), 10.0, draw.log(3e3, 8e3)
    velocity, ra = draw.log(0.8, 3), draw.between(0.12, 0.3)
    width = 1.35 * _line_width(radius, length, load, 0, velocity, 10, ra / 3)
    pixels = draw.one_of((320, 80), (256, 96), (320, 64))
    size = width / pixels[0]
    along = size * draw.between(2.2, 3)
    entries = _system(draw, radius=radius, length=length) | _ramp(load, draw.between(8, 20))
    entries |= _window(width, pixels, (size, 1.1 * size)) | _wear(1.2e-6)
    entries |= _rough(draw, ra, [along, along], hurst=0.8)
    entries |= {
        "motion.slide_roll_ratio": draw.one_of(0.5, 1.0),
        "pin.diameter": f"{4 * radius:g} mm",
        "pin.width": "10 mm",
        "temperature.bulk": "60 degC",
        "friction.coefficient": 0.06,
        "temperature.critical_area_fraction": draw.one_of(0.5, 0.1, 0.5),
    }
    return entries, velocity, {}


FAMILIES = {
    "shipped": shipped,
    "lay": lay,
    "twin disc": twin_disc,
    "ball": ball,
    "local": local,
    "hold": hold,
    "record": record,
    "measured": measured,
    "tops": tops,
    "stages": stages,
    "coarse pixels": coarse_pixels,
    "wide summits": wide_summits,
}
