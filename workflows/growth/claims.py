"""The claims and numbers of sections 5.2 to 5.5, each decided from the computed datasets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import xarray as xr

from workflows.growth import beam_claims, edge_claims, holes_claims, shear_claims
from workflows.growth.evidence import Evidence
from workflows.reporting.claim_table import Claim, not_tested, write_table

CLAIMS: tuple[Callable[[Evidence], Claim | list[Claim]], ...] = (
    edge_claims.set_up,
    edge_claims.angles_in_range,
    edge_claims.no_convergence,
    edge_claims.finer_is_better,
    edge_claims.mean_angle,
    edge_claims.centre_line,
    edge_claims.one_segment,
    edge_claims.best_path,
    edge_claims.tip_against_domain,
    edge_claims.larger_domain,
    edge_claims.whole_loop,
    edge_claims.fixed_grips,
    edge_claims.snap_back,
    shear_claims.unit_of_stress,
    shear_claims.points,
    shear_claims.fifteen_steps,
    shear_claims.down_then_flat,
    shear_claims.beside_fem,
    shear_claims.twentieth,
    shear_claims.whole_loop,
    shear_claims.shear_path,
    holes_claims.set_up,
    holes_claims.tips_apart,
    holes_claims.attracted,
    holes_claims.beside_fem,
    lambda e: not_tested("holes_phase_field"),
    holes_claims.best_paths,
    holes_claims.whole_loop,
    holes_claims.holes_conditions,
    holes_claims.holes_energy,
    beam_claims.set_up,
    beam_claims.points,
    beam_claims.case_1,
    beam_claims.case_2,
    lambda e: not_tested("beam_experiments"),
    beam_claims.all_paths,
    beam_claims.beam_paths,
    beam_claims.near_miss,
)
# Datasets of `Evidence`.
GROWN = ("edge", "shear", "holes", "beam")
DATASETS = (*GROWN, *(f"{name}_grids" for name in GROWN))


def decide(evidence: Evidence) -> list[Claim]:
    """Decide all claims."""
    found: list[Claim] = []
    for claim in CLAIMS:
        decided = claim(evidence)
        found += decided if isinstance(decided, list) else [decided]
    return found


def write_claims(
    studies: Mapping[str, str | Path], *, table: str | Path, markdown: str | Path, page: str | Path
) -> None:
    """Decide the claims and write them as CSV, Markdown and HTML.

    Parameters
    ----------
    studies : mapping of str to Path
        By the names of `Evidence`.
    table, markdown, page : Path
    """
    claims = decide(Evidence(**{name: xr.load_dataset(studies[name]) for name in DATASETS}))
    write_table(claims, "Sections 5.2 to 5.5", table, markdown, page)
