"""Page of Markdown with every result, its figure and the command for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from pipeline.analysis.tables import markdown_of
from workflows.paper.report import Report

_PAGE = Path(__file__).with_name("gallery.md")


def page(reports: Sequence[Report]) -> str:
    """Markdown of the gallery; figures lie beside it under the names of their results."""
    return _PAGE.read_text(encoding="utf-8").replace("<!-- results -->", "\n".join(_lines(reports)))


def _lines(reports: Sequence[Report]) -> Iterator[str]:
    yield "| result | | verdicts | takes about |"
    yield "|---|---|---|---|"
    for report in reports:
        agree = sum(finding.agrees for finding in report.findings)
        yield (
            f"| [{report.name}](#{report.name}) | {report.title} | "
            f"{agree} of {len(report.findings)} agree | {_about(report.seconds)} |"
        )
    for report in reports:
        name, title = report.name, report.title
        yield f"\n## {name}\n"
        yield f"{title[0].upper()}{title[1:]}. `python -m workflows.paper {name}`\n"
        yield f"![{title}]({name}.png)\n"
        yield from markdown_of(report.table)
        yield ""
        for finding in report.findings:
            verdict = "agrees" if finding.agrees else "differs"
            yield f"- **{verdict}** — *{finding.printed}*: {finding.computed}.{finding.reason}"
        yield f"\n{' '.join(report.notes)}"


def _about(seconds: float) -> str:
    """Round a duration.

    Examples
    --------
    >>> _about(0.3), _about(27.0), _about(130.0)
    ('1 s', '30 s', '2 min')
    """
    if seconds < 1:
        return "1 s"
    if seconds < 95:
        return f"{float(f'{seconds:.1g}'):g} s"
    return f"{seconds / 60:.0f} min"
