"""Caveats: limits of an answer that a reader must know, each a line of at most 100 columns."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

from pipeline.analysis.condition_words import unmodelled_rise_words
from pipeline.analysis.dataset import Layout
from pipeline.analysis.preset_error import error_in_words, velocity_error
from pipeline.analysis.results import Results
from pipeline.analysis.rises import rises_of
from pipeline.analysis.specimen import note_on_failed
from pipeline.shipped import typed_name
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.left_out import (
    UNKNOWN_FILM,
    caveat_on_turns,
    cold_tracks,
    note_on_ends,
    note_on_turns,
)
from pipeline.sweep.sweep import Sweep
from tribo import Corrections
from tribo.simulation.corrections import NEEDED
from tribo.simulation.lubrication import find_lubrication


def caveats_of(data: Results) -> list[str]:
    """Caveats of all scenes of a sweep, without repeats."""
    lines = (scene_caveats(one, one.conditions) for one in data.scenes)
    return [*dict.fromkeys(itertools.chain(*lines))]


def scene_caveats(scene: Results, conditions: Conditions) -> tuple[str, ...]:
    """Caveats, one line each, for results of a scene under `conditions`."""
    sweep, critical = scene.sweep, conditions.critical_temperature
    exact = "inputs such as the steel's conductivity are taken as exact (irg help model)"
    lines = [
        note_on_failed(scene),
        sweep.caveat,
        *doubt_lines(sweep, answered=True),
        unmodelled_rise_words(conditions),
        note_on_ends(sweep),
        UNKNOWN_FILM
        if sweep.scene.pin.length is None and find_lubrication(sweep.scene, sweep.lubricant)
        else None,
        caveat_on_turns(sweep, _warm_transitions(scene, conditions)) if critical else None,
        exact,
        error_in_words(sweep) if critical and velocity_error(sweep) is None else None,
    ]
    return tuple(line for line in lines if line)


def doubt_lines(sweep: Sweep, most: int = 3, answered: bool = False) -> list[str]:
    """Lines with the gravest doubts about a scene, `most` of them, and the number of the others.

    In an answer (`answered`) those are left out that have caveats of their own: on sharp ends, on
    earlier turns, and on a narrow window, which stands at the points that it limits.
    """
    own = (note_on_ends(sweep), note_on_turns(sweep))
    lines = [
        str(doubt)
        for doubt in sweep.doubts
        if not answered or (doubt.words not in own and doubt.place != "window.pixels")
    ]
    if (more := len(lines) - most) > 0:
        lines[most:] = [f"and {more} more: irg check {typed_name(sweep.name)}"]
    return lines


def _warm_transitions(data: Results, conditions: Conditions) -> str:
    """From where wear is severe, in words, with heat of earlier turns; empty if unknown."""
    tracks, is_known = cold_tracks(data.sweep), {*NEEDED} <= {*data.columns}
    is_own = data.kind is Layout.PLANE and not data.labels and conditions == data.sweep.conditions
    if not (tracks and is_known and is_own):
        return ""
    parts = conditions.corrections or Corrections()
    parts = replace(parts, motion=data.sweep.scene.motion, **tracks)
    rises = rises_of(data, replace(conditions, corrections=parts))
    first = rises.turns("velocity", data.loads).first
    begins = [f"from {v:.3g} m/s" if v > 0 else "at every velocity computed" for v in first]
    ends = {float(data.loads[k]): begins[k] for k in (0, -1) if first[k] < math.inf}
    return ", ".join(f"{begin} at {load:g} N" for load, begin in ends.items())
