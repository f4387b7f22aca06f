"""All refusals of sweeps, their conditions, variants: causes, and what each says."""

import math

import numpy as np

import tribo
from pipeline import Conditions
from pipeline.sweep.areal import areal_roughness, remove_form
from pipeline.sweep.conditions import bulk_entries, criterion_of, known_critical_temperature
from pipeline.sweep.measurement import Measurement
from pipeline.sweep.missing import MissingSurface
from pipeline.sweep.severity import require_bulks
from pipeline.sweep.variants import Column, Row, Variants, surfaces
from tests.helpers import tiny
from tests.helpers.entries import rows
from tests.helpers.refusals import refusal_tests

OIL = {"friction": 0.1, "bulk_temperature": 298.15, "critical_temperature": 418.15}
RECORD = tribo.MeasuredLoad(np.array([0.0, 1.0, 3.0]), np.array([0.0, 80.0, 750.0]))
CURVE = tribo.Corrections(friction=tribo.Friction(by_velocity=((1.0, 1.0), (2.0, 1.1))))


def conditions(**changes):
    return lambda: Conditions(**OIL | changes)


SMOOTH = tiny.sweep(roughness=None)
REFUSALS = {
    # conditions
    "friction": (conditions(friction=-0.1), "friction is -0.1; it must be finite and ≥ 0"),
    "two frictions": (conditions(friction=(0.1, 0.2)), "(0.1, 0.2); it must be one finite"),
    "bulk nan": (conditions(bulk_temperature=math.nan), "bulk_temperature is nan; it must be"),
    "bulk": (conditions(bulk_temperature=-1.0), "-1.0 K; it must be above 0"),
    "critical": (conditions(critical_temperature=298.15), "above the bulk temperature, 298.15 K"),
    "disk above": (conditions(disk_temperature=420.0), "must be above the bulk temperature, 420 K"),
    "share": (lambda: criterion_of("share", 1.0), "share is 1.0"),
    "share nan": (lambda: criterion_of("share", math.nan), "failing_share is nan; it must be one"),
    "curve": (conditions(corrections=CURVE, disk_temperature=350.0), "friction.by_velocity: "),
    "criterion": (lambda: criterion_of("laws:median", 0.1), "allowed are share, highest, mean"),
    "no critical": (lambda: known_critical_temperature(conditions(critical_temperature=None)()),
                    "temperature.critical is missing"),
    "bodies": (lambda: bulk_entries({"pin": 300.0}), "bulk_temperature names pin; give one"),
    "unequal": (lambda: require_bulks({}, conditions(disk_temperature=350.0)()),
                "25 °C of the pin"),
    # the sweep and its variants
    "hold": (lambda: tiny.sweep(loading=RECORD)._with_hold(2.0), "hold is 2 s, but the load"),
    "test alone": (lambda: Measurement(400.0, 1.0).simulated, "belongs to no scene; take it from"),
    "field": (lambda: tiny.sweep().changed("friktion", 0.1), "friktion: unknown key (did you mean"),
    "surface": (lambda: SMOOTH._take_surface(3), "realization is 3"),
    "labels": (lambda: Variants((Column("a"),), (Row({"a": 1}, {}),) * 2).by_name,
               "have the same values"),
    "row": (lambda: surfaces((1, 2)).values((("realization", 5),)),
            "the sweep has no realization 5; it has realization 1 to 2"),
    "gap": (lambda: (surfaces((1,)) * rows("pin", {"a": {}})).union(
        surfaces((2,)) * rows("pin", {"b": {}})), "missing, realization 1, pin b"),
    # surfaces
    "not beside": (lambda: MissingSurface("0", "it is not here").heights(None), "not here"),
    "no heights": (lambda: remove_form(np.full((3, 3), np.nan), (1.0, 1.0)), "all heights are"),
    "level": (lambda: areal_roughness(np.indices((20, 30))[1] * 0.1, (1.0, 1.0)), "are a plane"),
}  # fmt: skip


refusals, test_what_is_refused_is_named, test_the_table_has_every_refusal = refusal_tests(
    "sweep", REFUSALS
)
