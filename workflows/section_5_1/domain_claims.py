"""Claims of section 5.1 about the domain: its radius, and where the forces of the nodes are."""

from __future__ import annotations

import numpy as np
import xarray as xr

from cfmpm.body.grid import Floats
from workflows.reporting.claim_table import Claim, paper_claim
from workflows.section_5_1.evidence import (
    Evidence,
    grade,
    of_nodes,
    percent,
    percents,
    settled,
    word,
)

# CF is settled where it stays this near to its value at the largest radius: norm, angle [deg].
SETTLED, SETTLED_ANGLE = 0.02, 0.1
# Forces have almost vanished where they are below this part of the tip's.
VANISHED, VANISH_AT, LAYERS = 0.1, 20.0, 4
# Radii that the paper states [mm]: of the two grids, and of the FEM of [45].
STATED, STATED_FEM = (20.0, 10.0), 15.0
# J and the component of CF along the crack are equal within this part.
PROJECTED = 0.01
# The step of the sweep of radii [mm].
STEP = 5.0


def _radii(e: Evidence, scheme: str = "MPM") -> list[tuple[float, float]]:
    """From where on norm and angle are settled, on the two grids of Fig. 6."""
    found = []
    for grid in e.swept:
        one = e.T3.sel(scheme=scheme, grid=grid)
        norm = settled(one.cf_norm, SETTLED, relative=True)
        found.append((norm, settled(one.cf_angle, SETTLED_ANGLE, relative=False)))
    return found


def _told(e: Evidence) -> str:
    return "; ".join(
        f"{e.points(grid)} points: norm from {norm:g} mm, angle from {angle:g} mm"
        for grid, (norm, angle) in zip(e.swept, _radii(e), strict=True)
    )


BAR = (
    f"norm within {100 * SETTLED:g} % and angle within {SETTLED_ANGLE:g} deg of the largest radius"
)


def settling_angle(e: Evidence) -> Claim:
    """From 50 mm on, on the coarser grid."""
    norm, angle = _radii(e)[0]
    held = max(norm, angle) <= e.radius
    return paper_claim(
        "settling_angle",
        found=_told(e).split(";")[0],
        held=word(held),
        test=f"{BAR}, from R = {e.radius:g} mm at the latest",
        reference="a few element sizes",
        best="T6 graded: from the smallest radius on",
        sentence=f"On the paper's grid CF {'is' if held else 'is not'} settled at R = "
        f"{e.radius:g} mm.",
    )


def settling_sooner(e: Evidence) -> Claim:
    """A finer grid settles sooner."""
    coarse, fine = _radii(e)
    sooner = fine[0] < coarse[0] and fine[1] <= coarse[1]
    as_stated = all(max(one) <= stated for one, stated in zip((coarse, fine), STATED, strict=True))
    return paper_claim(
        "settling_sooner",
        found=_told(e),
        held=grade(sooner, as_stated),
        test=f"{BAR}: sooner on the finer grid, and from the stated radii on",
        reference="a few element sizes",
        best="T6 graded: from the smallest radius on",
        sentence=f"The finer grid settles {'sooner' if sooner else 'no sooner'}, "
        + word(
            as_stated,
            "at the stated radii.",
            f"but not at the stated {STATED[0]:g} and {STATED[1]:g} mm.",
        ),
    )


def fem_radius(e: Evidence) -> Claim:
    """FEM needs the same radius."""
    own, fem = _radii(e)[1], _radii(e, "FEM")[1]
    similar = max(abs(a - b) for a, b in zip(own, fem, strict=True)) <= STEP
    stated = [abs(radius - STATED_FEM) <= STEP for radius in fem]
    return paper_claim(
        "fem_radius",
        found=f"FEM on {e.points(e.swept[1])} triangles: norm from {fem[0]:g} mm, angle from "
        f"{fem[1]:g} mm; MPM on the same grid {own[0]:g} and {own[1]:g} mm",
        held=grade(similar, all(stated)),
        test=f"{BAR}: within {STEP:g} mm, the step of the sweep, of MPM and of {STATED_FEM:g} mm",
        sentence=f"FEM needs {'the same' if similar else 'another'} radius as MPM; its norm is "
        f"settled at {fem[0]:g} mm, its angle at {fem[1]:g} mm, where the paper quotes "
        f"{STATED_FEM:g} mm.",
    )


def one_twentieth(e: Evidence) -> Claim:
    """50 mm is not one twentieth of the crack length."""
    part, of_height = e.radius / e.crack_length, e.radius / e.height
    fits = bool(np.isclose(part, 1 / 20))
    return paper_claim(
        "one_twentieth",
        found=f"{part:g} of the crack length, {of_height:g} of the height",
        held="yes" if fits else "misprint",
        test="arithmetic. In 5.2 to 5.5 one half of the crack length is taken: a twentieth would "
        "be less than an element",
        sentence=f"R = {e.radius:g} mm is {part:g} of the crack length, "
        + word(fits, "as stated.", "not one twentieth as stated."),
    )


