"""Advice in messages helps: what a command advises is done, and the message is gone."""

import re
import shlex
import shutil
from pathlib import Path
from typing import NamedTuple

import pytest

import pipeline
from pipeline.run.serial import run_serial
from pipeline.store.create import writing
from tests.helpers.scenes import SCENE

SMALL = (
    SCENE.replace("increments = 10", "increments = 2")
    .replace("[48, 16]", "[24, 8]")
    .replace(', "600 N"]', "]")
    .replace('"1 m/s", ', "")
)
TEST = '\nload = "400 N"\nvelocity = "2 m/s"\noutcome = "transition"\n\n[sweep]'


class Case(NamedTuple):
    """A command whose message gives advice, and what follows the advice.

    Groups of the pattern `advice` fill the braces of `followed` and of the new text of `edit`. The
    scene small.toml is then simulated into the store `run`, if there is one.
    """

    command: str
    advice: str
    followed: str
    helps: str  # text that the command prints in the end
    code: int = 2
    edit: tuple[str, str, str] | None = None  # file, old and new text
    run: str = ""


CASES = {
    # scenes
    "a misspelt entry": Case(
        "check typo.toml", r'did you mean "(\w+)"\?', "check typo.toml", "4: 2 loads, 2 velocities",
        edit=("typo.toml", "incremnts", "{}"),
    ),
    "pixels that fit": Case(
        "check block.toml", "give multiples of 5", "check block.toml", "25 × 10 elements",
        edit=("block.toml", "[24, 8]", "[125, 50]"),
    ),
    "elements that fit": Case(
        "check block.toml", "or change fidelity.pixels_per_element", "check block.toml",
        "24 × 8 elements", edit=("block.toml", "pixels_per_element = 5", "pixels_per_element = 1"),
    ),
    "a wider window": Case(
        "check long.toml", r"increase\s+window.pixels", "check long.toml", "96 × 64 elements",
        code=0, edit=("long.toml", "[24, 8]", "[96, 64]"),
    ),
    # run
    "no preset beside an accuracy": Case(
        "run small.toml --accuracy 5% --preset fine --dry-run", "leave out --preset",
        "run small.toml --accuracy 5% --dry-run", "4: 2 loads, 2 velocities",
    ),
    "values of the store": Case(
        "run small.toml -o bare.zarr",
        r"use the values of the store[^$]*fields: (\w+) in the store",
        "run small.toml -o bare.zarr --set sweep.fields={}", "4 of 4 points done, 0 of them",
        code=3,
    ),
    # answers
    "a load and a velocity": Case(
        "margin small.zarr --load '300 N'", "give both a load and a velocity",
        "margin small.zarr --load '300 N' --velocity '3 m/s'", "probability of severe wear",
    ),
    "the end of the run": Case(
        "margin partial.zarr --load '300 N' --velocity '3 m/s'", "finish the run",
        "margin partial.zarr --load '300 N' --velocity '3 m/s'", "probability of severe wear",
        run="partial.zarr",
    ),
    "a friction": Case(
        "boundary small.zarr --friction 0,12", "give a share such as (0.1)",
        "boundary small.zarr --friction {}", "friction 0.1,",
    ),
    "a condition": Case(
        "boundary small.zarr --at friction=0.1", 'did you mean "(.*?)"',
        "boundary small.zarr --at {}=0.1", "friction 0.1,",
    ),
    "a table's name": Case(
        "boundary small.zarr -o a.txt", r"must end in one of (\.csv)", "boundary small.zarr -o a{}",
        "a.csv",
    ),
    "a simulation first": Case(
        "status none.zarr", "run a scene first", "status none.zarr", "4 points: 4 done",
        run="none.zarr",
    ),
    # tests
    "tests to infer from": Case(
        "infer small.toml", r"add (\[\[tests\]\]) with load, velocity and outcome",
        "infer small.toml", "critical temperature", edit=("small.toml", "[sweep]", "{}" + TEST),
    ),
    "options of a width": Case(
        "infer small.toml --contact-width '0.2 mm'", "also needs (--load) and (--velocity)",
        "infer small.toml --contact-width '0.12 mm' {} '400 N' {} '4 m/s'",
        "each further second at full load lowers the rate by about",
    ),
    # tables of operating points
    "a column to ignore": Case(
        "margin small.zarr --points duty.csv", '(--ignore "gear")',
        "margin small.zarr --points duty.csv {}", "2 operating points",
    ),
    "a column of names": Case(
        "margin small.zarr --points duty.csv", "to (number) if it has names",
        "margin small.zarr --points duty.csv", "2 operating points",
        edit=("duty.csv", "gear", "{}"),
    ),
    "a decimal comma": Case(
        "margin small.zarr --points comma.csv", '(--decimal ",")',
        "margin small.zarr --points comma.csv {}", "2 operating points",
    ),
    "a unit": Case(
        "margin small.zarr --points bare.csv", 'give a load above 0, such as "200 (N)"',
        "margin small.zarr --points bare.csv", "2 operating points",
        edit=("bare.csv", "load,", "load [{}],"),
    ),
    # figures
    "one case": Case(
        "plot over.zarr --kind tests -o a.png", '(--at "pin_radius=2 mm")',
        "margin over.zarr --load '300 N' --velocity '3 m/s' {}", "probability of severe wear",
    ),
    # report, verify, new, help
    "both of a report's point": Case(
        "report small.zarr --load '300 N' -o a.html", "give a load and a velocity, or",
        "report small.zarr --load '300 N' --velocity '3 m/s' -o a.html", "a.html",
    ),
    "a report's name": Case(
        "report small.zarr -o a.docx", r"must end in (\.html)", "report small.zarr -o a{}",
        "a.html",
    ),
    "a repair": Case(
        "verify damaged.zarr", "irg run repairs it with the same scene", "verify damaged.zarr",
        "4 done and undamaged, 0 damaged", code=1, run="damaged.zarr",
    ),
    "a name of a scene": Case(
        "new rig", r"such as (\w+\.toml)", "new {}", "rig.toml is written",
    ),
    "another name": Case(
        "new small.toml", "choose another name", "new other.toml", "other.toml is written",
    ),
    "a whole command": Case(
        "new", r"such as: irg (new scene\.toml)", "{}", "scene.toml is written",
    ),
    "the next command": Case(
        "new rig.toml", "estimate its cost: irg (check rig.toml)", "{}", "points", code=0,
    ),
    "a page": Case("help chosing", r'did you mean "(\w+)"', "help {}", "# "),
}  # fmt: skip


