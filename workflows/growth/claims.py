"""The claims and numbers of sections 5.2 to 5.5, each decided from the computed datasets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import xarray as xr

from workflows.growth import beam_claims, edge_claims, holes_claims
from workflows.growth.evidence import Evidence
from workflows.reporting.claim_table import Claim, write_table

CLAIMS: tuple[Callable[[Evidence], Claim | list[Claim]], ...] = (
    edge_claims.straight,
    edge_claims.tip_against_domain,
    edge_claims.fixed_grips,
    edge_claims.snap_back,
    edge_claims.shear_path,
    holes_claims.holes_path,
    holes_claims.holes_conditions,
    holes_claims.holes_energy,
    beam_claims.beam_paths,
    beam_claims.beam_cases,
    beam_claims.near_miss,
)


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
        edge, shear, holes and beam, from `datasets.write_growth`.
    table, markdown, page : Path
    """
    names = ("edge", "shear", "holes", "beam")
    claims = decide(Evidence(**{name: xr.load_dataset(studies[name]) for name in names}))
    write_table(claims, "Sections 5.2 to 5.5", table, markdown, page)
