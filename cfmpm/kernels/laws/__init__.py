"""Constitutive laws at finite deformation, one module each, and their common functions.

A law has the stored energy W = W_mu(F) + lambda U(J) per reference volume; the volumetric part is
separate so that J can be replaced by its mean over a patch of points. At small strain every law is
Hooke's law with the lambda and mu of the material. The module of a law (`registry.laws`) has the
kernels below. A kernel takes only the arguments that it needs, by name: ``lam`` and ``mu`` [MPa],
the constants of the law by their names, and

``response(..., H, y)``
    Kirchhoff stress, energy and spatial tangent of W_mu, in the form of `dispatch.respond`.
    ``H`` is the displacement gradient F - I as xx, xy, yx, yy, and ``y`` is J - 1.
``volumetric(..., y)``
    lambda U, lambda U' and lambda U'' [MPa]; the derivatives are with respect to J.
``across(..., H, y, tau)``, optional
    Out-of-plane Kirchhoff stress zz of W_mu in plane strain [MPa], from its in-plane stress
    ``tau``. Without this kernel it is zero.

A law with internal variables lists their names in ``INTERNAL_VARIABLES``; they are zero in the
initial state. Its ``response`` also takes ``internal``, the variables of all points at the start of
the step, and ``p``, the row of the point, and also returns the new row. A variable
``plastic_work`` is the plastic work per reference volume [N mm/mm^3].

All kernels compute from H and never subtract two numbers near 1: no digits are lost at small
strain. They return floats.
"""
