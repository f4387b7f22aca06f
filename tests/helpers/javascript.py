"""The computing scripts of a page, run by Node on what the page of a sweep holds."""

import json
import math
import shutil
import subprocess
from pathlib import Path

import pipeline.page
from pipeline.page.content import content
from tests.helpers.browser import absent

_FOLDER = Path(pipeline.page.__file__).parent
_SCRIPTS = (
    "numbers", "field", "plot", "state", "conditions", "margin", "operating",
    "tables", "diagram",
)  # fmt: skip
_STUB = """
const held = JSON.parse(require("fs").readFileSync(0, "utf8"));
const document = { getElementById: () => ({ textContent: held.content }) };
"""


def run(ds, script, argument=None):
    """Result of a script that can use the page's functions and `argument`; null becomes NaN."""
    node = shutil.which("node")
    if node is None:
        absent("no node")
    sources = [(_FOLDER / f"{name}.js").read_text("utf-8") for name in _SCRIPTS]
    ask = f"const result = ((argument) => {{ {script} }})(held.argument);"
    code = "\n".join(
        ['"use strict";', _STUB, *sources, ask, "console.log(JSON.stringify(result));"]
    )
    done = subprocess.run(
        [node, "-e", code],
        input=json.dumps({"content": json.dumps(content(ds, 0)), "argument": argument}),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return _with_nan(json.loads(done.stdout))


def _with_nan(value):
    if isinstance(value, list):
        return [_with_nan(item) for item in value]
    if isinstance(value, dict):
        return {key: _with_nan(item) for key, item in value.items()}
    return math.nan if value is None else value
