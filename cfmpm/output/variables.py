"""The variables of a history: names, units, meaning, and how they grow with the load."""

from __future__ import annotations

# What became of a tip, in the order of the flag values of `tip_status`.
ARRIVED = ("arrived_boundary", "arrived_hole", "arrived_crack")
TIP_STATUS = (
    "growing",
    "stopped",
    *ARRIVED,
    "severed",  # inside a body that another crack has cut apart
)
ARRIVED_FLAGS = tuple(map(TIP_STATUS.index, ARRIVED))
STEP, TIP, RADIUS = ("step",), ("step", "tip"), ("step", "tip", "radius")
_STRESS_INTENSITY = "MPa mm0.5"

_REACTION = (
    "force on the body at the loaded part: what the load applies, or what its prescribed "
    "components exert; of supports that share a node the first has its force"
)
# Name: dimensions, units, long name.
VARIABLES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "tip_x": (TIP, "mm", "position of the crack tip"),
    "tip_y": (TIP, "mm", "position of the crack tip"),
    "crack_length": (TIP, "mm", "length of the crack line that ends in the tip"),
    "tip_status": (TIP, "1", "what the tip does"),
    "cf_x": (TIP, "N mm-1", "configurational force on the largest domain (paper eq 27)"),
    "cf_y": (TIP, "N mm-1", "configurational force on the largest domain (paper eq 27)"),
    "cf_norm": (TIP, "N mm-1", "norm of the configurational force on the largest domain"),
    "cf_angle": (TIP, "degree", "angle of the configurational force from the crack tangent"),
    "cf_tip_x": (TIP, "N mm-1", "configurational force on the tip node (paper eq 26)"),
    "cf_tip_y": (TIP, "N mm-1", "configurational force on the tip node (paper eq 26)"),
    "cf_plastic_x": (TIP, "N mm-1", "what plastic work adds to the configurational force"),
    "cf_plastic_y": (TIP, "N mm-1", "what plastic work adds to the configurational force"),
    "J_plastic": (TIP, "N mm-1", "what plastic work adds to J, which is of the stored energy"),
    "J": (TIP, "N mm-1", "domain integral along the crack tangent, largest ring"),
    "G": (
        TIP,
        "N mm-1",
        "energy release rate from K_I and K_II, largest ring; at finite deformation J",
    ),
    "G_kink": (TIP, "N mm-1", "what drives the tip in the direction in which it would kink"),
    "K_I": (TIP, _STRESS_INTENSITY, "stress intensity factor of mode I, largest ring"),
    "K_II": (TIP, _STRESS_INTENSITY, "stress intensity factor of mode II, largest ring"),
    "T_stress": (TIP, "MPa", "T-stress, largest ring"),
    "cf_norm_grid": (
        TIP,
        "N mm-1",
        "norm of the configurational force on a disc of the grid, where that is reset",
    ),
    "tip_drift": (TIP, "mm", "distance of the material's tip from that of the grid, if reset"),
    "kink_angle": (TIP, "degree", "angle of largest hoop stress from the crack tangent"),
    "clearance": (TIP, "mm", "distance to the nearest thing that no domain may hold"),
    "tip_size": (TIP, "mm", "element size at the tip"),
    "min_opening": (TIP, "mm", "smallest opening of the crack's faces, negative in overlap"),
    "critical_load_factor": (TIP, "1", "load factor at which G_kink reaches g_c"),
    "domain_radius": (RADIUS, "mm", "radius of the domain, as used"),
    "J_radius": (RADIUS, "N mm-1", "domain integral along the crack tangent"),
    "J_plastic_radius": (RADIUS, "N mm-1", "what plastic work adds to J"),
    "G_radius": (RADIUS, "N mm-1", "energy release rate from K_I and K_II"),
    "K_I_radius": (RADIUS, _STRESS_INTENSITY, "stress intensity factor of mode I"),
    "K_II_radius": (RADIUS, _STRESS_INTENSITY, "stress intensity factor of mode II"),
    "T_stress_radius": (RADIUS, "MPa", "T-stress"),
    "cf_norm_radius": (RADIUS, "N mm-1", "norm of the configurational force on the domain"),
    "cf_angle_radius": (RADIUS, "degree", "angle of the configurational force, from the tangent"),
    "strain_energy": (STEP, "N", "strain energy per mm of thickness (N mm/mm)"),
    "plastic_work": (STEP, "N", "plastic work per mm of thickness (N mm/mm); nan without flow"),
    "external_work": (STEP, "N", "work of the loads per mm of thickness (N mm/mm)"),
    "fracture_energy": (STEP, "N", "g_c times new crack length per mm of thickness (N mm/mm)"),
    "energy_gap": (STEP, "N", "external_work less strain_energy less fracture_energy"),
    "jump": (STEP, "1", "1 where a tip has broken through to what it met, at the load before"),
    "newton_iterations": (STEP, "1", "Newton iterations so far; 0 for a linear solve"),
    "substeps": (STEP, "1", "load steps so far, those in between included; 0 for a linear solve"),
    "finite_effect": (
        STEP,
        "1",
        "part of the energy that finite deformation, left out, would change: an estimate",
    ),
    "residual_norm": (STEP, "1", "largest unbalanced force over the largest nodal force"),
    "negative_pivots": (STEP, "1", "negative pivots of the stiffness; nan by amg"),
    "unstable_points": (STEP, "1", "points that lost ellipticity; nan: linear, not looked at"),
    "n_points": (STEP, "1", "material points"),
    "n_nodes": (STEP, "1", "nodes of the background grid"),
    "contact_pairs": (STEP, "1", "pairs of nodes at which crack faces press on each other"),
    "min_det_F": (STEP, "1", "least volume ratio of the material points; nan at small strain"),
    "least_fill": (STEP, "1", "of triangles with material the least part that it fills, if reset"),
    "grid_resets": (STEP, "1", "how often the grid was moved under the points so far, if reset"),
    "grid_quality": (STEP, "1", "worst triangle that growth changed; 1 equilateral, 0 flat"),
    "empty_elements": (
        STEP,
        "1",
        "triangles without a material point; where the grid is reset, with fewer than were seeded",
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
# The same, of scenes with fatigue alone.
OF_FATIGUE = {
    "cycles": (STEP, "1", "cycles of load so far, by Paris' law"),
    "delta_K": (TIP, _STRESS_INTENSITY, "range of sqrt(K_I^2 + K_II^2) in a cycle"),
    "cycles_to_fracture": ((), "1", "cycles of load after which the first tip reaches g_c"),
    "critical_crack_length": ((), "mm", "length of the crack whose tip reaches g_c, at that"),
    "da_dN": (TIP, "mm", "growth per cycle, by Paris' law; zero at and below the threshold"),
}
# With which power of the load factor the quantities of a linear scene grow; the others not at all.
LOAD_POWER = {
    **dict.fromkeys(("K_I", "K_II", "T_stress", "min_opening"), 1),
    **dict.fromkeys(("K_I_radius", "K_II_radius", "T_stress_radius"), 1),
    "finite_effect": 1,
    **dict.fromkeys(("reaction_x", "reaction_y", "displacement_x", "displacement_y"), 1),
    "displacement": 1,
    **dict.fromkeys(("cf_x", "cf_y", "cf_norm", "cf_tip_x", "cf_tip_y", "cf_norm_radius"), 2),
    **dict.fromkeys(("J", "G", "G_kink", "J_radius", "G_radius", "strain_energy"), 2),
}
# Quantities whose largest difference over the radii is stated as their spread.
SPREAD = ("J", "G", "K_I", "K_II", "T_stress", "cf_norm", "cf_angle")
