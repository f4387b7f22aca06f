"""Contacts and heat with the disk at other positions, if too few elements touch at one position."""

from __future__ import annotations

from dataclasses import replace

from tribo.simulation.disk_positions import Pass, further_positions
from tribo.simulation.loading_step import solve_pass
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.temperature import add_temperature, mean_heat
from tribo.wear import Stage


def position_means(scene: Scene, before: State, state: State, velocity: float) -> State:
    """Solve the contact at further positions of the disk, to average the heat over them.

    Returns `state` with its temperature averaged over the positions, if it has a temperature. Else
    returns it with the pressures at these positions, `State.passing`. If one position is enough,
    `state` is returned unchanged. Its pressure and wear remain those with the unshifted disk.
    `before` is the state one step earlier, with the history of the heat, and `velocity` the sliding
    velocity [m/s].
    """
    stage, contacts = Stage(state.normal_load, 0.0, 0.0), []
    for shift in further_positions(scene, state.normal_load):
        contact, _ = solve_pass(
            scene, state, Pass(stage, shift), None, state.wear_depth, state.pressure
        )
        contacts.append(contact)
    if not contacts:
        return state
    iterations = sum(contact.iterations for contact in contacts)
    passing = replace(
        state,
        passing=tuple(contact.pressure for contact in contacts),
        iterations=state.iterations + iterations,
        residual=max(state.residual, *(contact.residual for contact in contacts)),
        history=state.history or state,
    )
    if state.heat is None:
        return passing
    shifted_heats = (
        add_temperature(scene, before, replace(state, pressure=pressure), velocity).heat
        for pressure in passing.passing
    )
    heat = mean_heat(
        [state.heat, *(shifted_heat for shifted_heat in shifted_heats if shifted_heat)]
    )
    return replace(passing, heat=heat, passing=())
