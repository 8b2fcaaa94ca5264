"""Criteria of crack growth: its direction, and the driving force that is compared with g_c."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.registry.table import Registry


@dataclass(frozen=True)
class Criterion:
    """A criterion for the direction of growth, or a driving force.

    Attributes
    ----------
    place : str
        Place of its code: a `fracture.criteria.protocols.Direction` or `DrivingForce`.
    description : str
        For ``cfmpm check``: completes "in the direction ...", or names the driving force.
    needs_k : bool
        Whether it needs stress intensity factors, which are not defined at finite deformation.
    """

    place: str
    description: str
    needs_k: bool = False


# Words of growth.direction; other packages: entry points of the group cfmpm.directions.
DIRECTIONS = Registry(
    "direction",
    {
        "max_hoop": Criterion(
            "cfmpm.fracture.criteria.max_hoop:MaxHoop", "of the largest hoop stress", needs_k=True
        ),
        "max_energy": Criterion(
            "cfmpm.fracture.criteria.max_energy:MaxEnergy",
            "of the largest energy release rate",
            needs_k=True,
        ),
        "cf": Criterion("cfmpm.fracture.criteria.along_cf:AlongCf", "of the configurational force"),
    },
)

# Default of growth.direction; also the direction of G_kink at stationary tips.
DEFAULT_DIRECTION = "max_hoop"

# Words of growth.criterion; other packages: entry points of the group cfmpm.driving_forces.
DRIVING_FORCES = Registry(
    "driving_force",
    {
        "energy_release_rate": Criterion(
            "cfmpm.fracture.criteria.energy_release_rate:energy_release_rate", "G of the kink"
        ),
        "cf_norm": Criterion("cfmpm.fracture.criteria.cf_norm:cf_norm", "|CF|"),
    },
)
