"""Transformation of the state on a grid that is reset to the reference configuration."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cfmpm.body import particle_domains
from cfmpm.body.body import Body
from cfmpm.body.grid import Floats
from cfmpm.body.motion import Motion
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.equilibrium.contact import CrackFaces
from cfmpm.fracture import cf
from cfmpm.updated.grids import (
    everywhere,
)
from cfmpm.updated.loads import (
    STIFFNESS,
    largest_modulus,
)


def pull_back(gradients: Floats, base: Floats) -> Floats:
    """Transform spatial basis gradients to gradients in the reference configuration.

    Parameters
    ----------
    gradients : (q, k, 2) float
        dS/dx [1/mm].
    base : (q, 2, 2) float
        Displacement gradient H_n.

    Returns
    -------
    (q, k, 2) float
        dS/dX_j = dS/dx_i (F_n)_ij [1/mm].
    """
    return gradients + np.einsum("qki,qij->qkj", gradients, base)


def closed_faces(body: Body, motion: Motion) -> CrackFaces:
    """Return the crack faces for contact.

    The nodes of a following grid are those of the reference. In a fixed grid the crack faces of
    the material are not at the doubled nodes, and there is no contact.
    """
    if motion.reset.fixed:
        return CrackFaces(replace(body.grid, crack_faces={}))
    return CrackFaces(motion.reference, motion.displacement)


def in_reference(
    body: Body, gradients: Floats, balance: Equilibrium
) -> tuple[Body, Floats, Equilibrium]:
    """Transform a state of equilibrium to the reference configuration.

    Parameters
    ----------
    body : Body
    gradients : (q, k, 2) float
        Basis gradients at its quadrature points.
    balance : Equilibrium

    Returns
    -------
    body, gradients, balance
        On the initial grid of the material points, with the displacement of the tracers; unchanged
        if the grid is not reset.
    """
    motion = body.motion
    if motion is None:
        return body, gradients, balance
    points = replace(body.points, position=motion.position, element=motion.element)
    seen = replace(
        body, grid=motion.reference, points=points, quadrature=None, loading=motion.loading
    )
    displacement = motion.traced(body.grid, everywhere(body, balance.displacement))
    force = balance.internal_force
    if motion.reset.fixed:
        # Tracers that move relative to the grid are held by springs.
        loads = motion.loading.at(balance.load_factor)
        slip = loads.displacement - displacement
        prescribed = motion.loading.prescribed
        held = np.where(prescribed, STIFFNESS * largest_modulus(body) * slip, 0.0)
        force = loads.force + held
    return (
        seen,
        motion.gradients,
        replace(
            balance,
            points=particle_domains.means(points, body.quadrature, balance.points),
            displacement=displacement,
            internal_force=force,
            contact_force=np.zeros_like(force) if motion.reset.fixed else balance.contact_force,
        ),
    )


def compare(body: Body, gradients: Floats, balance: Equilibrium) -> dict[str, Floats]:
    """Measure at each tip how far the grid has separated from the material.

    Parameters
    ----------
    body : Body
        The body that was solved.
    gradients : (q, k, 2) float
        Basis gradients at its quadrature points.
    balance : Equilibrium

    Returns
    -------
    dict of str to (tip,) array
        `cf_norm_grid`, the norm of the configurational force over a disc of the current grid, of
        the same radius in space, and `tip_drift`; empty if the grid is not reset.
    """
    motion = body.motion
    if motion is None:
        return {}
    force = body.loading.at(balance.load_factor).body_force
    nodal = cf.finite_nodal_force(body.grid, balance.points, gradients, force)
    traced = motion.reference.nodes + motion.traced(
        body.grid, everywhere(body, balance.displacement)
    )
    norm, drift = [], []
    for tip, own, domain in zip(
        body.grid.tips, motion.reference.tips, body.tip_domains, strict=True
    ):
        on_grid = cf.domain_force(body.grid, nodal, tip, max(domain.radii))
        norm.append(np.hypot(*on_grid))
        place = body.grid.nodes[tip.node]
        if not motion.reset.fixed:
            place = place + balance.displacement[tip.node]
        drift.append(np.hypot(*(traced[own.node] - place)))
    return {"cf_norm_grid": np.array(norm), "tip_drift": np.array(drift)}
