"""All refusals of scenes, and of the files that they name: what causes each, and what it says."""

import math
from pathlib import Path

import numpy as np
import pandas as pd

from pipeline import load_scene, new_scene, run_point, to_si
from pipeline.kinds import LOAD, WORKERS
from pipeline.scene.contact_estimate import require_admissible_load
from pipeline.scene.variants import variants_of
from pipeline.units import share_of
from tests.helpers import laws, tiny
from tests.helpers.refusals import refusal_tests
from tests.pipeline.scene.conftest import MEASURED_SURFACE, ROUGHNESS, TEXT

RAMP = 'rate = "150 N/s"\nreference_load = "750 N"'
STAGES = '\n[[tests]]\nvelocity = "2 m/s"\nmild_up_to = "400 N"\n'


def scene(*changes, text=TEXT, **overrides):
    """Read the scene of these tests with texts replaced, or with other entries."""
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    Path("scene.toml").write_text(text, encoding="utf-8")
    return load_scene("scene.toml", overrides=overrides)


def entry(key, value, **other_entries):
    return lambda: scene(**{key: value}, **other_entries)


def text(old, new):
    return lambda: scene((old, new))


def toml(content, name="scene.toml"):
    def read():
        Path(name).write_bytes(content)
        return load_scene(name)

    return read


def file(read, name, content):
    """Function that writes a file and reads it by `read`."""

    def build():
        Path(name).write_bytes(content)
        return read(Path(name))

    return build


def load(content):
    """Function that reads a scene with a load record of this content."""
    return file(lambda path: scene((RAMP, f'file = "{path}"')), "load.csv", content)


def chain():
    for number in range(25):
        Path(f"c{number}.toml").write_text(f'extends = "c{number + 1}.toml"\n')
    return load_scene("c0.toml")


def long_load():
    with Path("load.csv").open("wb") as record:
        record.truncate(40_000_001)
    return scene((RAMP, 'file = "load.csv"'))


def along(rows, **other_entries):
    def build():
        Path("rows.csv").write_text(rows)
        return scene(**{"sweep.along": "rows.csv"}, **other_entries)

    return build


ROW = "load [N],velocity [m/s]\n300,2\n"


def measured(shape, **other_entries):
    np.save("surface.npy", np.zeros(shape))
    return scene((ROUGHNESS, MEASURED_SURFACE), **other_entries)


def new_scene_twice():
    new_scene("mine.toml")
    return new_scene("mine.toml")


def new_scene_at_a_link():
    Path("link.toml").symlink_to("no scene.toml")
    return new_scene("link.toml")


def over(path, values, **other_entries):
    return entry("sweep.over", {path: values}, **other_entries)


def uncertain(paths, deviation):
    return entry("uncertainty", {paths: deviation})


FILES = {
    "load header": (load(b"time [s],load [N],load [kN]\n0,0,0\n1,5,1\n"), "occurs twice"),
    "load inf": (load(b"time [s],load [N]\n0,0\n\n1,1e999\n"),
                 'row 4, load [N]: "1e999 N" is too large'),
    "load back": (load(b"time [s],load [N]\n0,0\n\n2,5\n1,6\n"),
                  "row 5: time 1 s after 2 s"),
    "load large": (long_load, "it has 40 MB; at most 40 MB are read"),
}  # fmt: skip

QUANTITIES = {
    "no unit": (lambda: to_si("4 m/m", like="1 m"), '"4 m/m" has no unit'),
    "degrees": (lambda: to_si("25 C", like="1 K"), "cannot be converted to K"),
    "dimension": (lambda: to_si("7 kg", like="750 N"), "cannot be converted to N"),
    "no quantity": (lambda: to_si("five", like="1 m"), '"five" is not a number with'),
    "hardness": (lambda: to_si("19 HRC", like="6 GPa"), "20 to 68 HRC); give HV"),
    "unknown": (lambda: to_si("4 kx", like="1 N"), "has an unknown unit: 'kx'"),
    "infinite": (lambda: to_si("1e400 N", like="1 N"), '"1e400 N" is too large'),
    "unit": (lambda: to_si("4 2 um", like="1 m"), "has a unit that cannot be read"),
    "named": (lambda: LOAD.argument("load", "4 m"), 'load: "4 m"'),
    "count": (lambda: WORKERS.argument("samples", 1.5), "samples: 1.5 is not a whole number"),
    "an array": (
        lambda: to_si(np.eye(2), "1 N"),
        "text is array([[1., 0.], [0., 1.]]); give a number with a unit as text",
    ),
    "a frame": (
        lambda: LOAD.argument("load", pd.DataFrame({"load": [4.0]})),
        "load is a table; give one of its columns",
    ),
    "share": (lambda: share_of("ten"), '"ten" is not a number; give one such as 0.1'),
}


