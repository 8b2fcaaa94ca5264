"""The claims and numbers of Fig. 8, each decided from the computed datasets and the FEM."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from cfmpm.ending import RUN_STATUS
from workflows.large_strain.datasets import G_AT_10, curve, fem, lefm, modulus, of_fem, reached
from workflows.large_strain.figures import LARGEST_LOAD
from workflows.large_strain.settings import STEPS
from workflows.reporting.claim_table import Claim, not_tested, paper_claim, write_table

# J [N/mm] and force on the top [N/mm] of the neo-Hookean plate by elongation: converged FEM.
CONVERGED = {
    0.1: (684_877.0, 1.000124e7),
    0.3: (4_803_510.0, 2.667376e7),
    0.5: (11_220_580.0, 4.039292e7),
}
FINE, FOLLOWING = 0.005, 0.02
# How a run that ends early is told, by the word of its end.
ENDINGS = {
    "unstable": "the stiffness is no longer positive definite",
    "unsolvable": "no equilibrium is found",
}
# CF agrees with FEM within this part; a strain is that of the paper within this part.
AGREES, LIKE = 0.1, 0.06
WIDTH = 500.0
# Of J, what finite deformation changes at 100 MPa of dead load: converged FEM (design study).
BY_100_MPA = -0.00185


@dataclass(frozen=True)
class Evidence:
    """What claims are decided from.

    Attributes
    ----------
    curves, steps : xarray.Dataset
        From `datasets.write_large_strain` and `datasets.write_steps`.
    """

    curves: xr.Dataset
    steps: xr.Dataset


def converged(e: Evidence) -> list[Claim]:
    """Neo-Hookean: the numbers of a converged FEM."""
    return [
        _converged(e.curves, "neo_hookean_T6_0.5", "total Lagrangian, T6", FINE),
        _converged(e.curves, "neo_hookean_following", "following grid, T3", FOLLOWING),
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
        "",
        "; ".join(f"{j:.5g} N/mm" for j, _ in known),
        "; ".join(f"{j:.5g} N/mm" for j, _ in found),
        "yes" if held else "no",
        f"within {100 * allowed:g} % of a converged FEM, the force on the ends too",
        error=f"J {_percent(error[:, 0])}; force {_percent(error[:, 1])}",
        figures="large_strain_laws",
    )


def agrees(e: Evidence) -> Claim:
    """CF up to a strain of 50 %, as printed."""
    there = reached(e.steps)
    to_the_end = [n for n in STEPS if bool(there.sel(control="moved", steps=n).all())]
    one = e.steps.sel(control="moved").where(there.sel(control="moved"))
    off = abs(one.cf_norm / of_fem(one.elongation) - 1.0).max("case")
    near = [n for n in STEPS if float(off.sel(steps=n)) <= AGREES]
    counts = {n: int(there.sel(control="moved", steps=n).sum()) for n in STEPS}
    first = e.steps.sel(control="moved", steps=1)
    total = curve(e.curves, "hencky_uniform")
    apart = abs(first.cf_norm / np.interp(first.elongation, total.elongation, total.force) - 1.0)
    held = {*to_the_end, *near} and ("yes" if {*to_the_end} & {*near} == {*STEPS} else "in part")
    return paper_claim(
        "large_agrees",
        found="of ten elongations to 50 % are reached: "
        + ", ".join(f"{count} in {n} step{'s' * (n > 1)} each" for n, count in counts.items())
        + f". In one step nothing has been reset, and CF is that of the total formulation within "
        f"{100 * float(apart.max()):.1f} %",
        held=held or "no",
        test=f"all ten reached, CF within {100 * AGREES:g} % of FEM (T6) where that is stable, for "
        "each number of steps; the formula of [62] is not given",
        reference=f"FEM with Hencky's law, stable to {100 * _end_of_fem():.0f} %",
        best="Ciarlet's law, T6 graded, total Lagrangian: "
        f"{100 * float(curve(e.curves, 'ciarlet_T6_0.5').elongation[-1]):.0f} % elongation",
        error="largest difference from FEM: "
        + ", ".join(f"{100 * float(off.sel(steps=n)):.0f} % ({n})" for n in STEPS if counts[n]),
        sentence="CF to a strain of 50 % comes out only in one load step for each load, in which "
        "the grid is never reset; in more steps the run ends before."
        if to_the_end == [1]
        else f"As printed all ten loads are reached with {len(to_the_end)} of {len(STEPS)} numbers "
        "of load steps.",
    )


def _end(e: Evidence, variant: str) -> str:
    """Elongation at the end of a path."""
    return f"{100 * curve(e.curves, variant).elongation[-1]:.0f} %"


def _end_of_fem() -> float:
    return float(fem("hencky", "T6", 4.0).elongation[-1])


def numerical_fracture(e: Evidence) -> Claim:
    """Where runs end as printed."""
    there = reached(e.steps)
    ends = e.steps.elongation.where(~there)
    furthest = {n: float(e.steps.elongation.sel(steps=n).max()) for n in STEPS}
    earliest = {n: float(ends.sel(steps=n).min()) for n in STEPS}
    states = {int(word) for word in e.steps.run_status.values[~there.values]}
    said = sorted({ENDINGS.get(RUN_STATUS[word], "no state follows") for word in states})
    empty = e.steps.empty_elements.where(~there).max(["control", "case"])
    early = [n for n in STEPS if earliest[n] < 0.5]
    beyond = [n for n in STEPS if earliest[n] >= 0.5 and np.isfinite(earliest[n])]
    return paper_claim(
        "large_fracture",
        found="runs that end early end at "
        + ", ".join(
            f"{100 * earliest[n]:.0f} % and more ({n} step{'s' * (n > 1)})"
            for n in STEPS
            if np.isfinite(earliest[n])
        )
        + f": {' or '.join(said)}; up to "
        + ", ".join(f"{int(empty.sel(steps=n))}" for n in STEPS if np.isfinite(earliest[n]))
        + " triangles inside have lost their point",
        held="yes" if beyond and not early else "in part" if beyond else "no",
        test="a run that ends before its load does so beyond 50 %, for each number of steps",
        best=f"never reset, the same grid goes to {_end(e, 'hencky_uniform')} by Hencky's law; "
        f"Ciarlet's law, T6 graded, to {_end(e, 'ciarlet_T6_0.5')}",
        sentence="Numerical fracture comes beyond 50 % in one load step "
        f"({100 * furthest[1]:.0f} %), but at {100 * min(earliest[n] for n in early):.0f} % and "
        "more as soon as the grid is reset."
        if beyond and early
        else "Numerical fracture comes beyond 50 % as stated."
        if beyond
        else "Numerical fracture comes before 50 %.",
    )


def largest_load(e: Evidence) -> Claim:
    """No equilibrium carries the paper's largest load."""
    limit = modulus(e.curves) / np.e
    dead = e.steps.sel(control="dead")
    borne = {n: float(dead.nominal_stress.sel(steps=n).max()) for n in STEPS}
    all_borne = bool(reached(dead).all("case").any())
    path, best = curve(e.curves, "hencky_dead"), curve(e.curves, "ciarlet_dead")
    return paper_claim(
        "large_tractions",
        found="largest traction borne: "
        + ", ".join(f"{1e-3 * borne[n]:.1f} GPa ({n} step{'s' * (n > 1)})" for n in STEPS),
        held="yes" if all_borne else "in part" if max(borne.values()) >= LARGEST_LOAD else "no",
        test="the ten tractions as dead loads, all reached in some number of steps",
        reference=f"Hencky's law in plane strain bears at most E'/e = {1e-3 * limit:.1f} GPa, "
        "without a crack",
        best=f"Hencky, T6 graded {1e-3 * path.stress[-1]:.1f} GPa; Ciarlet's law "
        f"{1e-3 * best.stress[-1]:.0f} GPa",
        sentence="The paper's ten tractions are borne."
        if all_borne
        else f"There is no equilibrium at the largest tractions: the plate bears "
        f"{1e-3 * max(borne.values()):.0f} GPa of the paper's {1e-3 * LARGEST_LOAD:.0f}.",
    )


