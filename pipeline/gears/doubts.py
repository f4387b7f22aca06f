"""Warnings on values of a gear pair that are probably mistakes."""

from __future__ import annotations

from pipeline.gears.contact import Mesh
from pipeline.scene.doubts import soft_or_hard
from pipeline.scene.format import BULK
from pipeline.scene.kinds import unusual
from pipeline.sweep.remarks import Remark


def doubts(one: Mesh) -> list[Remark]:
    """Notes of the pair, then warnings on values of pair and duty outside their usual ranges."""
    pressure, sliding = (
        max(abs(getattr(at, of)) for at in one.places) for of in ("pressure", "sliding")
    )
    found = [
        ("duty.torque: highest pressure", unusual(pressure, (0.01, 5), "GPa")),
        ("duty.speed: sliding velocity", unusual(sliding, (0, 100), "m/s")),
        ("temperature.bulk", unusual(one.duty.bulk, BULK.usual, BULK.unit)),
    ]
    for body, material in zip(("pinion", "wheel"), one.pair.materials, strict=True):
        found.append((f"{body}.material", soft_or_hard(material)))
    doubts = (Remark(place, "warning", words) for place, words in found if words)
    return [*dict.fromkeys((*one.pair.notes, *doubts))]
