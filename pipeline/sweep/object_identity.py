"""What an object of a user's class is: its state by value, and the sources of its modules.

Neither its ``repr``, which may round or hide values, nor its pickled bytes, which differ between
processes, identify an object.
"""

from __future__ import annotations

import copyreg
import hashlib
import pickle
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from tribo import InputError

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