def elongations(e: Evidence) -> Claim:
    """Elongations that the paper gives to its loads."""
    dead = e.steps.sel(control="dead", steps=1)
    there = reached(dead).values
    asked, found = dead.asked.values[there], dead.elongation.values[there]
    linear = dead.asked.values / float(e.curves.young)
    fits = bool(np.all(np.abs(found / (asked / 2e5) - 1.0) <= LIKE))
    by_modulus = bool(np.all(np.abs(linear / (dead.asked.values / 2e5) - 1.0) <= LIKE))
    last = (100 * float(found[-1]), 1e-3 * float(asked[-1]))
    return paper_claim(
        "large_strains",
        found=f"{100 * found[0]:.1f} % at {1e-3 * asked[0]:.0f} GPa, {last[0]:.1f} % at "
        f"{last[1]:.0f} GPa",
        held="yes" if fits and there.all() else "misprint" if by_modulus else "no",
        test=f"elongation of the loads that are reached, in one step, within {100 * LIKE:g} % of "
        "5 to 50 %; else whether these are the stress over E",
        reference=f"stress over E is {100 * linear[0]:.1f} % and {100 * linear[-1]:.1f} %",
        best=f"Ciarlet's law {100 * curve(e.curves, 'ciarlet_dead').elongation[-1]:.0f} % at "
        f"{1e-3 * LARGEST_LOAD:.0f} GPa",
        sentence="The tractions strain the plate as stated."
        if fits and there.all()
        else "The paper's strains of 5 to 50 % are stress over E, not the elongation of the plate."
        if by_modulus
        else "The tractions do not strain the plate as stated.",
    )


