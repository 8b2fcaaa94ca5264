"""An independent reference at large strain: total Lagrangian FEM in plane strain, by scikit-fem.

Nothing of cfmpm's kernels is used: basis and quadrature are scikit-fem's; laws, assembly, Newton's
method, reactions and J are written here. Only a mesh is given, as arrays.
"""

from workflows.reference.total_lagrangian.equilibrium import (
    Equilibrium,
    NotConvergedError,
    StabilityLostError,
    at_rest,
    follow,
    newton,
)
from workflows.reference.total_lagrangian.laws import (
    LAWS,
    Floats,
    Law,
    Response,
    least_acoustic,
    respond,
)
from workflows.reference.total_lagrangian.solid import (
    Bools,
    Ints,
    Loads,
    Solid,
    hold,
    j_integral,
    make_solid,
    no_loads,
    ring_plateau,
    traction_force,
)

__all__ = [
    "LAWS",
    "Bools",
    "Equilibrium",
    "Floats",
    "Ints",
    "Law",
    "Loads",
    "NotConvergedError",
    "Response",
    "Solid",
    "StabilityLostError",
    "at_rest",
    "follow",
    "hold",
    "j_integral",
    "least_acoustic",
    "make_solid",
    "newton",
    "no_loads",
    "respond",
    "ring_plateau",
    "traction_force",
]
