"""Claims of section 5.4: two cracks and two holes."""

from __future__ import annotations

import numpy as np
import xarray as xr

from cfmpm.output.variables import ARRIVED_FLAGS
from workflows.growth.datasets import energy_released, steps, tip_path
from workflows.growth.evidence import Evidence, arrival, grade, lost, signed, told
from workflows.reference.path_points import reference
from workflows.reporting.claim_table import Claim

# Largest distance from the reference paths [mm].
HOLES = 0.08


def holes_path(e: Evidence) -> list[Claim]:
    """The paths at two holes."""
    x, y = reference("holes_points").T
    claims = []
    for name, label in {
        "cf": "CF direction (paper)",
        "paper": "the same, points and volumes as in the paper",
        "hoop": "largest hoop stress, second order",
    }.items():
        run = steps(e.holes, name)
        left = tip_path(e.holes, name, "left_crack")
        right = [20.0, 10.0] - tip_path(e.holes, name, "right_crack")
        missed = [np.interp(x, path[:, 0], path[:, 1], right=np.nan) - y for path in (left, right)]
        ends = [arrival(run, tip) for tip in ("left_crack", "right_crack")]
        near = float(np.nanmax(np.abs(missed))) if np.isfinite(missed).all() else np.inf
        along, far = near <= HOLES, set(ends) == {"arrived_hole"}
        claims.append(
            Claim(
                f"5.4 Two holes, {label}, {int(run.n_points[0])} points",
                "past the near hole, into the far one, point-symmetric",
                "y = " + ", ".join(f"{v:.3f}" for v in y) + " at x = 2, 4, 6, 8, 10",
                f"left crack {told(run, 'left_crack')}, right crack {told(run, 'right_crack')}"
                + lost(run),
                grade(along, far),
                f"within {HOLES:g} mm, and both end in the far hole",
                error=f"left {signed(missed[0])}, right {signed(missed[1])} mm",
                figures="13",
                sentence="Two cracks, two holes, by the "
                f"{'largest hoop stress' if name == 'hoop' else 'CF direction'}: the paths "
                f"{'follow' if along else 'leave'} the reference "
                f"{'within' if along else 'by more than'} {HOLES:g} mm, and "
                f"{'both' if far else 'not both'} cracks end in a hole.",
            )
        )
    return claims


def holes_conditions(e: Evidence) -> list[Claim]:
    """What the paths at two holes depend on, and whether the load suffices."""
    soft, stiff = (tip_path(e.holes, name, "left_crack") for name in ("cf", "stiff"))
    same = soft.shape == stiff.shape and bool(np.abs(soft - stiff).max() < 1e-6)
    rollers = steps(e.holes, "rollers")
    end = tip_path(e.holes, "rollers", "left_crack")[-1]
    entered = np.hypot(*(end - [3.9, 5.2])) < 0.2
    run = steps(e.holes, "hoop")
    driving = run.cf_norm.sel(tip="left_crack").values
    peak, least = np.nanmax(driving), np.nanmin(driving)
    return [
        Claim(
            "5.4 Young's modulus: 20.8 GPa (paper) or 98 GPa (source)",
            "20.8 GPa",
            "the path does not depend on it while both tips run",
            "the same path" if same else "another path",
            "yes" if same else "no",
            "all places within 1e-6 mm",
            figures="13",
            sentence=f"The paths at two holes {'do not depend' if same else 'depend'} on Young's "
            "modulus, for which the paper and its source give different values.",
        ),
        Claim(
            "5.4 Edges free to move sideways",
            "not stated",
            "the left crack enters the near hole at about (4.0, 5.2)",
            f"{told(rollers, 'left_crack')} at ({end[0]:.2f}, {end[1]:.2f})",
            "yes" if entered else "no",
            "within 0.2 mm: the edges of the paper cannot have been free",
            figures="13",
            sentence="With edges free to move sideways, which the paper leaves open, the crack "
            f"{'enters' if entered else 'does not enter'} the near hole.",
        ),
        Claim(
            "5.4 The criterion is met to the end at u = 2 mm",
            "g_c = 1 N/mm, u = 2 mm",
            "at fixed displacement the driving force falls by some two hundred times",
            f"CF falls from {peak:.0f} to {least:.1f} N/mm; with the source's u = 0.1 mm at each "
            f"edge to {0.01 * least:.2f}",
            "yes" if least >= 1.0 else "no",
            "smallest CF of the left crack above g_c; 2 mm are read as 1 mm at each edge",
            figures="14",
            sentence="The displacement of 2 mm "
            f"{'drives' if least >= 1.0 else 'does not drive'} the cracks to the ends of their "
            "paths at two holes.",
        ),
    ]


