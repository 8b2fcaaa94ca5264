"""States of a body and the result of a run: plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr

from cfmpm.body import particle_domains
from cfmpm.body.body import Body
from cfmpm.body.grid import Floats, Grid
from cfmpm.body.loads import Loading
from cfmpm.body.points import DeformedPoints
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture import growth
from cfmpm.scene import Scene

# Phases of every run; growth adds "release", a grid that is reset adds "reset".
PHASES = ("grid", "points", "stiffness", "equilibrium", "fracture")


@dataclass(frozen=True)
class Stage:
    """A body to be solved next, and the state from which its solution starts.

    Attributes
    ----------
    scene : Scene
        Expanded: with its geometry, loads and names.
    body : Body
    decision : growth.Decision or None
        The decision from which this body was made.
    step : int
        Number of the next step; growth and load steps are counted together.
    level : int
        Number of the load step.
    balance : Equilibrium or None
        The last equilibrium, on this grid; None before the first one, and at small strain after
        growth has changed the grid.
    gradients : (p, k, 2) float or None
        Basis gradients at the quadrature points [1/mm]; None for a new grid.
    """

    scene: Scene
    body: Body
    decision: growth.Decision | None = None
    step: int = 1
    level: int = 0
    balance: Equilibrium | None = None
    gradients: Floats | None = None


@dataclass(frozen=True, repr=False)
class State:
    """A body in equilibrium; a state proportional to the load factor is that at factor one.

    Attributes
    ----------
    body : Body
    balance : Equilibrium
    configurational_force : (n, 2) float
        At the grid nodes [N/mm].
    tips : dict of str to array
        Values at the tips of the grid, (tip,) or (tip, radius), by the names of the variables of
        a history, at the load factor of `balance`.
    decision : growth.Decision
        The next crack growth.
    level : int
        Number of the load step.
    stage : Stage
        The stage that was solved; solving it again gives the same state. Its body is `body`, unless
        the grid is reset: `body` is then in the reference configuration.
    """

    body: Body
    balance: Equilibrium
    configurational_force: Floats
    tips: Mapping[str, Any]
    decision: growth.Decision
    level: int
    stage: Stage

    def __repr__(self) -> str:
        return f"<State of {self.scene.name}, step {self.stage.step}>"

    @property
    def scene(self) -> Scene:
        """The scene, expanded: with its geometry, loads and names."""
        return self.stage.scene

    @property
    def grid(self) -> Grid:
        """The background grid."""
        return self.body.grid

    @property
    def points(self) -> DeformedPoints:
        """The material points, each with the mean state over its quadrature points."""
        return particle_domains.means(self.body.points, self.body.quadrature, self.balance.points)

    @property
    def loading(self) -> Loading:
        """Loads and supports."""
        return self.body.loading

    @property
    def displacement(self) -> Floats:
        """Displacement of the grid nodes [mm], (n, 2)."""
        return self.balance.displacement


@dataclass(frozen=True, repr=False)
class Result(State):
    """The result of a run: its history and the last state of equilibrium.

    Attributes
    ----------
    history : xarray.Dataset
        The quantities of `output.variables.VARIABLES` by step, tip and radius.
    """

    history: xr.Dataset

    def __repr__(self) -> str:
        sizes = self.history.sizes
        said = ", ".join(
            f"{sizes[key]} {name}{'' if sizes[key] == 1 else 's'}"
            for key, name in {"step": "step", "tip": "crack tip"}.items()
        )
        return f"<Result of {self.scene.name}: {said}; see its history>"
