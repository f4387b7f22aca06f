"""Values of a pair that are probably a slip, as those of a scene are."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.gears.contact import Mesh
from pipeline.gears.reading import FACE_WIDTH, LOAD_FACTOR, MODULE, ROUGHNESS
from pipeline.scene.doubts import Usual, beyond_usual, material_doubts
from pipeline.scene.format import BULK, CRITICAL, FRICTION
from pipeline.scene.reference import usual_of
from pipeline.sweep.remarks import Remark

BODIES = "pinion", "wheel"


def doubts(one: Mesh) -> list[Remark]:
    """Values of a pair and its duty outside their usual ranges."""
    found = [*beyond_usual(_quantities(one)), *_materials(one)]
    return [Remark(place, "warning", words) for place, words in found]


def _quantities(one: Mesh) -> Iterator[Usual]:
    pair, duty = one.pair, one.duty
    yield "mesh.module", pair.gears.module, *usual_of(MODULE)
    yield "mesh.face_width", pair.gears.face_width, *usual_of(FACE_WIDTH)
    for body, roughness in zip(BODIES, pair.roughness, strict=True):
        yield f"{body}.roughness", roughness, *usual_of(ROUGHNESS)
    yield "duty.torque: highest pressure", max(at.pressure for at in one.places), 0.01, 5, "GPa"
    yield "duty.speed: sliding velocity", max(abs(at.sliding) for at in one.places), 0, 100, "m/s"
    yield "duty.load_factor", duty.load_factor, *usual_of(LOAD_FACTOR)
    yield "friction.coefficient", one.friction, *usual_of(FRICTION)
    yield "temperature.bulk", duty.bulk, *usual_of(BULK)
    yield "temperature.critical", pair.critical, *usual_of(CRITICAL)


def _materials(one: Mesh) -> Iterator[tuple[str, str]]:
    for body, material in zip(BODIES, one.pair.materials, strict=True):
        yield from material_doubts(f"{body}.material", material)
