"""Equilibrium of a body: small strain, finite deformation, contact."""
