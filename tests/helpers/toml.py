"""Values as TOML, for scenes that tests write."""

import json
import re

_BARE_KEY = re.compile("[A-Za-z0-9_-]+")


def as_toml(value):
    """Write a value as TOML."""
    match value:
        case dict():
            keys = (key if _BARE_KEY.fullmatch(key) else as_toml(key) for key in value)
            items = map(" = ".join, zip(keys, map(as_toml, value.values()), strict=True))
            return f"{{ {', '.join(items)} }}"
        case list():
            return f"[{', '.join(map(as_toml, value))}]"
        case float():
            return short if float(short := f"{value:g}") == value else repr(value)
    return json.dumps(value, ensure_ascii=False, default=str)
