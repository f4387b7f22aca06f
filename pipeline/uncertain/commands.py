"""The commands ``irg infer`` and ``irg sensitivity``, and their options."""

from __future__ import annotations

from pipeline.cli import options as o
from pipeline.cli.options import Command

_INFER = (
    o.SCENE.but(help="scene file, or a store of samples"),
    o.PRESET,
    o.SET,
    o.CRITERION,
    *o.KEPT,
    o.SCATTER,
    o.quantity(
        "--contact-width", "W", "348 um",
        "width measured at --load and --velocity, to find the specific wear rate instead",
    ),
    o.quantity(
        "--duration", "T", "8 s",
        "time of sliding until the width was measured, ramp included; default: the scene's",
    ),
    o.BULK,
    o.FIGURE_OR_TABLE.but(
        metavar="TABLE.csv", help="file of the table, .csv or .md; for samples also of a figure"
    ),
    *o.PLACE,
    o.REALIZATION,
)  # fmt: skip

COMMANDS = (
    Command(
        "infer", "pipeline.uncertain.answer_infer:infer",
        "find the critical temperature from measured transitions, or a wear rate from a contact "
        "width; from a store of samples, all unknown inputs by the transitions and tests",
        'scene.toml --contact-width "348 um" --load "750 N" --velocity "1.25 m/s"',
        (*_INFER, o.AT),
    ),
    Command(
        "sensitivity", "pipeline.uncertain.answer_sensitivity:sensitivity",
        "find the share of each unknown input in the scatter of the boundary (Sobol' indices)",
        "results/uncertain.zarr -o sensitivity.png",
        (o.STORE, o.FIGURE_OR_TABLE, *o.WEIGHED, *o.JUDGED),
    ),
)  # fmt: skip
