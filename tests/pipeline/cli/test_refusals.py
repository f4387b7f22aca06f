"""All refusals of commands and their options: what causes each; tests/kept has what it says."""

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
    "no quantity": irg("plot", "a.zarr", "--load", "3"),
    "not above 0": irg("plot", "a.zarr", "--load=-5N"),
    "critical": irg("boundary", "tiny.zarr", "--critical-temperature", "20 degC"),
    "table": irg("boundary", "a.zarr", "-o", "a.txt"),
    "surfaces": irg("paper", "fig4", "--surfaces", "0"),
    "friction": irg("boundary", "a.zarr", "--friction", "0,12"),
    "frictions": irg("point", "first_try", *POINT, "--friction", "0.1", "--friction", "0.2"),
    "outside": irg("margin", "tiny.zarr", "--load=2 N", "--velocity=1 m/s"),
    "below rest": irg("margin", "tiny.zarr", "--load=250 N", "--velocity=-1 m/s"),
    "share": irg("run", "first_try", "--accuracy", "200%"),
    "area fraction": irg("boundary", "tiny.zarr", "--critical-area-fraction", "0,1"),
    "nested": nested,
    "no value": irg("check", "first_try", "--set", "title"),
    # files that are read and would be written
    "over a scene": over_itself("check", "scene.csv", "-o", "scene.csv"),
    "over a link": over_itself("margin", "tiny.zarr", "--points", "duty.csv", "-o", "link.csv"),
    # options that do not go together
    "at": irg("boundary", "tiny.zarr", "--at", "temperature.critical=150"),
    "at entry": irg("boundary", "tiny.zarr", "--at", "pin.radius=3"),
    "twice": irg("margin", "tiny.zarr", *POINT, "--friction=0.1", "--at=friction.coefficient=0.2"),
    "set twice": irg("point", "first_try", *POINT, "--friction=0.1",
                      "--set=friction.coefficient=0.2"),
    "load twice": irg("margin", "tiny.zarr", *POINT, "--load", "600 N"),
    "entry twice": irg("check", "first_try", "--set=increments=50", "--set=increments=60"),
    "accuracy and preset": irg("run", "first_try", "--accuracy", "2%", "--preset", "fine", "-n"),
    "accuracy and settings": irg("run", "first_try", "--accuracy=2%", "--set=increments=5",
                                  "--preset=fine"),
    "no velocity": irg("margin", "tiny.zarr", "--load", "250 N"),
    "two places": irg("margin", "tiny.zarr", "--points", "a.csv", *POINT),
    "plot": irg("plot", "tiny.zarr", "--kind", "tests", "--log"),
    "no tests": irg("infer", "fig5"),
    "none to show": irg("boundary", "tiny.zarr", "--by", "test"),
    "ignored": irg("infer", "first_try", "--duration", "9 s"),
    "width": irg("infer", "first_try", *WIDTH),
    "width at a load": irg("infer", "first_try", *WIDTH, "--load", "400 N"),
    "short": irg("infer", "first_try", *WIDTH, *POINT, "--duration", "1 s"),
    "record": recorded,
    "new": irg("new"),
    "help": irg("help", "boundry"),
    "at value": irg("boundary", "tiny.zarr", "--at", "pin.radius=3 mm"),
    # words that are not understood
    "nothing": irg("run"),
    "a command": irg("boundry", "a.zarr"),
    "option first": irg("--load", "400 N", "margin", "tiny.zarr"),
    "two spellings": irg("check", "first_try", "--set=increments=5",
                          "--set=fidelity.increments=6"),
    "dry run from nowhere": irg("run", "first_try", "-n", "--from", "no.zarr"),
    "dry run out of reach": irg("run", "first_try", "-n", "--accuracy", "0.1%"),
    "a kind": irg("plot", "a.zarr", "--kind", "row"),
    "decimals": irg("plot", "a.zarr", "--width", "8,5 cm"),
    "of another": irg("status", "a.zarr", "--friction", "0.1"),
    "misspelt": irg("boundary", "a.zarr", "--fricton", "0.1"),
    "no option": irg("margin", "a.zarr", "400 N"),
    "no quotes": irg("margin", "a.zarr", "400", "N"),
    "no command": irg(),
    "both": irg("run", "a.toml", "--workers", "2", "--scheduler", "tcp://a:1"),
}  # fmt: skip

ELSEWHERE = {
    "inputs._select_entry InputError": "tests/pipeline/test_over.py",
    "check.check InputError": "test_check.py, with the meaning that is printed before",
    "values.setting ValueError": "in the table; tracing stops where the stack runs out",
}
"""Refusals that are not in the table: where they are tested, or why not."""


refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "cli", REFUSALS, ELSEWHERE, tiny="tiny_store"
)
