"""Claims of section 5.2: an edge crack in tension."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cfmpm.body.grid import Floats
from workflows.growth.datasets import radius_of, segment_angles, steps, tip_path
from workflows.growth.edge_figures import RANGES
from workflows.growth.evidence import Evidence, arrival, grade, lost, reset, share, told, toughness
from workflows.growth.outcomes import Outcome, outcomes, range_of_angles
from workflows.reporting.claim_table import Claim, paper_claim

# G of the edge crack at u_y = 1 mm at each end, by crack length [N/mm]: converged T6 grids.
FIXED_GRIPS = {100.0: 328.87, 200.0: 479.48, 300.0: 489.83}
# A mean angle, and a distance from the middle, that no figure shows [deg, mm].
MEAN, MIDDLE = 0.5, 2.0
TIP = "crack_1"
# The statement of each range.
STATED = {790: "edge_790", 2584: "edge_2584"}


def set_up(e: Evidence) -> Claim:
    """Domain radius, grid and toughness are those of the paper."""
    radii = {n: radius_of(e.edge, f"as_printed_{n}") for n in RANGES}
    points = {n: int(steps(e.edge, f"as_printed_{n}").n_points[0]) for n in RANGES}
    g_c = toughness(steps(e.edge, "as_printed_2584"))
    same = all(radius == 50.0 for radius in radii.values()), abs(g_c - 1.0) < 1e-6
    near = all(abs(points[n] / n - 1.0) <= 0.01 for n in RANGES)
    return paper_claim(
        "edge_loading",
        found=f"R = {radii[2584]:g} mm at the start, g_c = {g_c:g} N/mm, "
        + " and ".join(f"{found} points" for found in points.values()),
        held=grade(*same, near),
        test="radius and g_c the same, points within 1 %",
        sentence="The edge crack is computed with the radius, the toughness and the grids of the "
        "paper; its displacement is not given.",
    )


def angles_in_range(e: Evidence) -> list[Claim]:
    """Angles lie in the ranges of the paper, on its grid and on others of about its size."""
    claims = []
    for n, (least, most) in RANGES.items():
        path = tip_path(e.edge, f"as_printed_{n}")
        low, high = _range(path)
        near = _near(e, n)
        inside = [least <= below and above <= most for below, above in map(range_of_angles, near)]
        best = _range(tip_path(e.edge, "best"))
        held = sum(inside)
        points = int(steps(e.edge, f"as_printed_{n}").n_points[0])
        claims.append(
            paper_claim(
                STATED[n],
                found=f"{low:.2f} to {high:.2f} deg on {points} points; of {len(near)} grids near "
                f"{n} points {held} stay within",
                held=share(held + (least <= low and high <= most), len(near) + 1),
                test="all segments, to the free edge; yes if on all grids, in part if on some",
                best=f"{best[0]:.2f} to {best[1]:.2f} deg",
                reference="0 deg by symmetry",
                sentence=f"Near {n} points the angles of growth stay within the paper's range on "
                f"{held} of {len(near)} grids.",
            )
        )
    return claims


def no_convergence(e: Evidence) -> Claim:
    """Angles go up and down on both grids."""
    turns = {}
    for n in RANGES:
        rise = np.diff(segment_angles(tip_path(e.edge, f"as_printed_{n}")))
        rise = rise[np.abs(rise) > 1e-6]
        turns[n] = sum(first * second < 0.0 for first, second in pairwise(rise))
    held = min(turns.values()) >= 2
    return paper_claim(
        "edge_no_convergence",
        found="; ".join(f"{n} points: {count} changes up and down" for n, count in turns.items()),
        held="yes" if held else "no",
        test="at least two on each grid",
        sentence="From segment to segment the angle of growth "
        f"{'goes up and down' if held else 'does not oscillate'} on both grids.",
    )


def finer_is_better(e: Evidence) -> Claim:
    """The finer grid gives smaller angles."""
    alone = {n: _mean_size(segment_angles(tip_path(e.edge, f"as_printed_{n}"))) for n in RANGES}
    many = {
        n: float(np.mean([_mean_size(segment_angles(one.path)) for one in _near(e, n)]))
        for n in RANGES
    }
    better = alone[2584] < alone[790], many[2584] < many[790]
    return paper_claim(
        "edge_finer",
        found=f"mean size of the angle {alone[790]:.2f} deg on 790, {alone[2584]:.2f} deg on 2584 "
        f"points; over ten grids each {many[790]:.2f} and {many[2584]:.2f} deg",
        held=grade(*better),
        test="smaller on the paper's grids, and in the mean of ten grids each",
        best=f"{_mean_size(segment_angles(tip_path(e.edge, 'best'))):.2f} deg",
        sentence=f"The finer grid gives {'' if all(better) else 'not always '}the smaller angles "
        "of growth.",
    )


def mean_angle(e: Evidence) -> Claim:
    """The mean angle along the path is near zero."""
    found = {n: _mean(tip_path(e.edge, f"as_printed_{n}")) for n in RANGES}
    near = {n: sum(abs(_mean(one.path)) <= MEAN for one in _near(e, n)) for n in RANGES}
    total = {n: len(_near(e, n)) for n in RANGES}
    held = sum(near.values()), sum(total.values())
    return paper_claim(
        "edge_mean",
        found="; ".join(
            f"{n} points: {found[n]:+.2f} deg, within {MEAN:g} deg on {near[n]} of {total[n]} grids"
            for n in RANGES
        ),
        held=share(*held),
        test=f"angle from the first to the last tip, within {MEAN:g} deg on all grids",
        best=f"{_mean(tip_path(e.edge, 'best')):+.3f} deg",
        reference="0 deg by symmetry",
        sentence=f"The mean angle of growth is within {MEAN:g} deg of zero on {held[0]} of "
        f"{held[1]} grids.",
    )


def centre_line(e: Evidence) -> Claim:
    """The crack ends in the middle of the far edge."""
    found, held, total = [], 0, 0
    for n in RANGES:
        end = tip_path(e.edge, f"as_printed_{n}")[-1, 1] - 500.0
        near = _near(e, n)
        middle = sum(_in_the_middle(one) for one in near)
        held, total = held + middle, total + len(near)
        found.append(f"{n} points: ends {end:+.1f} mm off; within on {middle} of {len(near)} grids")
    return paper_claim(
        "edge_centre_line",
        found="; ".join(found),
        held=share(held, total),
        test=f"comes across, and ends within {MIDDLE:g} mm of the middle, on all grids",
        best=f"{told(steps(e.edge, 'best'), TIP)} {tip_path(e.edge, 'best')[-1, 1] - 500.0:+.2f} "
        "mm off the middle",
        reference="the middle, by symmetry",
        sentence=f"The crack crosses the plate within {MIDDLE:g} mm of its middle on {held} of "
        f"{total} grids.",
    )


def one_segment(e: Evidence) -> Claim:
    """In each step the crack grows by one segment."""
    found, held = [], []
    for n in RANGES:
        run = steps(e.edge, f"as_printed_{n}").isel(tip=0)
        grown = np.hypot(run.tip_x.diff("step"), run.tip_y.diff("step")).values
        held.append(bool((grown > 0.0).all()))
        found.append(f"{n} points: {len(grown)} steps, {(grown > 0.0).sum()} segments")
    return paper_claim(
        "edge_segments",
        found="; ".join(found),
        held=grade(*held),
        test="the tip moves in each step",
        sentence="Each step of growth releases one segment."
        if all(held)
        else "Not each step of growth releases a segment.",
    )


def tip_against_domain(e: Evidence) -> Claim:
    """CF of the tip node alone scatters."""
    found = []
    for n in RANGES:
        run = steps(e.edge, f"as_printed_{n}").isel(tip=0)
        tangent = np.append(0.0, segment_angles(tip_path(e.edge, f"as_printed_{n}")))
        at_tip = np.degrees(np.arctan2(run.cf_tip_y, run.cf_tip_x)).values - tangent
        ahead = slice(0, -3)
        found.append((np.abs(run.cf_angle.values[ahead]).max(), np.abs(at_tip[ahead]).max()))
    better = [n for n, (domain, tip) in zip(RANGES, found, strict=True) if domain < tip]
    return Claim(
        "5.2 Angle along the path: domain against tip node",
        "",
        "0 deg by symmetry",
        "smaller on " + " and ".join(f"{n}" for n in better) + " points" if better else "nowhere",
        grade(*(n in better for n in RANGES)),
        "largest angle of CF from the crack, on the path that the domain gives",
        error="; ".join(
            f"{n} points: domain {domain:.2f}, tip {tip:.2f} deg"
            for n, (domain, tip) in zip(RANGES, found, strict=True)
        ),
        figures="9",
        sentence="Along the path the angle of CF scatters less on a domain than at the tip node, "
        f"on {len(better)} of {len(RANGES)} grids.",
    )


def larger_domain(e: Evidence) -> Claim:
    """With twice the radius the crack runs straight."""
    found = outcomes(e.edge_grids, TIP, how="twice")
    middle = sum(map(_in_the_middle, found))
    return Claim(
        "5.2 Straight path with twice the radius, R = 100 mm",
        "",
        "the middle, by symmetry",
        f"within {MIDDLE:g} mm of the middle on {middle} of {len(found)} grids",
        share(middle, len(found)),
        "50 mm are less than two of the elements of 790 points",
        figures="scatter_edge",
        sentence=f"With twice the radius the edge crack keeps to the middle on {middle} of "
        f"{len(found)} grids.",
    )


def whole_loop(e: Evidence) -> Claim:
    """Growth with the grid reset after each release."""
    runs = {f"{n} points": steps(e.edge, f"reset_{n}") for n in RANGES}
    return reset("5.2", runs, TIP, "9")


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


def best_path(e: Evidence) -> Claim:
    """By the best that can be had the crack runs straight."""
    run, path = steps(e.edge, "best"), tip_path(e.edge, "best")
    largest, off = np.abs(segment_angles(path)).max(), path[-1, 1] - 500.0
    held = arrival(run, TIP) == "arrived_boundary" and abs(off) <= 0.1
    return Claim(
        f"5.2 Straight path by the best, {int(run.n_points[0])} points",
        "",
        "0 deg by symmetry",
        f"{told(run, TIP)} at y = {path[-1, 1]:.2f} mm{lost(run)}",
        "yes" if held else "no",
        "crosses the plate and ends within 0.1 mm of the middle",
        error=f"largest angle {largest:.2f} deg; end {off:+.3f} mm off the middle",
        figures="9 10",
        sentence="By the best that can be had the edge crack "
        f"{'crosses' if held else 'does not cross'} the plate in its middle, within 0.1 mm.",
    )


def _near(e: Evidence, n: int) -> list[Outcome]:
    """The crack as printed on grids of about as many points."""
    found = outcomes(e.edge_grids, TIP, how="as_printed")
    return [one for one in found if abs(one.points - n) < abs(one.points - sum(RANGES) + n)]


def _in_the_middle(one: Outcome) -> bool:
    return one.status == "arrived_boundary" and abs(one.path[-1, 1] - 500.0) <= MIDDLE


def _range(path: Floats) -> tuple[float, float]:
    angles = segment_angles(path)
    return float(angles.min()), float(angles.max())


def _mean(path: Floats) -> float:
    """Angle from the first to the last tip [deg]."""
    return float(np.degrees(np.arctan2(*(path[-1] - path[0])[::-1])))


def _mean_size(angles: Floats) -> float:
    return float(np.abs(angles).mean())
