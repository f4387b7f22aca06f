"""Wear laws and surfaces of a user's class in a sweep, and what a store keeps of them.

A store keeps the import name of the class, digests of the object's values and code, what answers
need, and the object's ``repr`` for people. So a run that continues the store can compare the law
with that of its own sweep, and reading a store imports nothing.

An object is identified by its state by value, and by the sources of its modules. Neither its
``repr``, which may round or hide values, nor its pickled bytes, which differ between processes,
identify it.
"""

from __future__ import annotations

import copyreg
import hashlib
import pickle
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from pipeline.sweep.codec import NOT_IDENTITY, NOT_STORED
from tribo import InputError, MeasuredRoughness, Scene, Surface, Wear, WearLaw
from tribo.numerics import Grid
from tribo.simulation.lubrication import SurfaceSummary, summarize_surface
from tribo.surface import UnknownHeights, array_digest, surface_heights
from tribo.types import Array
from tribo.wear import WearPattern, evaluate_wear, require_wear

_ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


@dataclass(frozen=True, repr=False, kw_only=True)
class UserObject:
    """An object of a user's class, by what a store keeps of it."""

    name: str  # import name of the class
    values: str  # SHA-256, see `Identity`
    code: str
    text: str = field(compare=False, metadata=NOT_IDENTITY)  # of the object, for people
    original: Any = field(default=None, compare=False, metadata=NOT_STORED)  # None from a store
    # Packages of its code, which workers get with the object.
    packages: tuple[str, ...] = field(default=(), compare=False, metadata=NOT_STORED)

    def __repr__(self) -> str:
        digests = f"values {self.values[:8]}, code {self.code[:8]}"
        return f"{self.text:.300} of class {self.name} ({digests})"

    def require_original(self) -> Any:
        """The object itself; `InputError` if the sweep was read from a store, which lacks it."""
        if self.original is None:
            raise InputError(f"the store has no code of {self}; run the sweep of its script")
        return self.original


@dataclass(frozen=True, repr=False, kw_only=True)
class UserLaw(UserObject):
    """A wear law of a user's class."""

    pattern: WearPattern

    def mean_wear(self, begin: float, end: float, pressure: float, velocity: float) -> Wear:
        """The wear of the law in a step, see `tribo.WearLaw.mean_wear`."""
        wear: Wear = self.require_original().mean_wear(begin, end, pressure, velocity)
        return wear


@dataclass(frozen=True, repr=False, kw_only=True)
class UserSurface(UserObject, UnknownHeights):
    """A surface of a user's class."""

    summary: SurfaceSummary | None

    def heights(self, pixels: Grid) -> Array:
        """Heights of the surface [m], see `tribo.Surface.heights`."""
        heights: Array = self.require_original().heights(pixels)
        return heights


def user_law(_scene: Scene, law: WearLaw) -> UserLaw:
    """A wear law for a sweep; `InputError` if it fails, or a store cannot keep what it is."""
    require_wear(law)

    def evaluate() -> object:
        return evaluate_wear(law, 0.0, 1e-3, 1e8, 1.0)

    return UserLaw(**_identify_constant("wear law", law, evaluate), pattern=law.pattern)


def user_surface(scene: Scene, surface: Surface) -> UserSurface:
    """A surface for a scene; `InputError` if it fails, or a store cannot keep what it is."""
    if not hasattr(surface, "heights"):
        raise InputError(f"the surface {surface!r:.200} has no heights; see tribo.Surface")

    def evaluate() -> object:
        return array_digest(surface_heights(surface, scene.pixels))

    identity = _identify_constant("surface", surface, evaluate)
    heights = MeasuredRoughness(surface_heights(surface, scene.pixels))
    summary = summarize_surface(replace(scene, roughness=heights))
    return UserSurface(**identity, summary=summary)


def _identify_constant(
    role: str, original: object, evaluate: Callable[[], object]
) -> dict[str, Any]:
    """What a store keeps of an object, whose equal calls must have equal results."""
    _require_module(role, original)
    # The first call may fill what the object computes once, such as a cached property.
    results = [(evaluate(), _identify(role, original)) for _ in range(2)]
    (result, identity), second = results
    if (result, identity) != second:
        raise InputError(
            f"the {role} {identity['text']:.200} changes when it is used; points are simulated in "
            "any order, so write it without random numbers and without values that change"
        )
    return identity


