"""Reference of the dataset, written from the variables themselves.

``python -m pipeline.store.reference`` prints the page.
"""

from __future__ import annotations

from collections.abc import Mapping

from pipeline.store.schema import (
    BULK_COLUMNS,
    BULK_FIELDS,
    COLUMNS,
    COORDINATES,
    FIELDS,
    RATE_COLUMNS,
    RECORDS,
    Variable,
)

_HEAD = """\
# The dataset

`xarray.open_zarr(OUT)` reads a store, and so does any program that knows Zarr;
`pipeline.open_sweep` gives the same with a check of its parts. All is in SI. Points that are not
done, and steps beyond a point's own, are NaN. This page is made from the variables by
`make reference`.

No variable holds a temperature. The rise above bulk is stored for a coefficient of friction of 1,
so that any friction and bulk temperature can be judged afterwards:

    temperature = bulk temperature + friction × rise

`max_rise` is the highest rise in the contact, `mean_rise` the mean, and `rise_quantile` the one
that a share of the contact stays below: at `quantile` 0.9 the one that 10 % of the contact exceeds,
which decides about severe wear unless the scene says otherwise. `pipeline.temperatures` gives them
as temperatures, also for bodies of unequal bulk temperature.

```python
import xarray as xr

ds = xr.open_zarr("results/irg_transition.zarr", chunks=None)
ds["rise_quantile"].sel(load=600, velocity=1.5)  # K at friction 1, by step and quantile
```

Write `ds["load"]` and `ds["quantile"]`: `ds.load` and `ds.quantile` are methods of xarray's. The
last step of a point below the highest load is not the last of the dimension:
`pipeline.end_of_point` takes each point's own. The scene, its hash, the versions and the preset are
attributes of the dataset. A sweep over `realizations` or `samples` has that dimension in front;
`over` gives a dimension for each of its entries, by its path.
"""
_TABLES: dict[str, Mapping[str, Variable]] = {
    "Coordinates": COORDINATES,
    "Variables of each point": RECORDS,
    "Variables at each step": COLUMNS,
    "Fields at the end of each point": FIELDS,
    "Variables of bodies that differ in bulk temperature": BULK_COLUMNS | BULK_FIELDS,
    "Variables of sweeps with `wear_rates`": RATE_COLUMNS,
}


def page() -> str:
    """Text of the page, in Markdown."""
    parts = [_HEAD]
    for title, variables in _TABLES.items():
        parts.append(
            f"\n## {title}\n\n| variable | dimensions | unit | meaning |\n|---|---|---|---|\n"
        )
        for name, variable in variables.items():
            dims, units = ", ".join(variable.dims), variable.units or ""
            parts.append(f"| `{name}` | {dims} | {units} | {variable.long_name} |\n")
    return "".join(parts)


if __name__ == "__main__":
    print(page(), end="")
