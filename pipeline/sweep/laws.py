"""Laws of a user's own: Python objects in a scene, and what a store keeps of them.

::

    InputError
    ├── LawError       a law is needed, of which a store has only the name
    └── MissingError   heights are needed that were not stored with the sweep
"""

from __future__ import annotations

import hashlib
import linecache
import sys
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final, NoReturn

import numpy as np

from tribo import PINS, InputError, Rule
from tribo.surface import UnknownHeights

_ROOTS: Final = ("tribo", "pipeline")
"""Packages whose laws are not a user's own."""
_METHODS: Final = ("over", "heights", "profile")
"""Methods of a wear law, a surface and a pin."""
ASKED: Final = ("pattern", "radius", "length", "material", "words")
"""Attributes of a wear law and of a pin that answers use."""
_KEPT: Final = "_source_sha256"


class LawError(InputError, AttributeError):
    """A user's law (wear, surface, criterion or pin) is needed, but only its name is stored."""


class MissingError(InputError):
    """The content of a file that a scene names is needed, but was not stored with the scene."""


@dataclass(frozen=True)
class MissingSurface(UnknownHeights):
    """A measured surface whose heights are not known, since its file was not stored."""

    digest: str
    words: str

    def heights(self, pixels: Any) -> Any:
        """Raise a `MissingError`: the heights are not known."""
        raise MissingError(self.words)

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True)
class Law(UnknownHeights):
    """What a store records of a user's Python object: a wear law, surface, criterion or pin.

    Attributes
    ----------
    name : str
        Module and name of the object's class; for a criterion, those of its function.
    parameters : tuple
        Names and values of the object's fields, and of attributes that are read after a run, such
        as the length of a pin. An array is replaced by text with its SHA-256.
    source_sha256 : str
        SHA-256 of the file that defines the class or function, or of its source if there is no
        file.
    """

    name: str
    parameters: tuple[tuple[str, Any], ...]
    source_sha256: str

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if name not in (known := dict(self.parameters)):
            self._refuse()
        return known[name]

    def _refuse(self, *_: Any) -> NoReturn:
        """Raise a `LawError`: only the name of the law is known."""
        raise LawError(
            f"{self.name} is a Python object, of which a store has only the name; give it anew: "
            "pipeline.load_scene(…, laws=…)"
        )

    over = heights = _refuse  # methods of a wear law and of a surface

    def __str__(self) -> str:
        return f"{self.name}({', '.join(f'{name}={value}' for name, value in self.parameters)})"


class StoredRule(Law):
    """What a store records of a user's criterion, in the place of the `Rule`, which it lacks."""

    def __getattr__(self, name: str) -> Any:
        return super().__getattr__(name) if name.startswith("_") else self._refuse()

    def _refuse(self, *_: Any) -> NoReturn:
        """Raise a `LawError`: nothing can be judged by the name of a criterion."""
        raise LawError(
            f"the store is judged by the criterion {self.name}, a Python object, of which it has "
            "only the name; give another criterion, such as --criterion=share, or in Python "
            "pipeline.at(ds, criterion=rule); irg plot --kind=temperature needs none"
        )


def is_user_law(part: Any) -> bool:
    """True if a part of a scene is a Python object of the user's own.

    Such an object is a wear law, surface or pin of the user's own class, or a `Rule`. A `Law`, the
    stored record of such an object, counts, too.
    """
    kind = type(part)
    root = getattr(kind, "__module__", "").partition(".")[0]
    if root in _ROOTS or kind in tuple(PINS.values()):
        return kind in (Rule, Law, StoredRule)
    return any(hasattr(kind, name) for name in _METHODS)


def law_record(law: Any) -> Law:
    """Record of a law for a store: its name, fields and the hash of its source.

    Raises
    ------
    InputError
        If neither the file nor the source of its code can be read.
    """
    if isinstance(law, Law):
        return law
    names = [one.name for one in fields(law) if one.name != "rise"]
    names += [name for name in ASKED if name not in names and hasattr(law, name)]
    parameters = tuple((name, _storable(getattr(law, name))) for name in names)
    record = StoredRule if isinstance(law, Rule) else Law
    return record(name_of(law), parameters, _source_sha256(code_of(law)))


def name_of(law: Any) -> str:
    """Name of a user's law: module and name of its class or function, as in "module:name"."""
    if isinstance(law, Law):
        return law.name
    code = code_of(law)
    return f"{code.__module__}:{code.__qualname__}"


def code_of(law: Any) -> Any:
    """Class or function that holds the code of a user's wear law, surface, criterion or pin.

    It is the class of `law`. For a criterion it is the function that was given, or the class if a
    callable object was given.
    """
    called = law.rise if isinstance(law, Rule) else type(law)
    return called if hasattr(called, "__qualname__") else type(called)


def _storable(value: Any) -> Any:
    """Convert a parameter of a law for a store: an array becomes text with its SHA-256."""
    if not isinstance(value, np.ndarray):
        return value
    sha256 = hashlib.sha256(value.tobytes()).hexdigest()  # numbers may be of any type
    return f"{' × '.join(map(str, value.shape))} numbers, SHA-256 {sha256[:16]}…"


def _source_sha256(code: Any) -> str:
    """SHA-256 of the file that defines a class or function, or of its source if not in a file."""
    try:
        # Kept on the class, so that it is of the code that runs, also on workers and after edits.
        if _KEPT not in vars(code):
            setattr(code, _KEPT, hashlib.sha256(_source(code)).hexdigest())
        return str(vars(code)[_KEPT])
    except (TypeError, AttributeError) as error:
        raise InputError(f"{code!r} is no function or class of Python; give one") from error


def _source(code: Any) -> bytes:
    """Content of the file that defines a class or function, or its source if there is no file."""
    file = getattr(sys.modules.get(code.__module__), "__file__", None)
    if file and Path(file).is_file():
        return Path(file).read_bytes()
    # A class in a notebook does not refer to its cell, but the code of its methods does.
    for part in (code, *vars(code).values()):
        name = getattr(getattr(part, "__code__", None), "co_filename", "")
        if not Path(name).is_file() and (lines := linecache.getlines(name)):
            return "".join(lines).encode()
    raise InputError(
        f"{code.__module__}:{code.__qualname__} has neither a file nor a source, by whose hash a "
        "store knows it; save it in a file, and import it"
    )
