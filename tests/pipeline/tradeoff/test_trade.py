"""Speed against accuracy, measured on a small scene."""

from dataclasses import replace

import pytest

from pipeline.figures.studies import draw_trade
from pipeline.tradeoff import trade as tradeoff
from pipeline.tradeoff.trade import trade
from tests.helpers.accuracy_scenes import PAPER
from tribo import PRESETS, Grid, InputError, SelfAffineRoughness

SMALL = PAPER.changed(
    pixels=Grid((48, 24), (8e-6, 8e-6)),
    roughness=SelfAffineRoughness(0.27e-6, 0.8, (16e-6, 16e-6), seed=0),
)


@pytest.fixture(scope="module")
def measured():
    said = []
    table = trade(SMALL, base="draft", loads=(200.0,), progress=said.append)
    assert said[0] == f"1 of {len(table.choices)}: reference"
    assert len(said) == len(table.choices)
    assert said[-1].startswith("{0} of {0}: ".format(len(table.choices)))
    return table


def named(table, name):
    return next(choice for choice in table.choices if choice.name == name)


def test_errors_and_costs_go_opposite_ways_from_draft_to_reference(measured):
    presets = [named(measured, name) for name in ("draft", "standard", "fine", "reference")]
    errors = [choice.velocity_error for choice in presets]
    assert all(error < bound for error, bound in zip(errors[:3], (0.08, 0.03, 0.01), strict=True))
    assert errors == sorted(errors, reverse=True)
    assert errors[3] == 0
    works = [choice.work for choice in presets]
    assert works == sorted(works)
    assert presets[0].saving > 10
    assert presets[1].saving > 5
    assert presets[2].saving > 2


def test_every_choice_says_what_it_costs_and_where_it_errs(measured):
    for choice in measured.choices:
        assert choice.seconds > 0
        assert choice.convolutions > 0
        assert choice.peak_bytes > 1e5
        assert len(choice.velocity_errors) == 1
        assert max(map(abs, choice.velocity_errors)) == choice.velocity_error
    # Of a rise that is known to 1 %, the velocity is known to 1 % over its exponent, about 0.6; but
    # the point whose rise errs most need not lie at the boundary.
    draft = named(measured, "draft")
    assert draft.velocity_error > draft.rise_error / 2 > 0
    assert 0 < draft.share_error < 1
    coarsest = named(measured, "as in the scene")
    assert coarsest.area_error > 0
    assert coarsest.fidelity == SMALL.scene.fidelity


def test_each_numerical_choice_is_varied_alone(measured):
    varied = {choice.varied for choice in measured.choices} - {None}
    assert varied == {
        "averaging",
        "contact_tolerance",
        "heat_tolerance",
        "history_coarsening",
        "increments",
        "kernel",
        "partition",
        "pixels_per_element",
        "wear_scheme",
    }
    draft = PRESETS["draft"]
    for choice in measured.choices:
        if choice.varied:
            value = getattr(choice.fidelity, choice.varied)
            assert choice.fidelity == replace(draft, **{choice.varied: value}) != draft


def test_it_names_the_cheapest_within_an_error_and_none_of_the_front_is_beaten(measured):
    loose = measured.cheapest(0.1)
    assert loose.velocity_error <= 0.1
    assert loose.work == min(c.work for c in measured.choices if c.velocity_error <= 0.1)
    assert measured.cheapest(0.0) is measured.front[-1] is measured.reference
    for one in measured.front:
        assert not any(
            other.work < one.work and other.velocity_error < one.velocity_error
            for other in measured.choices
        )


def test_a_choice_is_wasted_that_costs_and_gains_nothing(measured):
    def choice(name, varied, work, errors):
        like = measured.reference
        return replace(like, name=name, varied=varied, work=work, velocity_errors=errors)

    choices = [
        choice("fine", None, 100.0, (0.01, 0.02)),
        choice("fine, a", "increments", 50.0, (0.0105, 0.0195)),  # half the work, nothing lost
        choice("fine, b", "partition", 50.0, (0.05, 0.02)),  # loses
        choice("fine, c", "kernel", 95.0, (0.01, 0.02)),  # saves nothing
    ]
    (wasted,) = tradeoff._wasted(choices, "fine", PRESETS["fine"])
    assert (wasted.field, wasted.saving) == ("increments", 2.0)
    assert wasted.moves == pytest.approx(0.0005)
    assert "the work is 2 times less" in str(wasted)


def test_the_figure_shows_presets_variations_and_front_with_the_values_of_each(measured):
    figure = draw_trade(measured)
    (axes,) = figure.axes
    drawn = {line.get_gid(): line for line in axes.lines}
    varied = {choice.varied for choice in measured.choices} - {None}
    assert set(drawn) == {"front", "presets", "the scene's own"} | varied
    words = {text.get_text() for text in axes.texts}
    assert words == {"draft", "standard", "fine", "as in the scene"}
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    for field in varied:
        choices = [choice for choice in measured.choices if choice.varied == field]
        choices.sort(key=lambda choice: choice.work)
        values = [choice.name.partition(" = ")[2] for choice in choices]
        assert f"{field.replace('_', ' ')} {', '.join(values)}" in names
        assert list(drawn[field].get_xdata()) == [choice.saving for choice in choices]


def test_only_choices_that_go_with_unequal_bulk_temperatures_are_tried():
    scene = PAPER.changed(unequal_bulks=True)
    names = []
    for name, _, fidelity in tradeoff._candidates(scene, ("draft", "fine"), "standard"):
        scene.changed(fidelity=fidelity)
        names.append(name)
    assert len(names) > 10


def test_unknown_presets_and_scenes_without_heat_are_refused():
    with pytest.raises(InputError, match="preset 'fast' is unknown; known are draft, standard"):
        trade(PAPER, ("fast",))
    without = PAPER.changed(conditions=replace(PAPER.conditions, friction=0.0))
    with pytest.raises(InputError, match="friction is 0"):
        trade(without)
    still = PAPER.changed(velocities=(0.0,))
    with pytest.raises(InputError, match="no velocity but 0"):
        trade(still)
