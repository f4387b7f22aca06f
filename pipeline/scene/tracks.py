"""Tracks around bodies, which earlier turns have warmed: rims of discs, or plates."""

from __future__ import annotations

import math

import tribo
from pipeline.scene.format import Body


def track_length(body: Body) -> float | None:
    """Length of the track around a body [m]: the rim of a disc, or the given value, or None."""
    return math.pi * body.diameter if body.diameter else body.track_length


def disc_of(body: Body) -> tribo.Disc | None:
    """The disc that a body is; None if it is none, or a size is missing."""
    if body.diameter and body.width:
        return tribo.Disc(diameter=body.diameter, width=body.width)
    return None
