"""The claims and numbers of Fig. 8, each decided from the computed dataset and the FEM."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr

from workflows.large_strain.datasets import G_AT_10, curve, fem, lefm, modulus
from workflows.large_strain.figures import LARGEST_LOAD
from workflows.reporting.claim_table import Claim, write_table

# J [N/mm] and force on the top [N/mm] of the neo-Hookean plate by elongation: converged FEM.
CONVERGED = {
    0.1: (684_877.0, 1.000124e7),
    0.3: (4_803_510.0, 2.667376e7),
    0.5: (11_220_580.0, 4.039292e7),
}
FINE, FOLLOWING = 0.005, 0.02
LAWS = {"hencky": "Hencky's law", "ciarlet": "Ciarlet's neo-Hookean law"}
WIDTH = 500.0
# Of J, what finite deformation changes at 100 MPa of dead load: converged FEM (design study).
BY_100_MPA = -0.00185


def converged(data: xr.Dataset) -> list[Claim]:
    """Neo-Hookean: the numbers of a converged FEM."""
    return [
        _converged(data, "neo_hookean_T6_0.5", "total Lagrangian, T6", FINE),
        _converged(data, "neo_hookean_following", "following grid, T3", FOLLOWING),
    ]


def _converged(data: xr.Dataset, variant: str, label: str, allowed: float) -> Claim:
    path = curve(data, variant, "J")
    at = np.array(list(CONVERGED))
    known = np.array(list(CONVERGED.values()))
    found = np.column_stack(
        [np.interp(at, path.elongation, path.force), np.interp(at, path.elongation, path.stress)]
    ) * [1.0, WIDTH]
    error = found / known - 1.0
    held = bool(np.abs(error).max() <= allowed)
    return Claim(
        f"Fig. 8 J and force at 10, 30, 50 % elongation, neo-Hookean, {label}",
        "no neo-Hookean law",
        "; ".join(f"{j:.5g} N/mm" for j, _ in known),
        "; ".join(f"{j:.5g} N/mm" for j, _ in found),
        "yes" if held else "no",
        f"within {100 * allowed:g} % of a converged FEM, the force on the ends too",
        error=f"J {_percent(error[:, 0])}; force {_percent(error[:, 1])}",
        figures="8",
        sentence="With a neo-Hookean law J and the force on the ends "
        f"{'follow' if held else 'do not follow'} a converged FEM to 50 % elongation.",
    )


def paper_mode(data: xr.Dataset) -> list[Claim]:
    """A grid that is set back after every step, one point a triangle."""
    return [_paper_mode(data, law) for law in LAWS]


def _paper_mode(data: xr.Dataset, law: str) -> Claim:
    path, known = curve(data, f"{law}_paper"), fem(law, "T6", 4.0)
    end = float(path.elongation[-1])
    off = float(path.force[-1] / np.interp(end, known.elongation, known.force) - 1.0)
    return Claim(
        f"Fig. 8 CF by the paper's reset of the grid, T3, {LAWS[law]}",
        "agrees with the analytical curve to 50 % elongation",
        f"J by FEM at {100 * end:.1f} %: {np.interp(end, known.elongation, known.force):.4g} N/mm",
        f"ends at {100 * end:.1f} %, CF {path.force[-1]:.4g} N/mm",
        "no" if end < 0.5 else "yes",
        "reaches 50 %; at its end the stiffness is not positive definite, and "
        f"{int(data.empty_elements.sel(variant=f'{law}_paper').max())} triangles inside the body "
        "have lost their point",
        error=f"CF {100 * off:+.0f} % at its end",
        figures="8",
        sentence="With the grid reset after each load step the computation "
        + (
            f"ends at {100 * end:.0f} % elongation; the paper's reaches 50 %."
            if end < 0.5
            else "reaches 50 % elongation, as the paper's does."
        ),
    )


def what_stops(data: xr.Dataset) -> Claim:
    """The material, not the mesh, ends the path of Hencky elasticity."""
    names = ("hencky_T3_4", "hencky_T6_4", "hencky_T6_0.5")
    ends = {name: 100 * float(curve(data, name).elongation[-1]) for name in names}
    lost = {name: 100 * float(data.ellipticity_lost.sel(variant=name)) for name in names}
    known = {
        f"{element} tip {size:g} mm": 100 * float(fem("hencky", element, size).elongation[-1])
        for element in ("T3", "T6")
        for size in (8.0, 4.0)
    }
    neo = min(
        float(curve(data, "neo_hookean_T6_0.5").elongation[-1]),
        float(fem("neo_hookean", "T6", 4.0).elongation[-1]),
    )
    finer_sooner = ends[names[0]] > ends[names[1]] > ends[names[2]]
    material = finer_sooner and neo >= 1.0
    return Claim(
        "Fig. 8 FEM stops at 32 % elongation as its mesh distorts, MPM goes beyond 50 %",
        "FEM 32 %, MPM beyond 50 %",
        "FEM loses stability at "
        + ", ".join(f"{e:.0f} % ({n})" for n, e in known.items())
        + "; neo-Hookean never",
        "ellipticity lost at "
        + ", ".join(f"{lost[n]:.1f}" for n in names)
        + " %, stability at "
        + ", ".join(f"{ends[n]:.0f}" for n in names)
        + " % (T3, T6 tip 4 mm, T6 tip 0.5 mm); neo-Hookean 100 %",
        "no" if material else "in part",
        "MPM and FEM with Hencky's law both end, on finer grids sooner; both reach 100 % with a "
        "neo-Hookean law on the same grids: the material ends the path, and neither method goes "
        "further than the other",
        figures="8",
        sentence="MPM does not go further than FEM: with Hencky's law both lose stability, on "
        "finer grids sooner."
        if material
        else "Where MPM and FEM end does not depend on the grid as expected.",
    )


def largest_load(data: xr.Dataset) -> Claim:
    """No equilibrium carries the paper's largest load."""
    path = curve(data, "hencky_dead")
    limit, reached = modulus(data) / np.e, float(path.stress[-1])
    missed = reached < limit < LARGEST_LOAD
    return Claim(
        "Fig. 8 traction of 1e4 to 1e5 MPa",
        f"up to {LARGEST_LOAD:.0e} MPa",
        f"a dead load on Hencky's law in plane strain has a limit at E'/e = {limit:.0f} MPa, "
        "without a crack",
        f"last stable state at {reached:.0f} MPa, elongation {100 * path.elongation[-1]:.1f} %",
        "no" if missed else "yes",
        "no state of balance at 1e5 MPa, and the tip is unstable before the limit of the plate",
        figures="8",
        sentence=f"There is no equilibrium at the paper's largest traction, {LARGEST_LOAD:.0e} MPa."
        if missed
        else "The paper's largest traction is reached.",
    )


