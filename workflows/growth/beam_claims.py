"""Claims of section 5.5: a beam with three holes."""

from __future__ import annotations

import numpy as np
import xarray as xr

from workflows.growth.datasets import segment_angles, steps, tip_path
from workflows.growth.evidence import Evidence, arrival, grade, told
from workflows.growth.figures import BOTTOM, HOLE, INCH, MIDDLE, distance_to_path, gap_to_hole
from workflows.reference.path_points import reference
from workflows.reporting.claim_table import Claim

# Largest distance from the reference paths [mm], and difference of the kink [deg].
BEAM, KINK = 1.5, 0.4


def beam_paths(e: Evidence) -> list[Claim]:
    """The paths at three holes."""
    return [
        _beam(e, name, case, kink, label)
        for case, kink in (("15_5", -16.8), ("10_4", -12.6), ("10_6", -12.2))
        for name, label in (("cf", "CF direction, T3 (paper)"), ("hoop", "hoop stress, T6"))
    ]


def _beam(e: Evidence, name: str, case: str, kink: float, label: str) -> Claim:
    path = tip_path(e.beam, f"{name}_{case}")
    run = steps(e.beam, f"{name}_{case}")
    known = reference(f"beam_{case}")
    # Up to two radii below the level of the bottom hole, where its near-miss begins.
    before = known[known[:, 1] < 2.25 * INCH]
    missed = max(distance_to_path(path, point) for point in before)
    first = segment_angles(path)[0] - 90.0
    bottom, middle = (gap_to_hole(path, hole) for hole in (BOTTOM, MIDDLE))
    along, kinked = missed <= BEAM, abs(first - kink) <= KINK
    return Claim(
        f"5.5 Three holes, a = {int(case[:2]) / 10:g} in, x = {case[3]} in, {label}",
        "",
        f"kink {kink:g} deg",
        f"kink {first:.1f} deg; gaps {max(bottom, 0.0):.1f} mm at the bottom, "
        f"{max(middle, 0.0):.1f} mm at the middle hole; {_arrived_at(run)}",
        grade(along, kinked),
        f"within {BEAM:g} mm of the reference before the holes, kink within {KINK:g} deg",
        error=f"{missed:.2f} mm before the holes, kink {first - kink:+.1f} deg",
        figures="15",
        sentence="Beam with three holes, by the "
        f"{'CF direction' if name == 'cf' else 'largest hoop stress'}: the crack "
        f"{'follows' if along else 'leaves'} the reference path before the holes, and its first "
        f"angle {'agrees' if kinked else f'is {abs(first - kink):.0f} deg off'}.",
    )


def beam_cases(e: Evidence) -> list[Claim]:
    """The paper's two cases by its words; which specimen case II is, it does not say."""
    kinds = {"cf": "CF direction", "hoop": "hoop stress"}
    first = {kind: tip_path(e.beam, f"{kind}_15_5") for kind in kinds}
    gaps = {
        kind: [gap_to_hole(path, hole) for hole in (BOTTOM, MIDDLE)] for kind, path in first.items()
    }
    # Where the crack is at the level of the middle hole.
    right = [np.interp(MIDDLE[1], path[:, 1], path[:, 0]) > MIDDLE[0] for path in first.values()]
    near = [0.0 < gap <= HOLE for both in gaps.values() for gap in both]
    others = {f"{kind}_{case}": kind for case in ("10_4", "10_6") for kind in kinds}
    arrested = [
        arrival(steps(e.beam, name), "crack_1") == "arrived_hole"
        and gap_to_hole(tip_path(e.beam, name)[-2:], BOTTOM) < 0.01 * HOLE
        for name in others
    ]
    return [
        Claim(
            "5.5 Case I, read as a = 1.5 in, x = 5 in",
            "towards the bottom hole, deflects to its other side, comes to the right of the middle "
            "hole",
            "passes both at 2.5 to 3.2 mm",
            "; ".join(
                f"{kinds[kind]}: {'right' if side else 'left'} of the middle hole, gaps "
                + " and ".join(f"{gap:.1f} mm" for gap in gaps[kind])
                for kind, side in zip(kinds, right, strict=True)
            ),
            grade(all(right), all(near)),
            "to the right at the level of the middle hole, within a radius of the edges of both",
            figures="15",
            sentence="Case I of the beam: the crack "
            f"{'passes' if all(right) else 'does not pass'} to the right of the middle hole, "
            f"{'near' if all(near) else 'not near'} the edges of both holes.",
        ),
        Claim(
            "5.5 Case II, which may be a = 1.0 in, x = 4 or 6 in",
            "the bottom hole arrests the crack",
            "x = 4 in: into the middle hole; x = 6 in: past the bottom hole by 2.5 mm",
            "; ".join(
                f"x = {name[-1]} in, {kinds[kind]}: {_arrived_at(steps(e.beam, name))}"
                for name, kind in others.items()
            ),
            grade(any(arrested)),
            "one of them ends in the bottom hole",
            figures="15",
            sentence="The paper states that the bottom hole arrests the crack in case II of the "
            f"beam; here it does in {sum(arrested)} of {len(arrested)} computations.",
        ),
    ]


def _arrived_at(run: xr.Dataset) -> str:
    """What became of the crack, and where [in]."""
    ends = run.isel(tip=0, step=-1)
    x, y = float(ends.tip_x) / INCH, float(ends.tip_y) / INCH
    return f"{told(run, 'crack_1')} at ({x:.2f}, {y:.2f}) in"


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
        "deflects to the opposite side",
        f"passes in {known[0]:.2f} mm (remeshing), {known[1]:.2f} mm (XFEM)",
        ", ".join(f"{g:.2f} mm (size {s})" for g, s in zip(gaps, sizes, strict=True)),
        "yes" if passes else "no",
        "no grid is caught; the finest passes within 0.3 mm of the references' distance",
        error=f"{gaps[-1] - np.mean(known):+.2f} mm on the finest grid",
        figures="16",
        sentence="On finer grids the crack in the beam "
        f"{'passes' if passes else 'does not pass'} the bottom hole at the distance that remeshing "
        "and XFEM give.",
    )
