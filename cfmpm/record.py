"""The record that a run keeps: values of each step, what was chosen, left out and doubtful."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cfmpm import remarks, results
from cfmpm.body import Body
from cfmpm.clock import Clock
from cfmpm.equilibrium import Equilibrium
from cfmpm.fracture import stability
from cfmpm.fracture.growth import Decision
from cfmpm.grid import Triangulation
from cfmpm.scene.model import Scene


class Record:
    """The steps of a run, as they come.

    Parameters
    ----------
    scene : Scene
        As the user wrote it.
    body : Body
        At the start: its tips, and the ends of cracks that are none, keep their names and places.
    clock : Clock
    """

    def __init__(self, scene: Scene, body: Body, clock: Clock) -> None:
        self.scene, self.full = scene, body.scene
        self.tips = {tip.name: (tip.crack, tip.end) for tip in body.grid.tips}
        self.boundaries = list(body.loading.boundaries)
        self.radii = _nominal_radii(body)
        geometry = body.scene.geometry
        self.holes = {str(hole.name) for hole in geometry.holes} if geometry else set()
        self.steps: list[results.StepRecord] = []
        self.warnings: dict[str, None] = {}
        self.notes: dict[str, Any] = {}
        self._clock = clock
        self._seconds: dict[str, float] = {}
        self._start_lengths = self._lengths(body.triangulation)

    def add(
        self,
        body: Body,
        balance: Equilibrium,
        tips: Mapping[str, Any],
        decision: Decision,
    ) -> None:
        """Add a state of balance.

        Parameters
        ----------
        body : Body
        balance : Equilibrium
            At load factor one.
        tips : mapping of str to array
            Values at the tips of the grid, at load factor one.
        decision : Decision
            With the load factor that the step is recorded at.
        """
        factor = decision.load_factor
        if not np.isfinite(factor):
            factor = self.steps[-1].load_factor if self.steps else 1.0
        values = self._of_ends(body, decision)
        rows = [list(self.tips).index(tip.name) for tip in body.grid.tips]
        for name, found in tips.items():
            values[name] = np.full((len(self.tips), *found.shape[1:]), np.nan)
            values[name][rows] = found
        values |= _of_body(body, balance)
        values = {
            name: np.asarray(value) * factor ** results.LOAD_POWER.get(name, 0)
            for name, value in values.items()
        }
        conjugates = _conjugates(body, balance, factor)
        values["external_work"] = self._work_done(factor, conjugates)
        values["fracture_energy"] = self._fracture_energy(body)
        self._append(factor, values, conjugates)
        self.notes |= remarks.choices(body, balance)
        self.warnings |= dict.fromkeys(remarks.doubts(body, balance))

    def add_severed(self, triangulation: Triangulation) -> None:
        """Add the last position of the cracks, after which a part of the body is free."""
        self._append(np.nan, self._of_line_ends(triangulation))

    def history(self, ending: str) -> xr.Dataset:
        """Gather the record into a dataset.

        Parameters
        ----------
        ending : str
            Why the run ended.
        """
        return results.build_history(
            self.scene,
            self.steps,
            stability=self._stability(),
            tips=list(self.tips),
            radii=self.radii,
            boundaries=self.boundaries,
            notes={
                **self.notes,
                "ending": ending,
                "left_out": remarks.left_out(self.full, bool(self.tips)),
                "warnings": list(self.warnings),
            },
        )

    def _append(
        self,
        factor: float,
        values: Mapping[str, Any],
        conjugates: tuple[float, float] = (np.nan, np.nan),
    ) -> None:
        spent = {
            phase: total - self._seconds.get(phase, 0.0)
            for phase, total in self._clock.seconds.items()
        }
        self._seconds = dict(self._clock.seconds)
        self.steps.append(results.StepRecord(factor, values, spent, conjugates))

    def _of_ends(self, body: Body, decision: Decision) -> dict[str, Any]:
        """Where each crack ends, and what it does there."""
        values = self._of_line_ends(body.triangulation)
        for i, name in enumerate(self.tips):
            if name in decision.running:
                values["tip_status"][i] = results.TIP_STATUS.index("growing")
        return values

    def _of_line_ends(self, mesh: Triangulation) -> dict[str, Any]:
        lengths = self._lengths(mesh)
        nodes = {name: _end_node(mesh, *place) for name, place in self.tips.items()}
        return {
            "tip_x": np.array([mesh.nodes[node, 0] for node in nodes.values()]),
            "tip_y": np.array([mesh.nodes[node, 1] for node in nodes.values()]),
            "crack_length": np.array([lengths[crack] for crack, _ in self.tips.values()]),
            "tip_status": np.array(
                [
                    results.TIP_STATUS.index(self._arrival(mesh, crack, nodes[name]))
                    for name, (crack, _) in self.tips.items()
                ],
                float,
            ),
        }

    def _arrival(self, mesh: Triangulation, crack: str, node: int) -> str:
        """Say where the end of a crack lies."""
        for name, pairs in mesh.edges.items():
            if (pairs == node).any():
                return "arrived_hole" if name in self.holes else "arrived_boundary"
        met = sum(int((pairs == node).sum()) for pairs in mesh.cracks.values())
        return "arrived_crack" if met > 1 else "stopped"

    def _lengths(self, mesh: Triangulation) -> dict[str, float]:
        return {
            name: float(np.hypot(*(mesh.nodes[pairs[:, 1]] - mesh.nodes[pairs[:, 0]]).T).sum())
            for name, pairs in mesh.cracks.items()
        }

    def _fracture_energy(self, body: Body) -> float:
        """g_c of the body times the new length of its cracks [N]."""
        new = sum(self._lengths(body.triangulation).values()) - sum(self._start_lengths.values())
        return 0.0 if new == 0.0 else new * (self.full.material.g_c or np.nan)

    def _work_done(self, factor: float, conjugates: tuple[float, float]) -> float:
        """Work of the loads from the start, by the trapezoidal rule over the steps [N]."""
        dead, grip = conjugates
        work, last_factor, last_dead, last_grip = 0.0, 0.0, 0.0, 0.0
        if self.steps:
            last = self.steps[-1]
            work, last_factor = float(last.values["external_work"]), last.load_factor
            last_dead, last_grip = last.conjugates
        work += 0.5 * (factor + last_factor) * (dead - last_dead)
        return work + 0.5 * (grip + last_grip) * (factor - last_factor)

    def _stability(self) -> NDArray[np.int8]:
        """How the cracks go on from each step, as far as crack control tells."""
        growth = self.full.growth
        if growth is None or growth.control == "load":
            return np.zeros(len(self.steps), np.int8)
        factor = np.array([step.load_factor for step in self.steps])
        dead, grip = np.array([step.conjugates for step in self.steps]).reshape(-1, 2).T
        if np.any(dead != 0.0):  # with grips besides, the force is still that of all loads
            return stability.classify(factor, dead)
        return stability.classify(grip, factor)


def _end_node(mesh: Triangulation, crack: str, end: int) -> int:
    pairs = mesh.cracks[crack]
    return int(pairs[0, 0] if end == 0 else pairs[-1, 1])


def _conjugates(body: Body, balance: Equilibrium, factor: float) -> tuple[float, float]:
    """What the dead loads have moved through and the force on the grips, per load factor [N]."""
    loading, u = body.loading, balance.displacement
    applied = float((loading.force * np.where(loading.prescribed, 0.0, u)).sum())
    reaction = float(
        ((balance.internal_force - balance.contact_force) * loading.displacement).sum()
    )
    return factor * applied, factor * reaction


def _of_body(body: Body, balance: Equilibrium) -> dict[str, Any]:
    """Energies, counts and the forces and displacements of the loaded parts."""
    loading, source, u = body.loading, body.integration, balance.displacement
    # Sums by numpy itself: the bits of a threaded BLAS (a @ b) depend on its threads.
    held = balance.internal_force - loading.force - balance.contact_force
    parts = loading.boundaries.values()
    reaction = np.array(
        [(part.force + np.where(part.holds, held[part.nodes], 0.0)).sum(axis=0) for part in parts]
    ).reshape(-1, 2)
    motion = np.array(
        [(part.weights[:, None] * u[part.nodes]).sum(axis=0) for part in parts]
    ).reshape(-1, 2)
    # A part at which nothing but round-off is left has no direction of force.
    size = np.hypot(*reaction.T)
    felt = size > 1e-9 * np.abs(balance.internal_force).max(initial=0.0)
    along = np.full(len(size), np.nan)
    along[felt] = (motion * reaction).sum(axis=1)[felt] / size[felt]
    return {
        "strain_energy": np.sum(source.energy * source.volume),
        "newton_iterations": 0,
        "residual_norm": balance.residual_norm,
        "negative_pivots": balance.negative_pivots,
        "n_points": len(body.points),
        "n_nodes": len(body.grid.nodes),
        "n_unknowns": balance.n_unknowns,
        "contact_pairs": balance.contact_pairs,
        "grid_quality": body.quality,
        "empty_elements": body.empty_elements,
        "floating_nodes": body.floating_nodes,
        "reaction_x": reaction[:, 0],
        "reaction_y": reaction[:, 1],
        "displacement_x": motion[:, 0],
        "displacement_y": motion[:, 1],
        "displacement": along,
    }


def _nominal_radii(body: Body) -> list[float]:
    """The radii asked for, else those of the tip with the most room."""
    if not isinstance(body.scene.fracture.radii, int):
        return list(body.scene.fracture.radii)
    if not body.tip_domains:
        return []
    return list(max((domain.radii for domain in body.tip_domains), key=max))
