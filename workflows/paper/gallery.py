"""Page of Markdown with every result, its figure and the command for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from workflows.paper.report import Report

_PAGE = Path(__file__).with_name("gallery.md")


def page(reports: Sequence[Report]) -> str:
    """Markdown of the gallery; figures lie beside it under the names of their results."""
    lines = [*_summary(reports), *(line for report in reports for line in _section(report))]
    results = "\n".join(lines)
    return _PAGE.read_text(encoding="utf-8").replace("<!-- results -->", results)


def _summary(reports: Sequence[Report]) -> Iterator[str]:
    yield "| result | | verdicts | takes about |"
    yield "|---|---|---|---|"
    for report in reports:
        agree = sum(finding.agrees for finding in report.findings)
        yield (
            f"| [{report.name}](#{report.name}) | {report.title} | "
            f"{agree} of {len(report.findings)} agree | {_about(report.seconds)} |"
        )


def _section(report: Report) -> Iterator[str]:
    yield ""
    yield f"## {report.name}"
    yield ""
    yield f"{report.title[0].upper()}{report.title[1:]}. `irg reproduce {report.name}`"
    yield ""
    yield f"![{report.title}]({report.name}.png)"
    yield ""
    yield from report.table.markdown()
    yield ""
    for finding in report.findings:
        verdict = "agrees" if finding.agrees else "differs"
        yield f"- **{verdict}** — *{finding.printed}*: {finding.computed}.{finding.reason}"
    yield ""
    yield " ".join(report.notes)


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
