"""A fidelity that was picked for its accuracy, and why; stored with what it computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from tribo import Fidelity

__all__ = ["KEPT_FIELDS", "Selection", "Trial"]

KEPT_FIELDS = ("temperature_interval", "heat_model")
"""What a scene keeps of its own fidelity: what it asks to see, and by which physics."""


@dataclass(frozen=True, slots=True)
class Trial:
    """A fidelity that was tried, and by how much it moves the boundary velocity at most.

    Attributes
    ----------
    name : str
    fidelity : Fidelity
    error : float
        Relative, to expect at any load.
    work : float
        Of its points, in elements times convolutions.
    """

    name: str
    fidelity: Fidelity
    error: float
    work: float


@dataclass(frozen=True, slots=True)
class Selection:
    """The fidelity that was picked, and why.

    Attributes
    ----------
    accuracy : float
        That was asked for, relative, of the boundary velocity.
    name : str
    fidelity : Fidelity
    error : float
        To expect at most, from those measured and what the yardstick itself may err; 0 for the
        reference.
    yardstick : str
        What the error was measured against.
    trials : tuple of Trial
        What was tried, from cheap to dear; the last one was picked.
    points : tuple of (float, float)
        Where: loads [N] and velocities [m/s].
    saving : float
        How many times less work than the yardstick takes.
    work : float
        Of the whole probe, in elements times convolutions.
    seconds : float
        That the probe took.
    """

    accuracy: float
    name: str
    fidelity: Fidelity
    error: float
    yardstick: str
    trials: tuple[Trial, ...]
    points: tuple[tuple[float, float], ...]
    saving: float
    work: float
    seconds: float

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        places = [{"load": load, "velocity": velocity} for load, velocity in self.points]
        trials = [asdict(trial) for trial in self.trials]
        return asdict(self) | {"points": places, "trials": trials}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Selection:
        """Return what `as_dict` was taken of."""
        trials = (trial | {"fidelity": Fidelity(**trial["fidelity"])} for trial in data["trials"])
        given = {
            "fidelity": Fidelity(**data["fidelity"]),
            "trials": tuple(Trial(**trial) for trial in trials),
            "points": tuple((place["load"], place["velocity"]) for place in data["points"]),
        }
        return cls(**{**data, **given})

    def __str__(self) -> str:
        dropped = [f"{trial.name} errs by {100 * trial.error:.2g} %" for trial in self.trials[:-1]]
        why = f" ({', '.join(dropped)})" if dropped else ""
        return (
            f"accuracy {100 * self.accuracy:g} %: picked {self.name}, whose boundary errs by "
            f"{100 * self.error:.2g} % against {self.yardstick} with {self.saving:.2g} times less "
            f"work{why}; the probe took {self.seconds:.1f} s"
        )
