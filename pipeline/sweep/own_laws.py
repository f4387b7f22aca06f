"""The user's own laws, named in a scene as ``"module:name"``: code, which runs only where allowed.

`Laws` finds the text of a module without running it; `Own` carries permission, text and hash.

::

    InputError
    └── OwnLawError   code that the user has not allowed to run
"""

from __future__ import annotations

import functools
import hashlib
import inspect
import sys
import threading
import traceback
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, Final, NamedTuple

from pipeline.quantities import display
from tribo import (
    LAWS,
    InputError,
    MeasuredRoughness,
    Rule,
    Scene,
    SelfAffineRoughness,
    Surface,
    WearLaw,
)
from tribo.surface import UnknownHeights

GROUP: Final = "irg_transition.laws"
"""Entry points by which an installed package registers its laws."""
WEAR, SURFACE, CRITERION = "wear law", "surface", "criterion"
_METHODS: dict[str, tuple[type, str]] = {WEAR: (WearLaw, "over"), SURFACE: (Surface, "heights")}
_PREFIX = "irg_own"
_LARGEST = 1_000_000  # [bytes] of a module
_loading = threading.RLock()  # a worker's second thread must not take a module that is half made


class OwnLawError(InputError):
    """Code that a scene or a store names, which the user has not allowed to run."""


class _Text(NamedTuple):
    """Text of a module, where it stands, and the package that it belongs to if it is installed."""

    content: bytes
    file: Path
    package: str | None = None

    @property
    def digest(self) -> str:
        return hashlib.sha256(self.content).hexdigest()


@dataclass(frozen=True, slots=True)
class Laws:
    """Where names of code are looked for, and whether that may run."""

    folder: Path  # the scene's, or the command's where an option names the code
    are_allowed: bool  # by the user: --own-laws or own_laws=True

    def named(self, kind: str, reference: str, parameters: Mapping[str, Any] | None = None) -> Own:
        """The law, surface or criterion of a name; `OwnLawError` if it is not allowed to run."""
        module, _, name = reference.partition(":")
        if not module or not name.isidentifier():
            raise InputError(f'"{reference}" is not the name of an object; give "module:name"')
        text = self._text(module, reference)
        if not self.are_allowed:
            raise OwnLawError(
                f'the {kind} "{reference}" is code of {text.file} (SHA-256 {text.digest}), and '
                "code runs only if you say so: read it, then add --own-laws (in Python "
                "own_laws=True)"
            )
        values = tuple(sorted((parameters or {}).items()))
        return Own(reference, kind, values, text.content, text.digest, text.package, True)

    def _text(self, module: str, reference: str) -> _Text:
        """Text of a module, which is not run."""
        file = self.folder / f"{module}.py"
        # An identifier has neither a slash nor a dot; a link could still lead to another folder.
        is_here = module.isidentifier() and file.is_file()
        if is_here and file.resolve().parent == self.folder.resolve():
            if file.stat().st_size > _LARGEST:
                raise InputError(f'"{reference}": {file} is larger than {display(_LARGEST, "MB")}')
            return _Text(file.read_bytes(), file)
        installed = _installed(reference)
        if installed is None:
            where = f"no file {module}.py" if module.isidentifier() else f'no file for "{module}"'
            raise InputError(
                f'"{reference}": there is {where} in {self.folder.absolute()}, and no installed '
                f"package registers it as an entry point of {GROUP}; see OWN_LAWS.md"
            )
        return installed


@dataclass(frozen=True, repr=False)
class Own:
    """An object of a user's module; it has the attributes of that object.

    All that it is made of goes along to a worker, where the object is made anew: an `InputError` if
    it may not run, or the text has another hash, or is another one in the package there.
    """

    reference: str
    kind: str
    parameters: tuple[tuple[str, Any], ...]
    source: bytes
    digest: str
    package: str | None
    is_allowed: bool

    def __post_init__(self) -> None:
        if not self.is_allowed:
            raise OwnLawError(f'"{self.reference}" is code, and is not allowed to run')
        here = _Text(self.source, Path()) if self.package is None else _installed(self.reference)
        if here is None or here.digest != self.digest:
            found = "is missing" if here is None else f"has the SHA-256 {here.digest}"
            raise InputError(
                f'the {self.kind} "{self.reference}" {found} here, and the scene was read with '
                f"{self.digest}; install the same version everywhere"
            )
        _ = self.made

    def __reduce__(self) -> tuple[Any, ...]:
        return Own, astuple(self)  # so that a worker compares before it executes

    @property
    def made(self) -> Any:
        """Object that the reference names, made with the parameters."""
        return _made(self)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self.made, name)

    def __repr__(self) -> str:
        arguments = ", ".join(f"{name}={value!r}" for name, value in self.parameters)
        return f"{self.reference}({arguments})"


@dataclass(frozen=True)
class Reference(UnknownHeights):
    """A law, surface or criterion that a store names: no code, and none runs by its name."""

    reference: str
    kind: str
    parameters: tuple[tuple[str, Any], ...]
    digest: str
    pattern: str | None = None  # a wear law has one

    @property
    def made(self) -> Any:
        """Nothing: an `OwnLawError`, since a user's word is needed."""
        raise OwnLawError(
            f'the {self.kind} is "{self.reference}" (SHA-256 {self.digest}), which is code, and '
            "nothing that a store names is run; give its scene with --own-laws"
        )

    def over(self, begin: float, end: float) -> Any:
        """Raise an `OwnLawError`, as a wear law that is not at hand."""
        return self.made.over(begin, end)

    def heights(self, pixels: Any) -> Any:
        """Raise an `OwnLawError`, as a surface that is not at hand."""
        return self.made.heights(pixels)


