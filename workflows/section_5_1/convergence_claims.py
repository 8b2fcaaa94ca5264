"""Claims of section 5.1 about convergence: tip and domain, MPM and FEM, T3 and T6."""

from __future__ import annotations

import numpy as np

from workflows.reporting.claim_table import Claim, paper_claim
from workflows.section_5_1.evidence import (
    Evidence,
    degrees,
    grade,
    largest_difference,
    percent,
    percents,
    word,
)

# Two computations are the same where they differ by round-off only.
ROUND_OFF = 1e-10
# Bars for the paper's words: very close to the analytical value; T3 similar to T6, in the norm
# and in the angle [deg].
VERY_CLOSE, SIMILAR, SIMILAR_ANGLE = 0.02, 0.05, 0.1
# Of the paper's seven numbers of points, how far those here may be off.
SAME_GRID = 0.01


def discretisations(e: Evidence) -> Claim:
    """Seven grids of the paper's size."""
    points = e.T3.n_points.values
    off = np.abs(points / e.T3.grid.values - 1.0).max()
    return paper_claim(
        "discretisations",
        found=", ".join(f"{int(n)}" for n in points) + " points",
        held=word(off <= SAME_GRID),
        test=f"each within {100 * SAME_GRID:g} % of the paper's number; gmsh does not give the "
        "same triangles",
        error=f"up to {100 * off:.1f} %",
        sentence="The seven grids have the paper's numbers of points, to a per cent."
        if off <= SAME_GRID
        else "The grids do not have the paper's numbers of points.",
    )


def tip_oscillates(e: Evidence) -> Claim:
    """The tip node alone."""
    norms, angles = np.diff(e.tip_norm()), e.tip_angle()
    falls = int((norms < 0).sum())
    turns = int((np.sign(angles[1:]) != np.sign(angles[:-1])).sum())
    held = word(falls > 0 and turns > 0, "yes", "in part" if falls or turns else "no")
    return paper_claim(
        "tip_oscillates",
        found=f"the norm falls in {falls} of {len(norms)} refinements; the angle changes its sign "
        f"in {turns}",
        held=held,
        test="neither the norm rises nor the angle keeps its side in all refinements",
        error=f"norm {percents(e.error(e.tip_norm()))}; angle {degrees(angles)}",
        sentence="At the tip node alone CF does not converge uniformly: the angle "
        f"{'changes its side' if turns else 'keeps its side'}, and the norm stays "
        f"{100 * abs(e.error(e.tip_norm())[-1]):.0f} % off on the finest grid.",
    )


def domain_converges(e: Evidence) -> Claim:
    """The domain converges, the tip node does not."""
    domain, tip = (np.abs(e.error(norms)) for norms in (e.norm(e.T3), e.tip_norm()))
    order, of_tip = (
        -2.0 * np.polyfit(np.log(e.T3.n_unknowns), np.log(errors), 1)[0] for errors in (domain, tip)
    )
    falls = bool((np.diff(domain) < 0).all())
    better = order > of_tip and abs(e.angle(e.T3)[-1]) < abs(e.tip_angle()[-1])
    return paper_claim(
        "domain_converges",
        found=f"order h^{order:.2f}, on the tip node h^{of_tip:.2f}; angle on the finest grid "
        f"{abs(e.angle(e.T3)[-1]):.3f} deg, on the tip node {abs(e.tip_angle()[-1]):.2f}",
        held=grade(falls, better),
        test="the error of the norm falls in every refinement, and faster than on the tip node; "
        "the angle is better on the finest grid",
        reference="order h, because of the singularity",
        best=f"T6 graded to the tip: {percent(e.error(e.norm(e.graded))[-1], 4)}",
        error=percents(e.error(e.norm(e.T3))),
        sentence="On a domain CF converges with every finer grid, in norm and angle."
        if falls and better
        else "On a domain CF does not converge better than on the tip node.",
    )


def conclusion_domain(e: Evidence) -> Claim:
    """The domain is generally more accurate."""
    norm = np.abs(e.error(e.norm(e.T3))) < np.abs(e.error(e.tip_norm()))
    angle = np.abs(e.angle(e.T3)) < np.abs(e.tip_angle())
    most = [2 * better.sum() > better.size for better in (norm, angle)]
    return paper_claim(
        "conclusion_domain",
        found=f"smaller error of the norm on {norm.sum()} of {norm.size} grids, of the angle on "
        f"{angle.sum()}",
        held=grade(*most),
        test="on most grids, norm and angle each",
        error=f"norm: domain {percents(e.error(e.norm(e.T3)))}, tip "
        f"{percents(e.error(e.tip_norm()))}; angle: domain {degrees(np.abs(e.angle(e.T3)))}, tip "
        f"{degrees(np.abs(e.tip_angle()))}",
        sentence=f"The domain is more accurate than the tip node on {norm.sum()} of {norm.size} "
        f"grids in the norm and on {angle.sum()} in the angle.",
    )


