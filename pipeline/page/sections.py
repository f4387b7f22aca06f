"""Sections of a report: diagram, boundary, tests, errors, inputs, limits and origin."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr

import pipeline
from pipeline.answers.answer_frames import boundary_frame, comparison_frame, has_counted_tests
from pipeline.answers.answer_lines import (
    conditions_lines,
    error_lines,
    lines_of_tests,
    ruling_lines,
    shift_lines,
)
from pipeline.answers.readable import attribute_texts
from pipeline.answers.results import case_dims, sweep_of
from pipeline.answers.scene_wording import settings_words
from pipeline.figures.diagram import diagram
from pipeline.figures.tests_figure import draw_tests
from pipeline.frames import without_columns
from pipeline.messages import quoted, split_notes
from pipeline.page import elements
from pipeline.page.input_tables import case_rows, input_rows
from pipeline.store.schema import PLANE
from pipeline.sweep.case import OperatingPoint
from pipeline.sweep.codec import digest

_MODEL = (
    "The model: a rough, elastic–plastic contact under boundary lubrication is worn by Archard's "
    "law while the load grows, and heated by friction. Wear is severe where the contact gets too "
    "hot for the lubricant. An oil film that carries load, and the wear after the transition, are "
    "not part of it."
)
_CAUSES_OF_NUMERICAL_ERROR = (
    "Its causes are the elements and load steps, interpolation between simulated points, and "
    "the small number of simulated surfaces; more computing makes it smaller."
)
_CAUSES_OF_MODEL_ERROR = (
    "Its causes are the physics that is left out, and the inputs; only tests make it smaller."
)
_PAPER = (
    "R. Bosman and M. B. de Rooij: On the transition from mild to severe wear of lubricated, "
    "concentrated contacts: The IRG (OECD) transition diagram."
)

Conditions = Mapping[str, Any]
"""Conditions of an answer, by name."""


def plane_sections(
    ds: xr.Dataset, conditions: Conditions, points: Iterable[OperatingPoint] = ()
) -> list[elements.Section]:
    """Sections with the diagram, the boundary, tests compared with the computation, and errors."""
    boundary = pipeline.boundary(ds, **conditions)
    caption = elements.as_sentence(conditions_lines(boundary)[0])
    if not case_dims(ds):
        caption += " Dots: simulated points."
    if missing := boundary.attrs["missing_points"]:
        caption += f" ×: {missing} points that are pending or failed."
    (min_load, max_load), (min_velocity, max_velocity) = (
        ds[axis].values[[0, -1]].tolist() for axis in PLANE
    )
    points_inside = [
        (load, velocity)
        for load, velocity in points
        if min_load <= load <= max_load and min_velocity <= velocity <= max_velocity
    ]
    loads, velocities = [load for load, _ in points_inside], [speed for _, speed in points_inside]
    figure = elements.figure_of(
        lambda: diagram(ds, conditions, load=loads, velocity=velocities), caption,
        "Transition diagram over sliding velocity and normal load.",
    )  # fmt: skip
    omitted_columns = list[str]()
    table_caption = (
        "Critical velocity as computed; with tests: where severe wear is 5, 50, 95 % probable"
    )
    if not has_counted_tests(boundary):
        omitted_columns.append("50 % [m/s]")
        table_caption = (
            "Critical velocity as computed, and where severe wear is 5 and 95 % probable"
        )
    if boundary["critical_velocity"].notnull().all():
        omitted_columns.append("outcome")
    frame = without_columns(boundary_frame(boundary), omitted_columns)
    table = elements.table_of(frame, table_caption)
    sections: list[elements.Section] = [("Transition diagram", [figure]), ("Boundary", [table])]
    if boundary.attrs.get("tests") and not case_dims(ds):
        sections.append(("Tests and prediction", [*_test_elements(ds, conditions)]))
    if rulings := [*map(elements.as_sentence, ruling_lines(boundary))]:
        sections.insert(2, ("Tests that rule verdicts out", [rulings]))
    lines = error_sentences(*error_lines(boundary), *shift_lines(boundary))
    return [*sections, ("Errors", [lines])]


def error_sentences(*lines: str) -> list[str]:
    """Sentences on errors: the size of each, and its origin."""
    sentences = list[str]()
    for line in lines:
        sentence = elements.as_sentence(line)
        if line.startswith("numerical"):
            sentence = f"{sentence} {_CAUSES_OF_NUMERICAL_ERROR}"
        elif line.startswith("model error"):
            sentence = f"{sentence} {_CAUSES_OF_MODEL_ERROR}"
        sentences.append(sentence)
    return sentences


def _test_elements(
    ds: xr.Dataset, conditions: Conditions
) -> Iterator[elements.PageFigure | elements.Table | list[str]]:
    """Yield figure, table and notes that compare tests with the computation."""
    tests = pipeline.compare_tests(ds, **conditions)
    caption = "Computed rise ratio of each test, next to its outcome."
    yield elements.figure_of(lambda: draw_tests(ds, conditions), caption, caption)
    table = comparison_frame(tests)
    log_ratios = tests["log_rise_ratio"].values
    computed = np.select([log_ratios > 0, log_ratios <= 0], ["severe", "mild"], "")
    table.insert(2, "computed", computed)
    yield elements.table_of(
        table, "Tests, each at its own conditions, and what is computed for them"
    )
    if lines := [*lines_of_tests(tests)]:
        yield lines


def common_sections(
    ds: xr.Dataset, conditions: Conditions, version: str, stated: Sequence[str]
) -> Iterator[elements.Section]:
    """Yield the last sections of each report: inputs, limits that are not yet `stated`, origin."""
    sweep = sweep_of(ds)
    tables: list[Any] = [
        elements.Table(
            "Inputs and their sources", ["part", "values", "source"], [*input_rows(sweep)]
        )
    ]
    headings, rows = case_rows(sweep)
    if rows:
        tables.append(elements.Table("Cases of the sweep", headings, rows))
    yield "Conditions and inputs", tables
    single_conditions = {name: value for name, value in conditions.items() if not np.ndim(value)}
    notes = split_notes(attribute_texts(pipeline.points(ds, **single_conditions), "notes"))
    limits = elements.without_help([*notes, *pipeline.points_with_warnings(ds).lines()])
    uncovered = [line for line in map(elements.as_sentence, limits) if line not in stated]
    yield "What is not covered", [_MODEL, uncovered] if uncovered else [_MODEL]
    choices = [
        f"{name.replace('_', ' ')} {quoted(value)}"
        for name, value in asdict(sweep.scene.fidelity).items()
    ]
    origin = [
        *str(ds.attrs.get("history", "")).splitlines(),
        f"scene {sweep.name}, inputs {digest(sweep.scene)} (SHA-256)",
        f"{settings_words(sweep)}: {', '.join(choices)}",
        f"The irg-transition developers: irg-transition (version {version}). BSD-3-Clause.",
        _PAPER,
    ]
    yield "How this was computed", [origin]
