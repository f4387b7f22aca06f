"""The form of a page that sets conditions: sliders and fields."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pipeline.analysis.at import COLDEST_OIL, HOTTEST_OIL
from pipeline.quantities import shown_in
from pipeline.sweep.conditions import Conditions


@dataclass(frozen=True, slots=True)
class Control:
    """A condition that the reader sets by a slider or in a field.

    Slider and field show the SI value + ``offset``.
    """

    name: str
    label: str
    low: float  # lower end of the slider, as shown
    high: float  # upper end of the slider, as shown
    step: float
    offset: float = 0.0
    least: float | None = None  # limit in SI; a value below is refused with the message `fault`
    most: float | None = None  # limit in SI; a value above is refused
    fault: str = ""

    def html(self) -> str:
        """HTML of the slider and the field, with an empty element for an error message."""
        label = html.escape(self.label)
        return (
            f'<div class="control"><label for="{self.name}">{label}</label>\n<div class="pair">'
            f'<input type="range" id="{self.name}-range" min="{self.low:g}" max="{self.high:g}" '
            f'step="{self.step:g}" aria-label="{label}">'
            f'<input type="text" inputmode="decimal" id="{self.name}" '
            f'aria-describedby="{self.name}-fault"></div>\n'
            f'<p class="fault" id="{self.name}-fault" role="alert"></p></div>'
        )


def controls(conditions: Conditions, has_heat: bool, two_bulks: bool) -> list[Control]:
    """Controls for the conditions that can be changed on the page of a sweep.

    If not `has_heat`, friction must be 0. If `two_bulks`, the disk has its own bulk temperature.
    """
    cold = "must be 0: the sweep was computed without friction and heat"
    friction = Control(
        "friction", "friction coefficient", 0.0,
        max(0.3, math.ceil(20 * conditions.friction) / 10), 0.001, least=0.0,
        most=None if has_heat else 0.0, fault="must be at least 0" if has_heat else cold,
    )  # fmt: skip
    bulk = conditions.bulk_temperature
    disk = bulk if conditions.disk_temperature is None else conditions.disk_temperature
    form = [friction, _bulk("bulk_temperature", " of the pin" if two_bulks else "", bulk)]
    if two_bulks:
        form.append(_bulk("disk_temperature", " of the disk", disk))
    critical = conditions.critical_temperature
    form.append(_celsius("critical_temperature", "critical temperature [°C]", critical, 400.0))
    return form


def scene_choice(names: Sequence[str]) -> str:
    """HTML to select a scene of a sweep by its name; empty if there is only one scene."""
    if len(names) < 2:
        return ""
    listed = (f'<option value="{k}">{html.escape(name)}</option>' for k, name in enumerate(names))
    select = f'<select id="scene" autocomplete="off">{"".join(listed)}</select>'
    return f'<p class="screen"><label>values of the entries: {select}</label></p>\n'


def _celsius(name: str, label: str, value: float | None, high: float, **limits: Any) -> Control:
    """Control of a temperature, shown in °C; `value` is the scene's [K], None if it has none.

    The slider contains 0 °C, `high` [°C] and `value`. `limits` are the fields `least`, `most` and
    `fault` of `Control`: the range allowed [K], and the message on a value outside.
    """
    degrees = None if value is None else shown_in(value, "°C")
    low = 0.0 if degrees is None else min(0.0, 10.0 * math.floor(degrees / 10))
    high = high if degrees is None else max(high, math.ceil(1.5 * degrees))
    return Control(name, label, low, high, 0.5, offset=shown_in(0.0, "°C"), **limits)


def _bulk(name: str, of_body: str, value: float) -> Control:
    ends = (f"{shown_in(end, '°C'):.2f}".replace("-", "−") for end in (COLDEST_OIL, HOTTEST_OIL))
    fault = f"from {' to '.join(ends)} °C"
    limits = {"least": COLDEST_OIL, "most": HOTTEST_OIL, "fault": fault}
    return _celsius(name, f"bulk temperature{of_body} [°C]", value, 200.0, **limits)
