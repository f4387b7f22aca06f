"""Values of options: what could mean two things is refused."""

import pipeline
import tribo
from pipeline.cli.options import PRESET
from tests.helpers import synthetic


def test_the_help_names_every_preset_that_ships():
    told = PRESET.settings["help"].rpartition(": ")[2].replace(" or ", ", ").split(", ")
    assert told == [*tribo.PRESETS]


def test_a_value_that_a_store_is_judged_at_has_its_unit(irg, monkeypatch):
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: synthetic.sweep())

    def judged(*entries, **options):
        return irg("boundary", "out.zarr", *(f"--at={entry}" for entry in entries), **options)

    assert '"150" has no unit; give one such as' in judged("temperature.critical=150", code=2)
    said = judged("pin.radius=3 mm", code=2)
    assert "run the scene with pin.radius = 3 mm into another store" in said
    said = judged("temperature.critical=150 degC", "friction.coefficient=0.12")
    told = (
        "friction 0.12 (tests 0.091 to 0.103), bulk temperature 25 °C, critical temperature 150 °C"
    )
    assert told in " ".join(said.split())
    same = irg("boundary", "out.zarr", "--critical-temperature=150 degC", "--friction=0.12")
    assert said == same
    several = irg(
        "boundary", "out.zarr", "--critical-area-fraction=5%", "--critical-area-fraction=10%"
    )
    assert "and 1 more" in " ".join(several.split())
    assert "is given twice" in irg(
        "boundary", "out.zarr", "--at=friction.coefficient=0.1", "--friction=0.12", code=2
    )
