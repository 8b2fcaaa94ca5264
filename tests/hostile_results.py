"""Damaged and crafted results: what commands do with them."""

from __future__ import annotations

import json
import os
import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import Result
from spoiling import damaged, spoiled

SCENE = {
    "name": "small",
    "family": {"kind": "single_edge", "width": 10, "height": 20, "crack_length": 4, "traction": 10},
    "material": {"E": 210e3, "nu": 0.3, "g_c": 1.0},
    "mesh": {"element": "T3", "size": 4},
    "growth": {"control": "crack", "increments": 2},
    "output": {"every": 1, "fields": True},
}
FILES = ("history.nc", "fields.nc", "fields_index.nc", "fields_0002.nc", "checkpoint.npz")


def results(folder: Path) -> Callable[[random.Random], None]:
    """Call a command on a result with a damaged file; other files must not change."""
    from typer.testing import CliRunner

    from cfmpm import simulation
    from cfmpm.cli.app import app
    from cfmpm.output.run_writer import RunWriter
    from cfmpm.scene import scene_from_dict

    whole, broken_off = folder / "whole", folder / "broken_off"
    scene, runner = scene_from_dict(SCENE), CliRunner()
    file = folder / "scene.yaml"
    file.write_text(json.dumps(SCENE))
    for where in (whole, broken_off):
        where.mkdir()
        writer = RunWriter(where)

        def observe(state: Any, record: Any, writer: RunWriter = writer) -> None:
            writer._due = 0.0  # write at each step
            writer.observe(state, record)

        result = simulation.run(scene, observe=observe)
        if where == whole:
            writer.finish(result)
    around = folder / "around"

    def one(rng: random.Random) -> None:
        command = rng.choice(["plot", "plot", "export", "resume", "resume", "check", "run"])
        shutil.rmtree(around, ignore_errors=True)
        result = around / "inner" / "result"
        shutil.copytree(broken_off if command == "resume" or rng.random() < 0.3 else whole, result)
        for where in (around, around / "inner", result / "mesh_", result / "vtu"):
            where.mkdir(exist_ok=True)
            (where / "precious.png").write_text("kept")
        spoil(result, rng)
        before = listed(around, result)
        arguments = {
            "check": ["check", str(file), "--output", str(result)],
            "run": ["run", str(file), "--output", str(result), "--overwrite"],
        }.get(command, [command, str(result)])
        done = runner.invoke(app, arguments, catch_exceptions=True)
        if listed(around, result) != before:
            raise AssertionError(f"{command} has touched what is not the result's")
        passed(done, command)

    return one


def listed(around: Path, result: Path) -> dict[str, Any]:
    """All files around a result with their contents."""
    return {
        str(path): path.read_bytes() if path.is_file() else None
        for path in sorted(around.rglob("*"))
        if not path.is_relative_to(result)
    }


def spoil(result: Path, rng: random.Random) -> None:
    """Damage a file of a result at random, or with a valid format."""
    there = [name for name in FILES if (result / name).exists()]
    path = result / rng.choice(there)
    kind = rng.randrange(10)
    if kind < 5:
        path.write_bytes(damaged(path.read_bytes(), rng))
    elif kind == 5:
        path.unlink()
        other = rng.choice(["fifo", "folder", "link", "device"])
        if other == "fifo":
            os.mkfifo(path)
        elif other == "folder":
            path.mkdir()
        else:
            path.symlink_to("/dev/zero" if other == "device" else "../precious.png")
    elif kind == 6:
        links = {".lock": "../lock", ".started": "../precious.png", "vtu": "..", "mesh_": ".."}
        name = rng.choice(list(links))
        if (result / name).is_dir():
            shutil.rmtree(result / name)
        (result / name).symlink_to(links[name])
    elif path.suffix == ".npz":
        craft_arrays(path, rng)
    else:
        craft_dataset(path, rng)


def craft_dataset(path: Path, rng: random.Random) -> None:
    """Change names, values and attributes of a dataset in a valid netCDF file."""
    import xarray as xr

    dataset = xr.load_dataset(path, engine="netcdf4")
    for _ in range(rng.choice([1, 1, 2, 4])):
        name = rng.choice([str(one) for one in dataset.variables])
        kind = rng.randrange(6)
        if kind == 0 and name in dataset.data_vars:
            dataset = dataset.drop_vars(name)
        elif kind == 1:
            attribute = rng.choice(sorted(dataset.attrs))
            value = rng.choice(["", "x", "[" * 3000, "{}", 1, 1e300, "[1]", "null"])
            if attribute == "config" and rng.random() < 0.8:
                value = json.dumps(spoiled(json.loads(str(dataset.attrs["config"])), rng))
            dataset.attrs[attribute] = value
        elif kind == 2 and name in dataset.data_vars and dataset[name].ndim:
            dataset[name] = dataset[name].isel({dataset[name].dims[0]: 0}, drop=True)
        elif name in dataset.variables and dataset[name].size:
            values = dataset[name].values.copy()
            if values.dtype.kind in "OUT":
                values = values.astype(object)
                words = [
                    "../../precious",
                    "/../precious",
                    "",
                    "a" * 300,
                    "../precious.png",
                    "/etc/x",
                ]
                values.flat[rng.randrange(values.size)] = rng.choice(words)
            else:
                numbers = (
                    [0, -1, 1, 127]
                    if values.dtype.kind in "iu"
                    else [0.0, -1.0, np.nan, np.inf, 1e300]
                )
                some = slice(None) if rng.random() < 0.3 else rng.randrange(values.size)
                values.reshape(-1)[some] = rng.choice(numbers)
            dataset[name] = (dataset[name].dims, values, dataset[name].attrs)
    for variable in dataset.variables.values():
        variable.encoding.clear()
    path.unlink()
    dataset.to_netcdf(path, engine="netcdf4")


def craft_arrays(path: Path, rng: random.Random) -> None:
    """Change arrays and texts of a checkpoint in a valid file."""
    with np.load(path) as file:
        arrays = dict(file)
    for _ in range(rng.choice([1, 1, 2])):
        name = rng.choice(list(arrays))
        kind = rng.randrange(6)
        if rng.random() < 0.4:
            texts = spoiled(json.loads(str(arrays["texts"])), rng)
            arrays["texts"] = np.array(json.dumps(texts))
        elif kind == 0 and name != "texts":
            del arrays[name]
        elif name in arrays and name != "texts" and arrays[name].size:
            values = arrays[name].copy()
            if kind == 1:
                values = values[: rng.randrange(len(values))]
            elif kind == 2:
                values = values.astype(float if values.dtype.kind in "iu" else np.int64)
            elif kind == 3:
                values = np.concatenate([values, values])
            else:
                numbers = (
                    [0, -1, 1, 10**9] if values.dtype.kind in "iub" else [0.0, -1.0, np.nan, 1e300]
                )
                some = slice(None) if rng.random() < 0.3 else rng.randrange(values.size)
                values.reshape(-1)[some] = rng.choice(numbers)
            arrays[name] = values
    np.savez(path, **arrays)


def passed(done: Result, what: str) -> None:
    """Raise where a command did not end by an exit of its own."""
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    if done.exit_code not in (0, 1, 2) or "Traceback" in done.output:
        raise AssertionError(f"{what}: status {done.exit_code}: {done.output}")