def simulate(path, scene, selection=slice(None)):
    """Simulate pending points of a scene into a store, without a cluster."""
    with writing(path, pipeline.load_scene(scene)) as store:
        run_serial(store, store.pending()[selection])


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """Folder of scenes, tables and stores."""
    folder = tmp_path_factory.mktemp("advice")
    texts = {
        "small.toml": SMALL,
        "typo.toml": SMALL.replace("increments", "incremnts"),
        "block.toml": SMALL.replace("pixels_per_element = 1", "pixels_per_element = 5"),
        "long.toml": SMALL.replace('"16 um"', '"90 um"'),
        "bare.toml": SMALL.replace("fields = true", "fields = false"),
        "over.toml": f'{SMALL}\n[sweep.over]\npin.radius = ["2 mm", "4 mm"]\n',
        "duty.csv": "load [N],velocity [m/s],gear\n200,2.5,3\n300,3,4\n",
        "comma.csv": "load [N];velocity [m/s]\n200;2,5\n300;3\n",
        "bare.csv": "load,velocity [m/s]\n200,2.5\n300,3\n",
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    for name in ("small", "bare", "over"):
        simulate(folder / f"{name}.zarr", folder / f"{name}.toml")
    simulate(folder / "partial.zarr", folder / "small.toml", slice(1))
    shutil.copytree(folder / "small.zarr", folder / "damaged.zarr")
    chunk = next(
        file for file in (folder / "damaged.zarr/rise_quantile").rglob("*") if ".0" in file.name
    )
    chunk.write_bytes(b"no array")
    return folder


@pytest.mark.parametrize("name", CASES)
def test_advice_that_is_followed_helps(stores, tmp_path, monkeypatch, irg, undrawn, name):
    case = CASES[name]
    shutil.copytree(stores, tmp_path / "work", ignore=shutil.ignore_patterns("*.zarr"))
    monkeypatch.chdir(tmp_path / "work")
    for store in stores.glob("*.zarr"):
        if store.name == case.run or f"-o {store.name}" in case.command:
            shutil.copytree(store, store.name)
        else:  # it is only read
            Path(store.name).symlink_to(store)
    message = irg(*shlex.split(case.command), code=case.code)
    match = re.search(case.advice, message)
    assert match, message
    scene = Path("small.toml")
    if case.edit:
        file, old, new = case.edit
        scene = Path(file) if file.endswith(".toml") else scene
        text = Path(file).read_text(encoding="utf-8")
        assert old in text
        Path(file).write_text(text.replace(old, new.format(*match.groups())), encoding="utf-8")
    if case.run:
        simulate(case.run, scene)
    output = irg(*shlex.split(case.followed.format(*match.groups())))
    assert case.helps in output
    assert not re.search(case.advice, output)
