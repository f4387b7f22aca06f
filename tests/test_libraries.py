"""Libraries are used by their public names only."""

import ast
import importlib
import inspect
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LIBRARIES = ("argparse", "dask", "distributed", "xarray", "zarr")
DOCUMENTED = {"xarray.core.indexing"}
"""Modules that the manual of a library names for its users, for a backend of xarray."""
OF_TUPLES = {"_asdict", "_field_defaults", "_fields", "_make", "_replace"}
"""Public names of named tuples."""
FILES = [path for name in ("pipeline", "workflows") for path in sorted((ROOT / name).rglob("*.py"))]


def is_private(name):
    return name.startswith("_") and not name.startswith("__")


def private_modules(tree):
    """Modules of libraries that are imported although they, or a package above, are private."""
    for node in ast.walk(tree):
        match node:
            case ast.ImportFrom(module=str(module)):
                paths = [f"{module}.{alias.name}" for alias in node.names]
            case ast.Import():
                paths = [alias.name for alias in node.names]
            case _:
                continue
        for path in paths:
            first, *parts = path.split(".")
            if first in LIBRARIES and (
                any(map(is_private, parts)) or (parts[:1] == ["core"] and path not in DOCUMENTED)
            ):
                yield path


def private_attributes(tree, own_names):
    """Private attributes that no class or function of this project defines."""
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(attr=name) if is_private(name) and name not in own_names:
                yield name
            case ast.Call(func=ast.Name(id="getattr"), args=[_, ast.Constant(value=str(name)), *_]):
                if is_private(name) and name not in own_names:
                    yield name


def defined_names(tree):
    """Private names that a module defines: functions, fields, and attributes of ``self``."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield name
            case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                yield name
            case ast.arg(arg=name):
                yield name


@pytest.fixture(scope="module")
def trees():
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in FILES}


def test_no_private_name_of_a_library_is_used(trees):
    own_names = OF_TUPLES.union(*(defined_names(tree) for tree in trees.values()))
    used = {
        str(path.relative_to(ROOT)): [*private_modules(tree), *private_attributes(tree, own_names)]
        for path, tree in trees.items()
    }
    # Only the process of the command line may end at once: see `pipeline.__main__`.
    assert {path: names for path, names in used.items() if names} == {
        "pipeline/__main__.py": ["_exit"]
    }


def test_no_private_method_of_a_library_is_replaced():
    for path in (ROOT / "pipeline").rglob("*.py"):
        if path.stem == "__main__":
            continue
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        module = importlib.import_module(name.removesuffix(".__init__"))
        for name, cls in inspect.getmembers(module, inspect.isclass):
            bases = [base for base in cls.__mro__[1:] if base.__module__.startswith(LIBRARIES)]
            replaced = [
                key for key in vars(cls) if is_private(key) and any(hasattr(b, key) for b in bases)
            ]
            if cls.__module__ == module.__name__:
                assert [key for key in replaced if not key.startswith("_abc")] == [], name


@pytest.mark.parametrize(
    "source",
    [
        "import zarr.core.sync",
        "from zarr.core.buffer import Buffer",
        "from distributed.deploy._local import LocalCluster",
        "client.cluster._adaptive",
        'getattr(client.cluster, "_adaptive", None)',
    ],
)
def test_a_private_name_is_noticed(source):
    tree = ast.parse(source)
    assert [*private_modules(tree), *private_attributes(tree, OF_TUPLES)]
