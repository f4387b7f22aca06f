"""Reference of the dataset, written from the table of its variables.

``python -m pipeline.store.reference`` prints the page.
"""

from __future__ import annotations

from pipeline.store.schema import (
    AT_END,
    BULK_COLUMNS,
    BULK_FIELDS,
    STEPPED,
    VARIABLES,
    is_coordinate,
)

_HEAD = """\
# The dataset

For whoever reads results with xarray or another program. After it you can select points and
stations, and turn a stored rise into a temperature.

`xarray.open_zarr(OUT)` reads a store, and so does any program that knows Zarr;
`pipeline.open_sweep` gives the same with a check of its parts. The notebook
[`stations.ipynb`](stations.ipynb) works with it. All is in SI. This page is made from
the variables by `make reference`.

```python
import xarray as xr

ds = xr.open_zarr("results/irg_transition.zarr", chunks=None)
ds["max_rise"].sel(step=0)  # K at friction 1, at the end of every point
ds["rise_quantile"].sel(load=600, velocity=1.5, cooler_share=0.9)  # along the way to one point
ds["wear_depth_max"].sel(step=0).interp(load=500, velocity=1.8)
```

## Stations

`step` counts the stations of a point back from its end: 0 is the end of every point, −1 the station
before. At each station every variable is finite. Before a point's first station all are NaN, and so
are points that are not done; `steps` counts a point's own stations.

| `[sweep] steps` | stations besides those that decide | cost |
|---|---|---|
| `"loads"`, the default of a ramp | the lower loads when the store was made | none |
| a number | so many, even in time | four take 1.25 times as long, eight 1.6 to 2.0 |
| `"all"` | each step of the ramp, of a record or of a hold | a temperature for each |
| `"end"`, the default of samples, records, holds and searches of the boundary | none | none |

The moment at which the load is reached decides, and so does the end of a hold. On a ramp a station
is the end of the point at that load, bit for bit; a load that failed is no station. `irg check`
counts the cost.

## Temperatures

No variable holds a temperature. The rise above bulk is stored for a coefficient of friction of 1,
so that any friction and bulk temperature can be judged afterwards:

    temperature = bulk temperature + friction × rise

`max_rise` is the highest rise in the contact, `mean_rise` the mean, and `rise_quantile` the one
that a share of the contact stays below: at `cooler_share` 0.9 the one that 10 % of the contact
exceeds, which decides about severe wear unless the scene says otherwise. `pipeline.temperatures`
gives them as temperatures, also for bodies of unequal bulk temperature.

## Axes

Loads, velocities and other numbers ascend, also while a store grows: values between those that are
there make a larger store, which takes the place of the old one. A dataset of `open_sweep` that was
opened before says so and asks to be opened again. With plain xarray open the store again where the
attribute `generation` has changed. An object store cannot be replaced so: there values can be added
at the ends alone.

Write `ds["load"]`: `ds.load` is a method of xarray's. The scene, its hash, the versions and the
preset are attributes of the dataset.

## Variants

In front of load and velocity stand the dimensions of the table of variants: `realization` for
surfaces, `wear_rate` for `wear_rates`, and one for each entry in `over`, by its path.
`pipeline.at_wear_rate` takes a sweep at one of the wear rates, or between two. Rows that are no
full product, such as pairs and samples, stand along one dimension, `variant`. Their labels are
coordinates along it, and so are `velocity` and `load` where each row has its own:

```python
samples = xr.open_zarr("results/samples.zarr", chunks=None)
samples.sel(step=0).set_index(variant="sample").sel(variant=5)
samples.sel(step=0).groupby_bins("velocity", 4).mean()
```
"""
_WITH = {
    "Variables of bodies that differ in bulk temperature": BULK_COLUMNS.keys() | BULK_FIELDS,
}
_OTHERS = "Fields at the end of each point", "Variables at each station", "Variables of each point"


def _title(name: str) -> str:
    """Title of the table that a variable stands in."""
    if is_coordinate(name):
        return "Coordinates"
    special = (title for title, names in _WITH.items() if name in names)
    fields, stations, points = _OTHERS
    usual = fields if name in AT_END else stations if name in STEPPED else points
    return next(special, usual)


def page() -> str:
    """Text of the page, in Markdown: every variable of `VARIABLES`, each in one table."""
    tables: dict[str, list[str]] = {}
    for name, variable in VARIABLES.items():
        dims, units = ", ".join(variable.dims), variable.units or ""
        row = f"| `{name}` | {dims} | {units} | {variable.long_name} |\n"
        tables.setdefault(_title(name), []).append(row)
    head = "| variable | dimensions | unit | meaning |\n|---|---|---|---|\n"
    parts = (f"\n## {title}\n\n{head}{''.join(rows)}" for title, rows in tables.items())
    return _HEAD + "".join(parts)


if __name__ == "__main__":
    print(page(), end="")
