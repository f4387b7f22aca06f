"""The commands ``irg new`` and ``irg help``."""

from __future__ import annotations

import argparse
import pydoc
import re
import sys
from pathlib import Path

import pipeline
from pipeline.cli.output import Result
from pipeline.cli.parser import commands, parse
from pipeline.shipped import PAGES_BY_TASK, page_name, shipped_pages, shipped_scenes
from pipeline.words import did_you_mean
from tribo import InputError


def new(options: argparse.Namespace) -> Result:
    """Answer ``irg new``: write a scene to start from, or list the shipped scenes."""
    if options.list:
        titles = {name: pipeline.load_scene(path).title for name, path in shipped_scenes().items()}
        return Result(titles, [f"{name:16} {title}" for name, title in titles.items()])
    if options.file is None:
        raise InputError("no file is named; give a file to write, such as: irg new scene.toml")
    scene, *copies = pipeline.new_scene(options.file, options.like)
    text = [
        f"{scene} is written" + "".join(f", {copy} copied" for copy in copies),
        f"its meaning and cost: irg check {scene}",
        f"its points: irg run {scene}",
    ]
    return Result({"file": str(scene), "copies": [str(copy) for copy in copies]}, text)


def help_(options: argparse.Namespace) -> Result:
    """Answer ``irg help``: print a page, the help of a command, or the names of all pages."""
    topic, pages = options.topic, shipped_pages()
    if topic is None:
        texts = {name: path.read_text(encoding="utf-8") for name, path in pages.items()}
        titles = {name: re.findall(r"(?m)^# (.+)", text)[0] for name, text in texts.items()}
        lines = [
            line
            for task, names in PAGES_BY_TASK.items()
            for line in (
                f"To {task}:",
                *(f"  irg help {name:12} {titles[name]}" for name in names if name in titles),
            )
        ]
        return Result(titles, [*lines, "Help on a command: irg COMMAND --help"])
    names = [command.name for command in commands()]
    page = page_name(Path(topic))
    if page not in pages:
        if topic in names:
            parse([topic, "--help"])
        meant = did_you_mean(topic, [*pages, *names])
        raise InputError(f'no page or command is called "{topic}"{meant}; irg help lists them')
    text = pages[page].read_text(encoding="utf-8")
    if sys.stdout.isatty() and not options.json:
        pydoc.pager(text)
        return Result({}, ())
    return Result({"page": page, "text": text}, [text.removesuffix("\n")])