EVEN = '{ first = "200 N", step = "200 N", hold = "60 s" }'


def stages(stage_text, loads=("200 N", "400 N"), more="", **other_entries):
    """Function that reads the scene with the loading in stages."""
    loading = (RAMP, f'rate = "150 N/s"\nstages = {stage_text}\n{more}')
    return lambda: scene(loading, **{"sweep.loads": [*loads], "without": "tests"} | other_entries)


def staged(test, loading=RAMP):
    """Function that reads the scene with one test by stages."""
    text = f"{TEXT[: TEXT.index('[[tests]]')]}\n[[tests]]\nstages = {EVEN}\n{test}\n"
    return lambda: scene((RAMP, loading), text=text)


def staged_record():
    """Read a scene whose load is recorded, with a test by stages."""
    Path("load.csv").write_text("time [s],load [N]\n0,0\n1,100\n2,200\n")
    return staged('velocity = "2 m/s"\nsevere_at = "400 N"', 'file = "load.csv"')()


RELIEF = {"depth": "2 um", "length": "0.3 mm"}
TEST = {"load": "400 N", "velocity": "1 m/s", "outcome": "mild"}
ENTRIES = {
    "ra": (entry("disk.roughness.ra", 0.27), "0.27 has no unit"),
    "no list": (entry("sweep.loads", []), "[] is empty"),
    "one side": (entry("window.pixels", [480]), "[480] needs 2 values, not 1"),
    "number twice": (entry("tests", [{**TEST, "number": 2}] * 2, without="tests"),
                     "tests: two tests have one number"),
    "entry of a test": (entry("tests", [{**TEST, "with": {"pin.radius": 3}}], without="tests"),
                        "tests[0].with: pin.radius: 3 has no unit"),
    "entries of a test": (entry("tests", [{**TEST, "with": ["1 mm"]}], without="tests"),
                          'tests[0].with: ["1 mm"] is not a table; give a table of entries'),
    "test without outcome": (entry("tests", [{"load": "4 N", "velocity": "1 m/s"}]),
                             'outcome: missing; required: "mild", "severe" or "transition"'),
    "outcome of stages": (
        entry("tests", [{"velocity": "1 m/s", "outcome": "mild", "severe_at": "4 N"}]),
        "tests[0].outcome: does not fit mild_up_to or severe_at; leave it out"),
    "load of stages": (
        entry("tests", [{"velocity": "1 m/s", "load": "4 N", "severe_at": "4 N"}]),
        "tests[0].load: does not fit mild_up_to or severe_at; leave it out"),
    "stages of velocity": (entry("tests", [{"velocity": "1 m/s", "severe_at": "4 m/s"}]),
                           'tests[0].severe_at: "4 m/s" cannot be converted to N'),
    "test without load": (entry("tests", [{"velocity": "1 m/s", "outcome": "mild"}]),
                          "tests[0].load: missing; required: a load above 0"),
    "stages of a transition": (
        entry("tests", [{**TEST, "outcome": "transition", "stages": [["400 N", "1 s"]]}]),
        "tests[0].stages: do not fit a transition; give mild_up_to and severe_at"),
    "load without stage": (stages(EVEN, ["300 N"]), "300 N is not a load stage; choose from 200 N"),
    "hold of stages": (stages(EVEN, more='hold = "4 s"'), "loading.hold: unknown key"),
    "stage without hold": (stages('[["4 N"]]', ["4 N"]), "needs 2 values, not 1"),
    "steps of stages": (stages(EVEN, **{"sweep.steps": "course"}), "only the onset and the end"),
    "many stages": (stages(EVEN.replace('step = "200', 'step = "1e-4')), "2e+06 load stages"),
    "severe without stage": (staged('velocity = "2 m/s"\nsevere_at = "350 N"'),
                             "load is 350 N, which is not a load stage; choose from 200 N"),
    "stages of a record": (staged_record, "stages need a rate of the load"),
    "degrees of an entry": (entry("temperature.bulk", "25 C"), 'to degC; give a temperature, such'),
    "nan": (entry("materials.steel.poisson_ratio", math.nan), "nan is outside the allowed range"),
    "short pin": (entry("pin.length", "0.455 mm"), "0.455 mm is shorter than the window, 0.456 mm"),
    "material": (entry("disk.material", "stell"), 'disk.material: "stell" is neither'),
    "like": (entry("oil", "vg33"), '"vg33" is not in the library'),
    "pixels": (entry("window.pixels", [480, 481]), "window.pixels: [480, 481] cannot be averaged"),
    "one pixel": (entry("window.pixels", [1, 1], **{"fidelity.pixels_per_element": 1}),
                  "a window of one pixel cannot be rough"),
    "relief of a repeating pin": (
        lambda: load_scene("first_try", overrides={"pin.relief": RELIEF}),
        'give ends = "free" as well'),
    "long relief": (
        lambda: load_scene("whole_pin", overrides={"pin.relief": RELIEF | {"length": "2 mm"}}),
        "pin.relief.length: 2 mm is more than half of pin.length, 3.4 mm; give at most half"),
    "ends of a ball": (lambda: load_scene("ball_on_disk", overrides={"pin.ends": "free"}),
                       "pin.ends: a ball has no ends; leave it out, or give"),
    "sharp ends": (entry("pin.ends", "sharp"), '"sharp" is not a valid choice; give "free"'),
    "crown": (entry("pin.shape", "crowned", without="pin.length"),
              "pin.crown_radius: missing; required for a crowned pin"),
    "no length": (lambda: scene(without="disk.roughness.correlation_length"),
                  'give a correlation_length, such as "4 um", or an rsm'),
    "two spellings": (entry("increments", 5, **{"fidelity.increments": 6}),
                      "fidelity.increments: is given twice, also as increments"),
    "two lengths": (entry("disk.roughness", {"ra": "0.27 um", "hurst_exponent": 0.8,
                                             "correlation_length": "4 um", "rsm": "30 um"}),
                    "correlation_length and rsm state the same; leave out one of them"),
    "rsm below ra": (entry("disk.roughness.rsm", ["30 um", "0.2 um"]),
                     "rsm (0.2 µm) is below ra (0.27 µm): are they swapped?"),
    "another track": (entry("motion", {"slide_roll_ratio": 1, "disk_track_length": "30 mm"},
                            **{"disk.track_length": "40 mm"}),
                      "motion.disk_track_length: 30 mm is not the 40 mm of disk.track_length"),
    "short track": (entry("motion", {"slide_roll_ratio": 1, "pin_track_length": "0.1 mm"}),
                    "it must be at least that of the window along x"),
    "critical": (entry("temperature.critical", "25 degC"), "not above temperature.bulk (25 °C)"),
    "far": (entry("temperature.bulk", "1e9 degC"), 'degC" is outside the allowed range, which is'),
    "comma": (entry("friction.coefficient", "0,1"), '"0,1" is not a number'),
    "step": (entry("sweep.velocities.step", "0.7 m/s"), 'steps of "0.7 m/s"; the number of'),
    "both": (entry("sweep.velocities", {"step": "1 m/s", "count": 4}), "either step or count"),
    "falling": (entry("sweep.velocities.to", "0.1 m/s"), "is descending"),
    "falling band": (entry("friction.band", [0.2, 0.1]), "falls; give the lower first"),
    "materials": (entry("materials", 3), "3 is not a table of tables"),
    "what materials are": (entry("materials", 3), "; give at least one table under a name of your "
                           "choice, each a table with elastic_modulus"),
    "entries as a preset": (lambda: load_scene("first_try", {"pin.radius": "3 mm"}),
                            "entries of a scene go into overrides="),
    "pin": (entry("pin", 3), "3 is not a table; expected a table with"),
    "key": (entry("realisations", 3), 'realisations: unknown key (did you mean "sweep.real'),
    "seeds": (entry("sweep.realizations", [3, 3]), "sweep.realizations[1]: 3 repeats entry [0]"),
    "without": (entry("without", "pin.lenght"), '"pin.lenght" is not an entry of'),
    "load": (lambda: require_admissible_load(scene(), 1e6, "--load"),
             "--load: 1e+06 N exceeds what the window of"),
    "points": (entry("sweep.loads", {"from": "1 N", "to": "7 N", "count": 5000},
                     **{"sweep.velocities": {"from": "1 m/s", "to": "7 m/s", "count": 5000}}),
               "2.5e+07 points are too many"),
    "long list": (entry("sweep.velocities", [f"{k + 1} m/s" for k in range(5001)]),
                  "5001 entries are too many, at most 5000 are allowed"),
    "scan": (lambda: measured((48, 20)), "the scan has 20 × 48 heights along x and y"),
    # laws in Python
    "track": (entry("disk.diameter", "0.5 mm", **{"disk.width": "9 mm"}), "disk.diameter: "),
    # uncertain inputs
    "no input": (uncertain("pin.radios", "5 %"), 'is no input of the scene (did you mean "pin.rad'),
    "infinite input": (
        entry("uncertainty", {"materials.steel.hardness": "5 %"},
              without="materials.steel.hardness"), "hardness: is no input of the scene"),
    "zero deviation": (uncertain("pin.radius", "0 %"), '"0 %" is outside the allowed range; giv'),
    "no temperature difference": (uncertain("temperature.bulk", "5 %"), "is not a number with a"),
    "input twice": (uncertain("pin.radius, pin.radius", "5 %"), "has pin.radius a second time"),
    "input in two keys": (
        entry("uncertainty", {"pin.radius": "5 %", "pin.length, pin.radius": "2 %"}),
        "has pin.radius a second time; give each"),
    "kelvins of a length": (uncertain("pin.radius", "5 K"), '"5 K" cannot be converted'),
    "kelvins of both": (uncertain("pin.radius, temperature.bulk", "5 K"), "cannot be converted"),
    "a temperature": (uncertain("temperature.bulk", "5 degC"),
                      '"5 degC" is outside the allowed range, which is 0.001 K to 200 K; give'),
    "bare difference": (uncertain("temperature.bulk", 5),
                        "5 has no unit; give a temperature difference"),
    "many per cent": (uncertain("pin.radius", "500 %"), '"500 %" is outside the allowed range; gi'),
    "more than a radius": (uncertain("pin.radius", "3 mm"), "1.5 is outside the allowed range; gi"),
    "several deviations": (uncertain("pin.radius, pin.length", "0.1 mm"), "differs between its"),
    "sensitivity of a store": (
        lambda: variants_of(tiny.sweep(), [(400.0, 2.0, ())]),
        "sensitivities need the scene file; use it in place of its store"),
    "input of a part of a user": (
        lambda: variants_of(load_scene("first_try").with_scene(wear=laws.ByPressure()),
                            [(400.0, 2.0, ())], {"wear.specific_wear_rate"}),
        "uncertainty.wear.specific_wear_rate has no effect, since with_scene has replaced wear"),
    "entry of a part of a user": (
        lambda: load_scene("first_try").with_scene(wear=laws.ByPressure())
        .source.changed("wear.specific_wear_rate", 0),
        "wear.specific_wear_rate has no effect, since with_scene has replaced wear"),
    "input refused on both sides": (
        lambda: variants_of(load_scene("first_try", overrides=TIGHT),
                            [(20.0, 2.0, ())], {"pin.length"}),
        "uncertainty.pin.length: ± 10 % of the input are refused: pin.length: "),
    # several values of an entry
    "over fixed": (over("sweep.loads", [1, 2]), "cannot take several values"),
    "over twice": (over("pin.radius", ["1 mm", "1000 um"]), "two cases of the sweep have the same"),
    "over nothing": (over("materials.x.like", ["AISI 52100", "42CrMo4"]), "changes nothing here"),
    "over faulty": (over("pin.radius", ["2 mm", "-1 mm"]), '"-1 mm" is outside the allowed range'),
    "over grid": (over("fidelity.pixels_per_element", [2, 4]), "the grid of the stored fields"),
    "along many entries": (entry("sweep.along", [{f"pin.k{k}": 1} for k in range(101)]),
                           "rows have 101 different entries; give 100 at most"),
    "test many entries": (entry("tests", [{"load": "300 N", "velocity": "2 m/s", "outcome": "mild",
                                           "with": {f"pin.k{k}": 1 for k in range(101)}}]),
                          "101 entries are too many; give 100 at most"),
    "over a list": (over("pin.radius", [["1 mm"]]),
                    'pin.radius"[0]: ["1 mm"] is neither a number nor a quantity; give a'),
    "over many entries": (entry("sweep.over", {f"pin.k{k}": [1] for k in range(101)}),
                          "sweep.over: 101 entries are too many; give 100 at most"),
    "over many": (over("pin.radius", [f"{2 + n / 1000} mm" for n in range(149)], **{
        "sweep.over.pin.length": [f"{3 + n / 1000} mm" for n in range(149)]}), "exceed the limit"),
    # rows of a scene
    "rows": (entry("sweep.along", [{"load": "1 N", "velocity": "1 m/s"},
                                   {"load": "1 N", "velocity": "2 m/s", "pin.radius": "2 mm"}]),
             "sweep.along: the rows: row 1, pin.radius: empty; give a value in each row"),
    "empty table": (lambda: scene(text='extends = "first_try"\n[sweep]\nloads = {}\n'),
                    "sweep.loads: the table is empty; fill it or remove it"),
    "row lacks": (entry("sweep.along", [{"load": "1 N"}]), "no column velocity in"),
    "row faulty": (along("load [N],velocity [m/s],pin.radius [mm]\n300,2,3\n300,3,-3\n"),
                   'sweep.along[1]: pin.radius = "-3 mm": pin.radius: "-3 mm" is outside'),
    "row faulty without loads": (along("load [N],velocity [m/s]\n300,\n", without=[
        "sweep.loads", "sweep.velocities"]), "sweep.along: rows.csv: row 2, velocity [m/s]: empty"),
    "row with a short track": (entry("sweep.along", [{"load": "400 N", "velocity": "2 m/s",
                                                      "disk.track_length": "0.5 mm"}]),
                               "disk.track_length: the track is 0.5 mm long"),
    "heat counts twice": (entry("disk.track_length", "314 mm",
                                **{"temperature.includes_earlier_revolutions": True}),
                          "disk.track_length: temperature.bulk includes this heat already"),
    "row column": (along("load [N],pin.radius [mm]\n300,3\n"), "no column velocity in"),
    "row name": (along("number,load [N],velocity [m/s]\n\x1b[31mA,300,3\n"),
                 '[31mA" has a line break or a control character; leave it out'),
    "load factors of a plane": (entry("sweep.load_factors", [0.5, 1]),
                                "sweep.load_factors: has no effect without the rows of"),
    "load factors without 1": (along(ROW, **{"sweep.load_factors": [0.5, 2]}),
                               "sweep.load_factors: [0.5, 2.0] lacks the load of the rows"),
    "near load factors": (along(ROW, **{"sweep.load_factors": [1, 1.00005]}),
                          "1 and 1.00005 differ by less than 0.01 %; give one of them"),
    "load factor 0": (along(ROW, **{"sweep.load_factors": [0, 1]}),
                      "sweep.load_factors[0]: 0 is outside the allowed range"),
    "many load factors": (along(ROW, **{"sweep.load_factors": [*range(1, 5003)]}),
                          "sweep.load_factors: 5002 entries are too many"),
    "row at a factor beyond the stages": (along(ROW, **{
        "sweep.load_factors": [0.5, 1],
        "loading": {"stages": [["100 N", "1 s"], ["300 N", "1 s"]], "rate": "150 N/s"}}),
        "sweep.loads: 150 N is not a load stage"),
    "rows by load factors": (along("load [N],velocity [m/s]\n" + "".join(
        f"{300 + n / 100},1\n" for n in range(2600)), **{"sweep.load_factors": [0.5, 1]}),
        "sweep.load_factors: 2 factors of 2600 rows exceed 5000 loads in all"),
    "row count": (along("load [N],velocity [m/s]\n" + "".join(
        f"{300 + n / 100},1\n" for n in range(5001))), "has 5001 rows; at most 5000 are read"),
}  # fmt: skip

