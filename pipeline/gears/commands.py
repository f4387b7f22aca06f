"""The command ``irg gears`` and its options."""

from __future__ import annotations

from pipeline.cli import options as o
from pipeline.cli import values
from pipeline.cli.options import Command, Group, Option
from pipeline.paths import user_path

_STAGE = o.value(
    "--stage N", "take torque, speed and bulk temperature of a load stage of FZG A/8.3/90",
    values.count,
)  # fmt: skip
_SCENE = o.value("--scene SCENE.toml", "scene to write for irg run", user_path, dest="new_scene")
_CRITICAL = (
    o.value(
        "--failure-stage N", "load stage of FZG A/8.3/90 in which the pair's oil fails, by its "
        "data sheet: simulates that test to find the critical temperature", values.count,
    ),
    o.quantity("--critical-temperature", "T", "250 degC", "critical temperature of the oil", True),
)  # fmt: skip
_DUTIES = (
    o.flag("--stages", "simulate the pair in all load stages of FZG A/8.3/90"),
    o.POINTS[0].but(
        help='duty spectrum to simulate, a row each, in columns such as "torque [N m]", '
        '"speed [rpm]" and "hours"'
    ),
)
COMMANDS = (
    Command(
        "gears", "pipeline.gears.answer:gears",
        "follow the contact of a pair of gears along its mesh, write its scene, simulate FZG's "
        "test or a duty spectrum",
        'fzg_a --set "pinion.roughness=0.8 um" --scene mesh.toml',
        (
            Option("pair", metavar="PAIR.toml", help="file of a pair of gears, or fzg_a"),
            o.SET.but(
                help='change an entry of the pair, like "pinion.roughness=0.8 um"; may be repeated'
            ),
            _STAGE, _SCENE, Group("", _CRITICAL), Group("", _DUTIES),
            o.SHEET, o.PRESET, o.WORKERS, o.FIGURE_OR_TABLE,
        ),
    ),
)  # fmt: skip