def path_dependent(e: Evidence) -> Claim:
    """CF over a domain does not depend on the domain in a linear elastic body."""
    far = slice(e.radius, None)

    def spread(series: xr.Dataset, grid: int) -> float:
        norm = series.cf_norm.sel(scheme="MPM", radius=far).isel(grid=grid)
        return float((norm.max() - norm.min()) / norm.mean())

    coarse, fine, graded = spread(e.T3, 0), spread(e.T3, -1), spread(e.graded, -1)
    independent = graded < 1e-3 and fine < coarse
    return paper_claim(
        "path_dependent",
        found=f"spread over R >= {e.radius:g} mm: {coarse:.1%} ({int(e.T3.n_points[0])} points), "
        f"{fine:.2%} ({int(e.T3.n_points[-1])})",
        held="misprint" if independent else "yes",
        test="the spread goes to zero with the grid: path-independent",
        reference="path-independent (Noether)",
        best=f"spread {graded:.0e} (T6 graded)",
        sentence="In a linear elastic body CF is "
        + word(
            independent,
            "path-independent, where the paper prints path-dependent.",
            "path-dependent.",
        ),
    )


def j_projection(e: Evidence) -> Claim:
    """J is the component of CF along the crack."""

    def apart(series: xr.Dataset) -> Floats:
        along = e.norm(series) * np.cos(np.radians(e.angle(series)))
        j: Floats = series.J.sel(scheme="MPM", radius=e.radius).values
        return along / j - 1.0

    off = apart(e.T3)
    held = abs(off[-1]) <= PROJECTED and abs(off[-1]) < abs(off[0])
    return paper_claim(
        "j_projection",
        found=f"component of CF along the crack over J, less one: {percent(off[0])} on the "
        f"coarsest, {percent(off[-1], 2)} on the finest grid",
        held=word(held),
        test=f"within {100 * PROJECTED:g} % on the finest grid, and nearer than on the coarsest; J "
        "by its own integral over a ring",
        reference="equal (Rice, Eshelby)",
        best=f"T6 graded: {apart(e.graded)[-1]:.0e}",
        error=percents(off),
        sentence="J is the component of CF along the crack"
        + word(held, ", on finer grids ever more closely.", " to some per cent only."),
    )


def _grids(e: Evidence) -> list[xr.Dataset]:
    return [e.grids.sel(grid=f"T3_{grid}") for grid in e.swept]


def vanishes(e: Evidence) -> Claim:
    """Nearly all is at the tip."""
    told, gone = [], []
    for grid, one in zip(e.swept, _grids(e), strict=True):
        distance, part, _ = of_nodes(one)
        bands = [
            part[(distance > inner) & (distance <= outer)].max(initial=0.0)
            for inner, outer in ((VANISH_AT, 25.0), (25.0, 40.0), (40.0, 60.0))
        ]
        # The edge of the plate and its corners are loaded: forces there are no crack's.
        gone.append(max(bands) < VANISHED)
        told.append(
            f"{e.points(grid)} points: {', '.join(f'{100 * band:.1f} %' for band in bands)}"
        )
    return paper_claim(
        "vanishes",
        found="largest force at 20 to 25, 25 to 40, 40 to 60 mm, over the tip's: "
        + "; ".join(told),
        held=grade(*gone),
        test=f"below {100 * VANISHED:g} % of the tip's beyond {VANISH_AT:g} mm, on both grids",
        sentence=f"Beyond {VANISH_AT:g} mm from the tip the forces of the nodes are "
        f"{'below' if all(gone) else 'not below'} {100 * VANISHED:g} % of the tip's.",
    )


def layers(e: Evidence) -> Claim:
    """Three to four layers of elements."""
    largest = []
    for one in _grids(e):
        distance, part, _ = of_nodes(one)
        there = one.triangle.values[:, 0] >= 0
        inside = set(one.triangle.values[there][_touching(one, {int(one.tip_node)})].ravel())
        for _ in range(LAYERS - 1):
            inside |= set(one.triangle.values[there][_touching(one, inside)].ravel())
        outside = np.setdiff1d(np.flatnonzero(distance < 90.0), list(inside))
        largest.append(float(part[outside].max(initial=0.0)))
    held = max(largest) < 0.01
    return paper_claim(
        "layers",
        found=f"largest force outside {LAYERS} layers, over the tip's: "
        + "; ".join(f"{100 * part:.2f} %" for part in largest),
        held=word(held),
        test="below 1 % of the tip's, on both grids, within 90 mm",
        sentence=f"Outside {LAYERS} layers of elements around the tip the forces of the nodes "
        f"{'vanish' if held else 'do not vanish'}.",
    )


def _touching(grid: xr.Dataset, nodes: set[int]) -> np.ndarray:
    """Which triangles have one of some nodes."""
    triangles = grid.triangle.values[grid.triangle.values[:, 0] >= 0]
    return np.isin(triangles, list(nodes)).any(axis=1)


def direction_drawn(e: Evidence) -> Claim:
    """Ahead of the tip."""
    ahead = [bool(of_nodes(one)[2][0] > 0) for one in _grids(e)]
    return paper_claim(
        "direction_drawn",
        found="points ahead of the tip" if all(ahead) else "does not point ahead of the tip",
        held=grade(*ahead),
        test="component along the crack of the force at the tip, on both grids",
        sentence=f"CF as drawn points {'in' if all(ahead) else 'against'} the direction of growth.",
    )
