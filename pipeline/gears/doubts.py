"""Values of a pair that are probably a slip, as those of a scene are."""

from __future__ import annotations

from pipeline.gears.contact import Mesh
from pipeline.gears.pairfile import PairFile
from pipeline.scene.declare import table_of
from pipeline.scene.doubts import beyond_declared, beyond_usual, material_doubts
from pipeline.scene.format import BULK
from pipeline.scene.reference import usual_of
from pipeline.sweep.remarks import Remark


def doubts(one: Mesh) -> list[Remark]:
    """Values of a pair and its duty outside their usual ranges."""
    keys, places = table_of(PairFile).keys, one.places
    found = [
        doubt
        for name, value in vars(one.pair.file).items()
        for doubt in beyond_declared(keys[name].kind, value, name)
    ]
    pressure, sliding = (
        max(abs(getattr(at, of)) for at in places) for of in ("pressure", "sliding")
    )
    found += beyond_usual(
        [
            ("duty.torque: highest pressure", pressure, 0.01, 5, "GPa"),
            ("duty.speed: sliding velocity", sliding, 0, 100, "m/s"),
            ("temperature.bulk", one.duty.bulk, *usual_of(BULK)),
        ]
    )
    for body, material in zip(("pinion", "wheel"), one.pair.materials, strict=True):
        found += material_doubts(f"{body}.material", material)
    return [Remark(place, "warning", words) for place, words in dict.fromkeys(found)]
