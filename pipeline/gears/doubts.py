"""Values of a pair that are probably a slip, as those of a scene are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pipeline.gears.contact import Mesh
from pipeline.scene.doubts import USUAL_BULK, Usual, beyond_usual, material_quantities
from pipeline.sweep.remarks import Remark


def doubts(meshes: Iterable[Mesh]) -> list[Remark]:
    """Values outside their usual ranges, of a pair and of its duties."""
    found = (each for one in meshes for each in beyond_usual(_quantities(one)))
    return [Remark(place, "warning", words) for place, words in dict.fromkeys(found)]


def _quantities(one: Mesh) -> Iterator[Usual]:
    pair, duty = one.pair, one.duty
    yield "mesh.module", pair.gears.module, 0.1, 100, "mm"
    yield "mesh.face_width", pair.gears.face_width, 1, 1000, "mm"
    for body, material, roughness in zip(
        ("pinion", "wheel"), pair.materials, pair.roughness, strict=True
    ):
        yield from material_quantities(f"{body}.material", material)
        yield f"{body}.roughness", roughness, 0, 10, "um"
    yield "duty.torque: highest pressure", max(at.pressure for at in one.places), 0.01, 5, "GPa"
    yield "duty.speed: sliding velocity", max(abs(at.sliding) for at in one.places), 0, 100, "m/s"
    yield "duty.load_factor", duty.load_factor, 0.5, 10, ""
    yield "friction.coefficient", one.friction, 0, 1, ""
    yield "temperature.bulk", duty.bulk, *USUAL_BULK, "K"
    yield "temperature.critical", pair.critical, 50, 800, "°C"
