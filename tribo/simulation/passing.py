"""Contacts with the disk at other positions, if too few elements touch at one position."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import replace

from tribo.simulation.disk_positions import Pass, further_positions, separation_at
from tribo.simulation.loading_step import guess_pressure, solve_pass
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.types import Array
from tribo.wear import Stage


def solve_positions(scene: Scene, state: State) -> State:
    """Solve the contact at further positions of the disk, to average the heat over them.

    Returns `state` with the pressures at these positions, `State.passing`; unchanged if one
    position is enough. Its pressure and wear remain those with the unshifted disk.
    """
    stage, contacts = Stage(state.normal_load, 0.0, 0.0), []
    shifts = further_positions(scene, state.normal_load)
    guesses: Iterable[Array] = itertools.repeat(state.pressure, len(shifts))
    if scene.wears_by_strips:
        shapes = (separation_at(scene, shift) + state.wear_depth for shift in shifts)
        guesses = guess_pressure(scene, state, shapes)
    for shift, guess in zip(shifts, guesses, strict=True):
        contact, _ = solve_pass(scene, state, Pass(stage, shift), None, state.wear_depth, guess)
        contacts.append(contact)
    if not contacts:
        return state
    iterations = sum(contact.iterations for contact in contacts)
    return replace(
        state,
        passing=tuple(contact.pressure for contact in contacts),
        iterations=state.iterations + iterations,
        residual=max(state.residual, *(contact.residual for contact in contacts)),
        history=state.history or state,
    )
