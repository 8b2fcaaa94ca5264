"""Claims of sections 5.2 and 5.3: an edge crack in tension and under shear."""

from __future__ import annotations

import numpy as np

from workflows.growth.datasets import segment_angles, steps, tip_path
from workflows.growth.evidence import Evidence, arrival, grade, lost, told
from workflows.reference.path_points import reference
from workflows.reporting.claim_table import Claim

# G of the edge crack at u_y = 1 mm at each end, by crack length [N/mm]: converged T6 grids.
FIXED_GRIPS = {100.0: 328.87, 200.0: 479.48, 300.0: 489.83}
# Largest and mean angle [deg] of a straight path, by points.
STRAIGHT = {790: (1.5, 0.3), 2584: (1.2, 0.3)}
# Largest distance from the reference path [mm].
SHEAR = 0.15


def straight(e: Evidence) -> list[Claim]:
    """The edge crack grows straight ahead."""
    return [
        _straight(e, kind, n, label)
        for n in STRAIGHT
        for kind, label in {
            "cf": "CF direction",
            "hoop": "largest hoop stress",
            "paper": "CF direction, points and volumes as in the paper",
        }.items()
    ]


def _straight(e: Evidence, kind: str, n: int, label: str) -> Claim:
    run = steps(e.edge, f"{kind}_{n}")
    path = tip_path(e.edge, f"{kind}_{n}")
    angles = segment_angles(path)
    largest, mean = np.abs(angles).max(), np.abs(angles).mean()
    allowed, allowed_mean = STRAIGHT[n]
    off = path[-1, 1] - 500.0
    crossed = arrival(run, "crack_1") == "arrived_boundary"
    steady, middle = largest <= allowed and mean <= allowed_mean, crossed and abs(off) <= 2.0
    ahead = (
        "crosses the plate in its middle" if middle else "does not cross the plate in its middle"
    )
    return Claim(
        f"5.2 Straight path, {label}, {n} points",
        f"angles within {allowed:g} deg, {allowed_mean:g} in the mean",
        "0 deg by symmetry",
        f"{told(run, 'crack_1')} at y = {path[-1, 1]:.1f} mm{lost(run)}",
        grade(steady, middle),
        "crosses the plate and ends within 2 mm; all segments count: in front of the free edge, "
        "where its domain radius is below two element sizes, a tip grows straight ahead",
        error=f"largest {largest:.2f}, mean {mean:.2f} deg; end {off:+.1f} mm off the middle",
        figures="9 10" if kind == "cf" else "10",
        sentence="The edge crack in tension grows straight across the plate, within the paper's "
        "range of angles."
        if steady and middle
        else f"By the {label} on {n} points the edge crack {ahead}, "
        f"{'within' if steady else 'beyond'} the paper's range of angles.",
    )


def tip_against_domain(e: Evidence) -> Claim:
    """CF of the tip node alone scatters."""
    found = []
    for n in STRAIGHT:
        run = steps(e.edge, f"cf_{n}").isel(tip=0)
        tangent = np.append(0.0, segment_angles(tip_path(e.edge, f"cf_{n}")))
        at_tip = np.degrees(np.arctan2(run.cf_tip_y, run.cf_tip_x)).values - tangent
        ahead = slice(0, -3)
        found.append((np.abs(run.cf_angle.values[ahead]).max(), np.abs(at_tip[ahead]).max()))
    better = [n for n, (domain, tip) in zip(STRAIGHT, found, strict=True) if domain < tip]
    return Claim(
        "5.2 Angle along the path: domain against tip node",
        "the domain scatters less",
        "0 deg by symmetry",
        "smaller on " + " and ".join(f"{n}" for n in better) + " points" if better else "nowhere",
        "yes" if all(domain < tip for domain, tip in found) else "no",
        "largest angle of CF from the crack, on the path that the domain gives",
        error="; ".join(
            f"{n} points: domain {domain:.2f}, tip {tip:.2f} deg"
            for n, (domain, tip) in zip(STRAIGHT, found, strict=True)
        ),
        figures="9",
        sentence="Along the path the angle of CF scatters less on a domain than at the tip node, "
        f"on {len(better)} of {len(STRAIGHT)} grids.",
    )