def elongations(data: xr.Dataset) -> Claim:
    """Elongations that the paper gives to its loads."""
    path = curve(data, "hencky_dead")
    first = 100 * float(np.interp(1e4, path.stress, path.elongation))
    E = modulus(data) * (1.0 - 0.3**2)
    linear = [100 * stress / E for stress in (1e4, LARGEST_LOAD)]
    return Claim(
        "Fig. 8 elongation of 5 to 50 % at these tractions",
        "5 % at 1e4 MPa, 50 % at 1e5 MPa",
        f"stress / E is {linear[0]:.1f} % and {linear[1]:.1f} %",
        f"{first:.1f} % at 1e4 MPa; no balance at 1e5 MPa",
        "misprint",
        "the abscissa is the stress over E: a nominal strain, not the elongation of the plate",
        figures="8",
        sentence="The paper's strains of 5 to 50 % are stress over E, not the elongation of the "
        "plate.",
    )


def small_loads(data: xr.Dataset) -> Claim:
    """Linear elasticity is left in proportion to the load."""
    path = curve(data, "hencky_dead", "J")
    ratio = path.force[1:] / lefm(path.stress[1:] / modulus(data), modulus(data))
    at = float(path.stress[1])
    middle = np.interp(1e4, path.stress[1:], ratio)
    off, known = float(ratio[0]) - 1.0, BY_100_MPA * at / 100.0
    held = abs(off / known - 1.0) <= 0.1
    return Claim(
        "Fig. 8 J against linear elasticity at the same nominal stress",
        "an analytical curve, whose formula is not given",
        f"{G_AT_10:.4f} (stress / 10 MPa)^2 N/mm for small stress; by FEM {100 * BY_100_MPA:.3f} % "
        "at 100 MPa, as the pull straightens the bent plate",
        f"{100 * off:+.1f} % at {at:.0f} MPa, {100 * middle - 100:+.0f} % at 1e4 MPa, "
        f"{100 * ratio[-1] - 100:+.0f} % at {path.stress[-1]:.0f} MPa",
        "yes" if held else "no",
        "at the first load it is off by what the FEM is, in proportion to the load, to a tenth",
        error=f"{100 * (off - known):+.2f} % of J",
        figures="8",
        sentence=f"At small loads J {'leaves' if held else 'does not leave'} linear elasticity as "
        "a converged FEM does.",
    )


CLAIMS: tuple[Callable[[xr.Dataset], Claim | list[Claim]], ...] = (
    converged,
    paper_mode,
    what_stops,
    largest_load,
    elongations,
    small_loads,
)


def decide(data: xr.Dataset) -> list[Claim]:
    """Decide all claims."""
    found: list[Claim] = []
    for claim in CLAIMS:
        decided = claim(data)
        found += decided if isinstance(decided, list) else [decided]
    return found


def write_claims(
    large_strain: str | Path, *, table: str | Path, markdown: str | Path, page: str | Path
) -> None:
    """Decide the claims and write them as CSV, Markdown and HTML.

    Parameters
    ----------
    large_strain : Path
        From `datasets.write_large_strain`.
    table, markdown, page : Path
    """
    write_table(decide(xr.load_dataset(large_strain)), "Large strain", table, markdown, page)


def _percent(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    return " ".join(f"{100 * value:+.2f}" for value in values) + " %"
