"""Constitutive laws at finite strain, one file each, and what they share.

A law is a stored energy per reference volume W = W_mu(F) + lambda U(J), so that J may be replaced
by its mean over a patch of points. At small strain it is Hooke's, with the lambda and mu of the
material. The module of a law, which `registry.laws` names, has these kernels; each takes what it
needs, by these names: ``lam``, ``mu``, the constants of the law by theirs, and

``response(..., H, y)``
    What W_mu gives: Kirchhoff stress, energy and spatial tangent as in `dispatch.respond`, without
    the volumetric part. ``H`` is the displacement gradient F - I as xx, xy, yx, yy, and y = J - 1.
``volumetric(..., y)``
    lambda U, lambda U' and lambda U'', of the derivatives with respect to J [MPa].
``across(..., H, y, tau)``, optional
    Kirchhoff stress zz of W_mu in plane strain, from its stress in the plane; zero without it.

A law with internal variables names them in ``INTERNAL_VARIABLES``; they are zero in the virgin
state. Its ``response`` takes ``internal`` and ``p`` too, those of all points at the start of the
step and the row of the point, and returns the new row besides. A variable ``plastic_work`` is the
plastic work per reference volume.

All start from H, so that nothing is lost at small strain: no number near 1 is ever subtracted from
another. All numbers returned are floats.
"""
