"""Write the sizes of today."""

from tests.house.measure import SIZES, measured, written

SIZES.write_text(written(measured()), encoding="utf-8")
