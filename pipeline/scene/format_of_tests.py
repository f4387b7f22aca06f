"""The format of tests in scene files: a point with its outcome, or one specimen in stages."""

from __future__ import annotations

from typing import Annotated as A
from typing import Any

from pipeline.scene.kinds import (
    BULK,
    FRICTION,
    HELD,
    LEVEL,
    LOAD,
    VELOCITY,
    OneOf,
    OneQuantity,
    Quantity,
    Scalar,
    Text,
    Whole,
)
from pipeline.scene.tables import Changes, Declared, Each, Either, List, table_of
from pipeline.sweep.case import OUTCOMES

NAME = Either(Text(), Whole(at_least=0))


# fmt: off
class TableFile(Declared):
    form_name = "table of rows"
    file: A[str,
        "Table as CSV or Excel, relative to the folder of the scene, with headings such as "
        "`load [N]`. A recorded load has `time [s]` and `load [N]`, tests have their entries."]
    decimal: A[str | None, OneOf((".", ",")), "Decimal mark of the file."] = None
    ignore: A[tuple[str, ...], List(Text(), distinct=True),
        'Headings of columns without a meaning here, such as ["date", "remark"].'] = ()

class EvenLevels(Declared):
    form_name = "even stages"
    first: A[Any, LEVEL, "Load or velocity of the first stage."]
    step: A[Any, LEVEL, "Difference between one stage and the next."]
    hold: A[float, HELD, "Time for which each stage is held."]

class Test(Declared):
    form_name = "entries"
    load: A[float | None, LOAD,
        "Normal load on the pin; left out where stages of load end the test."] = None
    velocity: A[float | None, VELOCITY,
        "Sliding velocity of the test; left out where stages of velocity end it."] = None
    outcome: A[str | None, OneOf(OUTCOMES),
        'Outcome at the end of the hold; "transition" if load or velocity was raised until wear '
        "became severe. Needed without `mild_up_to` and `severe_at`."] = None
    step: A[Any, OneQuantity((Quantity("0.25 m/s"), Quantity("50 N"))),
        "Step of velocity or of load by which a transition was reached: wear was still mild one "
        "step before."] = None
    stages: A[Any, Either(List(Each((LEVEL, HELD))), table_of(EvenLevels)),
        "Stages that the specimen passed, of load or of velocity, written as in `[loading]`; by "
        "default those of `[loading]`, whose rate leads from stage to stage."] = None
    mild_up_to: A[Any, Scalar(),
        "Highest mild stage, instead of the outcome: a load if `velocity` is given, a velocity if "
        "`load` is; give it alone if no stage was severe."] = None
    severe_at: A[Any, Scalar(),
        "Severe stage; use it alone if the very first stage was severe."] = None
    friction: A[float | None, FRICTION,
        "Measured coefficient of friction; by default the scene's."] = None
    bulk_temperature: A[float | None, BULK,
        "Bulk temperature of both bodies; by default the scene's."] = None
    with_: A[dict[str, Any] | None, Changes(),
        "Other entries of the scene that differ in this test, by their paths, such as "
        '`{ "wear.specific_wear_rate" = "3.7e-7 mm^3/(N m)" }`. The test is simulated with them. '
        "Critical temperature and area fraction, `[oil]` and `[model]` stay the scene's."] = None
    number: A[str | int | None, NAME,
        "Number or name of the test in the output; by default the next free number."] = None
# fmt: on