def holes_energy(e: Evidence) -> list[Claim]:
    """Where the work of the loads goes at two holes."""
    return [_surplus(steps(e.holes, "cf")), _balance(steps(e.holes, "crack_control"))]


def _surplus(run: xr.Dataset) -> Claim:
    """At a load that is held, what the release rate exceeds g_c by is lost."""
    gone = (run.external_work - run.strain_energy - run.fracture_energy).values
    surplus = energy_released(run) - run.fracture_energy.values
    last = np.flatnonzero(np.isfinite(surplus))[-1]
    off = surplus[last] / gone[last] - 1.0
    held = abs(off) <= 0.005
    return Claim(
        "5.4 Energy at the fixed displacement",
        "",
        "work of the loads = strain energy + g_c times new length + what G exceeds g_c by",
        f"of {run.external_work.values[last]:.0f} N mm/mm {gone[last]:.0f} are neither stored nor "
        f"g_c times new length; the sum of (J - g_c) da is {surplus[last]:.0f}: "
        "what a real crack would turn into kinetic energy",
        "yes" if held else "no",
        "sum within 0.5 % of what is lost, up to the first arrival: the cracks jump, and this "
        "computation is quasi-static",
        error=f"{100 * off:+.2f} %",
        figures="14",
        sentence="At fixed displacement the energy that is lost at two holes is "
        f"{'' if held else 'not '}what G exceeds g_c by.",
    )


def _balance(run: xr.Dataset) -> Claim:
    """On the equilibrium path nothing is lost, but for the arrival at a hole."""
    work, stored, spent = (
        run[name].values for name in ("external_work", "strain_energy", "fracture_energy")
    )
    missing = (work - stored - spent) / work.max()
    arrived = np.isin(run.tip_status, ARRIVED_FLAGS)
    first = int(np.flatnonzero(arrived.any(axis=1))[0])
    before = np.abs(missing[:first]).max()
    load = run.load_factor.values
    # In a linear body energy goes with the square of the load.
    at_held_grips = stored[first - 1] - stored[first] * (load[first - 1] / load[first]) ** 2
    toughness = spent[first] - spent[first - 1]
    balanced, breaks = before <= 0.005, at_held_grips > toughness
    return Claim(
        "5.4 Energy along the equilibrium path (control: crack)",
        "",
        "work of the loads = strain energy + g_c times new length, but where a crack jumps",
        f"as a crack breaks through to a hole, the last ligament releases {at_held_grips:.2f} N "
        f"mm/mm at held grips, of which g_c takes {toughness:.2f}; the load of the next growth is "
        f"{load[first] / load[first - 1]:.1f} times as high",
        "yes" if balanced and breaks else "no",
        "within 0.5 % up to the arrival, and the last ligament breaks by itself, at held grips: "
        "the energy released beyond g_c becomes kinetic energy",
        error=f"within {100 * before:.2f} % of the work up to the first arrival; that increment "
        f"loses {100 * (missing[first] - missing[first - 1]):.1f} %",
        sentence="Along the equilibrium path at two holes the energy is in balance within "
        f"{100 * before:.2g} % (allowed: 0.5 %), and the last ligament "
        f"{'breaks' if breaks else 'does not break'} by itself.",
    )
