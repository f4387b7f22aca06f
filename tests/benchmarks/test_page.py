"""Time of a page to draw a boundary anew while its reader moves a slider."""

import numpy as np

import pipeline
from tests.helpers import page_sweeps as sweeps
from tests.helpers import synthetic
from tests.helpers.browser import chromium

REDRAW = """
const times = [];
for (let k = 0; k < 15; k++) {
  const begun = performance.now();
  chosen.conditions.friction = 0.09 + 0.002 * k;
  update();
  times.push(performance.now() - begun);
}
return times;
"""


def test_redrawing(benchmark, tmp_path):
    ds = sweeps.over_equal_surfaces(
        synthetic.sweep(np.linspace(200, 750, 12), np.linspace(0.3, 6, 30)), 8
    )
    page = pipeline.explore(ds, tmp_path / "page.html").path
    with chromium() as browser:
        browser.get(page.as_uri())
        times = benchmark.pedantic(browser.execute_script, (REDRAW,), rounds=1)
    print(
        f"\n12 loads, 30 velocities and 8 surfaces: drawn anew in {np.median(times):.0f} ms, "
        f"{min(times):.0f} to {max(times):.0f} ms"
    )