def fixed_grips(e: Evidence) -> Claim:
    """Energy release rate along the straight path."""
    run = steps(e.edge, "t6").isel(tip=0)
    solved = run.G.notnull().values
    found = np.interp(list(FIXED_GRIPS), run.crack_length.values[solved], run.G.values[solved])
    errors = found / np.array(list(FIXED_GRIPS.values())) - 1.0
    near = np.abs(errors).max() <= 0.01
    return Claim(
        "5.2 G at fixed grips, a = 100, 200, 300 mm",
        "",
        ", ".join(f"{value:g}" for value in FIXED_GRIPS.values()) + " N/mm",
        ", ".join(f"{value:.2f}" for value in found) + " N/mm",
        "yes" if near else "no",
        f"within 1 % on a uniform T6 grid, {int(run.n_points[0])} points",
        error=", ".join(f"{100 * error:+.2f}" for error in errors) + " %",
        sentence=f"At fixed grips G of the growing edge crack is {'' if near else 'not '}that of "
        "converged computations, within 1 %.",
    )


def snap_back(e: Evidence) -> Claim:
    """The whole equilibrium path under crack control."""
    run = steps(e.edge, "crack_control")
    # The last segments are in front of the free edge, where G is inaccurate.
    run = run.isel(step=slice(0, -4))
    opening = run.load_factor.values
    spent = (run.strain_energy + run.fracture_energy).values
    missing = np.abs(run.external_work.values / spent - 1.0).max()
    held = 0 < opening.argmin() < len(opening) - 1 and missing < 0.005
    return Claim(
        "5.2 Equilibrium path (control: crack)",
        "",
        "work of the loads = strain energy + g_c times new length",
        f"the grips go back from {opening[0]:.4f} to {opening.min():.4f} mm and forth again",
        "yes" if held else "no",
        "the grips turn, and the balance holds within 0.5 % up to three segments from the edge",
        error=f"balance of energy within {100 * missing:.2f} %",
        sentence="The equilibrium path of the growing edge crack snaps back, with its energy in "
        "balance."
        if held
        else "The equilibrium path of the growing edge crack has no turn or no balance of energy.",
    )


def shear_path(e: Evidence) -> list[Claim]:
    """The path under shear."""
    x, y = reference("shear_plate_limit").T
    claims = []
    for name, label in {
        "cf": "CF direction, first order (paper)",
        "paper": "the same, points and volumes as in the paper",
        "cf_second": "CF direction, second order",
        "hoop_second_1.38": "largest hoop stress, second order",
        "t6_second_2.76": "largest hoop stress, second order, T6",
    }.items():
        path = tip_path(e.shear, name)
        run = steps(e.shear, name)
        missed = np.interp(x, path[:, 0], path[:, 1], right=np.nan) - y
        near = np.abs(missed).max() <= SHEAR
        order = "second" if "second" in name else "first"
        claims.append(
            Claim(
                f"5.3 Path under shear, {label}, {int(run.n_points[0])} points",
                "turns down, then flattens",
                "-14.68 deg; y - 80 = " + ", ".join(f"{v - 80:.3f}" for v in y),
                f"{segment_angles(path)[0]:.2f} deg; ends at y = {path[-1, 1]:.1f} mm",
                "yes" if near else "no",
                f"within {SHEAR:g} mm at x = 40, 50, 60 mm",
                error=", ".join(f"{v:+.3f}" for v in missed) + " mm",
                figures="12" if name == "hoop_second_1.38" else "11",
                sentence=f"Under shear, with segments of {order} order, the crack "
                + (
                    f"follows the converged path within {SHEAR:g} mm."
                    if near
                    else f"leaves the converged path by more than {SHEAR:g} mm."
                ),
            )
        )
    return claims
