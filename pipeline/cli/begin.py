"""The commands ``irg new`` and ``irg help``."""

from __future__ import annotations

import argparse
import pydoc
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pipeline
from pipeline.cli.output import Result, pluralized
from pipeline.cli.parser import commands, parse
from pipeline.scene.library import library
from pipeline.shipped import PAGES_BY_TASK, page_name, shipped_pages, shipped_scenes
from pipeline.words import did_you_mean
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
    """Answer ``irg help``: print a page, the help of a command, or pages with a word."""
    topic, pages = options.topic, _pages()
    titles = {name: re.findall(r"(?m)^# (.+)", text)[0] for name, text in pages.items()}
    if topic is None:
        lines = [
            line
            for task, names in PAGES_BY_TASK.items()
            for line in (
                f"To {task}:",
                *(f"  irg help {name:12} {titles[name]}" for name in names if name in titles),
            )
        ]
        more = "Help on a command: irg COMMAND --help; pages with a word: irg help gear"
        return Result(titles, [*lines, more])
    page = page_name(Path(topic))
    if page not in pages:
        if topic in (command.name for command in commands()):
            parse([topic, "--help"])
        return _search(topic, pages)
    if sys.stdout.isatty() and not options.json:
        pydoc.pager(pages[page])
        return Result({}, ())
    return Result({"page": page, "text": pages[page]}, [pages[page].removesuffix("\n")])


def _pages() -> dict[str, str]:
    """Text of each page by name, with that of the library, which is made."""
    texts = {name: path.read_text(encoding="utf-8") for name, path in shipped_pages().items()}
    return texts | {"library": _library_page()}


def _library_page() -> str:
    """The library as Markdown: tables of materials and oils, and the sources of their numbers."""
    known, numbers = library(), {key: k for k, key in enumerate(library()["sources"], 1)}
    parts = ["# Materials and oils of the library", "", _LIBRARY]
    for kind in ("materials", "oils"):
        named = dict[int, list[str]]()
        for name, table in known[kind].items():
            named.setdefault(id(table), []).append(name)
        tables = {id(table): table for table in known[kind].values()}
        heads = list(dict.fromkeys(key for table in tables.values() for key in table))
        lines = _line(["name", *heads]), _line(["---"] * (1 + len(heads)))
        parts += ["", f"## {kind.capitalize()}", "", *lines]
        parts += [
            _line([", ".join(names), *(_cell(tables[key].get(head), numbers) for head in heads)])
            for key, names in named.items()
        ]
    sources = (f"{k}. {known['sources'][key]}" for key, k in numbers.items())
    parts += ["", "## Sources", "", *sources]
    return "\n".join(parts).replace("_", " ") + "\n"


_LIBRARY = (
    "Scenes take these values by name, material or oil. Numbers in brackets are sources,\n"
    "below. Hardness belongs to a heat treatment: give your own where it is known."
)


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cell(entry: Any, numbers: dict[str, int]) -> str:
    if entry is None:
        return "–"
    value, source = entry
    text = ", ".join(value) if isinstance(value, list) else str(value)
    return f"{text} [{numbers[source]}]"


def _search(topic: str, pages: dict[str, str]) -> Result:
    """Pages and scenes that have a word, those with the word in a heading first."""
    word = re.compile(rf"\b{re.escape(re.sub('s$', '', topic))}s?\b", re.IGNORECASE)
    found = list[tuple[int, str, str]]()
    for name, text in pages.items():
        heads = [" ".join(one) for one in re.findall(r"(?m)^(?:#+ (.+)|\*\*(.+?)\*\*)", text)]
        heads = [one.strip() for one in heads if word.search(one)]
        if count := len(word.findall(text)) + _HEAD * len(heads):
            where = heads[0] if heads else f"{pluralized(count, 'time', 'times')} in the text"
            found.append((count, f"irg help {name}", where))
    for name, path in shipped_scenes().items():
        text = path.read_text(encoding="utf-8")
        head = " ".join(line for line in text.splitlines() if line.startswith(("#", "title")))
        if word.search(f"{name.replace('_', ' ')} {head}"):
            title = text.partition("\n")[0].removeprefix("# ")
            found.append((_HEAD, f"irg new {name}.toml --from {name}", title))
    if not found:
        names = [command.name for command in commands()]
        meant = did_you_mean(topic, [*pages, *names])
        raise InputError(f'there is no page or command "{topic}"{meant}; irg help lists all')
    found.sort(key=lambda one: -one[0])
    lines = [f"{command}: {where}" for _, command, where in found]
    return Result({command: where for _, command, where in found}, lines)


_HEAD = 10  # occurrences in a text that one in a heading outweighs
