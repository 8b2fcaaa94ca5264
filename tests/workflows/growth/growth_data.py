"""Synthetic datasets of growing cracks for tests: paths along the references."""

from __future__ import annotations

import numpy as np
import xarray as xr

from cfmpm.ending import RUN_STATUS
from cfmpm.output.variables import TIP_STATUS
from workflows.growth.beam_holes import BOTTOM, HOLE
from workflows.growth.datasets import KEPT
from workflows.growth.edge_claims import FIXED_GRIPS
from workflows.growth.settings import SCATTERED
from workflows.reference.path_points import reference

OF_STEP = ("strain_energy", "external_work", "fracture_energy", "n_points", "empty_elements")


def history(
    paths, ended="arrived", end="arrived_boundary", n_points=790.0, edges=("top",), **values
):
    """A run whose tips follow paths of equal length; values replace the ones of all steps."""
    paths = {name: np.asarray(path, float) for name, path in paths.items()}
    n, tips = len(next(iter(paths.values()))), list(paths)
    places = np.stack(list(paths.values()), axis=1)
    length = np.cumsum(np.hypot(*np.diff(places, axis=0, prepend=places[:1]).T).T, axis=0)
    data = {
        name: np.ones((n, len(tips))) for name in KEPT if name not in ("load_factor", "run_status")
    }
    data |= {name: np.zeros(n) for name in OF_STEP}
    data |= {name: np.zeros((n, len(edges))) for name in ("reaction_y", "displacement_y")}
    data |= {"tip_x": places[..., 0], "tip_y": places[..., 1], "crack_length": length}
    status = np.full((n, len(tips)), TIP_STATUS.index("growing"), np.int8)
    status[-1] = TIP_STATUS.index(end)
    data |= {"tip_status": status, "n_points": np.full(n, n_points)}
    data |= {"domain_radius": np.full((n, len(tips)), 1e3)}
    data |= {"cf_angle": np.zeros((n, len(tips))), "cf_tip_y": np.zeros((n, len(tips)))}
    data |= {
        name: np.reshape(value, data[name].shape) for name, value in values.items() if name in data
    }
    dims = {1: ("step",), 2: ("step", "tip")}
    of_edge = ("reaction_y", "displacement_y")
    variables = {
        name: (("step", "boundary") if name in of_edge else dims[np.ndim(value)], value)
        for name, value in data.items()
    }
    variables["load_factor"] = "step", values.get("load_factor", np.ones(n))
    variables["run_status"] = (), np.int8(RUN_STATUS.index(ended))
    coords = {
        "step": np.arange(1, n + 1),
        "tip": tips,
        "boundary": list(edges),
    }
    return xr.Dataset(variables, coords)


def stack(histories):
    """Runs along the dimension variant, as in a study: missing steps are nan."""
    return xr.concat(
        histories.values(),
        xr.Variable("variant", list(histories)),
        join="outer",
        fill_value={"tip_status": np.int8(-1)},
    )


def on_grids(runs, **first):
    """Runs along grid, and along further parameters by the names of their values."""
    found = xr.concat(runs, xr.Variable("grid", np.arange(len(runs))), join="outer")
    for name, labels in first.items():
        found = xr.concat([found] * len(labels), xr.Variable(name, list(labels)))
    return found


def straight(n, bend=0.1, **values):
    """Across the plate in its middle, up and down by a few hundredths of a degree."""
    x = np.linspace(100.0, 500.0, 21)
    y = np.full(21, 500.0)
    y[1:-1:2] += bend * 790.0 / n
    return history({"crack_1": np.column_stack([x, y])}, n_points=n, crack_length=x, **values)


def edge():
    """The edge crack: straight; G and load with a limit point, as in converged computations."""
    x = np.linspace(100.0, 500.0, 21)
    G = np.interp(x, list(FIXED_GRIPS), list(FIXED_GRIPS.values()))
    turning = 0.05 + 1e-6 * (x - 300.0) ** 2
    tip = {
        "cf_tip_y": np.full(21, 0.05),
        "domain_radius": np.full((21, 1), 50.0),
        "fracture_energy": x - 100.0,
    }
    return stack(
        {
            **{f"{kind}_{n}": straight(n, **tip) for kind in PRINTED for n in (790, 2584)},
            "best": straight(3000, 0.0),
            "t6": straight(2000, 0.0, G=G),
            "crack_control": straight(
                2000,
                0.0,
                load_factor=turning,
                strain_energy=np.full(21, 50.0),
                fracture_energy=x - 100.0,
                external_work=x - 50.0,
            ),
        }
    )


PRINTED = ("as_printed", "reset")


def edge_grids():
    """Straight on four grids."""
    runs = [straight(n) for n in (780, 800, 2500, 2600)]
    return on_grids(runs, how=SCATTERED["edge"]["how"])


def under_shear(steps=15, **values):
    """Through the converged points, in as many steps."""
    start = [35.0, 80.0], [37.5, 80.0 - 2.5 * np.tan(np.radians(14.68))]
    known = np.vstack([*start, reference("shear_plate_limit"), [70.0, 73.5]])
    x = np.unique([*known[:, 0], *np.linspace(61.0, 69.0, steps + 1 - len(known))])
    path = np.column_stack([x, np.interp(x, *known.T)])
    return history({"crack_1": path}, **values)


SHEAR = ("best", "reset", "reset_5", "cf_first_1.38", "cf_second_2.76", "hoop_second_1.38")
SIZES = ("cf_first_2.76", "hoop_first_2.76", "hoop_first_1.38", "t6_first_2.76", "t6_second_2.76")


