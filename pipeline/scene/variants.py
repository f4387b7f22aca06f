"""Values of an entry of a scene, some of them in percent of its own."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from os import PathLike
from typing import Any

from pipeline.scene.scenefile import scene_entry
from tribo import InputError

_RELATIVE = re.compile(r"([+-]\d+(?:\.\d+)?)\s*%")
_QUANTITY = re.compile(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(.*)")


def absolute(
    scene: str | PathLike[str],
    key: str,
    values: Iterable[Any],
    overrides: Mapping[str, Any] | None = None,
) -> Iterator[Any]:
    """Values of an entry, those such as ``"+20%"`` as the scene's own value changed by so much.

    Examples
    --------
    >>> list(absolute("first_try", "pin.radius", ["1 mm", "+20%"]))
    ['1 mm', '2.4 mm']
    """
    for value in values:
        relative = _RELATIVE.fullmatch(value) if isinstance(value, str) else None
        if relative is None:
            yield value
            continue
        present = scene_entry(scene, key, overrides)
        factor = 1 + float(relative[1]) / 100
        if isinstance(present, int | float) and not isinstance(present, bool):
            yield float(f"{present * factor:.12g}")
        elif isinstance(present, str) and (parts := _QUANTITY.fullmatch(present)):
            if parts[2].startswith(("deg", "°", "C")):
                raise InputError(
                    f"{key}={value}: the scene gives {present}, and a percentage of a temperature "
                    "depends on its scale; give a value such as 150 degC"
                )
            yield f"{float(parts[1]) * factor:.12g} {parts[2]}"
        else:
            raise InputError(f"{key}={value}: the scene gives no number there; give a value")
