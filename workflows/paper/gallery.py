"""The gallery: a page of Markdown with every result, its figure and the command for it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from workflows.paper.printed import PAPER
from workflows.paper.report import Report, Table

_HEAD = f"""# Everything that the paper shows, computed

{PAPER}:
each of its figures and tables that a model can give, recomputed by one command and put beside what
the paper prints. This page and its figures are what the commands give:

```
irg reproduce --list                      # the names below
irg reproduce table4                      # the table, and where it agrees with the paper
irg reproduce table4 -o table4.png        # and its figure; --json for all numbers
irg reproduce table4 --surfaces 2 --preset draft    # a first look, in seconds
irg reproduce all -o workflows            # this page
```

Verdicts are computed, not written: `agrees` and `differs` follow from the numbers each time. The
paper prints few of its curves as numbers; where it does not, its sentences about them are put to
the test. Temperatures over several random surfaces are means ± one standard deviation.

Many of the numbers rest on one assumption: the lateral structure of the disk's roughness is not
published, and the correlation length of 4 µm is our choice; [sensitivity](#sensitivity) shows how
much depends on it. In one thing we depart from the paper: wear is *swept*, since the disk moves,
where the paper wears the pin by the pressure of one and the same patch; [table4](#table4) has both.
"""

_SCENES = Table(
    ("scene", "what", "shown by"),
    (
        ("first_try", "the diagram in a few seconds", "`irg run`, `irg plot`"),
        ("irg_transition", "the paper's system: Fig. 10, Table 4", "`make diagram`"),
        ("fig4", "a smooth cylinder", "`irg reproduce fig4`"),
        ("fig5", "a ramp and a hold", "`irg reproduce fig5`"),
        ("fig8", "a recorded load; the record is synthetic", "`irg reproduce fig8`"),
        ("oil_a", "oil A at 25 °C", "`irg reproduce table6`"),
        ("oil_a_hot", "oil A at 100 °C", "`irg reproduce table6`"),
    ),
)

_OPTIONS_HEAD = """Each may be set without a change of the file, such as
`irg point workflows/first_try.toml --load "600 N" --velocity "1.5 m/s" --set wear.pattern=local`.
Measured transitions of another lubricant go into `[[measured]]`; `irg infer` then finds its
critical temperature as `irg reproduce inverse` does."""

_OPTIONS = Table(
    ("in the paper", "entry of a scene", "what else there is"),
    (
        (
            "compensation of the leakage (Fig. 3)",
            '`fidelity.kernel = "nearest-image"`',
            '`"periodic"`: all images',
        ),
        (
            "the same compensation in the heat",
            '`fidelity.heat_kernel = "nearest-image"`',
            '`"pin"`: as long as the pin; `"endless"`',
        ),
        (
            "explicit wear (Fig. 2)",
            '`fidelity.wear_scheme = "explicit"`',
            '`"implicit"`; `"sdirk2"`, of second order',
        ),
        ("wear by the local pressure, Eq. (26)", '`wear.pattern = "local"`', '`"swept"`'),
        (
            "heat taken to act since the start, Eq. (29)",
            '`fidelity.heat_model = "elapsed"`',
            '`"history"`: all heat at its own time',
        ),
        (
            "direct heat partition, Eq. (30)",
            '`fidelity.partition = "direct"`',
            '`"local"`: the same, iteratively; `"uniform"`: Blok\'s',
        ),
        (
            "pressure change as error, Eq. (24)",
            '`fidelity.contact_criterion = "pressure-change"`',
            '`"gap"`',
        ),
        ("moving average of the surface", '`fidelity.averaging = "mean"`', '`"sample"`'),
        ("maximum temperature (Blok)", "`temperature.failing_share = 0`", "`0.1`"),
        ("a recorded load (Fig. 8)", '`loading.file = "record.csv"`', "`loading.rate`"),
        ("its linear fit (Fig. 8)", "`loading.fit = true`", "the record itself"),
        ("constant load after the ramp (Fig. 5)", '`loading.hold = "4 s"`', "no hold"),
        ("all of its numerical choices", '`fidelity.preset = "as-published"`', '`"standard"` …'),
    ),
)


def page(reports: Iterable[Report]) -> str:
    """Markdown of the gallery; figures lie beside it under the names of their results."""
    reports = list(reports)
    lines = [_HEAD, "| result | | verdicts | takes about |", "|---|---|---|---|"]
    for report in reports:
        agree = sum(finding.agrees for finding in report.findings)
        lines.append(
            f"| [{report.name}](#{report.name}) | {report.title} | "
            f"{agree} of {len(report.findings)} agree | {_about(report.seconds)} |"
        )
    for report in reports:
        lines += ["", *_section(report)]
    links = ((f"[`{name}.toml`]({name}.toml)", what, how) for name, what, how in _SCENES.rows)
    lines += ["", "## Scenes", "", *Table(_SCENES.columns, tuple(links)).markdown()]
    lines += [
        "",
        "## The paper's methods as options",
        "",
        _OPTIONS_HEAD,
        "",
        *_OPTIONS.markdown(),
        "",
    ]
    return "\n".join(lines)


def _section(report: Report) -> Iterator[str]:
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
        why = f" {finding.why}" if finding.why else ""
        yield f"- **{verdict}** — *{finding.printed}*: {finding.computed}.{why}"
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
