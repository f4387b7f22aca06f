"""The command that describes a scan of a surface."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli.exit_codes import DONE
from pipeline.cli.output import show
from pipeline.cli.progress import working


def surface(options: argparse.Namespace) -> int:
    """Print the roughness of a scan, and the table of a scene that makes more of the same."""
    with working("fitting the spectrum"):
        scan = pipeline.surface_statistics(
            options.scan, options.height_unit, options.pixel_size, options.transpose, options.flip
        )
    text = list(scan.lines())
    if scan.is_self_affine:
        text += ["", "more of the same, in a scene:", "", scan.toml.rstrip()]
    else:
        text.append(
            "no random roughness stands for it: give the scan itself, as disk.roughness.file"
        )
    show(options, scan.as_dict(), text)
    return DONE