def constant_strain(e: Evidence) -> Claim:
    """T6 is more accurate, on the same triangles and for the same unknowns."""
    linear, quadratic = (np.abs(e.error(e.norm(one))) for one in (e.T3, e.T6))
    same_triangles = quadratic < linear
    fit = np.polyfit(np.log(e.T3.n_unknowns), np.log(linear), 1)
    per_unknown = quadratic < np.exp(np.polyval(fit, np.log(e.T6.n_unknowns)))
    held = same_triangles.all() and per_unknown.all()
    return paper_claim(
        "constant_strain",
        found=f"T6 has the smaller error on {same_triangles.sum()} of {len(linear)} grids, for "
        f"equal unknowns (T3 fitted) on {per_unknown.sum()}",
        held=grade(same_triangles.all(), per_unknown.all()),
        test="on every grid, for the same triangles and for the same unknowns",
        best=f"T6 graded to the tip: {percent(e.best / e.converged - 1, 4)}",
        error=f"T3 {percents(e.error(e.norm(e.T3)))}; T6 {percents(e.error(e.norm(e.T6)))}",
        sentence="Six-node triangles are more accurate than three-node ones on "
        f"{word(held, 'every grid', 'some grids only')}, for the same triangles and for the same "
        "unknowns; grading to the tip gains far more.",
    )


