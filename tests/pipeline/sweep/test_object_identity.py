"""What identifies an object of a user's class (pipeline/sweep/user_laws.py)."""

import functools
import importlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pipeline import StoreMismatchError, run_sweep
from pipeline.store.create import writing
from tests.helpers import tiny

SWEEP = tiny.sweep(velocities=(0.5, 1.5))
FILES = {
    "lab/__init__.py": "",
    "lab/constants.py": "SCALE = 2.0\nUNUSED = 3.0\n",
    "lab/tables.py": "def table(): return {'mild': 1e-15}\n",
    "bases_of_a_user.py": "class Base:\n    def exponent(self): return 1.0\n",
    "lab/laws.py": """
from dataclasses import dataclass, field
from functools import cached_property
import numpy as np
import tribo
from bases_of_a_user import Base
from lab.constants import SCALE
from lab import constants

FACTOR = 1.0
power = lambda x, exponent=1.0: x**exponent

def closed(factor):
    def scaled(pressure): return factor * pressure
    return scaled

scaled = closed(2.0)

def helper(pressure, offset=0.0):
    return FACTOR * SCALE * power(scaled(pressure)) + offset

def linear(x): return x

@dataclass
class Law(Base):
    rate: float = 1e-24
    table: object = None
    hidden: float = field(default=1.0, repr=False, compare=False)
    tags: frozenset = frozenset("abcdef")
    function: object = linear
    pattern: str = "local"

    unit = 1.0

    def __repr__(self): return "Law()"

    @cached_property
    def computed(self): return self.rate * self.hidden

    def mean_wear(self, begin, end, pressure, velocity):
        from lab.tables import table
        return tribo.Wear(self.computed * helper(pressure) ** self.exponent(), self.pattern)
""",
}


def forget_user_code():
    for module in [*sys.modules]:
        if module.partition(".")[0] in ("lab", "bases_of_a_user"):
            del sys.modules[module]


@pytest.fixture
def user_code(tmp_path, monkeypatch):
    """Function that imports the module of a user's law again, after texts in a file changed."""
    monkeypatch.syspath_prepend(tmp_path)

    def import_laws(name="lab/laws.py", *replacements):
        for file, text in FILES.items():
            for old, new in replacements if file == name else ():
                assert old in text
                text = text.replace(old, new)
            (tmp_path / file).parent.mkdir(exist_ok=True)
            (tmp_path / file).write_text(text, encoding="utf-8")
        forget_user_code()
        importlib.invalidate_caches()
        return importlib.import_module("lab.laws")

    yield import_laws
    forget_user_code()


CHANGED_TEXTS = {
    "helper": ("lab/laws.py", ("FACTOR * SCALE", "1.1 * FACTOR * SCALE")),
    "constant": ("lab/laws.py", ("FACTOR = 1.0", "FACTOR = 1.1")),
    "constant of another module": ("lab/constants.py", ("SCALE = 2.0", "SCALE = 2.2")),
    "module that is imported later": ("lab/tables.py", ("1e-15", "2e-15")),
    "base class elsewhere": ("bases_of_a_user.py", ("return 1.0", "return 1.1")),
    "default argument": ("lab/laws.py", ("offset=0.0", "offset=1.0")),
    "lambda": ("lab/laws.py", ("x**exponent", "x*exponent")),
    "closure": ("lab/laws.py", ("closed(2.0)", "closed(3.0)")),
    "class attribute": ("lab/laws.py", ("unit = 1.0", "unit = 2.0")),
    "default of a field": ("lab/laws.py", ("hidden: float = field(default=1.0",
                                           "hidden: float = field(default=2.0")),
}  # fmt: skip


def set_constant(module):
    module.FACTOR = 1.1
    return module.Law()


def set_constant_of_module(module):
    module.constants.UNUSED = 3.3
    return module.Law()


def set_class_attribute(module):
    module.Law.unit = 2.0
    return module.Law()


ARRAY = np.linspace(0.0, 1.0, 5000)
CHANGED_VALUES = {
    "hidden field": (lambda module: module.Law(hidden=1.1), {}),
    "array": (lambda module: module.Law(table=ARRAY + 1e-15), {"table": ARRAY}),
    "shape": (lambda module: module.Law(table=ARRAY.reshape(50, 100)), {"table": ARRAY}),
    "precision": (lambda module: module.Law(table=ARRAY.astype("f4")), {"table": ARRAY}),
    "type": (lambda module: module.Law(table=[1.0, 2.0]), {"table": (1.0, 2.0)}),
    "function": (lambda module: module.Law(function=module.helper), {}),
    "partial": (lambda module: module.Law(function=functools.partial(module.helper, offset=1.0)),
                {}),
    "variable": (set_constant, {}),
    "variable of another module": (set_constant_of_module, {}),
    "variable of the class": (set_class_attribute, {}),
}  # fmt: skip


@pytest.mark.parametrize("change", [*CHANGED_TEXTS, *CHANGED_VALUES])
def test_a_law_with_other_code_or_values_cannot_continue_a_store(user_code, path, change):
    build, values = CHANGED_VALUES.get(change, (lambda module: module.Law(), {}))
    with writing(path, SWEEP.with_scene(wear=user_code().Law(**values))):
        pass
    other = build(user_code(*CHANGED_TEXTS.get(change, ())))
    with pytest.raises(StoreMismatchError, match="wear: Law"):
        run_sweep(SWEEP.with_scene(wear=other), path, workers=1)


PRINT_DIGESTS = """
import numpy as np
np.set_printoptions(precision=1)
import lab.laws
from tests.helpers import tiny
law = lab.laws.Law(table=np.linspace(0.0, 1.0, 5000))
law.computed
wear = tiny.sweep().with_scene(wear=law).scene.wear
print(wear.values, wear.code)
"""


def test_the_same_law_has_the_same_identity_in_all_processes(user_code, tmp_path):
    wear = tiny.sweep().with_scene(wear=user_code().Law(table=ARRAY)).scene.wear
    folders = os.pathsep.join([str(tmp_path), str(Path(tiny.__file__).parents[2])])
    for seed in "12":
        variables = {**os.environ, "PYTHONPATH": folders, "PYTHONHASHSEED": seed}
        command = [sys.executable, "-c", PRINT_DIGESTS]
        printed = subprocess.run(command, env=variables, capture_output=True, text=True, check=True)
        assert printed.stdout.split() == [wear.values, wear.code]


def test_the_text_of_a_law_is_not_part_of_what_a_sweep_means(user_code):
    own_text = 'def __repr__(self): return "Law()"', "def __repr__(self): return str(id(self))"
    module = user_code("lab/laws.py", own_text)
    one, other, changed = (
        SWEEP.with_scene(wear=law) for law in (module.Law(), module.Law(), module.Law(hidden=2.0))
    )
    assert one.scene.wear.text != other.scene.wear.text
    assert one == other != changed


def test_a_law_whose_text_prints_an_address_continues_its_store(user_code, path):
    no_text = "lab/laws.py", ('def __repr__(self): return "Law()"', "pass")
    for _ in range(2):
        with writing(path, SWEEP.with_scene(wear=user_code(*no_text).Law())):
            pass
