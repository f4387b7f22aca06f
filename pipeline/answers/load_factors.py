"""Mild load factors of rows, and the smallest of them, which is the limit of the machine.

A row is a case with a load and a velocity of its own. It is simulated at several shares of its
load. The mild load factor is its mild limit of load over its load.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from pipeline.answers.answer_frames import row_labels
from pipeline.answers.case_results import CaseResults
from pipeline.answers.scene_wording import named_value
from pipeline.answers.value_text import variable_texts
from pipeline.answers.verdict_limits import Side, round_to
from pipeline.sweep.case_table import CASE

_SIDES = Side.BELOW, Side.INSIDE, Side.ABOVE
"""Sides of limits of rows that have one, that of the smallest limit first."""


def with_mild_load_factor(answer: xr.Dataset, case: CaseResults) -> xr.Dataset:
    """Margins of a row with its mild load factor; unchanged without load factors."""
    if case.own_load is None:
        return answer
    mild_load, side = answer["mild_load"], answer["mild_load_side"]
    factor = mild_load.copy(data=round_to(np.floor, mild_load.values / case.own_load))
    ends = [case.load_factors[0], case.load_factors[-1]]
    meaning = "largest share of the load of the row at which it is mild"
    factor.attrs = {"units": "1", "long_name": meaning, "valid_range": ends}
    side = side.assign_attrs(long_name="where mild_load_factor lies")
    return answer.assign(mild_load_factor=factor, mild_load_factor_side=side)


def with_governing_row(answer: xr.Dataset) -> xr.Dataset:
    """Margins of rows; ``governs`` is true at the row with the smallest mild load factor.

    Of several rows outside the simulated load factors it is that with the largest rise ratio.
    """
    if "mild_load_factor" not in answer or CASE not in answer.sizes:
        return answer
    names = "log_rise_ratio", "mild_load_factor", "mild_load_factor_side"
    ratio, factor, side = (answer[name].transpose(..., CASE) for name in names)
    rank = np.select([side == code for code in _SIDES], range(len(_SIDES)), len(_SIDES))
    order = np.lexsort((-ratio.values, np.nan_to_num(factor.values), rank))
    is_first = np.arange(rank.shape[-1]) == order[..., :1]
    governs = factor.copy(data=is_first & (rank < len(_SIDES)))
    governs.attrs = {"long_name": "the row has the smallest mild load factor of all rows"}
    return answer.assign(governs=governs.transpose(*answer["mild_load_factor"].dims))


def load_factor_lines(margins: xr.Dataset) -> Iterator[str]:
    """Lines on the smallest mild load factor of all rows; none without load factors."""
    if "mild_load_factor" not in margins:
        return
    dims = [str(dim) for dim in margins.sizes if dim != CASE]
    for index in np.ndindex(*(margins.sizes[dim] for dim in dims)):
        rows = margins.isel(dict(zip(dims, index, strict=True)))
        conditions = "".join(f" with {named_value(rows[dim])}" for dim in dims)
        yield _load_factor_line(rows, conditions)


def _load_factor_line(rows: xr.Dataset, conditions: str) -> str:
    """Line on the mild load factor of one row, or on the smallest of several."""
    texts = variable_texts(rows, "mild_load_factor").values
    unchanged = "at unchanged bulk temperature and friction"
    if not rows.sizes:
        return f"mild load factor{conditions}: {texts.item()}, {unchanged}"
    if not rows["governs"].any():
        return f"mild load factor{conditions}: no row has one"
    row = int(np.argmax(rows["governs"].values))
    count = int(rows["mild_load_factor_side"].isin(_SIDES).sum())
    which = "all rows" if count == len(texts) else f"{count} of {len(texts)} rows"
    return (
        f"mild load factor of {which}{conditions}: {texts[row]}; {row_labels(rows, CASE)[row]} "
        f"governs, {unchanged}"
    )
