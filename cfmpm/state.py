"""A body in balance and the result of a run: plain data."""

from __future__ import annotations

from dataclasses import dataclass

import xarray as xr

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats, Grid
from cfmpm.body.loads import Loading
from cfmpm.body.points import MaterialPoints
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture import growth
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
        The quantities of `output.variables.VARIABLES` by step, tip and radius.
    """

    history: xr.Dataset
