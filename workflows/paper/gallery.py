"""Page of Markdown with every result, its figure and the command for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from pipeline.answers.tables import markdown_of

from .report import WORDS, Report

_PAGE = Path(__file__).parents[1] / "README.md"
_BEGIN, _END = "<!-- results: written by the command -->\n", "\n<!-- end of results -->"


def page(reports: Sequence[Report]) -> str:
    """Markdown of the gallery: the shipped page, with the results replaced by `reports`.

    Figures lie beside it under the names of their results. A table that shows the same as its
    figure (``drawn`` in `WORDS`) is left out; the command prints it.
    """
    before, _, rest = _PAGE.read_text(encoding="utf-8").partition(_BEGIN)
    after = rest.partition(_END)[2]
    return before + _BEGIN + "\n".join(_lines(reports)) + _END + after


def _lines(reports: Sequence[Report]) -> Iterator[str]:
    yield "Statements that agree: " + ", ".join(map(_agreement, reports)) + "."
    for report in reports:
        name, title = report.name, report.title
        yield f"\n## {name}\n"
        yield f"{title[0].upper()}{title[1:]}{'.' * (title[-1] != '?')}\n"
        yield f"![{name}]({name}.png)\n"
        yield f"*{WORDS[name]['see']}*\n"
        if not WORDS[name].get("drawn"):
            yield from markdown_of(report.table)
            yield ""
        for finding in report.findings:
            verdict = "agrees" if finding.agrees else "differs"
            yield f"- **{verdict}** *{finding.printed}*: {finding.computed}.{finding.reason}"
        yield f"\n{' '.join(filter(None, report.notes))}"


def _agreement(report: Report) -> str:
    """Link to a result, and the number of its statements that agree with the paper."""
    agree = sum(finding.agrees for finding in report.findings)
    return f"[{report.name}](#{report.name}) {agree} of {len(report.findings)}"
