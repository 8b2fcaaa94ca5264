"""The claims and numbers of section 5.1, each decided from the computed datasets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from cfmpm.scene import load_scene
from cfmpm.scene.specimens.single_edge import SingleEdge
from workflows.reporting.claim_table import Claim, write_table
from workflows.section_5_1 import convergence_claims as convergence
from workflows.section_5_1 import domain_claims as domain
from workflows.section_5_1.convergence_claims import ROUND_OFF
from workflows.section_5_1.evidence import Evidence, largest_difference, percent, word


def finite_height(e: Evidence) -> Claim:
    """What a converged computation gives."""
    off = e.best / e.converged - 1.0
    near = abs(off) < 1e-4
    return Claim(
        "5.1 G of the plate of finite height",
        "",
        f"{e.converged:.6f} N/mm: {percent(e.converged / e.handbook - 1)} of the paper's line, as "
        "the strip of the handbook is infinitely long",
        f"{e.best:.6f} N/mm (J, T6 graded to the tip)",
        word(near),
        "finest graded grid within 1e-4",
        error=percent(off, 4),
        figures="5 7",
    )


def from_below(e: Evidence) -> Claim:
    """Compatible elements are too stiff: CF rises to its limit."""
    errors = {name: e.error(e.norm(one)) for name, one in (("T3", e.T3), ("T6", e.T6))}
    below = all((values < 0).all() and (np.diff(values) > 0).all() for values in errors.values())
    return Claim(
        "5.1 CF on the domain rises to its limit",
        "",
        "compatible elements are too stiff",
        "from below on every grid, T3 and T6" if below else "not on every grid",
        word(below),
        "below the converged value and rising in every refinement",
        figures="7",
    )


def equals_fem(e: Evidence) -> Claim:
    """On the first load step the method is linear FEM."""
    uniform = max(largest_difference(series) for series in (e.T3, e.T6))
    graded = largest_difference(e.graded)
    return Claim(
        "5.1 MPM is FEM at the first load step",
        "",
        "identical: one point (three) in a triangle is FEM's quadrature",
        "nodal CF, norms of CF, J and strain energy coincide, T3 and T6",
        word(uniform < ROUND_OFF),
        f"less than {ROUND_OFF:.0e} on uniform grids; scikit-fem assembles and solves on its own",
        error=f"largest relative difference {uniform:.0e}; {graded:.0e} on grids graded to 1e-5 of "
        "the body, where round-off grows",
        figures="5",
    )


CLAIMS: tuple[Callable[[Evidence], Claim], ...] = (
    convergence.discretisations,
    convergence.tip_oscillates,
    convergence.domain_converges,
    convergence.constant_strain,
    convergence.fem_norm_coarse,
    convergence.fem_norm_fine,
    convergence.fem_angle,
    domain.settling_angle,
    domain.one_twentieth,
    domain.j_projection,
    domain.path_dependent,
    domain.vanishes,
    domain.direction_drawn,
    domain.settling_sooner,
    domain.fem_radius,
    domain.layers,
    convergence.t6_points,
    convergence.t3_like_t6,
    convergence.analytical_value,
    convergence.converges_to_it,
    convergence.t6_cost,
    convergence.conclusion_domain,
    finite_height,
    from_below,
    equals_fem,
)


def decide(evidence: Evidence) -> list[Claim]:
    """Decide all claims."""
    return [claim(evidence) for claim in CLAIMS]


def write_claims(
    series: Mapping[str, str | Path],
    grids: str | Path,
    scene_file: str,
    *,
    radius: float,
    converged: float,
    swept: list[int],
    table: str | Path,
    markdown: str | Path,
    page: str | Path,
) -> None:
    """Decide the claims and write them as CSV, Markdown and HTML.

    Parameters
    ----------
    series : mapping of str to Path
        T3, T6 and T6_graded, from `datasets.write_datasets`.
    grids : Path
        From the same.
    scene_file : str
    radius, converged, swept
        As in `Evidence`.
    table, markdown, page : Path
    """
    plate = load_scene(scene_file).family
    assert isinstance(plate, SingleEdge)
    claims = decide(
        Evidence(
            T3=xr.load_dataset(series["T3"]),
            T6=xr.load_dataset(series["T6"]),
            graded=xr.load_dataset(series["T6_graded"]),
            grids=xr.load_dataset(grids),
            radius=radius,
            converged=converged,
            swept=tuple(swept),
            crack_length=plate.crack_length,
            height=plate.height,
        )
    )
    write_table(claims, "Section 5.1", table, markdown, page)