def _require_module(role: str, original: object) -> None:
    """Raise an `InputError` if an object's class is not one of a user's module."""
    cls, text = type(original), _describe(original)
    package = cls.__module__.partition(".")[0]
    if isinstance(original, type):
        raise InputError(f"the {role} {text:.200} is a class; give an object of it")
    if package == "__main__":
        raise InputError(
            f"the {role} {text:.200} is of class {cls.__qualname__} of a script or notebook, which "
            "a store cannot name; save the class in a module, such as laws.py, and import it"
        )
    if package in ("tribo", "pipeline"):
        raise InputError(f"the {role} {text:.200} is not your class; set it in the scene file")


def _describe(original: object) -> str:
    return _ADDRESS.sub("", " ".join(repr(original).split()))


def _identify(role: str, original: object) -> dict[str, Any]:
    """Import name, digests and text of an object, and the object itself."""
    text = _describe(original)
    return {
        "name": f"{type(original).__module__}.{type(original).__qualname__}",
        "text": text,
        **asdict(identify(original, f"the {role} {text:.200}")),
        "original": original,
    }


_ATOMS = (type(None), bool, int, float, complex, str, bytes)
_CONTAINERS = (tuple, list, dict, set, frozenset)
_NAMED = (type, FunctionType, BuiltinFunctionType)
"""Types whose objects are identified by their names, and by the sources of their modules."""
_INSTALLED = {"site-packages", "dist-packages"}
"""Folders of installed packages, which are not part of an identity."""
_WITH_CODE = {".py", ".so", ".pyd"}
"""Endings of files with code."""


@dataclass(frozen=True)
class Identity:
    """SHA-256 of an object's values and of its code, and the user's packages with this code."""

    values: str
    code: str
    packages: tuple[str, ...]


def identify(original: Any, description: str) -> Identity:
    """The identity of an object that is picklable, and of a class in a module.

    Its values are its state, and the numbers, texts and arrays that modules and classes of its code
    have as variables. Its code is that of the whole packages of these modules: the modules of its
    class, base classes, and objects that it refers to, and what these import at their top.

    Raises
    ------
    InputError
        If the object cannot be pickled, or its code cannot be found, is in a script, or has changed
        since it was imported. `description` names the object in the message.
    """
    cls = type(original)
    if cls.__module__ not in sys.modules:
        raise _missing_source(description, f"{cls.__module__}.{cls.__qualname__}")
    try:
        pickle.dumps(original)
    except Exception as error:
        raise InputError(
            f"{description} cannot be pickled ({error!s:.100}); functions and classes that it uses "
            "must be those of a module, not lambdas or parts of a function"
        ) from None
    names = {base.__module__ for base in cls.__mro__}
    state = _plain_state(original, names)
    if "__main__" in names:
        raise InputError(
            f"{description} uses a function or class of a script or notebook, which a store cannot "
            "name; save it in a module, such as laws.py, and import it"
        )
    modules = _user_modules(names, own=_package(cls.__module__))
    for module in modules:
        _require_source(module, description)
    variables = [
        (path, _plain_state(value, set()))
        for module in modules
        for path, value in _variables(module)
        if _is_data(value)
    ]
    packages = sorted({_package(module.__name__) for module in modules})
    code = [file for package in packages for file in _files(sys.modules[package])]
    return Identity(_digest((state, variables)), _digest(code), (*packages,))


def _digest(plain: Any) -> str:
    return hashlib.sha256(repr(plain).encode("utf-8", "surrogatepass")).hexdigest()


def _plain_state(value: Any, names: set[str], outer: tuple[int, ...] = ()) -> Any:
    """The state of an object as nested tuples of texts; equal only for equal types and values.

    The modules of classes and functions in it are added to `names`. `outer` has the ids of the
    objects that contain the value.
    """
    cls = type(value)
    if cls in _ATOMS:
        return cls.__name__, repr(value)
    if isinstance(value, _NAMED):
        names.add(value.__module__)
        return "name", value.__module__, value.__qualname__
    if id(value) in outer:
        return "outer", outer.index(id(value))
    if cls is np.ndarray and not value.dtype.hasobject:
        numbers = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return "array", str(value.dtype), value.shape, numbers
    parts: Iterable[Any] = value.items() if cls is dict else value
    if cls not in _CONTAINERS:  # the parts from which pickle builds the object
        reduce = copyreg.dispatch_table.get(cls)
        parts = reduce(value) if reduce else value.__reduce_ex__(4)
        if isinstance(parts, str):
            names.add(getattr(value, "__module__", cls.__module__))
            return "name", cls.__name__, parts
    plain = [
        _plain_state([*part] if hasattr(part, "__next__") else part, names, (*outer, id(value)))
        for part in parts
    ]
    return cls.__name__, (*(sorted(plain, key=repr) if cls in (set, frozenset) else plain),)


