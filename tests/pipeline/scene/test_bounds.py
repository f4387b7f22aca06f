"""Numbers that no machine has are faults of the scene, by the paths of their entries."""

import pytest

import pipeline
from pipeline.quantities import DIMENSIONS
from pipeline.scene.declare import Either, List, Range, Table, Tables, table_of
from pipeline.scene.faults import Faults
from pipeline.scene.format import SceneFile
from pipeline.scene.kinds import Number, Quantity, Whole
from pipeline.scene.units import si_unit


def numbers(kind, path=""):
    """Kinds of all quantities and numbers of the format, by their paths."""
    match kind:
        case Either():
            for one in kind.kinds:
                yield from numbers(one, path)
        case List() | Range() | Tables():
            yield from numbers(kind.of, path)
        case Table():
            for key, entry in kind.keys.items():
                yield from numbers(entry.kind, f"{path}.{key}".lstrip("."))
        case Quantity():
            yield path, kind
        case Number():
            yield path, kind


EVERY = list(dict.fromkeys(numbers(table_of(SceneFile))))
KINDS = [(path, kind) for path, kind in EVERY if type(kind) in (Number, Quantity)]


@pytest.mark.parametrize("text", ["1e-320", "1e300"])
@pytest.mark.parametrize(("path", "kind"), KINDS)
def test_every_number_has_a_smallest_and_a_largest_value(path, kind, text):
    faults = Faults()
    is_quantity = isinstance(kind, Quantity)
    value = f"{text} {kind.example.partition(' ')[2]}" if is_quantity else float(text)
    if is_quantity and "degC" in kind.example and "-" in text:
        value = value.replace("degC", "K")
    assert kind.read(value, path, faults) is None
    assert [fault.key for fault in faults] == [path]
    assert "out of range" in faults[0].problem


@pytest.mark.parametrize("kind", [kind for _, kind in KINDS if isinstance(kind, Quantity)])
def test_the_ends_of_a_range_are_allowed(kind):
    for end in kind.ends or DIMENSIONS[si_unit(kind.example)].limits:
        faults = Faults()
        assert kind.read(end, "entry", faults) > 0, faults


MANY_STEPS = {
    "loading.reference_load": "1e-6 N",
    "fidelity.increments": 10**9,
}


@pytest.mark.parametrize(("path", "value"), MANY_STEPS.items(), ids=MANY_STEPS)
def test_an_entry_that_asks_for_a_billion_steps_is_named(path, value):
    with pytest.raises(pipeline.SceneFileError, match=rf": {path.split('.')[0]}.*(100000|1e\+06)"):
        pipeline.load_scene("first_try", overrides={path: value})


BOUNDS = [(kind, name) for _, kind in EVERY if isinstance(kind, Number) for name in kind.bounds]


@pytest.mark.parametrize(("kind", "name"), list(dict.fromkeys(BOUNDS)))
def test_a_bound_itself_is_refused_or_allowed_as_its_word_says(kind, name):
    is_whole = isinstance(kind, Whole)
    bound = int(kind.bounds[name]) if is_whole else kind.bounds[name]
    is_read = kind.read(bound, "entry", Faults()) is not None
    assert is_read == (name in ("at_least", "at_most"))
    step = 1 if is_whole else 0.01
    beyond = bound - step if name in ("above", "at_least") else bound + step
    assert kind.read(beyond, "entry", Faults()) is None
