"""Simulation of one point of the transition diagram: contact, wear and heat of rough bodies.

The public names stand in ``__init__.pyi``. Each is loaded when it is first used, without a library
for that: this package needs NumPy and SciPy alone.
"""

import ast
import importlib
from pathlib import Path
from typing import Any


def _homes() -> dict[str, str]:
    """Module of each public name, by the stub."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = (line for line in stub.body if isinstance(line, ast.ImportFrom))
    return {name.name: f".{line.module or name.name}" for line in imports for name in line.names}


_HOMES = _homes()
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = importlib.import_module(_HOMES[name], __name__)
    found = home if _HOMES[name] == f".{name}" else getattr(home, name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return list(__all__)
