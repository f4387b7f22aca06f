"""The commands that need neither a scene nor a store: ``irg new`` and ``help``."""

from __future__ import annotations

import argparse
import pydoc
import re
import sys
from importlib import resources
from pathlib import Path

import pipeline
from pipeline.cli.output import Result
from pipeline.messages import did_you_mean
from pipeline.shipped import PAGES_BY_TASK, page_name, shipped_pages, shipped_scenes
from tribo import InputError


def new(options: argparse.Namespace) -> Result:
    """Answer ``irg new``: write a scene to start from, or list the shipped scenes."""
    if options.list:
        titles = {name: pipeline.load_scene(path).title for name, path in shipped_scenes().items()}
        return Result(titles, [f"{name:16} {title}" for name, title in titles.items()])
    if options.file is None:
        raise InputError("give the name of the file to write, such as: irg new scene.toml")
    scene, *copies = pipeline.new_scene(options.file, options.template)
    text = [
        f"{scene} is written" + "".join(f", {copy} copied" for copy in copies),
        f"to describe it and estimate its cost: irg check {scene}",
        f"to simulate its points: irg run {scene}",
    ]
    return Result({"file": str(scene), "copies": [str(copy) for copy in copies]}, text)


def help_(options: argparse.Namespace) -> Result:
    """Answer ``irg help``: print a page, the help of a command, or the titles of all pages."""
    topic = options.topic
    pages = {name: path.read_text(encoding="utf-8") for name, path in shipped_pages().items()}
    library = resources.files("pipeline.scene").joinpath("library.toml")
    pages["library"] = library.read_text(encoding="utf-8")
    if topic is None:
        titles = {name: re.findall(r"(?m)^# (.+)", text)[0] for name, text in pages.items()}
        lines = list[str]()
        for task, names in PAGES_BY_TASK.items():
            page_names = [name for name in names if name in titles]
            lines += [
                f"To {task}:",
                *(f"  irg help {name:12} {titles[name]}" for name in page_names),
            ]
        return Result(titles, [*lines, "Help on a command: irg COMMAND --help"])
    if topic in options.commands:
        options.commands[topic].print_help()
        return Result({}, ())
    page = page_name(Path(topic))
    if page not in pages:
        suggestion = did_you_mean(topic, [*pages, *options.commands])
        raise InputError(f'there is no page or command "{topic}"{suggestion}; irg help lists all')
    if sys.stdout.isatty() and not options.json:
        pydoc.pager(pages[page])
        return Result({}, ())
    return Result({"page": page, "text": pages[page]}, [pages[page].removesuffix("\n")])