TEXTS = {
    "odd key": (text("[pin]", '"a\\u2028b" = 1\n[pin]'), 'materials.steel."a\\u2028b": unknown'),
    "thousands": (text('["200 N"', '["1,200 N"'), "decimals with a point, and no marks of thous"),
    "utf-16": (toml(TEXT.encode("utf-16")), "is not valid TOML in UTF-8"),
    "workbook": (
        toml(b"PK\x03\x04", "tests.xlsx"),
        "is a workbook; save its sheet as CSV (File, Save",
    ),
    "table": (
        toml(b"load [N]\n300\n", "tests.csv"),
        'is a table; name it in a scene: file = "tests.csv" in [[tests]]',
    ),
    "binary": (toml(bytes(range(32))), "is binary; a scene is a text file (TOML), as irg new"),
    "one test": (entry("tests", {"file": "a.csv"}), "[tests] is a single table; write [[tests]]"),
    "deep": (toml(b"a = " + b"[" * 50_000), "lists are nested too deeply; correct it"),
    "no toml": (toml(b"a = [1"), "a list has a comma between its values, and ] at"),
    "digits": (toml(b"a = " + b"9" * 5000), "is not valid TOML in UTF-8: Exceeds the limit"),
    "large file": (
        toml(b"a = 1\n" + b"[b.c.d]\n" * 40_000),
        "it has 0.32 MB; at most 0.2 MB are read",
    ),
    "folder": (lambda: load_scene("."), "not a file; give a scene file (TOML)"),
    "no scene": (lambda: load_scene("first_tyr"), "first_tyr"),
    "number as a scene": (lambda: run_point(5, "400 N", "2 m/s"), "a scene is of type int; give a"),
    "circle": (toml(b'extends = "scene.toml"\n'), "a scene may not extend itself"),
    "no value": (
        lambda: load_scene("first_try", overrides={"pin.radius": None}),
        'is None; to leave it out, set without = ["pin.radius"]',
    ),
    "chain": (chain, "a scene may not extend itself, and at most 20 others"),
    "dotted": (
        toml(b"a = 1\n[b]\n" + b".".join([b'"a b"'] * 30_000) + b" = 1\n"),
        "joined by points",
    ),
    "without extends": (toml(b'without = ["pin"]\n'), 'nothing to remove: "without" needs'),
    "no radius": (lambda: scene(without="pin.radius"), "pin.radius: missing; required: a length"),
    "changed": (lambda: scene().changed("pin.radius", "3 N"), 'pin.radius: "3 N" cannot be conv'),
    "long path": (entry(".".join("a" * 500), 1), "no entry has more than 10 parts"),
    "changed long path": (lambda: scene().changed(".".join("a" * 500), 1), "no entry has more"),
    "extends none": (toml(b'extends = "no.toml"\n'), "extends: no.toml"),
    "extends": (toml(b"extends = 3\n"), "extends: 3"),
    "stages fall": (
        lambda: scene(text=TEXT + STAGES + 'severe_at = "3 N"\n'),
        "is not above mild_up_to",
    ),
    "new": (lambda: new_scene("mine.txt"), "give a name such as mine.toml"),
    "new like": (lambda: new_scene("mine.toml", "twin_disk"), 'did you mean "twin_disc"?'),
    "new again": (new_scene_twice, "mine.toml already exists"),
    "new at a link": (new_scene_at_a_link, "link.toml already exists"),
    "new folder": (
        lambda: new_scene("no/mine.toml"),
        "no/mine.toml cannot be written: No such file",
    ),
}


TIGHT = {
    "window.pixels": [96, 48], "window.pixel_size": ["5 um", "5 um"], "pin.length": "0.24 mm",
    "disk.diameter": "50 mm", "disk.width": "0.24 mm", "sweep.loads": ["20 N"],
}  # fmt: skip

REFUSALS = {**FILES, **QUANTITIES, **ENTRIES, **TEXTS}

refusals, test_each_is_named, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "scene", REFUSALS
)
