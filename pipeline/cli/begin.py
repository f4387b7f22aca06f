"""The commands that a user begins with: a scene to start from, a scan, and the pages."""

from __future__ import annotations

import argparse
import pydoc
import sys
from difflib import get_close_matches
from pathlib import Path

import pipeline
from pipeline.cli.output import Result
from pipeline.cli.parser import COMMANDS, parse
from pipeline.cli.progress import working
from pipeline.scene.editors import write_schema
from pipeline.scene.shipped import WORKFLOWS, shipped_scenes
from tribo import InputError

_OF_SITE = {"index", "API", "COMMANDS", "GALLERY"}  # no text of their own to print
_READING_ORDER = (
    "first-hour", "your-system", "your-tests", "choosing", "model", "physics", "scene", "dataset",
    "uncertain", "own-laws", "cluster", "accuracy", "measured", "extremes", "paper",
)  # fmt: skip
_NAMES = {"README": "paper"}
_SITE = WORKFLOWS.parent / "results" / "docs" / "index.html"


def new(options: argparse.Namespace) -> Result:
    """Write a scene to start from or the schema of scenes, or list those that are shipped."""
    if options.list:
        titles = {
            name: pipeline.load_scene(path).about.title for name, path in shipped_scenes().items()
        }
        return Result(titles, [f"{name:16} {title}" for name, title in titles.items()])
    if options.schema is not None:
        schema = write_schema(options.schema)
        use = f"editors use it in a scene beside it with the first line: #:schema ./{schema.name}"
        return Result({"file": str(schema)}, [f"{schema} is written", use])
    if options.file is None:
        raise InputError("no file is named; give one to write, such as: irg new scene.toml")
    scene, *copies = pipeline.new_scene(options.file, options.like, options.full)
    text = [
        f"{scene} is written" + "".join(f", {copy} copied" for copy in copies),
        f"its meaning and cost: irg check {scene}",
        f"its points: irg run {scene}",
    ]
    return Result({"file": str(scene), "copies": [str(copy) for copy in copies]}, text)


def surface(options: argparse.Namespace) -> Result:
    """Print the roughness of a scan, and the table of a scene that makes more of the same."""
    with working("fitting the spectrum"):
        scan = pipeline.surface_statistics(
            options.scan, options.height_unit, options.pixel_size, options.transpose
        )
    text = list(scan.lines())
    if scan.is_self_affine:
        text += ["", "more of the same, in a scene:", "", scan.toml.rstrip()]
    else:
        text.append(
            "no random roughness stands for it: give the scan itself, as disk.roughness.file"
        )
    return Result(scan.as_dict(), text)


def help_(options: argparse.Namespace) -> Result:
    """Print a page, the help of a command, or the names of all pages."""
    topic, pages = options.topic, _pages()
    if topic is None:
        titles = {name: _title(path) for name, path in pages.items()}
        lines = [f"irg help {name:12} {title}" for name, title in titles.items()]
        if _SITE.exists():
            lines.append(f"all of them as a site: {_SITE.as_uri()}")
        return Result(
            titles, ["pages, in the order of reading:", *lines, "a command: irg COMMAND --help"]
        )
    commands = [command.name for command in COMMANDS]
    if topic in commands:
        parse([topic, "--help"])
    page = _name(Path(topic))
    if page not in pages:
        near = get_close_matches(topic, [*pages, *commands], 1)
        meant = f' (did you mean "{near[0]}"?)' if near else ""
        raise InputError(f'no page or command is called "{topic}"{meant}; irg help lists them')
    text = pages[page].read_text(encoding="utf-8")
    if sys.stdout.isatty() and not options.json:
        pydoc.pager(text)
        return Result({}, ())
    return Result({"page": page, "text": text}, [text.removesuffix("\n")])


def _pages() -> dict[str, Path]:
    """File of each page that can be printed, by the name to ask for it."""
    return {
        _name(path): path
        for path in sorted(WORKFLOWS.glob("*.md"), key=_place)
        if path.stem not in _OF_SITE
    }


def _place(path: Path) -> tuple[int, str]:
    """Place of a page in the order of reading, those of no place last."""
    name = _name(path)
    known = name in _READING_ORDER
    return (_READING_ORDER.index(name) if known else len(_READING_ORDER), name)


def _name(path: Path) -> str:
    """Name of a page, by its file or as it is typed."""
    return _NAMES.get(path.stem, path.stem.lower().replace("_", "-"))


def _title(path: Path) -> str:
    with path.open(encoding="utf-8") as lines:
        return next(line[2:].strip() for line in lines if line.startswith("# "))