def shear():
    """The path under shear through its converged points."""
    start = {"J": np.full((16, 1), 533.3), "tip_size": np.full((16, 1), 1.3)}
    run = under_shear(n_points=1418.0, **start)
    return stack(dict.fromkeys(("as_printed", *SHEAR, *SIZES), run))


def shear_grids():
    """The same on three grids."""
    return on_grids([under_shear()] * 3, how=SCATTERED["shear"]["how"])


def holes():
    """The paths at two holes through their reference points; balanced energies."""
    left = np.vstack([[1.0, 2.85], reference("holes_points"), [16.0, 5.0]])
    both = {"left_crack": left, "right_crack": [20.0, 10.0] - left}
    n = len(left)
    new = np.append(0.0, np.cumsum(np.hypot(*np.diff(left, axis=0).T)))
    length = np.column_stack([1.0 + new, 1.0 + new])
    uneven = np.column_stack([np.full(n, 9.0), np.full(n, 9.5)])
    held = history(
        both,
        end="arrived_hole",
        J=np.full((n, 2), 300.0),
        cf_norm=uneven,
        domain_radius=np.full((n, 2), 0.5),
        crack_length=length,
        edges=("bottom", "top"),
        displacement_y=np.tile([-1.0, 1.0], (n, 1)),
    )
    held = held.assign(
        fracture_energy=("step", 2.0 * new),
        external_work=("step", np.full(n, 1e5)),
        strain_energy=("step", 1e5 - 600.0 * new),
    )
    alone = np.full((n, 2), TIP_STATUS.index("growing"), np.int8)
    alone[-2:, 0] = alone[-1, 1] = TIP_STATUS.index("arrived_hole")
    # The load rises three times where the left crack breaks through.
    load = np.where(np.arange(n) < n - 2, 0.02, 0.06)
    stored = np.full(n, 10.0)
    stored[-2:] = 9.0 * 3.0
    balanced = history(both, load_factor=load, tip_status=alone, strain_energy=stored)
    balanced = balanced.assign(
        fracture_energy=("step", new),
        external_work=("step", 10.0 + new + np.where(np.arange(n) < n - 2, 0.0, 20.0)),
    )
    near = np.linspace([1.0, 2.85], [4.0, 5.2], n)
    return stack(
        {
            **dict.fromkeys(("as_printed", "best", "reset", "reset_tenth", "cf", "stiff"), held),
            "crack_control": balanced,
            "rollers": history(
                {"left_crack": near, "right_crack": [20.0, 10.0] - near}, end="arrived_hole"
            ),
        }
    )


def holes_grids():
    """The same on three grids."""
    run = holes().sel(variant="as_printed", drop=True)
    return on_grids([run] * 3, how=SCATTERED["holes"]["how"])


SPECIMENS = {
    "15_5": ([127.0, 38.1], 16.8),
    "10_4": ([101.6, 25.4], 12.6),
    "10_6": ([152.4, 25.4], 12.2),
}


def in_beam(case):
    """Along the reference with the reference kink; at x = 6 in up to the bottom hole."""
    start, kink = SPECIMENS[case]
    angle = np.radians(90.0 - kink)
    first = np.array(start) + 2.0 * np.array([np.cos(angle), np.sin(angle)])
    known = reference(f"beam_{case}")
    path = np.vstack([start, first, known[known[:, 1] > first[1] + 1.0]])
    if case == "10_6":
        path = np.vstack([path[path[:, 1] < BOTTOM[1] - HOLE - 1.0], BOTTOM - [0.0, HOLE]])
    n = len(path)
    run = history(
        {"crack_1": path},
        end="arrived_hole",
        n_points=3500.0,
        edges=("support_left", "support_right", "force"),
        reaction_y=np.tile([25.0, 25.0, -50.0], (n, 1)),
    )
    return run.assign(fracture_energy=("step", 0.001 * run.crack_length.values[:, 0]))


def beam():
    """The paths at three holes along their references, with the reference kinks."""
    variants = {
        f"{kind}_{case}": in_beam(case) for case in SPECIMENS for kind in ("as_printed", "best")
    }
    known = history({"crack_1": reference("beam_15_5")})
    variants |= {
        f"{order}_{size}": known for order in ("first", "second") for size in (12, 8, 5, 3)
    }
    return stack(variants)


def beam_grids():
    """The same on two grids."""
    cases = [on_grids([in_beam(case)] * 2, how=SCATTERED["beam"]["how"]) for case in SPECIMENS]
    return xr.concat(cases, xr.Variable("case", list(SPECIMENS)), join="outer")


def moved(dataset, variant, dx=0.0, dy=0.0, from_step=1):
    """The dataset with the path of one variant shifted from a step on [mm]."""
    here = (dataset.variant == variant) & (dataset.step >= from_step)
    return dataset.assign(tip_x=dataset.tip_x + here * dx, tip_y=dataset.tip_y + here * dy)


def ended(dataset, variant, status):
    """The dataset with another last status of the tips of one variant."""
    last = dataset.tip_x.notnull().any("tip").cumsum("step").argmax("step") + 1
    here = (dataset.variant == variant) & (dataset.step == last)
    return dataset.assign(
        tip_status=xr.where(here, np.int8(TIP_STATUS.index(status)), dataset.tip_status)
    )


def scaled(dataset, variant, name, factor):
    """The dataset with one quantity of one variant multiplied."""
    here = dataset.variant == variant
    return dataset.assign({name: dataset[name] * xr.where(here, factor, 1.0)})