def refer(law: Any) -> Reference:
    """Name, parameters and hash of a law or surface, also if it is given in Python."""
    if isinstance(law, Reference):
        return law
    pattern = getattr(law, "pattern", None) if hasattr(law, "over") else None
    if isinstance(law, Own):
        pattern = pattern if law.kind == WEAR else None
        return Reference(law.reference, law.kind, law.parameters, law.digest, pattern)
    kind = type(law)
    reference = f"{kind.__module__}:{kind.__qualname__}"
    try:
        text = inspect.getsource(kind)
    except (OSError, TypeError) as error:
        raise InputError(
            f"the source of {reference} cannot be read, and a store keeps its hash; put it into a "
            'file, and name it as "module:name"'
        ) from error
    held = getattr(law, "__dataclass_fields__", None) or getattr(law, "__dict__", {})
    values = {name: getattr(law, name) for name in sorted(held)}
    parameters = tuple(
        (name, value if isinstance(value, str | float | int | bool) else repr(value))
        for name, value in values.items()
    )
    digest = hashlib.sha256(text.encode()).hexdigest()
    return Reference(reference, WEAR if pattern else SURFACE, parameters, digest, pattern)


def own_laws(scene: Scene) -> dict[str, Reference]:
    """Name, parameters and hash of a scene's own laws, by the field of the scene."""
    laws = {}
    if scene.wears_by_law and not isinstance(scene.wear, (*LAWS.values(),)):
        laws["wear"] = refer(scene.wear)
    if not isinstance(scene.roughness, SelfAffineRoughness | MeasuredRoughness | None):
        laws["roughness"] = refer(scene.roughness)
    return laws


@functools.lru_cache(maxsize=64)
def _made(own: Own) -> Any:
    """The object that a reference names, looked at before it is called."""
    reference, name = own.reference, own.reference.partition(":")[2]
    with _loading:
        module = _loaded(own)
    if name not in vars(module):
        raise InputError(f'"{reference}": the module has no {name}; give a name that it has')
    found = vars(module)[name]
    if reason := _unlike(found, own.kind):
        raise InputError(f'the {own.kind} is "{reference}", which {reason}')
    if not isinstance(found, type):
        if own.parameters:
            raise InputError(f'"{reference}" is no class, and takes no parameters; leave them out')
        return found
    try:
        return found(**dict(own.parameters))
    except Exception as error:
        words = ", ".join(f"{key} = {value!r}" for key, value in own.parameters) or "no parameters"
        raise InputError(
            f'"{reference}" cannot be made with {words}: {type(error).__name__}: {error}'
        ) from error


def _unlike(found: Any, kind: str) -> str | None:
    """Reason why an object is not of a kind, by its type and the signature of its method."""
    if kind == CRITERION:
        return None if issubclass(type(found), Rule) else "is not a tribo.Rule"
    protocol, name = _METHODS[kind]
    of_class = found if issubclass(type(found), type) else type(found)
    wanted = inspect.signature(getattr(protocol, name))
    method: Any = inspect.getattr_static(of_class, name, None)
    try:
        inspect.signature(method).bind(*wanted.parameters)
    except (TypeError, ValueError):
        _, *given = wanted.parameters
        return f"has no method {name}({', '.join(given)}); see tribo.{protocol.__name__}"
    return None


@functools.lru_cache(maxsize=64)
def _installed(reference: str) -> _Text | None:
    """Text of a module of an installed package that registers a name; nothing is imported."""
    if all(entry.value != reference for entry in entry_points(group=GROUP)):
        return None
    parts = reference.partition(":")[0].split(".")
    where, spec = None, None
    for count in range(1, len(parts) + 1):  # importlib.util.find_spec imports the packages above
        name = ".".join(parts[:count])
        specs = (finder.find_spec(name, where) for finder in sys.meta_path)
        spec = next(filter(None, specs), None)
        if spec is None:
            return None
        where = spec.submodule_search_locations
    if spec is None or spec.origin is None or not spec.origin.endswith(".py"):
        return None
    file = Path(spec.origin)
    return _Text(file.read_bytes(), file, spec.parent)


def _loaded(own: Own) -> ModuleType:
    """Load the module of a law under a name that no installed module has."""
    name = own.reference.partition(":")[0]
    file, full = f"{name}.py", f"{_PREFIX}_{own.digest}_{name.replace('.', '_')}"
    if full in sys.modules:
        return sys.modules[full]
    module = ModuleType(full)
    module.__package__ = own.package
    sys.modules[full] = module  # dataclasses look their module up
    try:
        exec(compile(own.source, file, "exec"), vars(module))
    except Exception as error:
        del sys.modules[full]
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if frame.filename == file and frame.lineno]
        line = getattr(error, "lineno", None) or (lines[-1] if lines else "?")
        raise InputError(
            f"{file}, line {line}: {type(error).__name__}: {error}; mend the module"
        ) from error
    return module