def _package(module: str) -> str:
    return module.partition(".")[0]


def _user_modules(names: Iterable[str], own: str) -> list[ModuleType]:
    """The modules of `names`, and those from which they import, as far as a user wrote them.

    `own` is a user's package, even if it is installed.
    """
    modules, to_read = dict[str, ModuleType](), {*names}
    while to_read:
        name = to_read.pop()
        module = sys.modules.get(name)
        if module is None or not (_package(name) == own or _is_users(module)):
            continue
        modules[name] = module
        for value in vars(module).values():
            attribute = "__name__" if isinstance(value, ModuleType) else "__module__"
            used = getattr(value, attribute, None)
            if isinstance(used, str) and used not in modules:
                to_read.add(used)
    return [modules[name] for name in sorted(modules)]


def _is_users(module: ModuleType) -> bool:
    """False for modules of Python, of this program, and of installed packages."""
    package, file = _package(module.__name__), getattr(module, "__file__", None)
    if package in ("tribo", "pipeline", "__main__") or package in sys.stdlib_module_names:
        return False
    return file is None or _INSTALLED.isdisjoint(Path(file).parts)


def _variables(module: ModuleType) -> Iterator[tuple[str, Any]]:
    """Yield path and value of all variables of a module and of its classes."""
    for owner in (module, *filter(_is_class, vars(module).values())):
        path = ".".join([module.__name__, *([owner.__qualname__] if _is_class(owner) else [])])
        if getattr(owner, "__module__", module.__name__) == module.__name__:
            for name, value in sorted(vars(owner).items()):
                if not name.startswith("__"):
                    yield f"{path}.{name}", value


def _is_class(value: Any) -> bool:
    return isinstance(value, type)


def _is_data(value: Any) -> bool:
    """True for numbers, texts and arrays, and for containers of nothing else."""
    if type(value) in _CONTAINERS:
        parts = (*value, *value.values()) if type(value) is dict else value
        return all(map(_is_data, parts))
    return type(value) in (*_ATOMS, np.ndarray) or isinstance(value, np.generic)


def _require_source(module: ModuleType, description: str) -> None:
    """Raise an `InputError` unless a module's functions are those of its file."""
    file = getattr(module, "__file__", None) or ""
    if not (hasattr(module, "__path__") or Path(file).is_file()):
        raise _missing_source(description, module.__name__)
    get_code = getattr(module.__loader__, "get_code", None)
    code = get_code(module.__name__) if get_code else None
    if code is None:  # compiled, or changed by its loader
        return
    in_file = {*_all_code(code)}
    for path, value in _variables(module):
        loaded = getattr(value, "__code__", None)
        if loaded and loaded.co_filename == code.co_filename and loaded not in in_file:
            raise InputError(
                f"{description} uses {path}, whose file has changed since it was imported; start "
                "Python again"
            )


def _missing_source(description: str, name: str) -> InputError:
    return InputError(
        f"{description} uses {name}, whose source cannot be found; save it in a module, such as "
        "laws.py, and import it"
    )


def _all_code(code: CodeType) -> Iterator[CodeType]:
    """Yield the code of a module, and that of all functions in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _all_code(constant)


def _files(package: ModuleType) -> list[tuple[str, str, bytes]]:
    """Package, name and contents of all files with code of a module or package, in order."""
    folders = [Path(folder) for folder in getattr(package, "__path__", ())]
    files = [(folder, file) for folder in folders for file in folder.rglob("*")]
    if not folders and (file_name := package.__file__):
        files = [(Path(file_name).parent, Path(file_name))]
    contents = (
        (file.relative_to(folder).as_posix(), file.read_bytes().replace(b"\r\n", b"\n"))
        for folder, file in files
        if file.suffix in _WITH_CODE
    )
    return [(package.__name__, name, text) for name, text in sorted(contents)]
