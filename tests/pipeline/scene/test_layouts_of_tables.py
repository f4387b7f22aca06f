"""Tables in the layouts of laboratories: points that are read, and words on those that are not."""

import itertools

import pandas as pd
import pytest

import pipeline
from pipeline.answers.answer_frames import complete_frame
from pipeline.condition_kinds import OperatingPoints
from tests.helpers.kept import assert_as_kept, refusal, relative

LOADS, VELOCITIES = [300.0, 1500.5], [1.25, 2.5]
HEADS = {
    "brackets": ("load [N]", "velocity [m/s]"), "parentheses": ("Load (N)", "Velocity (m/s)"),
    "other units": ("normal load [kN]", "sliding velocity (mm/s)"),
}  # fmt: skip
LAYOUTS = {
    "comma": (",", "."), "semicolon": (";", ","), "tab": ("\t", "."), "tab and comma": ("\t", ","),
}  # fmt: skip


@pytest.mark.parametrize(
    ("heads", "layout", "encoding"), [*itertools.product(HEADS, LAYOUTS, ["utf-8-sig", "utf-16"])]
)
def test_points_are_read_whatever_the_layout(heads, layout, encoding, tmp_path):
    delimiter, mark = LAYOUTS[layout]
    load, velocity = (1e-3, 1e3) if heads == "other units" else (1, 1)
    rows = [(f"{load * n:g}", f"{velocity * v:g}", "ok") for n, v in zip(
        LOADS, VELOCITIES, strict=True)]  # fmt: skip
    lines = [(*HEADS[heads], "remark (short)"), *rows]
    text = "\r\n".join(
        delimiter.join(cell.replace(".", mark) if k else cell for cell in line)
        for k, line in enumerate(lines)
    )
    (tmp_path / "points.csv").write_bytes(text.encode(encoding))
    points = OperatingPoints.read(tmp_path / "points.csv", decimal=mark)
    assert points.columns["load"] == pytest.approx(LOADS)
    assert points.columns["velocity"] == pytest.approx(VELOCITIES)
    assert [*points.labels] == ["remark (short)"]


def test_an_answer_of_the_program_is_read_as_points(tiny_store, tmp_path):
    points = pd.DataFrame({"pump": ["a", "b"], "load [N]": [200, 400], "velocity [m/s]": [0.6, 1]})
    points.to_csv(tmp_path / "points.csv", index=False)
    names = ("verdict", "probability", "governing_temperature")
    answer = pipeline.margin(tiny_store, tmp_path / "points.csv")
    complete_frame(answer).to_csv(tmp_path / "answer.csv", index=False)
    again = pipeline.margin(tiny_store, tmp_path / "answer.csv")
    for name in names:
        assert again[name].values == pytest.approx(answer[name].values, nan_ok=True)
    assert again["pump"].values.tolist() == ["a", "b"]


SLIPS = [
    'title = "C:\\Users\\a"\n',
    'title = "open\n',
    "title = 'open\n",
    "title = open\n",
    "[pin]\nradius = 2 mm\n",
    'title "a"\n',
    '[pin]\nradius = "2 mm"\n[pin]\n',
    'sweep = { loads = ["2 N"],\n velocities = ["1 m/s"] }\n',
    "[friction]\ncoefficient = 0,1\n",
    'title = "a"\ntitle = "b"\n',
]


def load(slip, folder):
    (folder / "a.toml").write_text(f'extends = "first_try"\n\n{slip}')
    return pipeline.load_scene(folder / "a.toml")


def test_slips_in_toml_are_named_in_words_that_are_kept(tmp_path):
    texts = {repr(slip): relative(refusal(load, slip, tmp_path), tmp_path) for slip in SLIPS}
    assert_as_kept("slips_in_toml", texts)
