"""FZG's test A/8.3/90: from a failure load stage to a critical temperature, and back."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pandas as pd

from pipeline.analysis.tables import frame_of
from pipeline.gears.contact import mesh
from pipeline.gears.judge import judge
from pipeline.gears.pair import Duty, Pair
from pipeline.gears.reading import read_pair
from pipeline.gears.rules import STAGES, scuffing_integral, stage_bulk, stage_torque
from pipeline.quantities import si_of
from tribo import InputError

_FZG = "fzg_a"
_CRITICAL = (
    "critical temperature [°C]", "standard deviation [K]", "hottest place, last stage passed [°C]",
    "hottest place, failed stage [°C]", "scuffing integral temperature [°C]",
)  # fmt: skip
_BEYOND_ALL = 1500.0  # critical temperature [K] so high that nothing is severe


def stage_duty(pair: Pair, stage: int) -> Duty:
    """Duty of FZG's test gears in a load stage, with the bulk temperature of ISO/TR 13989-2.

    `pair` is the pair whose lubricant factor counts in that temperature.
    """
    bulk = stage_bulk(stage, pair.file.friction.lubricant_factor)
    return Duty(stage_torque(stage), read_pair(_FZG).duty.speed, bulk)


def rig_pair(pair: Pair) -> Pair:
    """The FZG test gears, with the oil, friction and surface of `pair`.

    If `pair` is the test gears, it is returned unchanged; else an `InputError` is raised if `pair`
    has no oil.
    """
    rig = read_pair(_FZG)
    if pair.gears == rig.gears:
        return pair
    if pair.oil is None:
        raise InputError(
            "a failure load stage is that of an oil, and the pair has no oil; give [oil] in the "
            "file"
        )
    file = replace(rig.file, friction=pair.file.friction, surface=pair.file.surface)
    written = {**rig.written, "oil": pair.written["oil"]}
    return replace(rig, file=file, oil=pair.oil, written=written)


def critical_temperature(pair: Pair, stage: int, **choices: Any) -> pd.DataFrame:
    """Critical temperature of an oil that fails in a load stage of FZG's test, by simulation.

    The critical temperature lies between the highest contact temperatures in the last stage passed
    and in the failed stage. The value holds only for this model, with the same friction and bulk
    temperature.

    Parameters
    ----------
    pair : Pair
        Pair with the oil. If the pair is the test gears themselves, its roughness is also used.
    stage : int
        Failure load stage in A/8.3/90, from 2 to 12.
    **choices
        Preset, workers and progress of `judge`.

    Returns
    -------
    DataFrame
        One row with these columns. ``critical temperature [°C]`` is midway between the highest
        temperatures in both stages. ``standard deviation [K]`` combines a uniform distribution
        between them with the simulation's error, and is infinite if this error is unknown.
        ``hottest place, last stage passed [°C]`` and ``hottest place, failed stage [°C]`` are the
        temperatures themselves. ``scuffing integral temperature [°C]`` of ISO/TR 13989-2, Eq. 94,
        is for use with that report only. It is missing if the pair is the test gears, without an
        oil.

    Raises
    ------
    InputError
        If the test has no such stage, or the pair is not the test gears and has no oil.
    TriboError
        If a place cannot be simulated.
    """
    if not 2 <= stage <= len(STAGES):
        raise InputError(
            f"failure load stage is {stage}; give 2 to {len(STAGES)} of A/8.3/90; for an oil that "
            "passes all stages give the last one, as a lower bound"
        )
    gears = rig_pair(pair).with_critical(_BEYOND_ALL, None)
    meshes = [mesh(gears, duty=stage_duty(gears, number)) for number in (stage - 1, stage)]
    table, oil = judge(meshes, **choices), gears.oil
    hottest = table["decisive temperature [°C]"].tolist()
    passed, failed = (si_of(value, "°C") for value in hottest)
    errors = table["temperature error [K]"].astype(float)
    error = math.inf if errors.isna().any() else errors.max()
    doubt, integral = math.hypot((failed - passed) / math.sqrt(12), error), None
    if oil is not None:
        factor = gears.file.friction.lubricant_factor
        integral = scuffing_integral(stage, oil.viscosity(313.15) / oil.density, factor)
    return frame_of(_CRITICAL, [((passed + failed) / 2, doubt, passed, failed, integral)])


def predict_stages(pair: Pair, **choices: Any) -> pd.DataFrame:
    """Simulate a pair in each load stage of FZG's test, and return the verdict for each stage.

    Parameters
    ----------
    pair : Pair
        Any pair with a critical temperature, such as the test gears with another roughness.
    **choices
        Preset, workers and progress of `judge`.

    Returns
    -------
    DataFrame
        A row for each load stage, in ascending order. The first column is ``stage``, the number of
        the load stage from 1 on. The other columns are those of `judge`.
    """
    stages = range(1, len(STAGES) + 1)
    table = judge([mesh(pair, duty=stage_duty(pair, number)) for number in stages], **choices)
    table.insert(0, "stage", stages)
    return table


def first_failure(table: pd.DataFrame) -> str:
    """Sentence on the first load stage in a `table` of `predict_stages` that is probably severe.

    If there is none, the sentence says that all stages are passed.
    """
    failed = table[table["probability"] > 0.5]
    if failed.empty:
        return "Passes all load stages."
    first = failed.iloc[0]
    return f"Fails in load stage {first['stage']}. {first['sentence']}."
