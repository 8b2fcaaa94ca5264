"""Claims of section 5.5: a beam with three holes."""

from __future__ import annotations

import numpy as np
import xarray as xr

from cfmpm.body.grid import Floats
from workflows.growth.beam_figures import AS_IN_THE_PAPER, HOW
from workflows.growth.beam_holes import (
    BOTTOM,
    HOLE,
    INCH,
    MIDDLE,
    SPECIMENS,
    distance_to_path,
    gap_to_hole,
)
from workflows.growth.datasets import radius_of, segment_angles, steps, tip_path
from workflows.growth.evidence import Evidence, grade, share, told, toughness
from workflows.growth.outcomes import Outcome, beam_ending, outcomes, shares
from workflows.growth.outcomes import told as told_shares
from workflows.reference.path_points import reference
from workflows.reporting.claim_table import Claim, paper_claim

# Largest distance from the reference paths [mm], and difference of the kink [deg].
BEAM, KINK = 1.5, 0.4
KINKS = {"15_5": -16.8, "10_4": -12.6, "10_6": -12.2}
TIP = "crack_1"


def set_up(e: Evidence) -> Claim:
    """The load is that of the paper."""
    run = steps(e.beam, "as_printed_15_5")
    force = float(-run.reaction_y[0].min())
    radii = ", ".join(f"{radius_of(e.beam, f'as_printed_{case}'):g}" for case in SPECIMENS)
    return paper_claim(
        "beam",
        found=f"P = {force:g} N per mm of thickness; G = {float(run.G[0, 0]):.4f} N/mm at the "
        f"start, so that g_c = {toughness(run):g} N/mm lets the crack run (the paper states none); "
        f"R = {radii} mm",
        held="yes" if abs(force - 50.0) < 1e-6 else "no",
        test="force in balance with the supports",
        sentence="The beam is loaded by 50 N as in the paper.",
    )


def points(e: Evidence) -> Claim:
    """The grids have about as many points as those of the paper."""
    found = [int(steps(e.beam, f"as_printed_{case}").n_points[0]) for case in SPECIMENS]
    best = [int(steps(e.beam, f"best_{case}").n_points[0]) for case in SPECIMENS]
    held = [abs(n / 3500 - 1.0) <= 0.02 for n in found]
    return paper_claim(
        "beam_grid",
        found=", ".join(map(str, found)) + " points",
        held=grade(*held),
        test="within 2 % of 3500",
        best=", ".join(map(str, best)) + " points",
        sentence="The beam has about 3500 points, as in the paper.",
    )


def case_1(e: Evidence) -> Claim:
    """Case I passes the bottom hole and comes to the right of the middle one."""
    found = {how: outcomes(e.beam_grids, TIP, case="15_5", how=how) for how in HOW}
    right = {how: [_at_the_right(one) for one in each] for how, each in found.items()}
    printed = AS_IN_THE_PAPER["15_5"]
    into = sum(beam_ending(one) == "in the middle hole" for one in found["domains"])
    held = sum(right[printed])
    total = len(found[printed])
    return paper_claim(
        "beam_case_1",
        found=f"to the right of the middle hole on {held} of {total} grids; "
        f"{told_shares(shares(found[printed], beam_ending))}; with R = 12.7 mm "
        f"{told_shares(shares(found['R_12.7'], beam_ending))}",
        held=share(held, total),
        test="passes the bottom hole on its left, and is to the right of the centre of the middle "
        f"one, within {HOLE:g} mm of its edge; as printed R = 19.05 mm, one half of the crack",
        best=_passing(e, "best_15_5"),
        reference=f"own remeshing: {_gaps(reference('beam_15_5'))}",
        sentence="Case I of the beam: the crack passes the bottom hole and comes to the right of "
        f"the middle one on {held} of {total} grids; with a domain of 12.7 mm and points that keep "
        f"their domains it ends in the middle hole, on {into} of {len(found['domains'])}.",
    )


def case_2(e: Evidence) -> Claim:
    """Case II is arrested by the bottom hole."""
    told_, held, total = [], 0, 0
    for case in ("10_6", "10_4"):
        found = outcomes(e.beam_grids, TIP, case=case, how=AS_IN_THE_PAPER[case])
        ends = shares(found, beam_ending)
        told_.append(f"x = {case[3]} in: {told_shares(ends)}")
        if case == "10_6":
            held = sum(_arrested(one) for one in found)
            total = len(found)
    domains = outcomes(e.beam_grids, TIP, case="10_6", how="domains")
    return paper_claim(
        "beam_case_2",
        found="; ".join(told_)
        + f"; by domains, x = 6 in: {told_shares(shares(domains, beam_ending))}",
        held=share(held, total),
        test="read as a = 1 in at x = 6 in, R = 12.7 mm: ends in the bottom hole, or stops within "
        "a tenth of a radius of its edge, on all grids",
        best=f"x = 6 in: {_passing(e, 'best_10_6')}; x = 4 in: {_passing(e, 'best_10_4')}",
        reference=f"own remeshing: x = 6 in passes, {_gaps(reference('beam_10_6'))}; x = 4 in "
        "ends in the middle hole",
        sentence=f"Case II of the beam: arrested by the bottom hole on {held} of {total} grids; "
        "chance of the grid decides, and with finer grids the crack passes.",
    )


