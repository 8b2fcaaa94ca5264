"""Random input: invalid scenes, odd scenes to mesh, study files, damaged results; fixed seeds.

As a script it runs the given number of cases in child processes, and counts violations of what
is required:

    python tests/hostile.py scenes 10000
    python tests/hostile.py grids 1000
    python tests/hostile.py studies 1000
    python tests/hostile.py results 1000

`tests/test_hostile.py` runs a tenth.
"""

from __future__ import annotations

import copy
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import Result

ROOT = Path(__file__).parents[1]
CPU_SECONDS, MEMORY = 10.0, 2**30  # of one case; of a process
ODD: list[Any] = [
    *(
        None,
        True,
        "",
        "x",
        ".inf",
        "-.inf",
        ".nan",
        0,
        -1,
        1,
        2,
        -0.0,
        1e-300,
        1e300,
        1e31,
        10**400,
    ),
    *(
        [],
        [[]],
        {},
        [1],
        [0, 0],
        [1, 2, 3],
        {"at": [0, 0]},
        {"x": 1},
        "../../x",
        "/",
        "\0",
        "é",
        "a" * 300,
    ),
    *(1e-9, 1e9, 1e-5, 0.5, 3, 7.5, "steel", "T6", "finite", "crack", "auto", "all"),
]
TEXTS = [
    "a: &a [*a]\n",
    "[" * 5000,
    "{" * 5000,
    "- " * 5000,
    "? " * 3000,
    "[" + "1," * 200_000 + "1]",
    "- 1\n" * 200_000,
    "a: " + "x " * 1_000_000,
    "a0: &a0 [1, 1]\n" + "".join(f"a{i}: &a{i} [{f'*a{i - 1}, ' * 30}]\n" for i in range(1, 9)),
    "a: !!binary zzz\n",
    "a: !!python/object/apply:os.system [true]\n",
    "__use_yte__: true\n",
    "%YAML 9.9\n---\na: 1\n",
    "a: \"" + "\\x" * 10,
    "a: 1" * 10000,
    "&a " * 5000,
    "a: |\n" + " " * 500_000,
    "# " + "c" * 1_000_000 + "\na: 1\n",
    "x" * 3_000_000,
    "'" + "''" * 500_000,
    "[a: " * 2000,
]  # fmt: skip


def say(text: str) -> None:
    """Print while the output of cases is captured."""
    sys.__stdout__.write(f"{text}\n")  # type: ignore[union-attr]
    sys.__stdout__.flush()  # type: ignore[union-attr]


class TooLongError(BaseException):
    """A case takes more CPU time than allowed."""


@contextmanager
def limited() -> Iterator[None]:
    """End a case that takes too long, if Python code is running."""

    def stop(number: int, frame: object) -> None:
        raise TooLongError

    signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, CPU_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)


