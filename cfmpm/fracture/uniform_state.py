"""The uniform stress around a tip, which has no stress intensity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from cfmpm.body.grid import CrackTip, Floats


@dataclass(frozen=True)
class Uniform:
    """A uniform state around a tip, which an interaction integral need not sum: it has no K.

    Attributes
    ----------
    strain, stress : (2, 2) float
        In the frame of the tip; stress in MPa.
    tangent : (2,) float
        Of the tip.
    """

    strain: Floats
    stress: Floats
    tangent: Floats

    @classmethod
    def none(cls, tip: CrackTip) -> Self:
        """Return that without any stress."""
        return cls(np.zeros((2, 2)), np.zeros((2, 2)), tip.tangent)

    @classmethod
    def around(
        cls, tip: CrackTip, pressure: float, stress: Floats, volume: Floats, lame: Floats
    ) -> Self:
        """Return that of a tip whose faces bear a pressure.

        Parameters
        ----------
        tip : CrackTip
        pressure : float
            [MPa].
        stress : (p, 3) float
            At points around the tip, of which the mean along the crack is taken [MPa].
        volume : (p,) float
        lame : (2,) float
        """
        c, s = tip.tangent
        along = stress @ [c * c, s * s, 2.0 * c * s]
        sigma = np.diag([float(along @ volume) / max(volume.sum(), 1e-300), -pressure])
        lam, mu = lame
        strain = (sigma - 0.5 * lam / (lam + mu) * np.trace(sigma) * np.eye(2)) / (2.0 * mu)
        return cls(strain, sigma, tip.tangent)

    @property
    def t_stress(self) -> float:
        """What it is of the T-stress, which a pressure across the crack lowers [MPa]."""
        return float(self.stress[0, 0] - self.stress[1, 1])

    @property
    def size(self) -> float:
        """Largest of the stresses [MPa]."""
        return float(np.abs(self.stress).max())

    def left_of(self, stress: Floats, volume: Floats) -> float:
        """Return the root mean square of a stress (p, 3) without the uniform one [MPa].

        Parameters
        ----------
        stress : (p, 3) float
            At points around the tip [MPa].
        volume : (p,) float
        """
        square = (stress - self.voigt) ** 2 @ [1.0, 1.0, 2.0]
        return float(np.sqrt(square @ volume / max(volume.sum(), 1e-300)))

    @property
    def gradient(self) -> Floats:
        """Displacement gradient in the frame of the body, (2, 2)."""
        return self._turned(self.strain)

    @property
    def voigt(self) -> Floats:
        """Stress xx, yy, xy in the frame of the body [MPa], (3,)."""
        sigma = self._turned(self.stress)
        return np.array([sigma[0, 0], sigma[1, 1], sigma[0, 1]])

    def _turned(self, tensor: Floats) -> Floats:
        t = self.tangent
        frame = np.array([t, [-t[1], t[0]]])
        turned: Floats = frame.T @ tensor @ frame
        return turned
