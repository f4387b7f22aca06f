"""Pages of Markdown with the results: the gallery, and the comparison with the paper.

A block of a page stands between ``<!-- KIND: NAMES -->`` and ``<!-- end -->``. Kinds are
``figure``, a result with its figure; ``table``, the table of a result; and
``findings``, statements named as ``table4.width``, with their numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from pipeline.frames import markdown_of
from tribo import InputError

from .recomputed import WORDS, Finding, Recomputation, texts

PAGES = "README.md", "REPRODUCING.md", "MODEL.md"
_FOLDER = Path(__file__).parents[1]
_BLOCK = re.compile(r"(<!-- (\w+): ([\w. ]+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
_COLUMNS = "result", "the paper", "computed", "verdict"


def pages(reports: Sequence[Recomputation]) -> dict[str, str]:
    """Text of each page by its name: the shipped one, with the blocks of `reports` written again.

    Blocks and rows of other results stay as they are. A statement that agrees may be on no page;
    one that differs must be on a page.
    """
    reports_by_name = {report.name: report for report in reports}
    shipped = {name: (_FOLDER / name).read_text(encoding="utf-8") for name in PAGES}
    blocks = [block for text in shipped.values() for block in _BLOCK.findall(text)]
    listed = {name for _, kind, names, *_ in blocks if kind == "findings" for name in names.split()}
    for report in reports:
        for finding in report.findings:
            name = f"{report.name}.{finding.name}"
            if not finding.agrees and name not in listed:
                raise InputError(
                    f"{name} differs from the paper, and is on no page; "
                    "add its name to a block of findings"
                )

    def rewrite(block: re.Match[str]) -> str:
        begin, kind, names, shipped_lines, end = block.groups()
        if kind == "findings":
            lines = _findings(reports_by_name, names.split(), shipped_lines.splitlines())
        elif names not in reports_by_name:
            return block[0]
        elif kind == "table":
            lines = markdown_of(reports_by_name[names].table)
        else:
            lines = _figure(reports_by_name[names])
        return begin + "\n".join(lines) + "\n" + end

    return {name: _BLOCK.sub(rewrite, text) for name, text in shipped.items()}


def _figure(report: Recomputation) -> Iterator[str]:
    name, words = report.name, WORDS[report.name]
    yield f"\n## {name}\n"
    yield f"**{words['paper']}**: {report.title}.\n"
    yield f"![{name}]({name}.png)\n"
    yield f"*{words['see']}*\n"


def _findings(
    reports_by_name: Mapping[str, Recomputation], names: Sequence[str], shipped_lines: Sequence[str]
) -> Iterator[str]:
    """Yield a table of the named statements; rows of results without a report are as shipped."""
    shipped_rows = dict(zip(names, shipped_lines[2:], strict=False))
    yield from markdown_of(texts(_COLUMNS, ()))
    for name in names:
        result, _, statement = name.partition(".")
        link = f"[{result}](README.md#{result})"
        if result not in reports_by_name:
            yield shipped_rows.get(name, f"| {link} | {statement} | | |")
            continue
        findings = {finding.name: finding for finding in reports_by_name[result].findings}
        finding = findings[statement]
        computed = f"{finding.computed}.{finding.reason}"
        *_, row = markdown_of(
            texts(_COLUMNS, [(link, finding.printed, computed, _verdict(finding))])
        )
        yield row


def _verdict(finding: Finding) -> str:
    return "agrees" if finding.agrees else "**differs**"
