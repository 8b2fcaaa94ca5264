"""Summary of a run or a check as plain text of at most 100 columns."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cfmpm.body.body import Body
from cfmpm.body.grid import Grid
from cfmpm.output.analysis import parts_of_gap, resolved_steps
from cfmpm.output.warnings.of_scene import doubts_before
from cfmpm.registry.criteria import DIRECTIONS, DRIVING_FORCES
from cfmpm.scene import Scene
from cfmpm.state import Result

WIDTH = 100
# Name in the history, label, unit.
_OF_TIPS = (
    ("G", "G", "N/mm"),
    ("G_kink", "G of the kink", "N/mm"),
    ("J", "J", "N/mm"),
    ("J_plastic", "plastic part of J", "N/mm"),
    ("cf_norm", "|CF|", "N/mm"),
    ("cf_angle", "angle of CF from the crack", "deg"),
    ("K_I", "K_I", "MPa mm^0.5"),
    ("K_II", "K_II", "MPa mm^0.5"),
    ("T_stress", "T-stress", "MPa"),
    ("kink_angle", "kink angle, largest hoop stress", "deg"),
    ("critical_load_factor", "load factor at fracture", ""),
)
_TIPS_ABREAST = 2
# The row of G of the kink is omitted if it differs from G by less than this relative difference.
STRAIGHT = 1e-3
# The plastic part of J relative to J: what sums over points of an elastic body leave is below it.
ROUND_OFF = 1e-12


def of_run(result: Result, written: Sequence[Path]) -> str:
    """Summarize a run.

    Parameters
    ----------
    result : Result
    written : sequence of Path
        Files of the result.

    Returns
    -------
    str
    """
    whole = result.history
    solved = np.flatnonzero(np.isfinite(whole["n_unknowns"].values))
    history = whole.isel(step=solved[-1])
    growing = result.scene.growth is not None
    # What spoils the values comes before them.
    blocks = [_heading(result.scene), *_warnings(history)]
    tips = [str(name) for name in history["tip"].values]
    for first in range(0, len(tips), _TIPS_ABREAST):
        some = tips[first : first + _TIPS_ABREAST]
        blocks.append(_growth_table(whole, some) if growing else _tip_table(history, some))
    if tips and not growing and history.sizes["radius"] > 1:
        blocks.append(
            f"In brackets: range over {history.sizes['radius']} domain radii. It does not contain "
            "the discretisation error."
        )
    seconds = {str(t["phase"].values): float(t.sum()) for t in whole["wall_time"].T}
    iterations = history.attrs["linear_iterations"]
    facts = [
        *(_growth_facts(result) if growing else []),
        *_sizes(result.scene, result),
        ("unknowns", f"{int(history['n_unknowns'])}"),
        (
            "solver",
            f"{history.attrs['solver']}, "
            + (f"{iterations} iterations, " if iterations else "")
            + f"residual {float(history['residual_norm']):.1e} of the largest nodal force",
        ),
        *_path_of_load(whole, history)[: 1 if growing else None],
        *_pressed(history),
        ("energy", f"strain energy {float(history['strain_energy']):.6g} N mm per mm"),
        (
            "time",
            ", ".join(f"{phase} {s:.2f}" for phase, s in seconds.items())
            + f"; in all {sum(seconds.values()):.2f} s",
        ),
        *_list("left out", json.loads(history.attrs["left_out"])),
        *_list("written", [str(path) for path in written]),
    ]
    return "\n\n".join([*blocks, _facts(facts)])


def _path_of_load(whole: xr.Dataset, last: xr.Dataset) -> list[tuple[str, str]]:
    """Load and iterations at finite deformation, or the estimate of its effect at small strain."""
    steps = float(last["substeps"])
    if not steps > 0.0:
        effect, in_J = (
            float(np.fmax.reduce(np.abs(whole[name].values), axis=None, initial=np.nan))
            for name in ("finite_effect", "finite_effect_J")  # that of J is of tips, if any
        )
        said = f"finite deformation would change the energy by a fraction of about {effect:.1e}"
        if np.isfinite(in_J):
            said += f" and J by {in_J:.1e}"
        return [("strain", f"small; {said}")] if np.isfinite(effect) else []
    return [
        ("strain", whole.attrs["kinematics"]),
        (
            "load",
            f"factor {float(last['load_factor']):.6g} reached in {steps:.0f} steps, "
            f"{float(last['newton_iterations']):.0f} Newton iterations",
        ),
        ("ended", whole.attrs["ending"]),
    ]


def of_check(scene: Scene, start: Body, solver: str, left_out: Sequence[str], written: Path) -> str:
    """Summarize a scene before it is solved.

    Parameters
    ----------
    scene : Scene
        Expanded.
    start : Body
    solver : str
        The solver that a run would use.
    left_out : sequence of str
    written : Path
        The figure.

    Returns
    -------
    str
    """
    tips = [
        f"{tip.name} at {_place(*start.grid.nodes[tip.node])} mm: element size {tip.h:.3g}, "
        f"clearance {domain.clearance:.4g}, "
        f"domain radii {', '.join(f'{radius:.4g}' for radius in domain.radii)} mm"
        f"{' (cut back)' if domain.cut_back else ''}"
        for tip, domain in zip(start.grid.tips, start.tip_domains, strict=True)
    ]
    facts = [
        *_sizes(scene, start),
        ("unknowns", f"{int((~start.loading.prescribed).sum())}"),
        ("solver", solver),
        *_list("tips", tips + _with_two_tips(start.grid)),
        *_list("growth", _growth_plan(scene)),
        *_list("doubtful", doubts_before(scene, start)),
        *_list("left out", left_out),
        ("written", str(written)),
    ]
    return f"{_heading(scene)}\n\n{_facts(facts)}"


def _with_two_tips(grid: Grid) -> list[str]:
    """Cracks with two tips, in case one end was meant to lie on an edge or a hole."""
    cracks = [tip.crack for tip in grid.tips]
    return [
        f"{name} has two tips: neither end is on an edge or a hole"
        for name in dict.fromkeys(cracks)
        if cracks.count(name) == 2
    ]


def _growth_plan(scene: Scene) -> list[str]:
    """Load, criterion and direction of crack growth."""
    growth = scene.growth
    if growth is None:
        return []
    quantity = DRIVING_FORCES[growth.criterion].description
    load = {
        "load": f"at the load of the scene, every tip grows whose {quantity} reaches g_c",
        "crack": f"in each increment at the load at which {quantity} of the first tip is g_c",
        "fatigue": "by load cycles, every tip above the threshold by Paris' law, until "
        f"{quantity} of a tip reaches g_c",
    }[growth.control]
    direction = DIRECTIONS[growth.direction].description
    runs = "; only the tip with the largest driving force" if growth.tips == "largest" else ""
    return [f"{load}{runs}; in the direction {direction}; at most {growth.increments} increments"]


def _warnings(history: xr.Dataset) -> list[str]:
    """The warnings of the run."""
    texts = json.loads(history.attrs["warnings"])
    return ["\n".join(textwrap.wrap(text, WIDTH)) for text in texts]


def _heading(scene: Scene) -> str:
    text = f"{scene.name}: {scene.description}" if scene.description else scene.name
    return "\n".join(textwrap.wrap(text, WIDTH))


def _sizes(scene: Scene, of: Body | Result) -> list[tuple[str, str]]:
    grid, held = of.grid, of.loading.held
    facts = [
        (
            "grid",
            f"{len(grid.elements)} triangles {scene.mesh.element}, {len(grid.nodes)} nodes",
        ),
        ("points", f"{len(of.points)}"),
    ]
    if held:
        facts.append(("supports", f"{held} rigid motions, free of load, are held at nodes"))
    return facts


def _tip_table(history: xr.Dataset, tips: Sequence[str]) -> str:
    """Table of a row per quantity and a column per tip; each value with its spread."""
    rows = [["", *(_shortened(tip) for tip in tips)]]
    at = history.sel(tip=list(tips))
    places = zip(at["tip_x"].values, at["tip_y"].values, strict=True)
    rows.append(["tip [mm]", *(_place(x, y) for x, y in places)])
    for name, called, unit in _OF_TIPS:
        values = at[name].values
        if np.isnan(values).all() or (name == "G" and np.isnan(at["K_I"]).all()):
            continue  # not computed; without K, G is J
        if name == "G_kink" and np.allclose(values, at["G"], rtol=STRAIGHT, equal_nan=True):
            continue
        spread = (
            at[f"{name}_spread"].values if f"{name}_spread" in at else np.full(len(tips), np.nan)
        )
        form = ".3f" if unit == "deg" else "#.6g"
        if name == "J_plastic":
            none = np.abs(values) <= ROUND_OFF * np.abs(at["J"].values)
            values = np.where(none, 0.0, values)
        cells = [_with_spread(v, s, form) for v, s in zip(values, spread, strict=True)]
        rows.append([f"{called} [{unit}]" if unit else called, *cells])
        if name == "J" and np.isfinite(at["K_I"]).any():
            rows.append(["J / G - 1", *(_with_spread(v, np.nan, ".1e") for v in _apart(at))])
    radii = at["domain_radius"].values
    rows.append(["domain radii [mm]", *(_between(tip_radii) for tip_radii in radii)])
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        "   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def _growth_table(whole: xr.Dataset, tips: Sequence[str]) -> str:
    """Table of crack growth: a row per quantity and a column per tip."""
    meanings = whole["tip_status"].attrs["flag_meanings"].split()
    # Finite deformation has no K; G is J there.
    ranges = {"G [N/mm]": "G"}
    if np.isfinite(whole["K_I"]).any():
        ranges = {"K_I [MPa mm^0.5]": "K_I", "K_II [MPa mm^0.5]": "K_II"} | ranges
    if "delta_K" in whole:
        ranges |= {"dK [MPa mm^0.5]": "delta_K", "da/dN [mm/cycle]": "da_dN"}
    columns = []
    for name in tips:
        tip = whole.sel(tip=name)
        steps = np.hypot(np.diff(tip["tip_x"]), np.diff(tip["tip_y"]))
        evaluated = np.flatnonzero(np.isfinite(tip["J"].values))
        first, last = (tip.isel(step=evaluated[k]) for k in (0, -1))
        column = {
            "": _shortened(name),
            "status": meanings[int(tip["tip_status"][-1])].replace("_", " at "),
            "from [mm]": _place(float(tip["tip_x"][0]), float(tip["tip_y"][0])),
            "to [mm]": _place(float(tip["tip_x"][-1]), float(tip["tip_y"][-1])),
            "path [mm]": f"{steps.sum():.6g}",
        }
        for called, key in ranges.items():
            column[called] = f"{float(first[key]):.6g} to {float(last[key]):.6g}"
        if "K_I" in ranges.values():
            apart = np.abs(_apart(tip))[resolved_steps(tip)]
            column["J / G - 1, largest"] = f"{np.nanmax(apart, initial=0.0):.1e}"
            column["first kink angle [deg]"] = f"{float(first['kink_angle']):.3f}"
        columns.append(column)
    rows = [[called, *(column[called] for column in columns)] for called in columns[0]]
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        "   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def _apart(tips: xr.Dataset) -> NDArray[np.float64]:
    """Relative difference of J and of G from K_I and K_II, a measure of discretisation error.

    nan where both are zero up to the error of the method.
    """
    J, G = tips["J"].values, tips["G"].values
    felt = np.maximum(np.abs(J), np.abs(G)) > np.nan_to_num(tips["G_floor"].values)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(felt, J / G - 1.0, np.nan)


def _growth_facts(result: Result) -> list[tuple[str, str]]:
    """End, increments, loads and energy balance of crack growth."""
    whole, growth = result.history, result.scene.growth
    ending = whole.attrs["ending"]
    facts = [("ended", ending), ("increments", f"{whole.sizes['step'] - 1}")]
    if "cycles" in whole and whole.attrs["run_status"] != "fractured":
        facts.append(("cycles", f"{float(whole['cycles'][-1]):.6g}"))
    factor = np.where(np.isfinite(whole["load_factor"]), whole["load_factor"], np.nan)
    if np.ptp(factor[np.isfinite(factor)]) > 0.0:
        facts += _loads_of_growth(whole, factor)
    # Under load control the energy released beyond g_c is not balanced by any other term.
    if growth is not None and growth.control == "crack":
        work, spent = parts_of_gap(whole)
        facts.append(
            (
                "balance",
                "energy gap (external work - strain energy - fracture energy): at most "
                f"{work:.1e} of the external work; at the end {spent:.1e} of the fracture energy"
                + ("; without jumps" if (whole["jump"] > 0.0).any() else ""),
            )
        )
        facts += _list("jumps", [_jump(whole, int(i)) for i in np.flatnonzero(whole["jump"] > 0.0)])
    return facts


def _jump(whole: xr.Dataset, i: int) -> str:
    """What a break-through sets free, and what g_c takes of it."""
    free = float(whole["energy_gap"][i] - whole["energy_gap"][i - 1])
    where = f"step {i + 1}: as a tip breaks through, "
    if free >= 0.0:
        return f"{where}{free:.4g} N mm per mm go into motion"
    return f"{where}g_c takes {-free:.4g} N mm per mm more than the body sets free"


def _pressed(last: xr.Dataset) -> list[tuple[str, str]]:
    """Contact of crack faces."""
    pairs = int(last["contact_pairs"])
    if not pairs:
        return []
    overlap = max(0.0, -float(last["min_opening"].min()))
    return [("contact", f"{pairs} pairs of nodes in contact, overlap {overlap:.1e} mm")]


def _loads_of_growth(whole: xr.Dataset, factor: NDArray[np.float64]) -> list[tuple[str, str]]:
    """Load factors of crack growth, and the largest forces on the loaded parts."""
    grown = np.flatnonzero(np.diff(whole["crack_length"].values, axis=0).max(axis=1) > 0.0)
    highest = int(np.nanargmax(factor))
    first = f"{factor[grown[0]]:.6g} at first growth, " if grown.size else ""
    facts = [("load factor", f"{first}largest {factor[highest]:.6g} in step {highest + 1}")]
    force = np.hypot(whole["reaction_x"].values, whole["reaction_y"].values).T
    forces = []
    for name, values in zip(whole["boundary"].values, force, strict=True):
        if np.nanmax(values, initial=0.0) > 0.0:
            at = int(np.nanargmax(values))
            forces.append(f"largest on {name} {values[at]:.6g} N/mm in step {at + 1}")
    return facts + _list("force", forces)


def _place(x: float, y: float) -> str:
    return f"({x:.6g}, {y:.6g})"


def _with_spread(value: float, spread: float, form: str) -> str:
    text = format(value, form) if np.isfinite(value) else "never" if value > 0 else "-"
    return text.rjust(12) + (f"  ({spread:.2g})" if np.isfinite(spread) else "")


def _between(radii: np.ndarray) -> str:
    low, high = radii.min(), radii.max()
    return f"{high:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def _shortened(name: str, most: int = 28) -> str:
    return name if len(name) <= most else f"{name[: most - 1]}…"


def _list(title: str, items: Sequence[str]) -> list[tuple[str, str]]:
    return [(title if i == 0 else "", item) for i, item in enumerate(items)]


def _facts(facts: Sequence[tuple[str, str]]) -> str:
    """Format names and texts as two columns; long texts are wrapped within theirs."""
    margin = max(len(name) for name, _ in facts) + 2
    lines = []
    for name, text in facts:
        wrapped = textwrap.wrap(
            text, WIDTH - margin, break_long_words=False, break_on_hyphens=False
        )
        lines.append(name.ljust(margin) + wrapped[0])
        lines.extend(" " * margin + line for line in wrapped[1:])
    return "\n".join(lines)
