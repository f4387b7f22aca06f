"""Fixtures that read a scene after replacements in its text, or return its faults."""

from pathlib import Path

import pytest

from pipeline import SceneFileError, load_scene

WORKFLOWS = Path(__file__).parents[3] / "workflows"
PAPER = (WORKFLOWS / "irg_transition.toml").read_text(encoding="utf-8")
TEXT = "".join([
    PAPER[: PAPER.index("[fidelity]")].replace("[576, 480]", "[480, 480]"),
    '[fidelity]\npreset = "standard"\n\n[sweep]\nloads = ["200 N", "400 N", "600 N", "750 N"]\n',
    'velocities = { from = "1 m/s", to = "4 m/s", step = "0.6 m/s" }\nfields = true\n\n',
    PAPER[PAPER.index("[[tests]]") :],
])  # fmt: skip
ROUGHNESS = TEXT[TEXT.index("ra =") : TEXT.index("[window]")]
MEASURED_SURFACE = 'file = "surface.npy"\nheight_unit = "um"\n'


@pytest.fixture
def read(tmp_path):
    def read(*changes, text=TEXT, **arguments):
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
        return load_scene(tmp_path / "scene.toml", **arguments)

    return read


@pytest.fixture
def faults(read):
    def faults(*changes, **arguments):
        with pytest.raises(SceneFileError) as caught:
            read(*changes, **arguments)
        return caught.value.faults

    return faults
