"""The commands ``irg surface`` and ``irg tests``."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli.output import Result, working
from pipeline.laboratory.instruments import RawScan
from pipeline.laboratory.profile import data_sheet_toml, profile_statistics, profiles_in
from pipeline.laboratory.surfaces import read_raw
from pipeline.units import in_si
from tribo import InputError

_USUAL_PIXEL = 0.95e-6  # [m], of the shipped scenes
_STAGE = (
    "start [s]", "duration [s]", "load [N]", "velocity [m/s]", "friction begin", "friction steady",
    "friction highest", "friction end", "temperature [degC]",
)  # fmt: skip
"""Columns of a table of stages."""


def surface(options: argparse.Namespace) -> Result:
    """Answer ``irg surface``: roughness of a scan, and entries of a scene for surfaces like it."""
    if (options.ra is None) != (options.rsm is None) or (options.ra is None) == (not options.scan):
        raise InputError('give a SCAN, or --ra and --rsm of a data sheet, like --ra "0.2 um"')
    if options.scan is None:
        return _data_sheet_result(options)
    raw = read_raw(options.scan)
    if raw.places is not None:
        if options.transpose:
            raise InputError(f"{options.scan} is no map, which --transpose is for; leave it out")
        return _profile_result(options, raw)
    for name in ("length_unit", "cutoff", "lay"):
        if getattr(options, name) is not None:
            option = f"--{name.replace('_', '-')}"
            raise InputError(f"{options.scan} is a map, and {option} is for profiles; leave it out")
    with working("fitting the spectrum"):
        scan = pipeline.surface_statistics(
            options.scan, options.height_unit, options.pixel_size, options.transpose
        )
    return Result(scan.as_dict(), [*scan.lines()])


def _profile_result(options: argparse.Namespace, raw: RawScan) -> Result:
    """Result of ``irg surface`` for profiles."""
    named = ("height_unit", options.height_unit), ("length_unit", options.length_unit)
    height, length = (unit and in_si(name, f"1 {unit}", "1 um") for name, unit in named)
    step = options.pixel_size[0] if options.pixel_size else None
    places, heights = profiles_in(options.scan, raw, (height, length), step)
    try:
        found = profile_statistics(str(options.scan), places, heights, options.cutoff, options.lay)
    except InputError as error:
        raise InputError(f"{options.scan}: {error}") from error
    return Result(found.as_dict(), [*found.lines()])


def _data_sheet_result(options: argparse.Namespace) -> Result:
    """Result of ``irg surface`` for Ra and RSm of a data sheet."""
    pixel = min(options.pixel_size) if options.pixel_size else _USUAL_PIXEL
    with working("seeking the correlation length"):
        toml, assumed = data_sheet_toml(options.ra, options.rsm, pixel)
    document = {"ra": options.ra, "rsm": options.rsm, "assumed": assumed, "toml": toml}
    return Result(document, [*assumed, "", *toml.splitlines()])
