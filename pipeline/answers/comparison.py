"""`compare_tests` and `infer`: the tests of a scene, compared with the model."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Unpack

import numpy as np
import xarray as xr

from pipeline.answers.answer_dataset import answer_attributes, with_attributes
from pipeline.answers.condition_values import override_conditions
from pipeline.answers.critical_temperature import evidence_with_critical_temperature
from pipeline.answers.results import cases_of
from pipeline.answers.scene_wording import model_words
from pipeline.answers.specimen import specimen_of
from pipeline.answers.verdict_model import verdict_model
from pipeline.condition_kinds import ConditionValues
from pipeline.constants import VERDICT_PROBABILITIES
from pipeline.store.location import PathLike
from tribo import InputError


def compare_tests(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Compare the tests of a scene with the model, each at its own conditions, along ``test``.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or path of a store.
    **conditions
        Conditions as in `pipeline.margin`.

    Returns
    -------
    Dataset
        ``log_rise_ratio``, the ln of the computed rise over the allowable one; of a transition in
        steps also ``log_rise_ratio_mild``, one step before, and ``log_rise_ratio_severe``, at the
        transition; ``loo_probability``, the probability of the outcome, predicted from the other
        tests. The attribute ``levels`` has the values of ln(rise ratio) at which severe wear is 5,
        50 and 95 % probable.

    Examples
    --------
    >>> import pipeline
    >>> tests = pipeline.compare_tests("results/first_try.zarr")
    >>> tests["load"].values.tolist(), tests["log_rise_ratio"].round(2).values.tolist()
    ([750.0, 600.0, 400.0, 200.0], [0.03, -0.03, -0.1, -0.03])
    """
    case = cases_of(ds)[0]
    model = verdict_model(case, override_conditions(case.conditions, conditions))
    if model.omitted_tests:
        raise InputError(f"no tests to compare: {model.omitted_tests}")
    evidence = model.evidence
    pairs = zip(evidence.specimens, evidence.loo_probabilities, strict=True)
    loo_probabilities = {id(row): probability for rows, probability in pairs for row in rows}
    columns: dict[str, list[Any]] = {}
    for row in evidence.rows:
        test, test_conditions = row.test, row.conditions
        for name, value in {
            "test": test.number, "outcome": test.outcome,
            "load": test.normal_load, "velocity": test.velocity,
            "friction": test_conditions.friction if test_conditions else math.nan,
            "bulk_temperature": test_conditions.bulk_temperature if test_conditions else math.nan,
            "governing_temperature": row.temperature,
            "log_rise_ratio": row.mild if math.isnan(row.severe) else row.severe,
            "log_rise_ratio_mild": row.mild, "log_rise_ratio_severe": row.severe,
            "loo_probability": loo_probabilities.get(id(row), math.nan), "reason": row.reason,
        }.items():  # fmt: skip
            columns.setdefault(name, []).append(value)
    comparison = xr.Dataset({name: ("test", values) for name, values in columns.items()})
    comparison = comparison if columns else xr.Dataset(coords={"test": np.array([], object)})
    bulk = np.full(1, model.conditions.bulk_temperature)
    levels = [
        float(evidence.log_rise_ratio_quantiles(probability, bulk)[0])
        for probability in VERDICT_PROBABILITIES
    ]
    return with_attributes(comparison).assign_attrs(
        answer_attributes(model), missing_points=0, levels=levels
    )


@np.errstate(under="ignore")
def infer(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Find the critical temperature of the lubricant from the tests of a scene.

    The prior of ln(critical − bulk temperature) is Student's t with 4 degrees of freedom and a
    scale of 1, centred on ln(120 K). A critical temperature in the scene is ignored.

    Returns
    -------
    Dataset
        ``critical_temperature``, the median; ``spread_another_rig``, its standard deviation on
        another rig, model bias included, and ``spread_this_rig`` on this one; ``at_least``
        and ``at_most``, its bounds by only mild or only severe tests, at which the likelihood is 5
        % of its maximum. The attribute ``model`` names the surface, wear pattern and preset to
        which it belongs.

    Examples
    --------
    >>> import pipeline
    >>> oil = pipeline.infer("results/first_try.zarr")
    >>> (oil["critical_temperature"] - 273.15).round(1).item()
    141.2
    """
    case = cases_of(ds)[0]
    scene_conditions = replace(case.sweep.conditions, critical_temperature=None)
    oil = override_conditions(scene_conditions, conditions)
    evidence = evidence_with_critical_temperature(case, specimen_of(case, oil), oil)
    critical: Any = evidence.critical  # never None here
    values = {
        "critical_temperature": critical.temperature,
        "spread_another_rig": critical.spread_with_bias,
        "spread_this_rig": critical.spread,
        "at_least": critical.at_least,
        "at_most": critical.at_most,
    }
    answer = with_attributes(xr.Dataset(values)).assign_attrs(model=model_words(case.sweep))
    answer["critical_temperature"].attrs["long_name"] = "critical temperature from tests, median"
    return answer
