"""The criteria of fracture: where a crack turns to, and what is compared with its toughness."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.registry.table import Registry


@dataclass(frozen=True)
class Criterion:
    """A criterion as the scene knows it.

    Attributes
    ----------
    place : str
        Of its code: a `fracture.criteria.protocols.Direction` or `DrivingForce`.
    description : str
        What ``cfmpm check`` calls it.
    needs_k : bool
        Whether it needs stress intensity factors, which finite deformation does not have.
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

# What cracks follow if a scene does not say, and where `G_kink` of stationary cracks points.
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
