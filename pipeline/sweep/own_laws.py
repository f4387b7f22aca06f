"""Laws of one's own, named in a scene as ``"module:name"``.

The module is a file in the folder in which the command runs, or an installed package. Its text goes
along to the workers, so that these need no file, and its hash into the store.
"""

from __future__ import annotations

import functools
import hashlib
import importlib
import inspect
import sys
import traceback
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from tribo import InputError, MeasuredRoughness, Scene, SelfAffineRoughness
from tribo.laws import OwnWear

_PREFIX = "irg_own"


@dataclass(frozen=True, repr=False)
class Own:
    """An object of a module of one's own; it has the attributes of that object.

    It is made of its reference, such as ``"laws:running_in"``; the names and values with which the
    reference is called (a class also without any); and the text of the module, None if installed.
    An `InputError` where there is no such object, or making it fails.

    Examples
    --------
    >>> law = Own("tribo:RunningIn", (("initial_rate", 6e-15), ("final_rate", 1e-15),
    ...                               ("distance", 2.0)))
    >>> law.distance, law.reference
    (2.0, 'tribo:RunningIn')
    """

    reference: str
    parameters: tuple[tuple[str, Any], ...] = ()
    source: str | None = None

    def __post_init__(self) -> None:
        _made(self.reference, self.parameters, self.source)

    @classmethod
    def named(cls, reference: str, parameters: Mapping[str, Any] | None = None) -> Own:
        """Find an object by its name, from the folder in which the command runs."""
        module, _, name = reference.partition(":")
        if not module or not name.isidentifier():
            raise InputError(f'"{reference}" is not the name of an object; give "module:name"')
        file = Path(*module.split(".")).with_suffix(".py")
        source = file.read_text("utf-8") if file.is_file() else None
        return cls(reference, tuple(sorted((parameters or {}).items())), source)

    @property
    def made(self) -> Any:
        """Object that the reference names, made with the parameters."""
        return _made(self.reference, self.parameters, self.source)

    @property
    def digest(self) -> str:
        """SHA-256 of the module's text."""
        text = self.source
        if text is None:
            text = inspect.getsource(sys.modules[self.reference.partition(":")[0]])
        return hashlib.sha256(text.encode()).hexdigest()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self.made, name)

    def __repr__(self) -> str:
        arguments = ", ".join(f"{name}={value!r}" for name, value in self.parameters)
        return f"{self.reference}({arguments})"


def identity_of(law: Any) -> dict[str, Any]:
    """Name, parameters and hash of a law, also of one that is given in Python, as plain data."""
    if isinstance(law, Own):
        return {"law": law.reference, "parameters": dict(law.parameters), "hash": law.digest}
    kind = type(law)
    try:
        text = inspect.getsource(kind)
    except (OSError, TypeError) as error:
        raise InputError(
            f"the source of {kind.__module__}:{kind.__qualname__} cannot be read, and a store "
            'keeps its hash; put it into a file, and name it as "module:name"'
        ) from error
    names = getattr(law, "__dataclass_fields__", None) or getattr(law, "__dict__", {})
    values = ((name, getattr(law, name)) for name in sorted(names))
    fields = {
        name: value if isinstance(value, str | float | int | bool) else repr(value)
        for name, value in values
    }
    digest = hashlib.sha256(text.encode()).hexdigest()
    return {"law": f"{kind.__module__}:{kind.__qualname__}", "parameters": fields, "hash": digest}


def own_laws(scene: Scene) -> dict[str, dict[str, Any]]:
    """Name, parameters and hash of a scene's own laws, by the field of the scene."""
    laws = {}
    if isinstance(scene.wear, OwnWear):
        laws["wear"] = identity_of(scene.wear.law)
    if not isinstance(scene.roughness, SelfAffineRoughness | MeasuredRoughness | None):
        laws["roughness"] = identity_of(scene.roughness)
    return laws


@functools.lru_cache(maxsize=64)
def _made(reference: str, parameters: tuple[tuple[str, Any], ...], source: str | None) -> Any:
    """The object that a reference names."""
    module_name, _, name = reference.partition(":")
    module = _installed(module_name, reference) if source is None else _loaded(module_name, source)
    if not hasattr(module, name):
        public = ", ".join(sorted(_defined_in(module)))
        raise InputError(f'"{reference}": the module has no {name}; it has {public or "nothing"}')
    law = getattr(module, name)
    if not parameters and not isinstance(law, type):
        return law
    try:
        return law(**dict(parameters))
    except Exception as error:
        words = ", ".join(f"{key} = {value!r}" for key, value in parameters) or "no parameters"
        raise InputError(
            f'"{reference}" cannot be made with {words}: {type(error).__name__}: {error}'
        ) from error


def _defined_in(module: ModuleType) -> Iterator[str]:
    """Public names of a module, without those that it imports."""
    for name, value in vars(module).items():
        is_imported = isinstance(value, ModuleType) or (
            isinstance(value, type | FunctionType) and value.__module__ != module.__name__
        )
        if not (name.startswith("_") or is_imported):
            yield name


def _installed(module: str, reference: str) -> ModuleType:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f'"{reference}": there is no {module.replace(".", "/")}.py in {Path.cwd()}, and no '
            f"installed module {module} ({error}); run the command where the file lies"
        ) from error


def _loaded(name: str, source: str) -> ModuleType:
    """A module of a text, under a name of its own beside all that is installed."""
    digest = hashlib.sha256(source.encode()).hexdigest()[:16]
    full = f"{_PREFIX}_{digest}_{name.replace('.', '_')}"
    if full in sys.modules:
        return sys.modules[full]
    module = ModuleType(full)
    sys.modules[full] = module  # dataclasses look their module up
    try:
        exec(compile(source, f"{name}.py", "exec"), vars(module))
    except Exception as error:
        del sys.modules[full]
        line = getattr(error, "lineno", None) or _line_of(error, f"{name}.py")
        raise InputError(
            f"{name}.py, line {line}: {type(error).__name__}: {error}; mend the module"
        ) from error
    return module


def _line_of(error: BaseException, file: str) -> int | str:
    """Last line of a file on the way to an error."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == file and frame.lineno]
    return lines[-1] if lines else "?"