def what_stops(e: Evidence) -> Claim:
    """The material, not the mesh, ends the path of Hencky elasticity."""
    data = e.curves
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
    single = e.steps.sel(control="dead", steps=1)
    return paper_claim(
        "large_fem",
        found=f"MPM as printed, in one step, {100 * float(single.elongation.max()):.0f} %; the "
        "total formulation, which is FEM on the same grid, "
        f"{100 * float(curve(data, 'hencky_uniform').elongation[-1]):.0f} %",
        held="no" if material else "in part",
        test="on finer grids Hencky's law ends sooner, by MPM and FEM alike, and a neo-Hookean law "
        "reaches 100 % on the same grids: the material ends the path",
        reference="FEM loses stability at "
        + ", ".join(f"{end:.0f} % ({n})" for n, end in known.items())
        + "; neo-Hookean never",
        best="ellipticity lost at "
        + ", ".join(f"{lost[n]:.1f}" for n in names)
        + " %, stability at "
        + ", ".join(f"{ends[n]:.0f}" for n in names)
        + f" % (T3, T6 tip 4 mm, T6 tip 0.5 mm); neo-Hookean {100 * neo:.0f} %",
        sentence="MPM does not go further than FEM: with Hencky's law both lose stability, on "
        "finer grids sooner."
        if material
        else "Where MPM and FEM end does not depend on the grid as expected.",
    )


def domains(e: Evidence) -> Claim:
    """Domains of points on the grid that is reset."""
    fixed, following = (curve(e.curves, f"hencky_{name}") for name in ("domains", "following"))
    return Claim(
        "Fig. 8 Points with domains against numerical fracture",
        "",
        "convected particle domains [33, 63], which the paper names and does not try",
        f"on the paper's grid, reset after each step: to {100 * fixed.elongation[-1]:.0f} %; on a "
        f"grid that follows the body (T3, tip 2 mm): to {100 * following.elongation[-1]:.0f} %",
        "yes" if fixed.elongation[-1] >= 0.5 else "no",
        "50 % on the paper's grid; domains here are polygons that are cut exactly",
        figures="large_strain_laws",
    )


def small_loads(e: Evidence) -> Claim:
    """Linear elasticity is left in proportion to the load."""
    data = e.curves
    path = curve(data, "hencky_dead", "J")
    ratio = path.force[1:] / lefm(path.stress[1:] / modulus(data), modulus(data))
    at = float(path.stress[1])
    middle = np.interp(1e4, path.stress[1:], ratio)
    off, known = float(ratio[0]) - 1.0, BY_100_MPA * at / 100.0
    held = abs(off / known - 1.0) <= 0.1
    return Claim(
        "Fig. 8 J against linear elasticity at the same nominal stress",
        "",
        f"{G_AT_10:.4f} (stress / 10 MPa)^2 N/mm for small stress; by FEM {100 * BY_100_MPA:.3f} % "
        "at 100 MPa, as the pull straightens the bent plate",
        f"{100 * off:+.1f} % at {at:.0f} MPa, {100 * middle - 100:+.0f} % at 1e4 MPa, "
        f"{100 * ratio[-1] - 100:+.0f} % at {path.stress[-1]:.0f} MPa",
        "yes" if held else "no",
        "at the first load it is off by what the FEM is, in proportion to the load, to a tenth",
        error=f"{100 * (off - known):+.2f} % of J",
        figures="8",
    )


CLAIMS: tuple[Callable[[Evidence], Claim | list[Claim]], ...] = (
    agrees,
    largest_load,
    elongations,
    numerical_fracture,
    what_stops,
    converged,
    domains,
    small_loads,
)


def decide(evidence: Evidence) -> list[Claim]:
    """Decide all claims."""
    found: list[Claim] = []
    for claim in CLAIMS:
        decided = claim(evidence)
        found += decided if isinstance(decided, list) else [decided]
    return [*found, not_tested("large_cpdi")]


def write_claims(
    curves: str | Path,
    steps: str | Path,
    *,
    table: str | Path,
    markdown: str | Path,
    page: str | Path,
) -> None:
    """Decide the claims and write them as CSV, Markdown and HTML.

    Parameters
    ----------
    curves, steps : Path
        From `datasets.write_large_strain` and `datasets.write_steps`.
    table, markdown, page : Path
    """
    evidence = Evidence(xr.load_dataset(curves), xr.load_dataset(steps))
    write_table(decide(evidence), "Large strain", table, markdown, page)


def _percent(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    return " ".join(f"{100 * value:+.2f}" for value in values) + " %"
