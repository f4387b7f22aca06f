"""The command of the extra, and its options."""

from __future__ import annotations

from pipeline.cli import options as o
from pipeline.cli import values
from pipeline.cli.options import Command, Option
from pipeline.paths import user_path

COMMANDS = (
    Command(
        "gears", "pipeline.gears.answer:gears",
        "follow the contact of a pair of gears along its mesh, write its scene, simulate FZG's "
        "test or a duty spectrum",
        'fzg_a --set "pinion.roughness=0.8 um" --scene mesh.toml',
        (
            Option(
                "pair", metavar="PAIR.toml",
                help="file of a pair of gears, as irg help your-gears shows one; or fzg_a, the "
                "test gears A of FZG",
            ),
            Option(
                "--set", metavar="KEY=VALUE", type=values.setting, action="append", default=[],
                help='change an entry of the pair, like "pinion.roughness=0.8 um"; may be repeated',
            ),
            Option(
                "--places", metavar="N", type=values.count, default=25,
                help="number of even steps along the path of contact; default: 25",
            ),
            Option(
                "--stage", metavar="N", type=values.count,
                help="take torque, speed and bulk temperature of a load stage of FZG A/8.3/90",
            ),
            Option(
                "--scene", metavar="SCENE.toml", type=user_path, dest="new_scene",
                help="scene to write for irg run",
            ),
            Option(
                "--failure-stage", metavar="N", type=values.count,
                help="load stage of FZG A/8.3/90 in which the pair's oil fails, by its data sheet: "
                "simulates that test to find the critical temperature",
            ),
            Option(
                "--critical-temperature", metavar="T",
                type=values.quantity("145 degC", is_signed=True),
                help='{at.critical_temperature}, like "250 degC"',
            ),
            Option(
                "--stages", action="store_true",
                help="simulate the pair in all load stages of FZG A/8.3/90, and find the one that "
                "fails",
            ),
            Option(
                "--points", metavar="DUTY.csv", type=user_path,
                help="duty spectrum to simulate, a row each, in columns such as "
                '"torque [N m]", "speed [rpm]" and "hours"',
            ),
            o.SHEET, o.PRESET, o.WORKERS,
            o.FIGURE_OR_TABLE,
        ),
    ),
)  # fmt: skip
