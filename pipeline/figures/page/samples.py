"""Data of a sweep of samples in a page: the probability of severe wear, as a table."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from PIL import Image

from pipeline.analysis.dataset import attributes_of
from pipeline.figures.page.content import packed_array, record
from pipeline.figures.page.fields import png_of
from pipeline.figures.uncertainty import PALE, RISK_COLOURS
from pipeline.store.schema import DONE
from pipeline.uncertain.answers import frame_of_lines, probabilities, risk_lines
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.weigh import posterior_if_given
from tribo.types import Array


def content_of_samples(
    ds: xr.Dataset, given_measured: bool = False, scatter: float | None = None, **criterion: Any
) -> dict[str, Any]:
    """Collect what a page of samples shows, as plain data."""
    attributes = attributes_of(ds)
    ensemble = Ensemble.of(ds, **criterion)
    weighed = posterior_if_given(ensemble, given_measured, scatter)
    draws = weighed.draws if weighed else None
    evidence = f", given {len(weighed.judged)} tests of the scene" if weighed else ""
    known = [str(ensemble.certificate)] if ensemble.certificate else []
    single = ensemble.loads if len(ensemble.loads) == 1 else None
    plane = probabilities(ensemble, draws, loads=single)
    shares, lines = risk_lines(plane)
    return {
        "title": attributes.get("title"),
        "name": attributes.get("name"),
        "evidence": evidence,
        "basis": [*map(str, (*ensemble.unknown, *ensemble.fixed)), *known],
        "measured": [*ensemble.tests],
        "loads": plane["load"].values.tolist(),
        "velocities": plane["velocity"].values.tolist(),
        "probability": packed_array([plane.values], "<f4"),
        "picture": _coloured(plane.values[::-1]),
        "scale": _coloured(np.linspace([0.0], [1.0], 64).T),
        "shares": list(shares),
        "lines": np.clip(lines, *ensemble.velocities).tolist(),
        "table": frame_of_lines(ensemble, draws),
        "samples": ds.sizes["variant"],
        "done": int((ds["status"] == DONE).sum()),
        "record": record(attributes),
    }


def _coloured(probability: Array) -> str:
    """Probabilities as a picture, from its top on, in the colours of the figure of them."""
    low, high = PALE
    shades = colormaps[RISK_COLOURS]((probability - low) / (high - low), bytes=True)[..., :3]
    return png_of(Image.fromarray(np.ascontiguousarray(shades)))
