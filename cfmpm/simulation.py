"""The nine steps of the method (paper section 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from cfmpm import mechanics
from cfmpm.body import body as bodies
from cfmpm.body.body import Body
from cfmpm.body.grid import Floats
from cfmpm.body.materials import lame_constants, region_materials
from cfmpm.clock import Clock
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.errors import SolveError
from cfmpm.fracture import growing, growth
from cfmpm.fracture.evaluation import evaluate_tips
from cfmpm.output.checkpoint import Start
from cfmpm.output.record import Record
from cfmpm.scene import Scene
from cfmpm.state import UNSOLVABLE, UNSTABLE, Result, State
from cfmpm.updated import reference, reset


def run(
    scene: Scene,
    announce: Callable[[str], None] = lambda phase: None,
    observe: Callable[[State, Record], None] = lambda state, record: None,
    start: Start | None = None,
) -> Result:
    """Solve a scene.

    Parameters
    ----------
    scene : Scene
    announce : callable, optional
        Called with the name of each phase (`GROWTH_PHASES`) as it begins.
    observe : callable, optional
        Called with each state of balance and the record so far.
    start : Start, optional
        Of a run of the same scene that was broken off; default: the scene's beginning.

    Returns
    -------
    Result

    Raises
    ------
    SceneError
        Where the scene turns out not to make sense on its grid.
    MeshError
        Where no grid could be made.
    SolveError
        Where there is no equilibrium to be found.

    Notes
    -----
    Small strain and linear elasticity need one solve for all load steps: Newton's loop (5) ends
    after one iteration, positions stay (6), and the grid is not reset (9).
    """
    clock = Clock(announce)
    with clock("grid"):  # step 1: grid with the cracks as doubled nodes, material points, loads
        start = start or Start.of(scene)
    body, record, decision, balance = start.body, start.record, start.decision, start.balance
    level, levels = start.level, mechanics.load_levels(body.scene)
    lame = lame_constants(body.scene, body.grid.region_names)
    g_c = [material.g_c for material in region_materials(body.scene, body.grid.region_names)]
    gradients: Floats | None = None
    while True:
        if gradients is None:
            with clock("points"):  # step 2: triangles of the points, basis gradients
                gradients = mechanics.prepare(body)
        with _step(len(record.steps) + 1):  # steps 3 to 6: stiffness, forces, balance, points
            before = balance if balance is not None and balance.finite else None
            try:
                balance = mechanics.solve(body, gradients, balance, levels[level], clock)
            except SolveError as error:
                ending = _ending_without_balance(error, body, record, balance, decision)
                if not ending:
                    raise
                break
            bodies.update_owners(body)
        with clock("fracture"):  # step 7: configurational force, J, K_I, K_II, T
            seen = reference.in_reference(body, gradients, balance)
            nodal = mechanics.nodal_force(*seen)
            plastic = mechanics.plastic_nodal_force(*seen)
            tips = evaluate_tips(seen[0], seen[1], lame, seen[2], nodal, g_c, plastic)
            tips |= reference.compare(body, gradients, balance)
            factor = balance.load_factor if balance.finite else levels[level]
            last, decision = (
                decision,
                growth.decide(
                    body.grid,
                    tips,
                    g_c,
                    scene.growth,
                    decision,
                    factor,
                    balance.scale(factor),
                    law=scene.fatigue,
                    grown=body.grown.segments,
                    blind=body.blind_tips,
                ),
            )
        record.add(seen[0], seen[2], tips, decision, clock.lap())
        state = State(seen[0], seen[2], nodal, decision, level, before, body)
        observe(state, record)
        if balance.stopped:
            ending = f"{UNSTABLE}: {balance.stopped}"
            break
        last_level = level + 1 == len(levels)
        ending = growth.ending(
            scene.growth,
            decision,
            body.grid.tips,
            len(record.steps),
            last_level=last_level,
            last=last,
            grown=body.grown.segments,
        )
        if ending:
            break
        if not decision.running:
            level += 1
            if body.motion is not None:
                try:
                    with clock("reset"):  # step 9: points where they have moved to, a grid for them
                        body, balance = reset.reset(body, balance)
                except SolveError as error:
                    ending = f"{UNSTABLE}: {error}"
                    break
                gradients = None
            continue
        with clock("release"):  # step 8: align segments, double nodes, redefine the grid
            try:
                body = growing.release(body, decision.running)
            except growing.GrowthEndError as end:
                severed = isinstance(end, growing.SeveredError)
                cut = record.add_severed(
                    end.triangulation,
                    clock.lap(),
                    decision,
                    end.grown,
                    "severed" if severed else "stopped",
                )
                ending = f"{end}; cut off by {' and '.join(cut)}" if severed else str(end)
                break
            balance = mechanics.carry_over(balance, state.grid, body.grid)
            gradients = None
    return Result(**vars(state), history=record.history(ending))


def _ending_without_balance(
    error: SolveError,
    body: Body,
    record: Record,
    balance: Equilibrium | None,
    decision: growth.Decision | None,
) -> str:
    """Say why a run ends where no balance was found; empty where that is a failure."""
    growth_ = body.scene.growth
    if record.steps and growth_ and growth_.transfer == "paper":
        record.add_severed(body.triangulation, {}, decision, body.grown, "stopped")
        return f"{UNSOLVABLE}: growth.transfer: paper took stiffness away; {error}"
    if record.steps and balance is not None and balance.finite:
        return f"{UNSTABLE}: {error}"
    return ""


@contextmanager
def _step(number: int) -> Iterator[None]:
    """Let the message of a failed solve begin with the number of its step."""
    try:
        yield
    except SolveError as failure:
        raise SolveError(f"step {number}: {failure}") from failure
