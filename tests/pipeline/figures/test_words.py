"""Words and numbers of a figure, as its reader sees them."""

import pytest

from pipeline.figures.studies import printed, signed
from pipeline.figures.style import as_text, entry_label


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        (as_text(r"worn by $\frac$" + chr(27)), r"worn by \$\frac\$"),
        (entry_label("disk.roughness.correlation_length"), "disk roughness:\ncorrelation length"),
        (signed(-0.125), "−12.5 %"),
        (signed(0.0), "0 %"),
        (printed("1.44e-06 mm^3/(N m)"), "1.44·10⁻⁶ mm³/(N m)"),
        (printed("3 um"), "3 µm"),
        (printed("145 degC"), "145 °C"),
    ],
)
def test_words_are_written_as_in_print(written, expected):
    assert written == expected
