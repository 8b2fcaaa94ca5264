"""Colours can be distinguished with every type of colour vision."""

from __future__ import annotations

import itertools

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from numpy.typing import ArrayLike, NDArray

from cfmpm.plotting.curves import STYLES
from cfmpm.plotting.growth import PARTS
from cfmpm.plotting.style import STRESS_MAP

# What is seen of linear red, green and blue without one kind of cones (Machado, Oliveira and
# Fernandes 2009, IEEE Trans. Vis. Comput. Graph. 15, 1291, severity 1).
VISION = {
    "all cones": np.eye(3),
    "no long ones": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "no middle ones": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
}
# From linear sRGB to CIE XYZ, relative to the white of daylight (IEC 61966-2-1).
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def lab(colours: ArrayLike, vision: ArrayLike) -> NDArray[np.float64]:
    """CIE L*a*b* of sRGB colours for a type of colour vision, (n, 3)."""
    rgb = np.asarray(colours, float)
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ np.transpose(vision), 0.0, 1.0)
    x, y, z = (seen @ XYZ.T / XYZ.sum(axis=1)).T
    f_x, f_y, f_z = (
        np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29) for t in (x, y, z)
    )
    return np.column_stack([116 * f_y - 16, 500 * (f_x - f_y), 200 * (f_y - f_z)])


@pytest.mark.parametrize("vision", VISION)
def test_colours_of_curves_are_told_apart(vision: str) -> None:
    seen = lab([to_rgb(colour) for colour, _ in STYLES], VISION[vision])
    nearest = min(np.linalg.norm(a - b) for a, b in itertools.combinations(seen, 2))
    assert nearest > 15.0  # 2.3 can just be told side by side


def test_curves_are_told_apart_without_colour() -> None:
    assert len({marker for _, marker in STYLES}) == len(STYLES)
    assert len({str(dashes) for _, dashes, _ in PARTS.values()}) >= len(PARTS) - 1


@pytest.mark.parametrize("vision", VISION)
def test_stress_grows_lighter(vision: str) -> None:
    colours = mpl.colormaps[STRESS_MAP](np.linspace(0.0, 1.0, 64))[:, :3]
    lightness = lab(colours, VISION[vision])[:, 0]
    assert (np.diff(lightness) > 0.0).all()
    assert np.ptp(lightness) > 60.0
