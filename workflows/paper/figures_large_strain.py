"""Figure 8 with the dataset behind it: the configurational force against elongation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.plotting import curves
from cfmpm.plotting.style import BLACK, panels
from cfmpm.results import write_dataset
from workflows.paper.large_strain import Curve, curve, fem, lefm, modulus

# Variants by panel with their labels; FEM on grids of its own: law, element, size at the tip [mm].
HENCKY = {
    "hencky_T3_4": "total, T3, tip 4 mm",
    "hencky_T6_4": "total, T6, tip 4 mm",
    "hencky_T6_0.5": "total, T6, tip 0.5 mm",
    "hencky_following": "following grid, T3, tip 4 mm",
    "hencky_paper": "paper mode, T3, 21 mm",
}
NEO_HOOKEAN = {
    "neo_hookean_T3_4": "total, T3, tip 4 mm",
    "neo_hookean_T6_0.5": "total, T6, tip 0.5 mm",
    "ciarlet_T6_0.5": "Ciarlet's, total, T6, tip 0.5 mm",
    "neo_hookean_following": "following grid, T3, tip 4 mm",
    "ciarlet_paper": "Ciarlet's, paper mode, T3, 21 mm",
}


def write_fig8(large_strain: str | Path, picture: str | Path, data: str | Path) -> None:
    """Draw the configurational force and the nominal stress against elongation.

    Parameters
    ----------
    large_strain : Path
        From `large_strain.write_large_strain`.
    picture, data : Path
        The PNG and the netCDF file to be written.
    """
    dataset = xr.load_dataset(large_strain)
    with panels(Path(picture), (12.0, 4.6), 1, 3) as axes:
        for one, shown, title, law, end in (
            (axes[0, 0], HENCKY, "Hencky, the paper's law", "hencky", 0.5),
            (axes[0, 1], NEO_HOOKEAN, "neo-Hookean", "neo_hookean", 1.0),
        ):
            for k, (name, label) in enumerate(shown.items()):
                _draw(one, curve(dataset, name), "force", label, k)
            for element, k in (("T3", 0), ("T6", 1)):
                known = fem(law, element, 4.0)
                colour = curves.STYLES[k][0]
                one.plot(
                    *(100 * known.elongation, known.force),
                    *("",),
                    marker="s" if element == "T3" else "D",
                    ms=5.5,
                    mfc="none",
                    mec=colour,
                    ls="",
                    label=f"independent FEM, {element}, tip 4 mm",
                )
            strain = np.linspace(0.0, end, 101)
            one.plot(
                100 * strain,
                lefm(strain, modulus(dataset)),
                color=BLACK,
                lw=0.9,
                ls=":",
                label="linear: 0.2548 (E' e / 10 MPa)$^2$",
            )
            top = np.nanmax(dataset.cf_norm.where(dataset.elongation <= end))
            one.set_xlim(0.0, 100 * end)
            one.set_ylim(0.0, 1.25 * top)
            one.set_title(title)
            one.set_ylabel("norm of CF, J of FEM [N/mm]")
        one = axes[0, 2]
        for k, (name, label) in enumerate(
            {
                "hencky_T6_4": "Hencky, ends moved",
                "hencky_dead": "Hencky, dead load",
                "neo_hookean_T6_0.5": "neo-Hookean, ends moved",
            }.items()
        ):
            _draw(one, curve(dataset, name), "stress", label, k)
        limit = modulus(dataset) / np.e
        curves.draw_level(one, limit, f"E'/e = {limit / 1e3:.1f} GPa: Hencky bears no more")
        one.axhline(1e5, color=BLACK, lw=0.9, ls=":", label="the paper's largest load, 100 GPa")
        one.set_xlim(0.0, 100.0)
        one.set_ylim(0.0, 1.6e5)
        one.set_title("force on the ends")
        one.set_ylabel("nominal stress [MPa]")
        for one in axes.flat:
            one.set_xlabel("elongation [%]")
            one.legend(loc="upper left", fontsize=6.5)
    write_dataset(dataset, Path(data))


def _draw(axes: Axes, path: Curve, quantity: str, label: str, style: int) -> None:
    """Draw a path, thin and dashed past its ellipticity, and a cross where it ends early."""
    colour = curves.STYLES[style][0]
    x, y = 100 * path.elongation, getattr(path, quantity)
    last = int(path.elliptic.sum()) - 1 if not path.elliptic.all() else len(x) - 1
    axes.plot(x[: last + 1], y[: last + 1], color=colour, lw=1.4, label=label)
    axes.plot(x[last:], y[last:], color=colour, lw=1.0, ls="--")
    if last < len(x) - 1:
        axes.plot(x[last], y[last], "o", color=colour, ms=4.0, mfc="white")
    if path.elongation[-1] < 0.999:
        axes.plot(x[-1], y[-1], "x", color=colour, ms=7.0, mew=1.6)
