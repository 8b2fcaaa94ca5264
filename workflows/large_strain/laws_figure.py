"""CF against elongation by law, formulation and grid: beyond the paper's Fig. 8."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.output.files import write_dataset
from cfmpm.plotting import curves
from cfmpm.plotting.style import BLACK, panels
from workflows.large_strain.datasets import G_AT_10, Curve, curve, fem, lefm, modulus
from workflows.large_strain.figures import LARGEST_LOAD, WIDE

# Variants by panel with their labels; FEM on grids of its own: law, element, size at the tip [mm].
HENCKY = {
    "hencky_T3_4": "total, T3, tip 4 mm",
    "hencky_T6_4": "total, T6, tip 4 mm",
    "hencky_T6_0.5": "total, T6, tip 0.5 mm",
    "hencky_following": "following grid, T3, tip 2 mm",
    "hencky_uniform": "total, T3, 21 mm",
}
NEO_HOOKEAN = {
    "neo_hookean_T3_4": "total, T3, tip 4 mm",
    "neo_hookean_T6_0.5": "total, T6, tip 0.5 mm",
    "ciarlet_T6_0.5": "Ciarlet's, total, T6, tip 0.5 mm",
    "neo_hookean_following": "following grid, T3, tip 2 mm",
}

STRESS = {
    "hencky_T6_4": "Hencky, ends moved",
    "hencky_dead": "Hencky, dead load",
    "neo_hookean_T6_0.5": "neo-Hookean, ends moved",
    "ciarlet_dead": "Ciarlet's, dead load",
}
# G of linear elasticity, see `large_strain.lefm`.
PARABOLA = f"{G_AT_10:.4f} (E' e / 10 MPa)$^2$"


def write_laws(large_strain: str | Path, picture: str | Path, data: str | Path) -> None:
    """Draw the configurational force and the nominal stress against elongation.

    Parameters
    ----------
    large_strain : Path
        From `large_strain.write_large_strain`.
    picture, data : Path
        The PNG and the netCDF file to be written.
    """
    dataset = xr.load_dataset(large_strain)
    with panels(Path(picture), (WIDE, 9.4), 2, 2) as axes:
        for one, shown, law, end in (
            (axes[0, 0], HENCKY, "hencky", 0.5),
            (axes[0, 1], NEO_HOOKEAN, "neo_hookean", 1.0),
            (axes[1, 0], HENCKY, "hencky", 0.5),
        ):
            # Below, all by the parabola of linear elasticity.
            scale = modulus(dataset) if one is axes[1, 0] else None
            for k, (name, label) in enumerate(shown.items()):
                _draw(one, curve(dataset, name), "force", label, k, scale)
            for k, element in enumerate(("T3", "T6")):
                known = _by_parabola(fem(law, element, 4.0), scale)
                label = f"independent FEM, {element}, tip 4 mm"
                curves.draw_curve(
                    one, 100 * known.elongation, known.force, label, k, line="", hollow=True
                )
            one.set_xlim(0.0, 103 * end)
        for one, end, title in (
            (axes[0, 0], 0.5, "Hencky, the paper's law"),
            (axes[0, 1], 1.0, "neo-Hookean"),
        ):
            strain = np.linspace(0.0, end, 101)
            parabola = lefm(strain, modulus(dataset))
            label = f"linear: {PARABOLA}"
            one.plot(100 * strain, parabola, ":", color=BLACK, lw=0.9, label=label)
            one.set_ylim(0.0, 1.25 * np.nanmax(dataset.cf_norm.where(dataset.elongation <= end)))
            one.set_title(title)
            one.set_ylabel("norm of CF; J of FEM [N/mm]")
        axes[1, 0].set_ylim(0.2, 0.7)
        axes[1, 0].set_title("Hencky, over the parabola of linear elasticity")
        axes[1, 0].set_ylabel("norm of CF; J of FEM, over linear [1]")
        _draw_stress(axes[1, 1], dataset)
        for one in axes.flat:
            one.set_xlabel("elongation [%]")
            one.legend(
                loc="upper left", bbox_to_anchor=(0.0, -0.17), fontsize=6.5, borderaxespad=0.0
            )
    write_dataset(dataset, Path(data))


def _draw_stress(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the nominal stress against elongation, and what Hencky elasticity bears at most."""
    for k, (name, label) in enumerate(STRESS.items()):
        _draw(axes, curve(dataset, name), "stress", label, k)
    limit = modulus(dataset) / np.e
    curves.draw_level(axes, limit, f"E'/e = {limit:.0f} MPa: most that Hencky bears")
    curves.draw_level(axes, LARGEST_LOAD, "the paper's largest load", line=":")
    axes.set_xlim(0.0, 103.0)
    axes.set_ylim(0.0, 1.7e5)
    axes.set_title("force on the ends")
    axes.set_ylabel("nominal stress [MPa]")


def _by_parabola(path: Curve, plane_modulus: float | None) -> Curve:
    """A path with its force over that of linear elasticity, if the modulus is given."""
    if plane_modulus is None:
        return path
    moved = path.elongation > 0.0
    force = path.force[moved] / lefm(path.elongation[moved], plane_modulus)
    return Curve(path.elongation[moved], force, path.stress[moved], path.elliptic[moved])


def _draw(
    axes: Axes,
    path: Curve,
    quantity: str,
    label: str,
    style: int,
    plane_modulus: float | None = None,
) -> None:
    """Draw a path, thin and dashed past its ellipticity, and a cross where it ends early."""
    path = _by_parabola(path, plane_modulus)
    colour = curves.STYLES[style][0]
    x, y = 100 * path.elongation, getattr(path, quantity)
    last = int(path.elliptic.sum()) - 1 if not path.elliptic.all() else len(x) - 1
    seen = last < len(x) - 1
    axes.plot(x[: last + 1], y[: last + 1], color=colour, lw=1.4, label=label)
    if seen:
        axes.plot(x[last:], y[last:], color=colour, lw=1.0, ls="--")
    if seen:
        axes.plot(x[last], y[last], "o", color=colour, ms=4.0, mfc="white")
    if path.elongation[-1] < 0.999:
        axes.plot(x[-1], y[-1], "x", color=colour, ms=7.0, mew=1.6)
