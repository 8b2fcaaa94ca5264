"""The nine steps of the method (paper section 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import xarray as xr

from cfmpm import body as bodies
from cfmpm import mechanics, updated
from cfmpm.body import Body
from cfmpm.clock import Clock
from cfmpm.equilibrium import Equilibrium
from cfmpm.errors import SolveError
from cfmpm.evaluation import evaluate_tips
from cfmpm.fracture import growth
from cfmpm.grid import Floats, Grid
from cfmpm.loading import Loading
from cfmpm.materials import lame_constants, region_materials
from cfmpm.points import MaterialPoints
from cfmpm.record import Origin, Record
from cfmpm.scene import Scene

PHASES = ("grid", "points", "stiffness", "equilibrium", "fracture")
GROWTH_PHASES = (*PHASES, "release")
RESET_PHASES = (*PHASES, "reset")
# How the ending begins of a run that no stable state goes on from.
UNSTABLE = "unstable"
# And of one that lost the stiffness that holds its nodes.
UNSOLVABLE = "unsolvable"


@dataclass(frozen=True)
class State:
    """A body in balance, at load factor one.

    Attributes
    ----------
    body : Body
    balance : Equilibrium
    configurational_force : (n, 2) float
        At the grid nodes [N/mm].
    decision : growth.Decision
        What the cracks do next.
    level : int
        Number of the load step.
    before : Equilibrium or None
        What finite deformation set out from, on the grid of the solve.
    solved : Body
        As it was solved: `body` itself, but where its grid is reset `body` is in the reference
        configuration.
    """

    body: Body
    balance: Equilibrium
    configurational_force: Floats
    decision: growth.Decision
    level: int
    before: Equilibrium | None
    solved: Body

    @property
    def scene(self) -> Scene:
        """The scene, expanded: with its geometry, loads and names."""
        return self.body.scene

    @property
    def grid(self) -> Grid:
        """The background grid."""
        return self.body.grid

    @property
    def points(self) -> MaterialPoints:
        """The material points."""
        return self.body.points

    @property
    def loading(self) -> Loading:
        """Loads and supports."""
        return self.body.loading

    @property
    def displacement(self) -> Floats:
        """Displacement of the grid nodes [mm], (n, 2)."""
        return self.balance.displacement


@dataclass(frozen=True)
class Result(State):
    """What a run leaves: its history, and the last state of balance.

    Attributes
    ----------
    history : xarray.Dataset
        The quantities of `results.VARIABLES` by step, tip and radius.
    """

    history: xr.Dataset

    def write(self, folder: str | Path, *, overwrite: bool = False) -> list[Path]:
        """Write the files that ``cfmpm run`` leaves in its folder at the end of a run.

        Parameters
        ----------
        folder : str or Path
            Made if needed. An earlier result there is replaced, with what was drawn and exported.
        overwrite : bool
            Whether also one that was broken off and could still go on.

        Returns
        -------
        list of Path
            history.nc and, where the scene has ``output.fields``, fields.nc. The fields of each
            step (``output.every``) are written only while the command runs.

        Raises
        ------
        SceneError
            Where a run is writing there, or one is that could still go on.
        OSError
            Where the folder cannot be written.
        """
        from cfmpm.keeper import write_result

        return write_result(self, Path(folder), overwrite=overwrite)


@dataclass(frozen=True)
class Start:
    """Where a run begins, or goes on.

    Attributes
    ----------
    body : Body
        To be solved next.
    record : Record
        The steps so far.
    decision : growth.Decision or None
        The one that made this body.
    level : int
        Number of the load step.
    balance : Equilibrium or None
        What finite deformation sets out from, on this grid.
    """

    body: Body
    record: Record
    decision: growth.Decision | None = None
    level: int = 0
    balance: Equilibrium | None = None

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """The beginning of a scene."""
        body = bodies.build(scene)
        record = Record(scene, body.scene, Origin.of(body))
        return cls(updated.begin(body) if scene.formulation == "updated" else body, record)


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
            seen = updated.in_reference(body, gradients, balance)
            nodal = mechanics.nodal_force(*seen)
            plastic = mechanics.plastic_nodal_force(*seen)
            tips = evaluate_tips(seen[0], seen[1], lame, seen[2], nodal, g_c, plastic)
            tips |= updated.compare(body, gradients, balance)
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
                        body, balance = updated.reset(body, balance)
                except SolveError as error:
                    ending = f"{UNSTABLE}: {error}"
                    break
                gradients = None
            continue
        with clock("release"):  # step 8: align segments, double nodes, redefine the grid
            try:
                body = bodies.release(body, decision.running)
            except bodies.GrowthEndError as end:
                severed = isinstance(end, bodies.SeveredError)
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
