"""Pages of Markdown with the results: the gallery, and the comparison with the paper.

A block of a page stands between ``<!-- KIND: NAMES -->`` and ``<!-- end -->``. Kinds are
``figure``, a result with its figure and command; ``table``, the table of a result; and
``findings``, statements named as ``table4.width``, with their numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from pipeline.frames import markdown_of

from .report import WORDS, Finding, Report, texts

PAGES = "README.md", "REPRODUCING.md", "MODEL.md"
_FOLDER = Path(__file__).parents[1]
_BLOCK = re.compile(r"(<!-- (\w+): ([\w. ]+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
_COLUMNS = "result", "the paper", "computed", "verdict"


def pages(reports: Sequence[Report]) -> dict[str, str]:
    """Text of each page by its name: the shipped one, with what the `reports` say written again.

    Blocks and rows of other results stay as they are.
    """
    known = {report.name: report for report in reports}

    def written(block: re.Match[str]) -> str:
        begin, kind, names, old, end = block.groups()
        if kind == "findings":
            lines = _findings(known, names.split(), old.splitlines())
        elif names in known:
            is_table = kind == "table"
            lines = markdown_of(known[names].table) if is_table else _figure(known[names])
        else:
            return block[0]
        return begin + "\n".join(lines) + "\n" + end

    shipped = {name: (_FOLDER / name).read_text(encoding="utf-8") for name in PAGES}
    return {name: _BLOCK.sub(written, text) for name, text in shipped.items()}


def _figure(report: Report) -> Iterator[str]:
    name, words = report.name, WORDS[report.name]
    yield f"\n## {name}\n"
    yield f"**{words['paper']}**: {report.title}. `irg paper {name}`\n"
    yield f"![{name}]({name}.png)\n"
    yield f"*{words['see']}*\n"


def _findings(
    known: Mapping[str, Report], names: Sequence[str], old: Sequence[str]
) -> Iterator[str]:
    """Yield a table of statements, in the order of their names; `old` are its lines before."""
    before = dict(zip(names, old[2:], strict=False))
    yield from markdown_of(texts(_COLUMNS, ()))
    for name in names:
        result, _, statement = name.partition(".")
        if result not in known:
            yield before.get(name, f"| [{result}](README.md#{result}) | {statement} | | |")
            continue
        (found,) = (one for one in known[result].findings if one.name == statement)
        computed = f"{found.computed}.{found.reason}"
        row = f"[{result}](README.md#{result})", found.printed, computed, _verdict(found)
        *_, line = markdown_of(texts(_COLUMNS, [row]))
        yield line


def _verdict(found: Finding) -> str:
    return "agrees" if found.agrees else "**differs**"
