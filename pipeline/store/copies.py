"""Copies of a sweep that xarray wrote as netCDF or Zarr: read only, and without checksums."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import xarray as xr

from pipeline.scene.stored_text import parse_sweep
from pipeline.store.place import ROOT, Folder, StoreError, StorePlace, damaged, io_errors
from pipeline.store.progress import FailedPoint, Summary, is_wanted
from pipeline.store.schema import ABOUT, DONE, FAILED, INPUTS, PENDING, PLANE, split_arrays
from pipeline.store.verify import Verification
from pipeline.sweep.model import Sweep
from tribo.types import Mask


def open_copy(place: StorePlace) -> xr.Dataset | None:
    """Open a copy of a sweep that xarray wrote as netCDF or Zarr; None for anything else."""
    with io_errors(place), suppress(ValueError, KeyError, TypeError, OSError, RecursionError):
        if isinstance(place, Folder) and place.path.is_file():
            copy = xr.open_dataset(place.path, chunks=None)
        elif place.read(f"{ABOUT}/{ROOT}") is None:
            form = 2 if place.read(ROOT) is None else 3
            copy = xr.open_zarr(place.zarr(), zarr_format=form, consolidated=False, chunks=None)
        else:
            return None
        if "scene" in copy.attrs:
            return copy
    return None


def sweep_of_copy(copy: xr.Dataset) -> Sweep:
    """The sweep that a copy is of."""
    held = copy.variables.get(INPUTS)
    return parse_sweep(
        copy.attrs["scene"], {} if held is None else split_arrays(held.values, held.attrs)
    )


def summary_of_copy(copy: xr.Dataset) -> Summary:
    """Count the points of a copy by state."""
    sweep, status = sweep_of_copy(copy), copy["status"].values
    asked = copy["asked"].values if "asked" in copy else np.ones(status.shape)
    is_asked = is_wanted(asked, status)
    return Summary(
        name=sweep.name,
        title=sweep.title,
        total=int(is_asked.sum()),
        done=int((is_asked & (status == DONE)).sum()),
        pending=int((is_asked & (status == PENDING)).sum()),
        failed=_points(copy, is_asked & (status == FAILED), "its reason is in the store alone"),
        earlier=int((status[~is_asked] == DONE).sum()),
        warned=int((copy["warning_flags"].values[status == DONE] != 0).sum()),
    )


def verify_copy(place: StorePlace, copy: xr.Dataset) -> Verification:
    """Read all data of a copy, and find done points without a result."""
    try:
        copy = copy.load()
    except (OSError, ValueError, RuntimeError) as error:
        raise StoreError(f"{damaged(place, 'the copy')}: {error}") from error
    done = copy["status"].values == DONE
    ends = copy["max_rise"].transpose(*copy["status"].dims, "step").values[..., -1]
    lost = _points(copy, done & np.isnan(ends), "the point is done, and has no results")
    return Verification(int(done.sum()) - len(lost), lost, (), has_checksums=False)


def _points(copy: xr.Dataset, where: Mask, message: str) -> tuple[FailedPoint, ...]:
    loads, velocities = (copy[one].broadcast_like(copy["status"]) for one in PLANE)
    axes = copy["status"].dims
    pairs = (one.transpose(*axes).values[where].tolist() for one in (loads, velocities))
    return tuple(FailedPoint(load, speed, message) for load, speed in zip(*pairs, strict=True))
