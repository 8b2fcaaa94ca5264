"""Independent solution of a kinked crack by conformal mapping, without grid and series."""

from __future__ import annotations

import numpy as np

STEP, REACH = 0.25, 30.0


def kinked_by_mapping(angle: float) -> tuple[float, float, float, float]:
    """Return F_11, F_12, F_21, F_22 of a straight kink that is short compared with the crack.

    Parameters
    ----------
    angle : float
        Angle of the kink from the tangent, positive anticlockwise, below 180 [deg].

    Notes
    -----
    z = (t + a)^(1 - m) (t - b)^(1 + m), a = 1 - m, b = 1 + m, m = angle / 180, takes the upper half
    of the t plane to the plane without a half-infinite crack (t < -a and t > b, on z > 0) and its
    kink (-a < t < b), whose tip is t = 0. With q = (t + a) (t - b) / (2 t), Muskhelishvili's
    condition of faces without traction, with a stress function phi(t) that is c t far away, reads

        phi'(t) = c + (1 - e^(2 i pi m)) / (2 pi i) int q(s) conj(phi'(conj s)) / (s - t)^2 ds

    along any way from -a to b below t and the pole s = 0. Where s runs over half a circle below the
    axis, and t over the one above it, only the ends are singular: equal steps in x,
    (t + a) / (b - t) = i e^x, then converge exponentially. What is solved for is
    u = phi' (t + a) (b - t) / 4, which vanishes at both ends.
    """
    m = angle / 180.0
    a, b = 1.0 - m, 1.0 + m
    w = 1j * np.exp(np.arange(-REACH, REACH + 0.5 * STEP, STEP))
    above, below = w, w.conj()
    s = (b * below - a) / (1.0 + below)
    factor = (1.0 - np.exp(2j * np.pi * m)) / (2j * np.pi)
    weight = -factor * STEP * below / s
    kernel = above[:, None] * weight / (below - above[:, None]) ** 2
    one = np.eye(len(w))
    system = np.block([[one - kernel.real, -kernel.imag], [-kernel.imag, one + kernel.real]])
    columns = []
    for far in (1.0, -1j):  # K_I - i K_II of the crack
        right = 1j * far * above / (1.0 + above) ** 2
        parts = np.linalg.solve(system, np.concatenate([right.real, right.imag]))
        u = parts[: len(w)] + 1j * parts[len(w) :]
        slope = 1j * far + (1.0 + a / b) ** 2 * (weight * u.conj() / (below - a / b) ** 2).sum()
        # Of z - z_tip = z'' t^2 / 2, turned into the direction of the kink.
        near = -1j * slope * (b / a) ** (-0.5 * m) * np.exp(-1j * np.pi * m)
        columns.append((float(near.real), -float(near.imag)))
    (f_11, f_21), (f_12, f_22) = columns
    return f_11, f_12, f_21, f_22
