"""The variables of a history: names, units, meaning, and how they scale with the load factor."""

from __future__ import annotations

# What became of a tip, in the order of the flag values of `tip_status`.
ARRIVED = ("arrived_boundary", "arrived_hole", "arrived_crack")
TIP_STATUS = (
    "growing",
    "stopped",
    *ARRIVED,
    "severed",  # inside a body that another crack has severed
)
ARRIVED_FLAGS = tuple(map(TIP_STATUS.index, ARRIVED))
STEP, TIP, RADIUS = ("step",), ("step", "tip"), ("step", "tip", "radius")
_STRESS_INTENSITY = "MPa mm0.5"

_CF_PLASTIC = "contribution of plastic work to the configurational force"
_REACTION = (
    "force on the body at the loaded part: the applied force, or the reaction of its prescribed "
    "components; the reaction of a node shared by supports counts for the first of them"
)
# Name: dimensions, units, long name.
VARIABLES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "tip_x": (TIP, "mm", "position of the crack tip"),
    "tip_y": (TIP, "mm", "position of the crack tip"),
    "crack_length": (TIP, "mm", "length of the crack that ends at the tip"),
    "tip_status": (TIP, "1", "status of the tip"),
    "tied": (
        TIP,
        "1",
        "1 where a tip reaches g_c at the load of the first one within the error of the grid; 0 "
        "where not, nan without crack control",
    ),
    "cf_x": (TIP, "N mm-1", "configurational force on the largest domain (paper eq 27)"),
    "cf_y": (TIP, "N mm-1", "configurational force on the largest domain (paper eq 27)"),
    "cf_norm": (TIP, "N mm-1", "norm of the configurational force on the largest domain"),
    "cf_angle": (TIP, "degree", "angle of the configurational force from the crack tangent"),
    "cf_tip_x": (TIP, "N mm-1", "configurational force on the tip node (paper eq 26)"),
    "cf_tip_y": (TIP, "N mm-1", "configurational force on the tip node (paper eq 26)"),
    "cf_plastic_x": (TIP, "N mm-1", _CF_PLASTIC),
    "cf_plastic_y": (TIP, "N mm-1", _CF_PLASTIC),
    "J_plastic": (TIP, "N mm-1", "contribution of plastic work to J, to be added to J"),
    "J": (
        TIP,
        "N mm-1",
        "J-integral of the elastic energy along the crack tangent, largest domain radius",
    ),
    "G": (
        TIP,
        "N mm-1",
        "energy release rate from K_I and K_II, largest radius; without K J, if positive",
    ),
    "G_kink": (TIP, "N mm-1", "energy release rate of a kink in the direction of growth"),
    "K_I": (TIP, _STRESS_INTENSITY, "stress intensity factor of mode I, largest domain radius"),
    "K_II": (TIP, _STRESS_INTENSITY, "stress intensity factor of mode II, largest domain radius"),
    "T_stress": (
        TIP,
        "MPa",
        "T-stress, the uniform stress along the crack less that across it (of closed faces, minus "
        "their pressure), largest domain radius",
    ),
    "cf_norm_grid": (
        TIP,
        "N mm-1",
        "norm of the configurational force on a disc of the grid; for a grid that is reset",
    ),
    "tip_drift": (
        TIP,
        "mm",
        "distance between the crack tips of the material and of the grid; for a grid that is reset",
    ),
    "kink_angle": (TIP, "degree", "angle of largest hoop stress from the crack tangent"),
    "clearance": (TIP, "mm", "distance to the nearest object that a domain must not contain"),
    "tip_size": (TIP, "mm", "element size at the tip"),
    "min_opening": (TIP, "mm", "smallest opening of the crack faces; negative where they overlap"),
    "contact_pressure": (
        TIP,
        "MPa",
        "mean pressure of the faces on each other in the largest ring, of a tip that they close; "
        "0 of one that is open",
    ),
    "G_floor": (
        TIP,
        "N mm-1",
        "below which J and G of a closed or unloaded tip are not told from zero; 0 of others",
    ),
    "finite_effect_J": (
        TIP,
        "1",
        "relative change of J by finite deformation, if neglected, which is twice that of K: "
        "estimated up to 0.01, infinite where it may be larger and is not found; nan where "
        "strain is too small for it to be felt",
    ),
    "critical_load_factor": (TIP, "1", "load factor at which G_kink reaches g_c"),
    "domain_radius": (RADIUS, "mm", "radius used for the domain"),
    "J_radius": (RADIUS, "N mm-1", "J-integral of the elastic energy along the crack tangent"),
    "J_plastic_radius": (RADIUS, "N mm-1", "contribution of plastic work to J"),
    "G_radius": (RADIUS, "N mm-1", "energy release rate from K_I and K_II"),
    "K_I_radius": (RADIUS, _STRESS_INTENSITY, "stress intensity factor of mode I"),
    "K_II_radius": (RADIUS, _STRESS_INTENSITY, "stress intensity factor of mode II"),
    "T_stress_radius": (RADIUS, "MPa", "T-stress"),
    "cf_norm_radius": (RADIUS, "N mm-1", "norm of the configurational force on the domain"),
    "cf_angle_radius": (
        RADIUS,
        "degree",
        "angle of the configurational force from the crack tangent",
    ),
    "strain_energy": (STEP, "N", "strain energy per mm of thickness (N mm/mm)"),
    "plastic_work": (
        STEP,
        "N",
        "plastic work per mm of thickness (N mm/mm); nan without plasticity",
    ),
    "external_work": (STEP, "N", "work of the loads per mm of thickness (N mm/mm)"),
    "fracture_energy": (STEP, "N", "g_c times new crack length per mm of thickness (N mm/mm)"),
    "energy_gap": (STEP, "N", "external_work less strain_energy less fracture_energy"),
    "jump": (STEP, "1", "1 where a tip broke through its last ligament at the load before"),
    "released_energy": (
        STEP,
        "N",
        "energy that the last segments set free, at the load before; nan where no crack has run",
    ),
    "newton_iterations": (STEP, "1", "Newton iterations so far; 0 for a linear solve"),
    "substeps": (STEP, "1", "load steps so far, including substeps; 0 for a linear solve"),
    "finite_effect": (
        STEP,
        "1",
        "relative change of the strain energy by finite deformation, if neglected: estimated up to "
        "0.01, infinite where it may be larger and is not found",
    ),
    "residual_norm": (
        STEP,
        "1",
        "largest unbalanced force over the largest nodal force; nan where nothing is carried",
    ),
    "force_imbalance": (
        STEP,
        "1",
        "resultant of all loads and reactions over the largest; nan where the grid is reset",
    ),
    "free_parts": (STEP, "1", "parts that have come off the body and that no support holds"),
    "negative_pivots": (STEP, "1", "negative pivots of the stiffness; nan by amg"),
    "unstable_points": (STEP, "1", "points that have lost ellipticity; nan at small strain"),
    "n_points": (STEP, "1", "material points"),
    "n_nodes": (STEP, "1", "nodes of the background grid"),
    "contact_pairs": (STEP, "1", "pairs of crack face nodes in contact"),
    "min_det_F": (STEP, "1", "smallest volume ratio of the material points; nan at small strain"),
    "least_fill": (
        STEP,
        "1",
        "smallest filled fraction of the triangles with material; for a grid that is reset",
    ),
    "grid_resets": (STEP, "1", "resets of the grid so far; for a grid that is reset"),
    "grid_quality": (
        STEP,
        "1",
        "quality of the worst triangle changed by growth; 1 equilateral, 0 degenerate",
    ),
    "empty_elements": (
        STEP,
        "1",
        "triangles without a material point; for a grid that is reset, with fewer than initially",
    ),
    "floating_nodes": (STEP, "1", "nodes without stiffness, which were held"),
    "n_unknowns": (STEP, "1", "free degrees of freedom"),
    "reaction_x": (("step", "boundary"), "N mm-1", _REACTION),
    "reaction_y": (("step", "boundary"), "N mm-1", _REACTION),
    "displacement_x": (("step", "boundary"), "mm", "mean displacement of the loaded part"),
    "displacement_y": (("step", "boundary"), "mm", "mean displacement of the loaded part"),
    "displacement": (
        ("step", "boundary"),
        "mm",
        "mean displacement of the loaded part along the force on it (reaction_x, reaction_y); "
        "nan without a force",
    ),
    "wall_time": (("step", "phase"), "s", "wall time"),
}
# Additional variables of scenes with fatigue.
OF_FATIGUE = {
    "cycles": (STEP, "1", "load cycles so far, by Paris' law"),
    "delta_K": (TIP, _STRESS_INTENSITY, "range of sqrt(K_I^2 + K_II^2) in a cycle"),
    "cycles_to_fracture": ((), "1", "load cycles after which the first tip reaches g_c"),
    "critical_crack_length": (
        (),
        "mm",
        "length of the first crack whose tip reaches g_c, at that load cycle",
    ),
    "da_dN": (TIP, "mm", "growth per cycle, by Paris' law; zero at and below the threshold"),
}
# Power of the load factor in the quantities of a linear scene; zero for those not listed.
LOAD_POWER = {
    **dict.fromkeys(("K_I", "K_II", "T_stress", "min_opening"), 1),
    **dict.fromkeys(("K_I_radius", "K_II_radius", "T_stress_radius"), 1),
    "contact_pressure": 1,
    **dict.fromkeys(("reaction_x", "reaction_y", "displacement_x", "displacement_y"), 1),
    "displacement": 1,
    **dict.fromkeys(("cf_x", "cf_y", "cf_norm", "cf_tip_x", "cf_tip_y", "cf_norm_radius"), 2),
    "G_floor": 2,
    **dict.fromkeys(("J", "G", "G_kink", "J_radius", "G_radius", "strain_energy"), 2),
}
# Quantities whose range over the domain radii is given as their spread.
SPREAD = ("J", "G", "K_I", "K_II", "T_stress", "cf_norm", "cf_angle")
