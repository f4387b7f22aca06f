"""The page UNCERTAIN.md: its commands, on fewer samples."""

import re
import shlex
from pathlib import Path

import pipeline
from pipeline.cli import main
from pipeline.uncertain import design, next_tests, sensitivity
from tests.helpers.samples import fewer_draws

WORKFLOWS = Path(__file__).parents[2] / "workflows"
FEW = ["--set", "sweep.samples=32", "--set", 'sweep.loads=["200 N", "400 N", "750 N"]', "-q"]


def test_the_commands_of_the_page_lead_to_a_probability_and_the_next_test(
    tmp_path, monkeypatch, capsys
):
    page = (WORKFLOWS / "UNCERTAIN.md").read_text(encoding="utf-8")
    commands = re.findall(r"^irg .*$", page, flags=re.MULTILINE)
    assert len(commands) == 15
    fewer_draws(monkeypatch)
    monkeypatch.setattr(design, "_MOST", 24)
    monkeypatch.setattr(next_tests, "_TRUTHS", 32)
    monkeypatch.setattr(sensitivity, "_POINTS", 2**8)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "results").mkdir()
    scene = str(WORKFLOWS / "uncertain.toml")
    printed = []
    for command in commands[1:]:  # the first foretells the cost alone
        if "--certify" in command:  # 25 boundaries, of which tests of a certificate find fewer
            continue
        arguments = shlex.split(command.replace("workflows/uncertain.toml", scene))[1:]
        few = [*FEW, "--workers", "2"] if arguments[0] == "run" else []
        if "posterior.png" in command or "given-measured" in command:
            arguments += ["--scatter", "10%"]
        assert main([*arguments, *few]) == 0
        printed.append(capsys.readouterr().out)
    assert "severe wear with a probability of" in printed[1]
    assert "measurements to make next" in "".join(printed)
    assert re.search(
        r"cannot be told apart by these tests \(correlation −0\.[5-9]", "".join(printed)
    )
    assert re.search(r"effective sample size \d+ of \d+", "".join(printed))
    (row,) = re.findall(r"velocity factor(.*)", printed[2])
    factors = list(map(float, re.findall(r"\d\.\d+", row)))
    assert factors == sorted(factors)  # the lowest is not known from so few
    assert 1 < factors[-1] < 3
    assert len(list((tmp_path / "results").glob("*.png"))) == 5
    ensemble = pipeline.Ensemble.of(pipeline.open_sweep(tmp_path / "results" / "uncertain.zarr"))
    near = pipeline.risk(ensemble, 400.0, 2.0).probability
    (probability,) = re.findall(r"probability of (\d\.\d+) ± 0\.\d+ there", page)
    # As far as 32 samples tell.
    assert abs(near - float(probability)) < 0.15
