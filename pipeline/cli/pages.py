"""The command that prints the pages: a first hour, how-to pages, explanations and references."""

from __future__ import annotations

import argparse
import pydoc
import sys
from difflib import get_close_matches
from pathlib import Path

from pipeline.cli.exit_codes import DONE
from pipeline.cli.output import show
from pipeline.cli.parser import COMMANDS, parse
from pipeline.scene.shipped import WORKFLOWS
from tribo import InputError

_OF_SITE = {"index", "API", "COMMANDS", "GALLERY"}  # no text of their own to print
_NAMES = {"README": "paper"}
_SITE = WORKFLOWS.parent / "results" / "docs" / "index.html"


def help_(options: argparse.Namespace) -> int:
    """Print a page, the help of a command, or the names of all pages."""
    topic, pages = options.topic, _pages()
    if topic is None:
        titles = {name: _title(path) for name, path in pages.items()}
        lines = [f"irg help {name:12} {title}" for name, title in titles.items()]
        if _SITE.exists():
            lines.append(f"all of them as a site: {_SITE.as_uri()}")
        show(options, titles, ["pages:", *lines, "a command: irg COMMAND --help"])
        return DONE
    commands = [command.name for command in COMMANDS]
    if topic in commands:
        parse([topic, "--help"])
    page = _name(Path(topic))
    if page not in pages:
        near = get_close_matches(topic, [*pages, *commands], 1)
        meant = f' (did you mean "{near[0]}"?)' if near else ""
        raise InputError(f'no page or command is called "{topic}"{meant}; irg help lists them')
    text = pages[page].read_text(encoding="utf-8")
    if options.json:
        show(options, {"page": page, "text": text}, ())
    elif sys.stdout.isatty():
        pydoc.pager(text)
    else:
        print(text, end="")
    return DONE


def _pages() -> dict[str, Path]:
    """File of each page that can be printed, by the name to ask for it."""
    return {
        _name(path): path for path in sorted(WORKFLOWS.glob("*.md")) if path.stem not in _OF_SITE
    }


def _name(path: Path) -> str:
    """Name of a page, by its file or as it is typed."""
    return _NAMES.get(path.stem, path.stem.lower().replace("_", "-"))


def _title(path: Path) -> str:
    with path.open(encoding="utf-8") as lines:
        return next(line[2:].strip() for line in lines if line.startswith("# "))
