"""The commands of the extra, and their options."""

from __future__ import annotations

from pipeline.cli import options as o
from pipeline.cli import values
from pipeline.cli.options import Command, Option

_INFER = (
    o.SCENE.but(help="scene file, or a store of samples"),
    o.PRESET,
    o.SET,
    o.CRITERION,
    o.OWN_LAWS,
    *o.KEPT,
    Option(
        "--next", metavar="COUNT", nargs="?", const=1, type=values.count,
        help="for samples: rank the measurements to make next, or plan COUNT runs at once",
    ),
    Option(
        "--for", metavar="ENTRY", dest="target",
        help="with --next: {candidates.target}",
    ),
    o.SCATTER,
    o.flag(
        "--discrepancy", "for samples: {posterior.discrepancy}"
    ),
    o.quantity(
        "--contact-width", "W", "348 um",
        "width measured at --load and --velocity, to find the specific wear rate instead",
    ),
    o.quantity(
        "--duration", "T", "8 s",
        "time of sliding until the width was measured, ramp included; default: the scene's",
    ),
    o.BULK.but(
        action="append",
        help='{at.bulk_temperature}, like "25 degC"; with --next a candidate, may be repeated',
    ),
    o.FIGURE_OR_TABLE.but(
        metavar="TABLE.csv", help="file of the table, .csv or .md; for samples also of a figure"
    ),
    *o.PLACE,
    o.REALIZATION,
)  # fmt: skip

_DESIGN = (
    Option(
        "--over", metavar="ENTRY", dest="entries", action="append", required=True,
        help="entry whose value is sought: an unknown input with a range, from and to; load or "
        "velocity; or temperature.critical, temperature.bulk or friction.coefficient; or two",
    ),
    Option(
        "--risk", metavar="SHARE", type=values.share,
        help="highest probability of severe wear; default: 1%%",
    ),
    o.quantity(
        "--margin", "T", "20 K",
        "goal instead of --risk: a distance below the critical temperature, kept with 95 %% "
        "probability",
    ),
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
    Command(
        "design", "pipeline.uncertain.answer_design:design",
        "find the value of an entry that makes severe wear unlikely enough",
        'results/uncertain.zarr --load "500 N" --velocity "2 m/s" --risk 1% --over '
        "disk.roughness.correlation_length",
        (
            o.STORE, *_DESIGN, *o.PLACE, *o.POINTS, o.FIGURE_OR_TABLE, *o.WEIGHED, *o.JUDGED,
        ),
    ),
)  # fmt: skip
