"""A new entry touches two files, by a line each beside its use: all else follows from these."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
LINES = {
    "pipeline/scene/format.py": (
        '    seed: A[int, SEED, "Seed of the random surface."] = 0\n',
        '    waviness: A[float, Quantity("1 um", usual=(0.1, 9)), "Height of the waves."] = 0.0\n',
    ),
    "tribo/surface/roughness.py": ("    seed: int = 0\n", "    waviness: float = 0.0\n"),
}
"""Files that the entry touches: a line that is there, and the line after it."""
USE = "        return self_affine(pixels, ", "        return self.waviness + self_affine(pixels, "
ASKED = """
import json, pipeline
from pipeline.answers.scene_notes import warning_text
from tests.helpers.stored import sweep_text, parse_sweep
from tests.sources.sections import all_keys
from pipeline.store.resume import mismatches

PATH = "disk.roughness.waviness"

def load(value, path=PATH):
    return pipeline.load_scene("first_try", overrides={path: value})

def fault():
    try:
        load(2)
    except pipeline.SceneFileError as error:
        return str(error)

one, other = load("2 um"), load("0.003 mm")
over = load({PATH: ["2 um", "3 um"]}, "sweep.over")
print(json.dumps({
    "height": one.scene.roughness.heights(one.scene.pixels).mean(),
    "is told": PATH in dict(all_keys()),
    "fault": fault(),
    "doubt": warning_text(load("20 um").warnings[0]),
    "is kept": parse_sweep(sweep_text(one), {}) == one != other,
    "mismatches": [*mismatches(one, other)],
    "rows": [over.case(name).scene.roughness.waviness for name in over.case_table.names],
}))
"""


def test_a_new_entry_of_two_files_is_read_told_doubted_kept_compared_and_varied(tmp_path):
    for name in ("pipeline", "tribo", "workflows"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name, (above, line) in LINES.items():
        text = (file := tmp_path / name).read_text()
        assert text.count(above) == 1, f"{name} has no such line any more"
        file.write_text(text.replace(above, above + line).replace(*USE))
    command = [sys.executable, "-W", "error", "-c", ASKED]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answers = json.loads(done.stdout)
    assert answers.pop("height") == pytest.approx(2e-6)
    path = "disk.roughness.waviness"
    assert answers == {
        "is told": True,
        "fault": f'first_try: {path}: 2 has no unit; give a length above 0, such as "1 um"',
        "doubt": f"{path}: 20 µm is unusual (0.1 to 9 µm is common): check number and unit",
        "is kept": True,
        "mismatches": [f"{path}: 2e-06 in the store, 3e-06 in the scene"],
        "rows": [2e-6, 3e-6],
    }
