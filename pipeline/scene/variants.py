"""The table of variants that a scene asks for: small functions fill it, one for each way to ask."""

from __future__ import annotations

from typing import Any

from pipeline.scene.along import Pairs, along_of, pairs_of, with_first_row
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults
from pipeline.scene.over import over_of, with_first_values, with_rates_of
from pipeline.scene.unknown import Make, fixed_paths, samples_of
from pipeline.sweep.model import Sweep


def with_first_variant(document: Document, faults: Faults) -> tuple[Document, Pairs | None]:
    """The document with the values of the first row below all it has itself, and its pairs."""
    document = with_first_values(document)
    pairs = pairs_of(document, faults)
    return with_first_row(document, pairs), pairs


def with_variants(
    sweep: Sweep,
    tables: dict[str, Any],
    document: Document,
    pairs: Pairs | None,
    make: Make,
    faults: Faults,
) -> Sweep:
    """The sweep, on its random surfaces so far, with all rows of its table of variants.

    `make` reads the scene with other values of some entries; `InputError` is raised at a row that
    does not go with the scene, other faults are noted.
    """
    asked = tables["sweep"]
    over = over_of(asked["over"], sweep, make)
    samples = samples_of(tables, sweep, over, make, faults, fixed_paths(document))
    sweep = sweep.changed(variants=samples or over * sweep.variants)
    sweep = with_rates_of(asked["wear_rates"], sweep, faults.notes)
    return along_of(pairs, sweep, make) if pairs else sweep
