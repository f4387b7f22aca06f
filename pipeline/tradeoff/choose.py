"""Choose the cheapest fidelity that keeps the error of a scene's boundary within a bound."""

from __future__ import annotations

from dataclasses import replace

from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.scene.units import share_of
from pipeline.scene.written import with_fidelity
from pipeline.store.place import PathLike, StoreMismatchError
from pipeline.store.root import find_sweep
from pipeline.sweep.model import Sweep
from pipeline.sweep.selection import Selection
from pipeline.sweep.stages import Report
from pipeline.tradeoff.trade import USUAL, trade
from tribo import PRESETS, ConvergenceError, InputError


def choose_accuracy(
    sweep: SceneLike,
    accuracy: float | str,
    store: PathLike | None = None,
    progress: Report | None = None,
) -> Sweep:
    """Return a sweep with the cheapest fidelity that keeps the critical velocity within `accuracy`.

    A fidelity is a set of numerical choices, and `accuracy` a relative error, such as 0.02 or "2%".
    An existing store keeps its fidelity. Raises a `StoreMismatchError` if this fidelity is less
    accurate, or if its error was not measured.
    """
    sweep, accuracy = sweep_of(sweep), share_of(accuracy)
    stored = None if store is None else find_sweep(store)
    selection = stored and stored.selection
    if stored and not selection:
        raise StoreMismatchError(
            f"{store} was computed with the scene's own fidelity, not one picked for its "
            "accuracy; leave out --accuracy to go on with it, or write to another store with -o"
        )
    if not selection:
        selection = choose_fidelity(sweep, accuracy, progress)
    elif selection.error > accuracy:
        raise StoreMismatchError(
            f"{store} was computed with {selection.name}, whose boundary may be off by "
            f"{100 * selection.error:.2g} %; write to another store for {100 * accuracy:g} %"
        )
    preset = selection.name if selection.fidelity == PRESETS.get(selection.name) else None
    return replace(with_fidelity(sweep, selection.fidelity, preset), selection=selection)


def measure_error(sweep: Sweep, store: PathLike, progress: Report) -> Sweep:
    """Measure the relative error that a sweep's numerical choices cause in the critical velocity.

    Returns a copy of the sweep whose field `selection` has this error. If the store at the path
    `store` already has such an error, it is used instead of a new measurement.
    """
    stored = find_sweep(store)
    selection = (stored and stored.selection) or choose_fidelity(sweep, None, progress)
    return replace(sweep, selection=selection)


def choose_fidelity(
    sweep: SceneLike, accuracy: float | str | None, progress: Report | None = None
) -> Selection:
    """Find the cheapest fidelity whose measured error of the critical velocity is within a bound.

    The candidates are the presets and the scene's own fidelity, measured by `trade`. If no
    candidate is within the bound, ``reference`` is taken. The scene's heat model is kept.

    Parameters
    ----------
    sweep : Sweep, str or path
        Scene to choose for, or its path or name.
    accuracy : float or str or None
        Largest relative error of the critical velocity, such as 0.02 or ``"2%"``. None keeps the
        scene's own fidelity, and measures its error.
    progress : callable, optional
        Called with a `Progress` before each measurement.

    Raises
    ------
    InputError
        If the accuracy is not between 0 and 1, or there is no friction heat.
    ConvergenceError
        If the reference does not converge; or, if `accuracy` is None, the scene's own fidelity.

    Examples
    --------
    >>> import pipeline
    >>> selection = pipeline.choose_fidelity("first_try", accuracy="5%")  # doctest: +SKIP
    >>> print(selection)  # doctest: +SKIP
    """
    sweep = sweep_of(sweep)
    accuracy = None if accuracy is None else share_of(accuracy)
    if accuracy is not None and not 0 < accuracy < 1:
        raise InputError(f"accuracy is {accuracy!r}; it must be between 0 and 1, such as 0.02")
    table = trade(sweep, () if accuracy is None else USUAL, progress)
    if accuracy is None and table.not_converged:
        raise ConvergenceError(table.not_converged[0], None)
    picked = table.choices[0] if accuracy is None else table.cheapest(accuracy)
    error = picked.error_at_any_load
    return Selection(accuracy, picked.name, picked.fidelity, error, table.choices)
