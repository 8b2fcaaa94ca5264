"""Random scenes with growing cracks, by seed, and checks of each state.

``python tests/verification/growth_scenes.py 500`` runs the scenes of seeds 0 to 499 and prints what
violations; a second number is the first seed.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np
import shapely

import cfmpm
from cfmpm.body.crack_faces import face_pairs, turning_of
from cfmpm.errors import MeshError, SceneError, SolveError
from cfmpm.output.record import Record
from cfmpm.scene import Scene, scene_from_dict
from cfmpm.state import State

# Resultant of loads and reactions over the largest of them; overlap of faces over the smallest
# element.
BALANCE, OVERLAP = 1e-9, 1e-6
# Energy that appears, over the largest so far. A segment changes the grid, and so energy a
# little.
FROM_NOTHING = 1e-3


def outline_of(rng: np.random.Generator) -> list[list[float]]:
    """Corners of a rectangle, an L or a convex polygon, about ten wide."""
    kind = rng.choice(["rectangle", "rectangle", "L", "polygon"])
    if kind == "rectangle":
        x, y = 10.0, float(np.round(rng.uniform(5.0, 14.0), 2))
        return [[0, 0], [x, 0], [x, y], [0, y]]
    if kind == "L":
        x, y = np.round(rng.uniform(3.0, 7.0, 2), 2).tolist()
        return [[0, 0], [10, 0], [10, y], [x, y], [x, 10], [0, 10]]
    n = int(rng.integers(3, 7))
    turns = (np.arange(n) + 0.8 * rng.uniform(0.2, 0.8, n)) / n * math.tau
    return np.column_stack([5 + 5 * np.cos(turns), 5 + 5 * np.sin(turns)]).round(3).tolist()


def _walk(start: Any, angle: float, length: float) -> list[float]:
    return [start[0] + length * math.cos(angle), start[1] + length * math.sin(angle)]


def _place(rng: np.random.Generator, body: shapely.Polygon) -> list[float]:
    x_low, y_low, x_high, y_high = body.bounds
    while True:
        at = [float(rng.uniform(x_low, x_high)), float(rng.uniform(y_low, y_high))]
        if body.buffer(-1.0).contains(shapely.Point(at)):
            return at


def crack_of(
    rng: np.random.Generator, outline: list[list[float]], holes: list[Any]
) -> list[list[float]]:
    """A crack from an edge or a hole, or inside; straight, or with a kink."""
    body, length = shapely.Polygon(outline), float(rng.uniform(0.8, 5.0))
    kind = rng.choice(["edge", "edge", "hole", "inside"] if holes else ["edge", "edge", "inside"])
    if kind == "edge":
        i = int(rng.integers(len(outline)))
        a, b = np.array(outline[i - 1]), np.array(outline[i])
        start = (a + rng.uniform(0.1, 0.9) * (b - a)).tolist()
        angle = math.atan2(b[1] - a[1], b[0] - a[0]) + math.pi / 2 + rng.uniform(-0.8, 0.8)
    elif kind == "hole":
        circle, angle = rng.choice(holes)["circle"], rng.uniform(-math.pi, math.pi)
        start = _walk(circle["centre"], angle, circle["radius"])
    else:
        angle = rng.uniform(-math.pi, math.pi)
        start = _walk(_place(rng, body), angle, -length / 2)
    points = [start, _walk(start, angle, length)]
    if rng.random() < 0.3:
        points.append(_walk(points[-1], angle + rng.uniform(-1.0, 1.0), 0.7 * length))
    return points


def loads_of(rng: np.random.Generator, outline: list[list[float]]) -> list[dict[str, Any]]:
    """Tension, compression or shear; clamped, gripped, on rollers or without supports."""
    n = len(outline)
    i = int(rng.integers(n))
    j = (i + int(rng.integers(1, n))) % n
    along = rng.integers(-3, 4, 2).astype(float)
    along[1] = along[1] or 1.0
    kind = rng.choice(["grip", "slide", "traction", "traction", "weight", "free", "rollers"])
    if kind in ("grip", "slide") and (j - i) % n in (1, n - 1):
        kind = "traction"
    clamp: dict[str, Any] = {"edge": f"edge_{i + 1}", "displacement": {"x": 0, "y": 0}}
    far: dict[str, Any] = {"edge": f"edge_{j + 1}"}
    if kind == "grip":
        return [clamp, far | {"displacement": {"x": 0.01 * along[0], "y": 0.01 * along[1]}}]
    if kind == "slide":
        return [clamp, far | {"displacement": {"y": 0.01 * along[1]}}]
    if kind == "traction":
        return [clamp, far | {"traction": along.tolist()}]
    if kind == "weight":
        return [clamp, {"body_force": (0.1 * along).tolist()}]
    if kind == "rollers":
        ends = np.array(outline)
        # On the side that lies flattest.
        i = int(np.abs(ends[:, 0] - np.roll(ends[:, 0], 1)).argmax() - 1) % n
        j = (i + n // 2) % n
        down = {"edge": f"edge_{i + 1}", "displacement": {"y": 0}}
        pin = {"point": outline[(i - 1) % n], "displacement": {"x": 0}}
        return [down, pin, far | {"traction": along.tolist()}]
    # In balance by itself: a uniform stress on all sides.
    sxx, syy, sxy = rng.integers(-2, 3, 3).astype(float)
    syy = syy or 1.0
    ends = np.array(outline)
    loads = []
    for k in range(n):
        t = ends[k] - ends[k - 1]
        normal = np.array([t[1], -t[0]]) / np.hypot(*t)
        on_side = [sxx * normal[0] + sxy * normal[1], sxy * normal[0] + syy * normal[1]]
        loads.append({"edge": f"edge_{k or n}", "traction": on_side})
    return loads


def config_of(rng: np.random.Generator) -> dict[str, Any]:
    """A random scene, which may be invalid."""
    outline = outline_of(rng)
    body = shapely.Polygon(outline)
    holes = [
        {"circle": {"centre": _place(rng, body), "radius": float(rng.uniform(0.4, 1.0))}}
        for _ in range(int(rng.integers(0, 3)))
    ]
    cracks = [crack_of(rng, outline, holes) for _ in range(int(rng.integers(1, 5)))]
    lines = [shapely.LineString(points) for points in cracks]
    if any(a.distance(b) < 0.3 for a, b in combinations(lines, 2)):
        raise SceneError([])
    geometry: dict[str, Any] = {
        "outline": outline,
        "holes": holes,
        "cracks": [{"points": points} for points in cracks],
    }
    control = str(rng.choice(["load", "crack", "crack", "fatigue", "finite"]))
    fatigue = control == "fatigue"
    toughness = {} if fatigue else {"g_c": 1e-12 if control == "load" else 1e-3}
    if control == "finite":
        toughness = {"g_c": 1e-12}
    material: dict[str, Any] = {"E": 1e3, "nu": float(rng.choice([0.0, 0.3, 0.49]))} | toughness
    if rng.random() < 0.4:
        shape = {"circle": {"centre": _place(rng, body), "radius": float(rng.uniform(0.8, 1.5))}}
        other = {"E": float(10 ** rng.uniform(2, 4)), "nu": 0.2} | toughness
        geometry["regions"] = [{"name": "other", "material": other, **shape}]
    size = float(rng.uniform(0.7, 1.4))
    tip = {"tip_size": 0.4 * size, "growth": 0.5}
    config: dict[str, Any] = {
        "name": "random",
        "geometry": geometry,
        "material": material,
        "loads": loads_of(rng, outline),
        "mesh": {
            "element": str(rng.choice(["T3", "T6"])),
            "size": size,
            "grading": "uniform" if rng.random() < 0.5 else tip,
        },
        "fracture": {} if rng.random() < 0.7 else {"refine": 0.3},
        "growth": {
            "control": "load" if control == "finite" else control,
            "tips": str(rng.choice(["all", "largest"])),
            "increments": 40,
        },
    }
    if control == "finite":
        config |= {"kinematics": "finite", "plane": "strain"}
        config["growth"]["direction"] = "cf"
        config["loads"] = [_gentle(load, 20.0) for load in config["loads"]]
    else:
        config["growth"]["direction"] = str(rng.choice(["cf", "max_hoop", "max_energy"]))
    if fatigue:
        config["fatigue"] = {"C": 1e-8, "m": 3, "load_ratio": float(rng.choice([0.0, 0.4]))}
    elif control != "finite":
        config["growth"]["criterion"] = str(rng.choice(["cf_norm", "energy_release_rate"]))
    return config


def _gentle(load: dict[str, Any], factor: float) -> dict[str, Any]:
    """Strains large enough to be finite, small enough to be stable."""
    larger = dict(load)
    for key in ("traction", "body_force"):
        if key in load:
            larger[key] = [factor / 4.0 * value for value in load[key]]
    if "displacement" in load:
        larger["displacement"] = {k: factor * v for k, v in load["displacement"].items()}
    return larger


def scene_of(seed: int) -> Scene:
    """The scene of a seed: the first valid one that it draws."""
    rng = np.random.default_rng([20261128, seed])
    while True:
        try:
            return scene_from_dict(config_of(rng))
        except SceneError:
            continue


class Watch:
    """Collects the violations in the states of a run."""

    def __init__(self) -> None:
        self.found: list[str] = []
        self.last: State | None = None
        self.largest = 0.0

    def __call__(self, state: State, record: Record) -> None:
        for text in (*self.forces(state, record), *self.energy(state), *self.tips(state, record)):
            self.found.append(f"step {state.stage.step}: {text}")
        scale = state.balance.scale(record.steps[-1].load_factor)
        self.found += [f"step {state.stage.step}: {text}" for text in overlaps(state, scale)]
        self.last = state

    def forces(self, state: State, record: Record) -> Iterator[str]:
        """Equilibrium of loads and reactions of the history, and of the weight."""
        step = record.steps[-1]
        parts = np.column_stack([step.values[f"reaction_{axis}"] for axis in "xy"])
        weight = state.loading.proportional.own_weight.sum(axis=0) * step.load_factor
        resultant = np.abs(parts.sum(axis=0) + weight).max()
        largest = np.abs([*parts, weight]).max()
        if resultant > BALANCE * largest:
            yield f"loads and reactions miss each other by {resultant / largest:.1e}"

    def energy(self, state: State) -> Iterator[str]:
        """The stored energy does not exceed the work; growth releases energy."""
        now = state.balance
        stored = float(now.points.energy @ now.points.volume)
        if now.finite:
            self.largest = max(self.largest, stored, abs(now.external_work))
            if self.last is None:
                return
            before = self.last.balance
            work = now.external_work - before.external_work
            rise = stored - float(before.points.energy @ before.points.volume) - work
            if rise > FROM_NOTHING * self.largest:
                yield f"energy appears: {rise / self.largest:.1e}"
            return
        loads = state.loading.at(now.load_factor)
        dead = float((loads.force * (now.displacement - loads.displacement)).sum())
        self.largest = max(self.largest, stored)
        held = now.internal_force - now.contact_force
        work = 0.5 * (dead + float((held * loads.displacement).sum()))
        if abs(stored - work) > 1e-7 * self.largest:
            yield f"stored energy and work differ: {stored:.6g}, {work:.6g}"
        potential = stored - dead
        if self.last is not None:
            rise = potential - self.potential
            if rise > FROM_NOTHING * self.largest:
                yield f"energy appears: {rise / self.largest:.1e}"
        self.potential = potential

    def tips(self, state: State, record: Record) -> Iterator[str]:
        """Energy release rates are not negative."""
        for name in ("G", "G_kink"):
            values = state.tips.get(name, np.zeros(0))
            if (values < 0.0).any():
                yield f"{name} = {values.min():.3g}"


def overlaps(state: State, scale: float) -> Iterator[str]:
    """Overlap of crack faces away from supports, at the load of the step."""
    grid, u = state.grid, state.displacement
    for crack in grid.crack_faces:
        turning = turning_of(grid, crack, u) if state.balance.finite else None
        pairs = face_pairs(grid, crack, turning)
        held = state.loading.supported[pairs.left] & state.loading.supported[pairs.right]
        opening = scale * pairs.opening(u)[~held.any(axis=1)]
        if not len(opening):
            continue
        size = math.sqrt(2.0 * grid.areas.min())
        if opening.min() < -OVERLAP * size:
            yield f"{crack} overlaps by {-opening.min() / size:.1e} of an element"


def violations(seed: int) -> tuple[str, list[str]]:
    """Run the scene of a seed; return its ending and the violations."""
    watch = Watch()
    try:
        ending = str(cfmpm.run(scene_of(seed), observe=watch).history.attrs["ending"])
    except (MeshError, SceneError) as error:
        ending = f"refused: {error}"
    except SolveError as error:
        return f"failed: {error}", [*watch.found, f"failed: {error}"]
    return ending, watch.found


def main(count: int, first: int = 0) -> int:
    """Run scenes, print violations, and return the number of scenes with violations."""
    bad = 0
    endings: Counter[str] = Counter()
    for seed in range(first, first + count):
        ending, found = violations(seed)
        endings[ending.split(":")[0]] += 1
        bad += bool(found)
        for text in found:
            sys.stdout.write(f"seed {seed}: {text}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{bad} of {count} scenes violate something; endings: {dict(endings)}\n")
    return bad


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:3] or ["500"])) > 0)
