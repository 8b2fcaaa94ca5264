"""The record of a run: values of each step, choices, omissions and warnings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats, Triangulation
from cfmpm.ending import Ending, LastCracks, RunEnded
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture import fatigue, stability
from cfmpm.fracture.growth import Decision
from cfmpm.fracture.relieved import relieved_nodes
from cfmpm.mechanics import effects
from cfmpm.output import choices, invariants, variables
from cfmpm.output.external_work import conjugates, released, work_after
from cfmpm.output.history import StepRecord, build_history
from cfmpm.output.warnings import of_history, of_scene, of_state
from cfmpm.output.warnings.doubt import Doubts
from cfmpm.output.warnings.of_units import doubts_of_units
from cfmpm.registry.solvers import SOLVERS
from cfmpm.registry.table import load
from cfmpm.scene.model import Scene
from cfmpm.state import Stage, State

# Status of a tip inside the body.
_INSIDE = ("growing", "stopped")


@dataclass(frozen=True)
class Origin:
    """The tips, loaded parts and radii at the start of a run, which are those of its history.

    Attributes
    ----------
    tips : dict of str to (str, int)
        Crack and end of each tip.
    boundaries : list of str
        Names of the loaded parts.
    radii : list of float
        Nominal domain radii [mm].
    """

    tips: Mapping[str, tuple[str, int]]
    boundaries: list[str]
    radii: list[float]

    @classmethod
    def of(cls, scene: Scene, body: Body) -> Self:
        """The origin of a run that starts with this body."""
        loading = body.loading if body.motion is None else body.motion.loading
        return cls(
            tips={tip.name: (tip.crack, tip.end) for tip in body.grid.tips},
            boundaries=list(loading.boundaries),
            radii=_nominal_radii(scene, body),
        )


class Record:
    """Collects the steps of a run.

    Parameters
    ----------
    scene : Scene
        As given by the user.
    full : Scene
        Expanded.
    origin : Origin
    """

    def __init__(self, scene: Scene, full: Scene, origin: Origin) -> None:
        self.scene, self.full, self.origin = scene, full, origin
        self.holes = {str(hole.name) for hole in full.geometry.holes} if full.geometry else set()
        self.steps: list[StepRecord] = []
        self.warnings: dict[str, None] = {}
        self.doubts = Doubts()
        self.notes: dict[str, Any] = {}
        self.finite = False
        self.decision: Decision | None = None
        self.came_off: list[Floats] = []

    @classmethod
    def of(cls, scene: Scene, stage: Stage) -> Self:
        """The record of a run that starts with this stage."""
        return cls(scene, stage.scene, Origin.of(stage.scene, stage.body))

    def add(self, state: State, seconds: Mapping[str, float]) -> None:
        """Add a state of equilibrium.

        Parameters
        ----------
        state : State
        seconds : mapping of str to float
            Wall time of each phase of the step [s].
        """
        body, balance, tips, decision = state.body, state.balance, state.tips, state.decision
        self.decision = decision
        self.finite = balance.finite
        factor = decision.load_factor if balance.proportional else balance.load_factor
        if not np.isfinite(factor):
            factor = self.steps[-1].load_factor if self.steps else 1.0
        values = self._of_ends(body, decision)
        rows = [list(self.origin.tips).index(tip.name) for tip in body.grid.tips]
        for name, found in tips.items():
            values[name] = np.full((len(self.origin.tips), *found.shape[1:]), np.nan)
            values[name][rows] = found
        values |= _of_body(body, balance)
        scale = balance.scale(factor)
        values = {
            name: np.asarray(value) * scale ** variables.LOAD_POWER.get(name, 0)
            for name, value in values.items()
        }
        values["finite_effect"], effect_J = effects(body, balance, factor)
        for name, found in (
            ("clearance", [domain.clearance for domain in body.tip_domains]),
            ("tip_size", [tip.h for tip in body.grid.tips]),
            ("finite_effect_J", effect_J),
        ):
            values[name] = np.full(len(self.origin.tips), np.nan)
            values[name][rows if len(found) else []] = found
        last = self.steps[-1] if self.steps else None
        values["jump"] = float(self._jumped(values["tip_status"]))
        values["released_energy"] = released(self.steps, body, balance, factor)
        values["external_work"] = (
            balance.external_work
            if balance.finite
            else work_after(last, body, balance, factor, jumped=bool(values["jump"]))
        )
        if self.full.fatigue is None:
            spent = body.grown.fracture_energy
            values["fracture_energy"] = spent
            values["energy_gap"] = values["external_work"] - values["strain_energy"] - spent
        self.steps.append(StepRecord(factor, values, seconds, conjugates(body, balance, scale)))
        self.notes |= choices.choices(self.full, body, balance)
        off = invariants.came_off(body, len(self.steps), self.came_off)
        if last is None:
            self.warnings |= dict.fromkeys(of_scene.doubts_of_scene(self.full, body))
        self.warnings |= dict.fromkeys(off)
        for doubts in (
            of_scene.doubts_of_tip_domains(self.full, body),
            of_state.doubts(self.full, body, balance),
            of_state.doubts_at_tips(body, balance, tips),
            of_state.doubts_of_fixed_loads(body, balance, tips),
        ):
            self.doubts.add(len(self.steps), doubts)

    def close(self, end: RunEnded, seconds: Mapping[str, float]) -> xr.Dataset:
        """Return the history of a run that has ended.

        Parameters
        ----------
        end : RunEnded
            With the last position of the cracks, if they grew after the last state.
        seconds : mapping of str to float
            Wall time of each phase since the last state [s].
        """
        ending = end.ending
        if end.cracks is not None:
            severed = ending.status == "severed"
            cut = self._add_cracks(end.cracks, seconds, "severed" if severed else "stopped")
            if severed:
                ending = replace(ending, text=f"{ending.text}; severed by {' and '.join(cut)}")
        return self.history(ending)

    def _add_cracks(
        self, cracks: LastCracks, seconds: Mapping[str, float], inside: str
    ) -> list[str]:
        """Add the last position of the cracks, in a body that is no longer solved.

        Parameters
        ----------
        cracks : LastCracks
        seconds : mapping of str to float
        inside : {"severed", "stopped"}
            Status of the tips that have not arrived.

        Returns
        -------
        list of str
            Names of the cracks that have arrived in this step.
        """
        values = self._of_line_ends(cracks.triangulation)
        status, (growing, stopped) = values["tip_status"], map(variables.TIP_STATUS.index, _INSIDE)
        arrived = status != stopped
        status[~arrived] = variables.TIP_STATUS.index(inside)
        if self.steps:
            arrived &= self.steps[-1].values["tip_status"] == growing
        if self.decision is not None and self.decision.progress is not None:
            values["cycles"], _ = fatigue.count(self.decision.progress, cracks.grown.segments, {})
        self.steps.append(StepRecord(np.nan, values, seconds))
        names = [crack for crack, _ in self.origin.tips.values()]
        return list(dict.fromkeys(np.array(names)[arrived].tolist()))

    def history(self, ending: Ending) -> xr.Dataset:
        """Convert the record to a dataset.

        Parameters
        ----------
        ending : Ending
        """
        history = build_history(
            self.scene,
            self.steps,
            ending,
            stability=self._stability(),
            tips=list(self.origin.tips),
            radii=self.origin.radii,
            boundaries=self.origin.boundaries,
            notes={
                **self.notes,
                "left_out": choices.left_out(self.full, bool(self.origin.tips), finite=self.finite),
            },
        )
        growth = self.full.growth
        first = [
            *invariants.violations(history),
            *of_history.doubts_of_release_rates(history, self.full),
            *of_history.doubts_of_kinematics(history, self.full, finite=self.finite),
        ]
        if growth is None:
            found = of_history.doubts_of_domains(history, self.full)
        else:
            first += of_history.doubts_of_held_tips(history, self.full)
            first = of_history.doubts_of_end(history, growth) + first
            found = of_history.doubts_of_path(history, self.full, growth)
        # Where units are mistaken, all else that is told follows from it.
        units = [*of_scene.unusual(self.full), *doubts_of_units(self.full)]
        texts = dict.fromkeys([*units, *first, *self.warnings, *self.doubts.said(), *found])
        history.attrs["warnings"] = json.dumps(list(texts), ensure_ascii=False)
        return history

    def _of_ends(self, body: Body, decision: Decision) -> dict[str, Any]:
        """Position and status of each tip, and its values of fatigue."""
        values = self._of_line_ends(body.triangulation)
        progress = decision.progress
        rates = {} if progress is None else progress.rates
        for i, name in enumerate(self.origin.tips):
            if name in decision.running or (decision.running and rates.get(name)):
                values["tip_status"][i] = variables.TIP_STATUS.index("growing")
        if self.full.growth is not None and self.full.growth.control == "crack":
            tips = {tip.name for tip in body.grid.tips}
            values["tied"] = np.array(
                [
                    float(name in decision.tied) if name in tips else np.nan
                    for name in self.origin.tips
                ]
            )
        if progress is not None:
            values["cycles"] = progress.cycles
            for quantity, found in (("delta_K", progress.ranges), ("da_dN", rates)):
                values[quantity] = np.array(
                    [found.get(name, np.nan) for name in self.origin.tips], float
                )
        return values

    def _of_line_ends(self, mesh: Triangulation) -> dict[str, Any]:
        lengths = mesh.crack_lengths
        nodes = {name: mesh.end_of(*place) for name, place in self.origin.tips.items()}
        return {
            "tip_x": np.array([mesh.nodes[node, 0] for node in nodes.values()]),
            "tip_y": np.array([mesh.nodes[node, 1] for node in nodes.values()]),
            "crack_length": np.array([lengths[crack] for crack, _ in self.origin.tips.values()]),
            "tip_status": np.array(
                [
                    variables.TIP_STATUS.index(self._arrival(mesh, *place))
                    for place in self.origin.tips.values()
                ],
                float,
            ),
        }

    def _arrival(self, mesh: Triangulation, crack: str, end: int) -> str:
        """Status of the end of a crack by its position."""
        edge = mesh.edge_at(mesh.end_of(crack, end))
        if edge is not None:
            return "arrived_hole" if edge in self.holes else "arrived_boundary"
        return "stopped" if mesh.is_tip(crack, end) else "arrived_crack"

    def _jumped(self, status: NDArray[np.float64]) -> bool:
        """Whether a tip has arrived, through a last ligament, since the step before."""
        if not self.steps:
            return False
        now, before = (
            np.isin(flags, variables.ARRIVED_FLAGS)
            for flags in (status, self.steps[-1].values["tip_status"])
        )
        return bool((now & ~before).any())

    def _stability(self) -> NDArray[np.int8]:
        """Stability of growth from each step on, under crack control."""
        growth = self.full.growth
        if growth is None or growth.control != "crack":
            return np.zeros(len(self.steps), np.int8)
        factor = np.array([step.load_factor for step in self.steps])
        dead, grip, _ = np.array([step.conjugates for step in self.steps]).reshape(-1, 3).T
        # With prescribed displacements besides, the force is still that of all loads. Steps that
        # hold only the last position of the cracks are nan.
        path = (factor, dead) if np.any(np.abs(dead) > 0.0) else (grip, factor)
        flags = stability.classify(*path)
        jumps = np.array([step.values.get("jump", 0.0) for step in self.steps], float) > 0.0
        flags[:-1][jumps[1:]] = 0
        return flags


def _of_body(body: Body, balance: Equilibrium) -> dict[str, Any]:
    """Energies, counts, and forces and displacements of the loaded parts."""
    loading, source, u = body.loading, balance.points, balance.displacement
    applied = loading.at(balance.load_factor).force
    held = balance.internal_force - applied - balance.contact_force
    relieved = relieved_nodes(body, balance)
    held[relieved] = 0.0
    parts, factor = loading.boundaries.values(), balance.load_factor
    reaction = np.array(
        [
            (part.force_at(factor) + np.where(part.holds, held[part.nodes], 0.0)).sum(axis=0)
            for part in parts
        ]
    ).reshape(-1, 2)
    motion = np.array(
        [(part.weights[:, None] * u[part.nodes]).sum(axis=0) for part in parts]
    ).reshape(-1, 2)
    # A force that is only round-off has no direction.
    size = np.hypot(*reaction.T)
    felt = size > 1e-9 * np.abs(balance.internal_force).max(initial=0.0)
    along = np.full(len(size), np.nan)
    along[felt] = (motion * reaction).sum(axis=1)[felt] / size[felt]
    values: dict[str, Any] = {}
    if balance.finite:
        values["min_det_F"] = np.linalg.det(np.eye(2) + source.displacement_gradient).min()
    if body.motion is not None:
        values |= {"least_fill": body.motion.fill, "grid_resets": body.motion.resets}
    return values | {
        "strain_energy": source.energy @ source.volume,
        "plastic_work": (
            body.materials.plastic_work(source) @ source.volume
            if source.internal_variables.size
            else np.nan
        ),
        "newton_iterations": balance.newton_iterations,
        "substeps": balance.substeps,
        "unstable_points": balance.unstable_points,
        # In a body that has come apart and carries nothing, all forces are round-off.
        "residual_norm": np.nan if relieved.all() else balance.residual_norm,
        "force_imbalance": invariants.force_imbalance(body, balance),
        "free_parts": len(loading.holds.free_parts),
        "negative_pivots": _negative_pivots(balance.solver),
        "n_points": len(body.points),
        "n_nodes": len(body.grid.nodes),
        "n_unknowns": balance.n_unknowns,
        "contact_pairs": balance.contact_pairs,
        "grid_quality": body.grown.quality,
        "empty_elements": body.empty_elements,
        "floating_nodes": body.floating_nodes,
        "reaction_x": reaction[:, 0],
        "reaction_y": reaction[:, 1],
        "displacement_x": motion[:, 0],
        "displacement_y": motion[:, 1],
        "displacement": along,
    }


def _negative_pivots(solver: str) -> float:
    """Number of negative pivots of an accepted state.

    It is zero, since a direct solver raises an error for a negative pivot; nan for an iterative
    solver, which has no pivots.
    """
    return 0.0 if not solver or load(SOLVERS[solver].place).direct else np.nan


def _nominal_radii(scene: Scene, body: Body) -> list[float]:
    """The requested radii, by default those of the tip with the largest clearance."""
    if not isinstance(scene.fracture.radii, int):
        return list(scene.fracture.radii)
    if not body.tip_domains:
        return []
    return list(max((domain.radii for domain in body.tip_domains), key=max))