def fem_norm_coarse(e: Evidence) -> Claim:
    """FEM on the same grid is the same."""
    better = np.abs(e.error(e.norm(e.T3, "FEM"))) < np.abs(e.error(e.norm(e.T3))) * (1 - ROUND_OFF)
    coarse = better[: len(better) // 2]
    return paper_claim(
        "fem_norm_coarse",
        found=f"FEM is better on {coarse.sum()} of the {coarse.size} coarse grids; MPM and FEM "
        f"differ by up to {largest_difference(e.T3):.0e}",
        held=word(coarse.all(), "yes", "in part" if coarse.any() else "no"),
        test="on the three coarse grids, by scikit-fem on the same triangles; the FEM of [45] has "
        "grids of its own",
        reference="the same: one point in a T3 is the quadrature of FEM",
        sentence=_like_fem(e),
    )


def fem_norm_fine(e: Evidence) -> Claim:
    """Both similar, and near the line."""
    off = float(np.abs(e.norm(e.T3) / e.norm(e.T3, "FEM") - 1.0)[-3:].max())
    line = e.line_error(e.norm(e.T3))[-1]
    similar, close = off <= VERY_CLOSE, abs(line) <= VERY_CLOSE
    return paper_claim(
        "fem_norm_fine",
        found=f"differ by {off:.0e} on the three finest grids; {percent(line)} of the line on the "
        "finest",
        held=grade(similar, close),
        test=f"within {100 * VERY_CLOSE:g} % of each other, and of the line on the finest grid",
        best=f"T6 graded: {percent(e.best / e.handbook - 1)} of the line",
        sentence=f"On fine grids MPM and FEM {'agree' if similar else 'do not agree'}, "
        f"{100 * abs(line):.0f} % off the analytical value.",
    )


def fem_angle(e: Evidence) -> Claim:
    """The angle is the same too."""
    off = max(
        np.abs(own - fem).max()
        for own, fem in (
            (e.angle(e.T3), e.angle(e.T3, "FEM")),
            (e.tip_angle(), e.tip_angle("FEM")),
        )
    )
    better = np.abs(e.angle(e.T3)) < np.abs(e.angle(e.T3, "FEM")) - 1e-6
    return paper_claim(
        "fem_angle",
        found=f"angles of MPM and FEM differ by up to {off:.0e} deg",
        held=word(2 * better.sum() > better.size),
        test="MPM has the smaller angle on most grids, by more than 1e-6 deg",
        reference="the same: one point in a T3 is the quadrature of FEM",
        sentence=_like_fem(e),
    )


def _like_fem(e: Evidence) -> str:
    return word(
        largest_difference(e.T3) < ROUND_OFF,
        "On the same grid MPM and FEM give the same CF, to round-off: neither is better in the "
        "norm nor faster in the angle.",
        "On the same grid MPM and FEM do not give the same CF.",
    )


def t6_points(e: Evidence) -> Claim:
    """Three points for one."""
    ratio = e.T6.n_points.values / e.T3.n_points.values
    held = bool((ratio == 3).all())
    return paper_claim(
        "t6_points",
        found=f"{ratio.min():g} times on every grid" if held else f"{ratio.min():g} times",
        held=word(held),
        test="on the same triangles",
        sentence=f"T6 has {ratio.min():g} times the points of T3.",
    )


def t3_like_t6(e: Evidence) -> Claim:
    """T3 is similar to T6."""
    off = e.norm(e.T3) / e.norm(e.T6) - 1.0
    turned = np.abs(e.angle(e.T3) - e.angle(e.T6))
    near, straight = np.abs(off) <= SIMILAR, turned <= SIMILAR_ANGLE
    better = (np.abs(e.error(e.norm(e.T6))) < np.abs(e.error(e.norm(e.T3)))).all()
    most = [2 * one.sum() > one.size for one in (near, straight)]
    return paper_claim(
        "t3_like_t6",
        found=f"norms within {100 * SIMILAR:g} % on {near.sum()} of {near.size} grids, angles "
        f"within {SIMILAR_ANGLE:g} deg on {straight.sum()}; T6 is more accurate on "
        f"{'every grid' if better else 'some grids'}",
        held=grade(*most),
        test="on most grids, norm and angle each",
        best="T6 graded to the tip",
        error=f"norm of T3 over T6 {percents(off)}; angles apart {degrees(turned)}",
        sentence="T3 and T6 give similar angles on "
        f"{straight.sum()} of {straight.size} grids, but similar norms on {near.sum()} only.",
    )


def converges_to_it(e: Evidence) -> Claim:
    """Very close to the analytical value."""
    ends = {name: e.line_error(e.norm(one))[-1] for name, one in (("T3", e.T3), ("T6", e.T6))}
    close = [abs(end) <= VERY_CLOSE for end in ends.values()]
    return paper_claim(
        "converges_to_it",
        found="; ".join(f"{name} {percent(end)} of 256 N per metre" for name, end in ends.items())
        + f"; angles {abs(e.angle(e.T3)[-1]):.3f} and {abs(e.angle(e.T6)[-1]):.4f} deg",
        held=grade(*close),
        test=f"norm within {100 * VERY_CLOSE:g} % on the finest grid",
        reference=f"{e.converged:.6f} N/mm, {percent(e.converged / e.handbook - 1)} of the line: "
        "the plate is of finite height, the handbook's strip is not",
        best=f"T6 graded: {percent(e.best / e.converged - 1, 4)} of the plate's own value",
        sentence="On the finest grid "
        + " and ".join(f"{name} is {100 * abs(end):.1f} %" for name, end in ends.items())
        + " off the analytical value.",
    )


def analytical_value(e: Evidence) -> Claim:
    """The paper's 256 N is the handbook value per metre of thickness."""
    right = round(1e3 * e.handbook) == 256
    return paper_claim(
        "analytical_value",
        found=f"{1e3 * e.handbook:.1f} N per metre of thickness ({e.handbook:.5f} N/mm)",
        held=word(right, "yes, per metre of thickness"),
        test="the handbook's polynomial for an infinite strip rounds to 256 N per metre",
        best=f"{e.best:.6f} N/mm of this plate (J, T6 graded)",
        reference=f"{e.converged:.6f} N/mm, the plate of finite height",
        sentence=word(
            right,
            "The analytical value of 256 N is that of a handbook, per metre of thickness.",
            "A handbook does not give the paper's analytical value of 256 N.",
        ),
    )


def t6_cost(e: Evidence) -> Claim:
    """T6 costs more."""
    unknowns, points, time = (
        float((e.T6[name] / e.T3[name])[-1]) for name in ("n_unknowns", "n_points", "run_time")
    )
    held = unknowns > 1 and points > 1
    return paper_claim(
        "t6_cost",
        found=f"on the finest grid {unknowns:.1f} times the unknowns and {points:g} times the "
        f"points of T3; run time here, once, {time:.1f} times",
        held=word(held),
        test="unknowns and points on the finest grid; run times of single runs scatter",
        best="for the same error T6 is cheaper: see the error by unknowns, beyond the paper",
        sentence=f"T6 costs {'more' if held else 'no more'} than T3 on the same triangles: "
        f"{unknowns:.1f} times the unknowns.",
    )
