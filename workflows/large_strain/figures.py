"""Figure 8 with the dataset behind it: the configurational force at the paper's ten loads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.output.files import write_dataset
from cfmpm.plotting.curves import STYLES, draw_curve
from cfmpm.plotting.style import BLACK, GREY, panels
from workflows.large_strain.datasets import G_AT_10, curve, fem, lefm, modulus, of_fem, reached

# Width of a page in print: 170 mm [inch].
WIDE = 6.6
# Of the paper's Fig. 8 [MPa].
LARGEST_LOAD = 1e5
TOTAL = "total Lagrangian, same grid"
HENCKY_FINE = "T6, 4 mm at the tip; by FEM in (b, d)"
BEST = "best: Ciarlet's law, T6 graded"
ANALYTICAL = "linear elasticity"


def write_fig8(
    curves: str | Path, steps: str | Path, picture: str | Path, data: str | Path
) -> None:
    """Draw CF at the ten loads of the paper in one to ten steps, and where runs end.

    Parameters
    ----------
    curves, steps : Path
        From `datasets.write_large_strain` and `datasets.write_steps`.
    picture, data : Path
        The PNG and the netCDF file to be written.
    """
    paths, ended = xr.load_dataset(curves), xr.load_dataset(steps)
    with panels(Path(picture), (WIDE, 7.6), 2, 2) as axes:
        _draw_tractions(axes[0, 0], paths, ended.sel(control="dead"))
        _draw_elongations(axes[0, 1], paths, ended.sel(control="moved"))
        _draw_reached(axes[1, 0], ended.sel(control="moved"))
        _draw_ratio(axes[1, 1], paths, ended.sel(control="moved"))
        handles, labels = axes[0, 0].get_legend_handles_labels()
        axes[0, 0].figure.legend(handles, labels, loc="outside upper center", ncols=2, fontsize=7)
    wanted = ["hencky_uniform", "hencky_uniform_dead", "ciarlet_T6_0.5", "ciarlet_dead"]
    kept = paths.sel(variant=wanted)[["elongation", "nominal_stress", "cf_norm"]]
    kept = kept.rename({name: f"path_{name}" for name in kept.data_vars})
    write_dataset(ended.assign(kept.data_vars).assign_attrs(paths.attrs), Path(data))


def _label(number: int) -> str:
    return f"as printed, {number} load step{'s' if number > 1 else ''} a load"


def _draw_cases(axes: Axes, cases: xr.Dataset, x: str, scale: float) -> None:
    """Loads that were reached, by the number of steps."""
    there = reached(cases)
    for k, number in enumerate(cases.steps.values):
        one = cases.sel(steps=number).where(there.sel(steps=number))
        hollow = k == 0  # the path of the total formulation runs through its marks
        draw_curve(
            axes, one[x] * scale, one.cf_norm, _label(int(number)), k, line="", hollow=hollow
        )


def _draw_tractions(axes: Axes, paths: xr.Dataset, cases: xr.Dataset) -> None:
    total, best = curve(paths, "hencky_uniform_dead"), curve(paths, "ciarlet_dead")
    fine = curve(paths, "hencky_dead")
    axes.plot(1e-3 * total.stress[1:], total.force[1:], color=BLACK, lw=1.0, label=TOTAL)
    axes.plot(1e-3 * fine.stress[1:], fine.force[1:], "--", color=BLACK, lw=1.2, label=HENCKY_FINE)
    axes.plot(1e-3 * best.stress[1:], best.force[1:], color=STYLES[4][0], lw=1.2, label=BEST)
    stress = np.linspace(5e3, LARGEST_LOAD, 100)
    parabola = G_AT_10 * (stress / 10.0) ** 2
    axes.plot(1e-3 * stress, parabola, ":", color=GREY, lw=1.2, label=ANALYTICAL)
    _draw_cases(axes, cases, "nominal_stress", 1e-3)
    limit = 1e-3 * modulus(paths) / np.e
    axes.axvline(limit, color=GREY, lw=0.8, zorder=0)
    axes.annotate(
        "Hencky bears\nno more: E'/e",
        (limit, 1.4e5),
        xytext=(-3, 0),
        ha="right",
        textcoords="offset points",
        fontsize=6.5,
        color=GREY,
    )
    axes.set_xlabel("traction [GPa]")
    axes.set_xlim(0.0, 105.0)
    _forces(axes, "the paper's tractions")


def _draw_elongations(axes: Axes, paths: xr.Dataset, cases: xr.Dataset) -> None:
    total, best = curve(paths, "hencky_uniform"), curve(paths, "ciarlet_T6_0.5")
    known = fem("hencky", "T6", 4.0)
    axes.plot(100 * total.elongation[1:], total.force[1:], color=BLACK, lw=1.0)
    axes.plot(100 * known.elongation, known.force, "--", color=BLACK, lw=1.2)
    axes.plot(100 * best.elongation[1:], best.force[1:], color=STYLES[4][0], lw=1.2)
    strain = np.linspace(0.025, 0.55, 100)
    axes.plot(100 * strain, lefm(strain, modulus(paths)), ":", color=GREY, lw=1.2)
    _draw_cases(axes, cases, "elongation", 100.0)
    axes.set_xlabel("elongation [%]")
    axes.set_xlim(0.0, 53.0)
    _forces(axes, "ends moved by the paper's strains")


def _forces(axes: Axes, title: str) -> None:
    axes.set_yscale("log")
    axes.set_ylim(1e5, 5e7)
    axes.set_ylabel("norm of CF [N/mm]")
    axes.set_title(title)


def _draw_reached(axes: Axes, cases: xr.Dataset) -> None:
    """Elongation at the last stable state against that asked for."""
    axes.plot([0.0, 53.0], [0.0, 53.0], color=GREY, lw=0.9, zorder=0)
    said: dict[str, Any] = {"rotation": 45, "rotation_mode": "anchor", "color": GREY}
    axes.annotate("reached", (41.0, 43.0), fontsize=7, **said)
    axes.annotate("numerical fracture", (33.0, 27.5), va="top", fontsize=7, **said)
    for k, number in enumerate(cases.steps.values):
        one = cases.sel(steps=number)
        draw_curve(
            axes, one.asked, 100 * one.elongation, _label(int(number)), k, line="", hollow=k == 0
        )
    axes.set_xlabel("elongation asked for [%]")
    axes.set_ylabel("elongation of the last stable state [%]")
    axes.set_xlim(0.0, 53.0)
    axes.set_ylim(0.0, 53.0)
    axes.set_title("how far each load comes")


def _draw_ratio(axes: Axes, paths: xr.Dataset, cases: xr.Dataset) -> None:
    """CF of the loads that were reached over the converged curve, as far as it goes."""
    known = fem("hencky", "T6", 4.0)
    there = reached(cases)
    total = curve(paths, "hencky_uniform")
    at = known.elongation
    axes.plot(
        100 * at, np.interp(at, total.elongation, total.force) / known.force, color=BLACK, lw=1.0
    )
    for k, number in enumerate(cases.steps.values):
        one = cases.sel(steps=number).where(there.sel(steps=number))
        converged = of_fem(one.elongation)
        draw_curve(
            axes, 100 * one.elongation, one.cf_norm / converged, "", k, line="", hollow=k == 0
        )
    axes.axhline(1.0, color=BLACK, lw=1.2, ls="--")
    axes.set_xlabel("elongation [%]")
    axes.set_ylabel("norm of CF over that of FEM, T6 [1]")
    axes.set_xlim(0.0, 53.0)
    axes.set_ylim(0.7, 1.1)
    axes.set_title("over FEM, T6, to its end")