def places(data: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every key of nested plain data."""
    if isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield (*at, key)
            yield from places(value, (*at, key))


def odd(rng: random.Random) -> Any:
    """A random value, which is rarely valid."""
    return copy.deepcopy(rng.choice(ODD))


def spoiled(data: Any, rng: random.Random) -> Any:
    """A copy of plain data with a few unexpected values, keys or lists."""
    data = copy.deepcopy(data)
    for _ in range(rng.choice([1, 1, 2, 3, 6])):
        there = list(places(data))
        if not there:
            return data
        *way, last = rng.choice(there)
        inside = data
        for key in way:
            inside = inside[key]
        kind = rng.randrange(7)
        if kind == 0 and isinstance(inside, dict):
            del inside[last]
        elif kind == 1 and isinstance(inside, dict):
            inside[rng.choice(["x", "name", "base", "__use_yte__", str(last) + "_"])] = rng.choice(
                ODD
            )
        elif kind == 2 and isinstance(inside, list):
            inside.extend(copy.deepcopy([inside[last]]) * rng.choice([1, 2, 50]))
        elif kind == 3 and isinstance(inside[last], float | int) and abs(inside[last]) < 1e99:
            inside[last] = inside[last] * rng.choice([-1, 0, 1e-6, 0.5, 2, 1e3, 1e9, 1 + 1e-7])
        elif kind == 4:
            other = rng.choice(there)
            value = data
            for key in other:
                if not isinstance(value, dict | list):
                    break
                try:
                    value = value[key]
                except LookupError:
                    break
            inside[last] = copy.deepcopy(value)
        else:
            inside[last] = odd(rng)
    return data


def as_yaml(data: Any, rng: random.Random) -> bytes:
    """The data as a YAML file, which sometimes is damaged too."""
    content = json.dumps(data).encode()
    if rng.random() < 0.1:
        return damaged(content, rng)
    return content


def damaged(content: bytes, rng: random.Random) -> bytes:
    """Bytes changed, removed or repeated."""
    kind, size = rng.randrange(6), len(content)
    if kind == 0:
        return content[: rng.randrange(size + 1)]
    some = bytearray(content)
    if kind == 1:
        begin = rng.randrange(size)
        del some[begin : begin + rng.choice([1, 8, 512, 4096])]
    elif kind == 2:
        begin = rng.randrange(size)
        some[begin:begin] = rng.randbytes(rng.choice([1, 8, 512]))
    elif kind == 3:
        begin = rng.randrange(size)
        n = min(rng.choice([8, 512, 4096]), size - begin)
        some[begin : begin + n] = bytes([rng.choice([0, 255])]) * n
    else:
        # The head of a file says what is where.
        reach = size if kind == 4 else min(size, 4096)
        for _ in range(rng.choice([1, 2, 8, 64])):
            some[rng.randrange(reach)] = rng.randrange(256)
    return bytes(some)


def bases(folder: Path) -> list[Any]:
    """Plain data of all files in a folder."""
    from cfmpm.scene.document import read_document

    return [read_document(path).data for path in sorted(folder.rglob("*.yaml"))]


def scenes(folder: Path) -> Callable[[random.Random], None]:
    """Read a random invalid scene."""
    from cfmpm.scene import load_scene

    sources = bases(ROOT / "configs" / "examples") + bases(ROOT / "configs" / "paper")
    sources = [one for one in sources if "base" not in one]

    def one(rng: random.Random) -> None:
        path = folder / "scene.yaml"
        if rng.random() < 0.02:
            path.write_text(rng.choice(TEXTS))
        else:
            path.write_bytes(as_yaml(spoiled(rng.choice(sources), rng), rng))
        load_scene(path)

    return one


# Largest expected number of triangles of a scene that is meshed: others may well take long.
MOST_TRIANGLES = 5000


def nudged(data: Any, rng: random.Random) -> Any:
    """A copy of plain data with a few numbers that may still fit."""
    data = copy.deepcopy(data)
    numbers = [
        way for way in places(data) if isinstance(value_at(data, way), float | int) and len(way) > 1
    ]
    for _ in range(rng.choice([1, 1, 2, 3, 6])):
        *way, last = rng.choice(numbers)
        inside, value = value_at(data, way), value_at(data, [*way, last])
        if isinstance(value, bool):
            continue
        kind = rng.randrange(4)
        if kind == 0:
            inside[last] = value * rng.choice([-1, 0.1, 0.5, 0.9, 0.99, 1.01, 1.1, 2, 3, 10])
        elif kind == 1:
            inside[last] = value * (1 + rng.choice([-1, 1]) * 10 ** rng.uniform(-9, -2))
        elif kind == 2:
            inside[last] = value_at(data, rng.choice(numbers))
        else:
            inside[last] = value + rng.uniform(-1, 1) * abs(value_at(data, rng.choice(numbers)))
    return data


def value_at(data: Any, way: Sequence[Any]) -> Any:
    """What stands at a place of plain data."""
    for key in way:
        data = data[key]
    return data


def grids(folder: Path) -> Callable[[random.Random], None]:
    """Check an odd but valid scene by the command, which meshes it and draws it."""
    from typer.testing import CliRunner

    from cfmpm.cli.app import app
    from cfmpm.errors import SceneError
    from cfmpm.meshing import expected_triangles
    from cfmpm.scene import load_scene

    sources = bases(ROOT / "configs" / "examples") + bases(ROOT / "configs" / "paper")
    sources = [one for one in sources if "base" not in one]
    path, runner = folder / "scene.yaml", CliRunner()

    def one(rng: random.Random) -> None:
        while True:
            source = rng.choice(sources)
            data = spoiled(source, rng) if rng.random() < 0.2 else nudged(source, rng)
            path.write_text(json.dumps(data))
            try:
                scene = load_scene(path)
            except SceneError:
                continue
            if (expected_triangles(scene) or 0.0) <= MOST_TRIANGLES:
                break
        shutil.rmtree(folder / "result", ignore_errors=True)
        arguments = ["check", str(path), "--output", str(folder / "result")]
        passed(runner.invoke(app, arguments, catch_exceptions=True), json.dumps(data))

    return one


def passed(done: Result, what: str) -> None:
    """Raise where a command did not end by an exit of its own."""
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    if done.exit_code not in (0, 1, 2) or "Traceback" in done.output:
        raise AssertionError(f"{what}: status {done.exit_code}: {done.output}")


def studies(folder: Path) -> Callable[[random.Random], None]:
    """Read a random invalid study file."""
    from cfmpm.study.reading import load_study

    for part in ("examples", "paper"):
        shutil.copytree(ROOT / "configs" / part, folder / part)
    sources = bases(ROOT / "configs" / "studies")

    def one(rng: random.Random) -> None:
        path = folder / "studies" / "study.yaml"
        path.parent.mkdir(exist_ok=True)
        if rng.random() < 0.02:
            path.write_text(rng.choice(TEXTS))
        else:
            path.write_bytes(as_yaml(spoiled(rng.choice(sources), rng), rng))
        load_study(path)

    return one


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


KINDS = {"scenes": scenes, "grids": grids, "studies": studies, "results": results}


def violations(kind: str, cases: range) -> Counter[str]:
    """Run cases of a kind in this process; count the violations.

    Parameters
    ----------
    kind : str
        A key of `KINDS`.
    cases : range
        Their seeds.
    """
    from cfmpm.errors import MeshError, SceneError, SolveError

    found: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        one = KINDS[kind](Path(folder).resolve())
        for seed in cases:
            begin = time.process_time()
            shown = StringIO()
            try:
                with limited(), redirect_stdout(shown), redirect_stderr(shown):
                    one(random.Random(f"{kind} {seed}"))
            except (SceneError, MeshError, SolveError) as error:
                if not str(error).strip():
                    found["errors without words"] += 1
            except TooLongError:
                found["hangs"] += 1
                say(f"{kind} {seed}: hangs")
            except BaseException as error:
                found["tracebacks"] += 1
                last = traceback.extract_tb(error.__traceback__)[-1]
                say(f"{kind} {seed}: {error!r:.300} {last.filename}:{last.lineno}")
            if time.process_time() - begin > CPU_SECONDS:
                found["slow"] += 1
                say(f"{kind} {seed}: {time.process_time() - begin:.1f} s")
    most = max(
        resource.getrusage(who).ru_maxrss * 1024
        for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    if most > MEMORY:
        found["memory"] += 1
    say(f"{kind} {cases}: {dict(found) or 'nothing'}, {most / 2**20:.0f} MB")
    return found


if __name__ == "__main__":
    begin = int(sys.argv[3]) if len(sys.argv) > 3 else 0
    sys.exit(bool(violations(sys.argv[1], range(begin, begin + int(sys.argv[2])))))
