"""Every public function and class has an example, which the suite runs."""

import doctest
import inspect

import pytest

import pipeline
import tribo

# These take minutes, or a cluster of their own.
LONG = {"trade"}  # it measures for a minute or more
PUBLIC = [
    (module.__name__, name)
    for module, names in ((pipeline, pipeline.__all__), (tribo, vars(tribo)))
    for name in names
    if callable(getattr(module, name)) and not name.startswith("_")
]


@pytest.mark.parametrize(("module", "name"), PUBLIC)
def test_a_public_name_has_an_example_that_runs(module, name):
    documented = inspect.getdoc(getattr({"pipeline": pipeline, "tribo": tribo}[module], name))
    examples = doctest.DocTestParser().get_examples(documented)
    runs = [example for example in examples if doctest.SKIP not in example.options]
    assert examples
    assert runs or name in LONG
