"""The nine steps of the method as functions that take and return one record (paper section 4.2)."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from typing import Any

from cfmpm import mechanics
from cfmpm.body.body import Body
from cfmpm.build import build
from cfmpm.clock import Clock
from cfmpm.ending import LastCracks, RunEnded
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.errors import SolveError
from cfmpm.fracture import growing, growth
from cfmpm.fracture.critical_load import TipsByFactor, critical_load_factors, presses
from cfmpm.fracture.evaluation import evaluate_tips
from cfmpm.registry.criteria import DEFAULT_DIRECTION
from cfmpm.scene import Scene, expand
from cfmpm.state import Stage, State
from cfmpm.updated import reference, regrow
from cfmpm.updated import reset as resets


def begin(scene: Scene, fixed: Collection[str] = ()) -> Stage:
    """Make the grid, with cracks as doubled nodes, the material points and the loads (step 1).

    Parameters
    ----------
    scene : Scene
    fixed : collection of str
        Names of the loads that act in full at every load factor; the others are proportional to it.
    """
    full, body = expand(scene), build(scene, fixed)
    return Stage(full, resets.begin(body, full) if full.formulation == "updated" else body)


def locate(at: Stage, clock: Clock) -> Stage:
    """Find the triangles of the points and evaluate the basis gradients on a new grid (step 2)."""
    if at.gradients is not None:
        return at
    with clock("points"):
        body, gradients = mechanics.locate(at.body)
        return replace(at, body=body, gradients=gradients)


def solve(at: Stage, before: State | None, clock: Clock) -> Equilibrium:
    """Solve for equilibrium at the load step and update the points (steps 3 to 6).

    Parameters
    ----------
    at : Stage
        From `locate`.
    before : State or None
        The last state of equilibrium of this run.
    clock : Clock

    Returns
    -------
    Equilibrium

    Raises
    ------
    RunEnded
        If no state of equilibrium follows the one before.
    SolveError
        If there is no first state of equilibrium.
    """
    assert at.gradients is not None
    body, factor = at.body, mechanics.load_levels(at.scene)[at.level]
    seeks_load = at.scene.growth is not None and at.scene.growth.control == "crack"
    # The load at which the next crack grows is near the last one; of the first none is known.
    reach = None
    if seeks_load:
        reach = math.inf if at.decision is None else at.decision.load_factor
    if seeks_load and at.decision is not None and not body.loading.is_proportional:
        factor = at.decision.load_factor
    try:
        balance = mechanics.solve(at.scene, body, at.gradients, at.balance, factor, clock, reach)
        if seeks_load and balance.parts is not None and body.grid.tips:
            return _at_growth(at, balance, clock)
    except SolveError as failure:
        error = SolveError(f"step {at.step}: {failure}")
        if before is None:
            raise error from failure
        settings = at.scene.growth
        if body.motion is not None and body.empty_elements:
            text = (
                f"unstable: {body.empty_elements} triangles inside the body have lost their "
                f"material points by resets of the grid; {failure}"
            )
            raise RunEnded("unstable", text) from failure
        if settings is not None and settings.transfer == "paper" and body.motion is None:
            text = f"unsolvable: growth.transfer: paper left nodes without stiffness; {failure}"
            cracks = LastCracks(body.triangulation, body.grown)
            raise RunEnded("unsolvable", text, cracks=cracks) from failure
        if before.balance.finite:
            raise RunEnded("unstable", f"unstable: {failure}") from failure
        raise error from failure
    if before is not None and _turned_away(before, body, balance):
        raise RunEnded(
            "unstable",
            "unstable: as a crack grew, the loads turn away the body, whose rotation no support "
            "holds",
        )
    return balance


def _turned_away(before: State, body: Body, balance: Equilibrium) -> bool:
    """Whether growth at a load that is held has left no balance that the body can turn to."""
    grown = balance.finite and balance.load_factor == before.balance.load_factor
    was = mechanics.leans(before.body, before.balance)
    return grown and not was and mechanics.leans(body, balance)


def _at_growth(at: Stage, balance: Equilibrium, clock: Clock) -> Equilibrium:
    """Solve at the load factor at which the first tip grows, under fixed and proportional loads."""
    growing = at.scene.growth
    assert balance.parts is not None
    assert growing is not None
    assert at.gradients is not None
    with clock("fracture"):
        by_factor = TipsByFactor.of(at.body, at.gradients, balance.parts, growing.direction)
        factor, reason = growth.load_of_growth(at.body, by_factor, growing, at.decision)
    if presses(at.body, balance.parts, factor):
        reason = (
            f"at load factor {factor:.6g}, at which a crack would grow, crack faces are in "
            "contact, so that the states under fixed and proportional loads cannot be superposed"
        )
        return replace(balance, stopped=reason, is_last=False)
    if not math.isfinite(factor):
        return replace(balance, stopped=reason)
    return mechanics.solve(at.scene, at.body, at.gradients, None, factor, clock)


def evaluate(at: Stage, balance: Equilibrium, clock: Clock) -> State:
    """Evaluate configurational force, J, K_I, K_II and T, and decide on growth (step 7)."""
    assert at.gradients is not None
    body, scene = at.body, at.scene
    direction = DEFAULT_DIRECTION if scene.growth is None else scene.growth.direction
    factor, least = balance.load_factor, None
    if balance.proportional:
        factor = mechanics.load_levels(scene)[at.level]
    elif scene.fatigue is not None:
        least = _at_least_load(at, factor, clock)
    with clock("fracture"):
        seen = reference.in_reference(body, at.gradients, balance)
        nodal = mechanics.nodal_force(*seen)
        plastic = mechanics.plastic_nodal_force(*seen)
        tips = evaluate_tips(*seen, nodal, plastic, direction, stationary=scene.growth is None)
        tips |= reference.compare(body, at.gradients, balance)
        if balance.parts is not None and body.grid.tips:
            by_factor = TipsByFactor.of(body, at.gradients, balance.parts, direction)
            tips |= critical_load_factors(body, by_factor, balance.parts)
        decision = growth.decide(
            body.grid,
            tips,
            body.materials.g_c,
            scene.growth,
            at.decision,
            factor,
            balance.scale(factor),
            law=scene.fatigue,
            grown=body.grown.segments,
            unresolved=body.unresolved_tips,
            proportional=balance.proportional,
            least=least,
        )
    return State(
        body=seen[0],
        balance=seen[2],
        configurational_force=nodal,
        tips=tips,
        decision=decision,
        level=at.level,
        stage=replace(at, gradients=None, balance=_kept(at.balance)),
    )


def _at_least_load(at: Stage, greatest: float, clock: Clock) -> dict[str, Any]:
    """Evaluate the tips at the minimum load of a cycle."""
    assert at.scene.fatigue is not None
    assert at.gradients is not None
    factor = at.scene.fatigue.load_ratio * greatest
    least = mechanics.solve(at.scene, at.body, at.gradients, None, factor, clock)
    with clock("fracture"):
        nodal = mechanics.nodal_force(at.body, at.gradients, least)
        return evaluate_tips(at.body, at.gradients, least, nodal)


def _kept(balance: Equilibrium | None) -> Equilibrium | None:
    """The equilibrium from which to solve again; at small strain none is needed."""
    return balance if balance is not None and balance.finite else None


def check_end(at: Stage, balance: Equilibrium, state: State) -> None:
    """End the run if neither growth nor a further load step follows this state.

    Parameters
    ----------
    at : Stage
        The stage that was solved.
    balance : Equilibrium
    state : State

    Raises
    ------
    RunEnded
    """
    if balance.stopped:
        word = "unstable" if balance.is_last else "unsolvable"
        raise RunEnded(word, f"{word}: {balance.stopped}")
    scene, tips = at.scene, at.body.grid.tips
    pressure = state.tips.get("contact_pressure", [])
    growth.check_end(
        scene.growth,
        state.decision,
        tips,
        at.step,
        lengths=at.body.triangulation.crack_lengths,
        last_level=at.level + 1 == len(mechanics.load_levels(scene)),
        last=at.decision,
        grown=at.body.grown.segments,
        pressed=[tip.name for tip, p in zip(tips, pressure, strict=True) if p > 0.0],
    )


def reset(at: Stage, balance: Equilibrium, clock: Clock) -> Stage:
    """Keep the state of equilibrium; in the updated formulation, reset the grid (step 9).

    It precedes step 8, so that segments are aligned on a grid at rest.

    Raises
    ------
    RunEnded
        If the grid cannot be reset.
    """
    if at.body.motion is None:
        return replace(at, balance=balance)
    try:
        with clock("reset"):
            body, at_rest = resets.reset(at.body, balance)
    except SolveError as error:
        raise RunEnded("unstable", f"unstable: {error}") from error
    return replace(at, body=body, balance=at_rest, gradients=None)


def release(at: Stage, state: State, clock: Clock) -> Stage:
    """Align segments with the directions of growth and double the tip nodes (step 8).

    Raises
    ------
    RunEnded
        If a part of the body is severed, if a crack has reached a point of a load, or if the points
        lie outside the new grid.
    """
    assert at.balance is not None
    grows = state.decision.running, state.decision.tie
    with clock("release"):
        if at.body.motion is None:
            body = growing.release(at.scene, at.body, *grows)
            carried = mechanics.carry_over(at.balance, at.body.grid, body)
        else:
            try:
                body, carried = regrow.release(at.scene, at.body, at.balance, *grows)
            except SolveError as error:
                raise RunEnded("unsolvable", f"unsolvable: {error}") from error
    return Stage(at.scene, body, state.decision, at.step + 1, at.level, carried)


def advance(at: Stage, state: State) -> Stage:
    """Go to the next load step."""
    return replace(at, decision=state.decision, step=at.step + 1, level=at.level + 1)
