"""All refusals of commands and their options: what causes each, and what it says."""

from functools import partial
from pathlib import Path

from tests.helpers.refusals import command, refusal_tests
from tests.helpers.scenes import SCENE


def irg(*arguments):
    return partial(command, *arguments)


def over_itself(*arguments):
    """Function that runs a command which would overwrite a file that it reads."""

    def build():
        Path("duty.csv").write_text("load [N],velocity [m/s]\n250,1\n")
        Path("link.csv").symlink_to("duty.csv")
        Path("scene.csv").write_text(SCENE)
        return command(*arguments)

    return build


def nested():
    return command("check", "first_try", "--set", f"title={'[' * 20_000}")


POINT = ("--load", "250 N", "--velocity", "1 m/s")
WIDTH = ("--contact-width", "0.2 mm")


def recorded():
    Path("load.csv").write_text("time [s],load [N]\n0,0\n1,200\n4,600\n")
    ramp = 'rate = "150 N/s"\nreference_load = "750 N"'
    assert ramp in SCENE
    Path("recorded.toml").write_text(SCENE.replace(ramp, 'file = "load.csv"'))
    return command("infer", "recorded.toml", *WIDTH, *POINT, "--duration", "9 s")


REFUSALS = {
    # values of options
    "no quantity": (irg("plot", "a.zarr", "--load", "3"),
                    '"3" has no unit; give a load above 0, such as "750 N"'),
    "not above 0": (irg("plot", "a.zarr", "--load=-5N"),
                    '"-5N" is outside the allowed range; give a load above 0'),
    "critical": (irg("boundary", "tiny.zarr", "--critical-temperature", "20 degC"),
                 "critical_temperature is 293.15 K (20 °C); it must be above the bulk temperature"),
    "table": (irg("boundary", "a.zarr", "-o", "a.txt"), "a.txt: the file name must end in"),
    "surfaces": (irg("paper", "fig4", "--surfaces", "0"), "not a whole number of at least 1"),
    "friction": (irg("boundary", "a.zarr", "--friction", "0,12"),
                 'argument --friction: "0,12" is not a number; give a share such'),
    "frictions": (irg("point", "first_try", *POINT, "--friction", "0.1", "--friction", "0.2"),
                  "friction.coefficient takes a single value here"),
    "outside": (irg("margin", "tiny.zarr", "--load=2 N", "--velocity=1 m/s"),
                "load 2 N is outside the sweep"),
    "below rest": (irg("margin", "tiny.zarr", "--load=250 N", "--velocity=-1 m/s"),
                   '"-1 m/s" is outside the allowed range; give a velocity above 0'),
    "share": (irg("run", "first_try", "--accuracy", "200%"),
              '"200%" is outside the allowed range; give a share'),
    "area fraction": (
        irg("boundary", "tiny.zarr", "--critical-area-fraction", "0,1"),
        '--critical-area-fraction: "0,1" is not a number; give a share'
    ),
    "nested": (nested, "title is nested without an end"),
    "no value": (irg("check", "first_try", "--set", "title"), '"title" is not of the form KEY'),
    # files that are read and would be written
    "over a scene": (over_itself("check", "scene.csv", "-o", "scene.csv"),
                     "scene.csv is an input of this command; choose another output file"),
    "over a link": (over_itself("margin", "tiny.zarr", "--points", "duty.csv", "-o", "link.csv"),
                    "link.csv is an input of this command; choose another output file"),
    # options that do not go together
    "at": (irg("boundary", "tiny.zarr", "--at", "temperature.critical=150"),
           'critical_temperature: "150" has no unit'),
    "at entry": (irg("boundary", "tiny.zarr", "--at", "pin.radius=3"), "pin.radius does not vary"),
    "twice": (irg("margin", "tiny.zarr", *POINT, "--friction=0.1", "--at=friction.coefficient=0.2"),
              "friction.coefficient is given twice"),
    "set twice": (irg("point", "first_try", *POINT, "--friction=0.1",
                      "--set=friction.coefficient=0.2"), "friction.coefficient is given twice"),
    "load twice": (irg("margin", "tiny.zarr", *POINT, "--load", "600 N"),
                   "irg margin: --load is given twice; give it once"),
    "entry twice": (irg("check", "first_try", "--set=increments=50", "--set=increments=60"),
                    "irg check: increments is given twice; give it once"),
    "accuracy and preset": (irg("run", "first_try", "--accuracy", "2%", "--preset", "fine", "-n"),
                            "--accuracy chooses the numerical settings; leave out --preset"),
    "accuracy and settings": (irg("run", "first_try", "--accuracy=2%", "--set=increments=5",
                                  "--preset=fine"), "leave out --preset, --set increments"),
    "no velocity": (irg("margin", "tiny.zarr", "--load", "250 N"),
                    "give both a load and a velocity"),
    "two places": (irg("margin", "tiny.zarr", "--points", "a.csv", *POINT),
                   "--points already gives loads and velocities"),
    "plot": (irg("plot", "tiny.zarr", "--kind", "tests", "--log"), "tests has no option 'log'"),
    "no tests": (irg("infer", "fig5"), "has no tests; add [[tests]]"),
    "none to show": (irg("boundary", "tiny.zarr", "--by", "test"), "the scene has no tests; add"),
    "ignored": (irg("infer", "first_try", "--duration", "9 s"),
                "apply only with --contact-width"),
    "width": (irg("infer", "first_try", *WIDTH),
              "--contact-width also needs --load and --velocity"),
    "width at a load": (irg("infer", "first_try", *WIDTH, "--load", "400 N"),
                        "--contact-width also needs --load and --velocity"),
    "short": (irg("infer", "first_try", *WIDTH, *POINT, "--duration", "1 s"),
              "shorter than the ramp to"),
    "record": (recorded, "--duration applies to load ramps; a recorded load has its own duration"),
    "new": (irg("new"), "give the name of the file to write"),
    "help": (irg("help", "boundry"), 'there is no page or command "boundry" (did you mean'),
    "at value": (irg("boundary", "tiny.zarr", "--at", "pin.radius=3 mm"),
                 "run the scene with pin.radius = 3 mm into another store"),
    # words that are not understood
    "nothing": (irg("run"), "SCENE.toml"),
    "a command": (irg("boundry", "a.zarr"), 'no command "boundry" (did you mean "boundary"?)'),
    "option first": (irg("--load", "400 N", "margin", "tiny.zarr"),
                     "options stand after the command: irg margin ... --load"),
    "two spellings": (irg("check", "first_try", "--set=increments=5",
                          "--set=fidelity.increments=6"),
                      "fidelity.increments is given twice"),
    "dry run from nowhere": (irg("run", "first_try", "-n", "--from", "no.zarr"), "no.zarr"),
    "dry run out of reach": (irg("run", "first_try", "-n", "--accuracy", "0.1%"),
                             "accuracy is 0.1 %, and the preset fine may err by"),
    "a kind": (irg("plot", "a.zarr", "--kind", "row"), "invalid choice: 'row' (choose from "),
    "decimals": (irg("plot", "a.zarr", "--width", "8,5 cm"), "write decimals with a point"),
    "of another": (irg("status", "a.zarr", "--friction", "0.1"),
                   'irg status: there is no option "--friction"; see irg status --help'),
    "misspelt": (irg("boundary", "a.zarr", "--fricton", "0.1"),
                 'there is no option "--fricton" (did you mean "--friction"?)'),
    "no option": (irg("margin", "a.zarr", "400 N"),
                  '"400 N" is not expected; write its option before it, as in --load "400 N"'),
    "no quotes": (irg("margin", "a.zarr", "400", "N"), '"400" is not expected; put text with a'),
    "no command": (irg(), "irg: a command is missing, such as irg run first_try"),
    "both": (irg("run", "a.toml", "--workers", "2", "--scheduler", "tcp://a:1"), "not allowed"),
}  # fmt: skip

ELSEWHERE = {
    "inputs._select_entry InputError": "tests/pipeline/test_over.py",
    "check.check InputError": "test_check.py, with the meaning that is printed before",
    "values.setting ValueError": "in the table; tracing stops where the stack runs out",
}
"""Refusals that are not in the table: where they are tested, or why not."""


refusals, test_each_is_named, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "cli", REFUSALS, ELSEWHERE, tiny="tiny_store"
)