def all_paths(e: Evidence) -> Claim:
    """The paths resemble the literature before they come to the holes."""
    missed = {case: _before_the_holes(e, f"as_printed_{case}") for case in SPECIMENS}
    best = {case: _before_the_holes(e, f"best_{case}") for case in SPECIMENS}
    held = [value <= BEAM for value in missed.values()]
    return paper_claim(
        "conclusion_paths",
        found="beam: "
        + ", ".join(f"{value:.1f} mm" for value in missed.values())
        + " from own remeshing before the holes; sections 5.3 and 5.4: as above",
        held=grade(*held),
        test=f"beam: within {BEAM:g} mm before the holes, in all three specimens",
        best=", ".join(f"{value:.1f} mm" for value in best.values()),
        sentence="Before they come to the holes the paths in the beam "
        f"{'follow' if all(held) else 'do not all follow'} those of remeshing within {BEAM:g} mm.",
    )


def beam_paths(e: Evidence) -> list[Claim]:
    """Paths and kinks at three holes."""
    return [
        _beam(e, kind, case, label)
        for case in SPECIMENS
        for kind, label in (("as_printed", "as printed"), ("best", "by the best"))
    ]


def _beam(e: Evidence, kind: str, case: str, label: str) -> Claim:
    name, kink = f"{kind}_{case}", KINKS[case]
    path = tip_path(e.beam, name)
    missed = _before_the_holes(e, name)
    first = segment_angles(path)[0] - 90.0
    along, kinked = missed <= BEAM, abs(first - kink) <= KINK
    return Claim(
        f"5.5 Three holes, a = {int(case[:2]) / 10:g} in, x = {case[3]} in, {label}",
        "",
        f"kink {kink:g} deg (own remeshing)",
        f"kink {first:.1f} deg; {_passing(e, name)}",
        grade(along, kinked),
        f"within {BEAM:g} mm of the reference before the holes, kink within {KINK:g} deg",
        error=f"{missed:.2f} mm before the holes, kink {first - kink:+.1f} deg",
        figures="16",
        sentence=f"Beam with three holes, {label}: the crack {'follows' if along else 'leaves'} "
        "the reference path before the holes, and its first angle "
        f"{'agrees' if kinked else f'is {abs(first - kink):.0f} deg off'}.",
    )


def near_miss(e: Evidence) -> Claim:
    """Whether the bottom hole catches the crack is not decided by the grid."""
    sizes = sorted(
        (int(v.removeprefix("first_")) for v in e.beam.variant.values if v.startswith("first_")),
        reverse=True,
    )
    gaps = [gap_to_hole(tip_path(e.beam, f"first_{size}"), BOTTOM) for size in sizes]
    known = [gap_to_hole(reference(name), BOTTOM) for name in ("beam_15_5", "beam_15_5_xfem")]
    passes = abs(gaps[-1] - np.mean(known)) < 0.3 and min(gaps) > 0.0
    return Claim(
        "5.5 Near-miss of the bottom hole, a = 1.5 in",
        "",
        f"passes in {known[0]:.2f} mm (remeshing), {known[1]:.2f} mm (XFEM)",
        ", ".join(f"{g:.2f} mm (size {s})" for g, s in zip(gaps, sizes, strict=True)),
        "yes" if passes else "no",
        "hoop stress: no grid is caught; the finest passes within 0.3 mm of the references' gap",
        error=f"{gaps[-1] - np.mean(known):+.2f} mm on the finest grid",
        figures="near_miss_beam",
        sentence="On finer grids the crack in the beam "
        f"{'passes' if passes else 'does not pass'} the bottom hole at the distance that remeshing "
        "and XFEM give.",
    )


def _at_the_right(one: Outcome) -> bool:
    """Whether a crack passes the bottom hole on its left and comes to the right of the middle."""
    x, y = one.path.T
    above = one.path[y > BOTTOM[1] + HOLE]
    if not len(above) or np.interp(BOTTOM[1], y, x) > BOTTOM[0]:
        return False
    nearest = above[np.hypot(*(above - MIDDLE).T).argmin()]
    return bool(nearest[0] > MIDDLE[0] and gap_to_hole(above, MIDDLE) <= HOLE)


def _arrested(one: Outcome) -> bool:
    return beam_ending(one) in ("in the bottom hole", "short of the bottom hole")


def _before_the_holes(e: Evidence, name: str) -> float:
    """Largest distance from own remeshing up to two radii below the bottom hole [mm]."""
    path, known = tip_path(e.beam, name), reference(f"beam_{name[-4:]}")
    before = known[known[:, 1] < 2.25 * INCH]
    return max(distance_to_path(path, point) for point in before)


def _gaps(path: Floats) -> str:
    bottom, middle = (gap_to_hole(path, hole) for hole in (BOTTOM, MIDDLE))
    at_bottom, at_middle = max(bottom, 0.0), max(middle, 0.0)
    return f"gaps {at_bottom:.1f} mm at the bottom, {at_middle:.1f} mm at the middle hole"


def _passing(e: Evidence, name: str) -> str:
    """Gaps to the holes, what became of the crack, and where [in]."""
    run: xr.Dataset = steps(e.beam, name)
    ends = run.isel(tip=0, step=-1)
    x, y = float(ends.tip_x) / INCH, float(ends.tip_y) / INCH
    return f"{_gaps(tip_path(e.beam, name))}; {told(run, TIP)} at ({x:.2f}, {y:.2f}) in"
