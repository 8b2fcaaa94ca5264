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

from hostile_results import passed, results
from spoiling import as_yaml, places, spoiled

ROOT = Path(__file__).parents[1]
CPU_SECONDS, MEMORY = 10.0, 2**30  # of one case; of a process
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
