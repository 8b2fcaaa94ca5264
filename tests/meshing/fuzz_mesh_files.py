"""Damaged mesh files, with fixed seeds: each is run as a scene and must end as specified.

``python tests/meshing/fuzz_mesh_files.py 1000`` runs the files of seeds 0 to 999 and prints what
became of them; it fails if a run left a traceback, crashed, took more than 10 s of CPU time or
1 GB of memory, or reported more than one line for each problem.
"""

from __future__ import annotations

import json
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

CPU, MEMORY = 10.0, 1e9  # s, bytes
FORMATS = [(1, 0), (2.2, 0), (2.2, 1), (4.0, 0), (4.1, 0), (4.1, 1)]
NUMBERS = [
    "0", "-1", "1", "2", "7", "1e300", "-1e-300", "nan", "inf", "1e400", "0.5", "99999999",
    "18446744073709551615", "-9223372036854775808", "4294967296", "2147483648", "", "x", "1 1",
]  # fmt: skip
SCENE = """name: damaged
mesh_file:
  file: a.msh
  cracks: [{crack}]
  regions: [{{name: {lower}, material: {{E: 1e5, nu: 0.2}}}}]
material: {{E: 2e5, nu: 0.3, g_c: 1}}
mesh: {{element: {element}}}
loads:
  - {{edge: {bottom}, displacement: {{x: 0, y: 0}}}}
  - {{edge: {top}, traction: [0, 10]}}
"""
NAMED = {"crack": "crack", "lower": "lower", "bottom": "bottom", "top": "top"}
UNNAMED = {"crack": "curve_3", "lower": "surface_4", "bottom": "curve_1", "top": "curve_2"}


def peak_memory() -> int:
    """Return the largest resident size since this program was started [bytes].

    That of `getrusage` begins with the size of the process that started the program.
    """
    lines = Path("/proc/self/status").read_text("ascii", "replace").splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:"))


def write_good(path: Path, version: float, binary: int) -> None:
    """A square of side 10 with an edge crack of 5 at half height, the lower quarter a group."""
    import gmsh

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 2.5)
    cad = gmsh.model.geo
    at = [(0, 0), (10, 0), (10, 2.5), (10, 10), (0, 10), (0, 5), (0, 2.5), (5, 5)]
    a, b, c, d, e, mouth, f, tip = (cad.addPoint(*place, 0) for place in at)
    ends = [(a, b), (b, c), (c, d), (d, e), (e, mouth), (mouth, f), (f, a), (c, f), (mouth, tip)]
    bottom, right, above, top, left, below, low_left, seam, crack = (
        cad.addLine(*pair) for pair in ends
    )
    low = cad.addPlaneSurface([cad.addCurveLoop([bottom, right, seam, low_left])])
    high = cad.addPlaneSurface([cad.addCurveLoop([above, top, left, below, -seam])])
    cad.synchronize()
    gmsh.model.mesh.embed(1, [crack], 2, high)
    for tag, (name, curve) in enumerate({"bottom": bottom, "top": -top, "crack": crack}.items(), 1):
        gmsh.model.addPhysicalGroup(1, [curve], tag, name)
    gmsh.model.addPhysicalGroup(2, [low], 4, "lower")
    gmsh.model.addPhysicalGroup(2, [low, -high], 5, "plate")
    gmsh.model.mesh.generate(2)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write(str(path))
    gmsh.finalize()


def cut_off(data: bytes, draw: random.Random, other: bytes) -> bytes:
    return data[: draw.randrange(len(data))]


def flip_bytes(data: bytes, draw: random.Random, other: bytes) -> bytes:
    changed = bytearray(data)
    for _ in range(draw.choice([1, 1, 2, 5, 20])):
        changed[draw.randrange(len(changed))] ^= 1 << draw.randrange(8)
    return bytes(changed)


def edit_numbers(data: bytes, draw: random.Random, other: bytes) -> bytes:
    places = list(re.finditer(rb"(?<=[\s\"])-?\d[\d.e+-]*(?=\s)", data))
    chosen = draw.sample(places, draw.choice([1, 1, 1, 2, 4]))
    for found in sorted(chosen, key=lambda place: -place.start()):
        new = draw.choice([*NUMBERS, draw.choice(places)[0].decode(), str(draw.randrange(70))])
        data = data[: found.start()] + new.encode() + data[found.end() :]
    return data


def nudge_numbers(data: bytes, draw: random.Random, other: bytes) -> bytes:
    """Change numbers to valid numbers of their type: other coordinates, other nodes."""
    places = list(re.finditer(rb"(?<=\s)\d[\d.e+-]*(?=\s)", data))
    chosen = draw.sample(places, draw.choice([1, 1, 2, 4]))
    for found in sorted(chosen, key=lambda place: -place.start()):
        old = found[0].decode()
        if re.fullmatch(r"\d+", old):
            new = str(max(0, int(old) + draw.choice([-5, -2, -1, 1, 2, 5, 20])))
        else:
            new = repr(
                float(old) + draw.choice([-5, -1, -0.3, -1e-3, -1e-9, 1e-9, 1e-3, 0.3, 1, 5])
            )
        data = data[: found.start()] + new.encode() + data[found.end() :]
    return data


def move_lines(data: bytes, draw: random.Random, other: bytes) -> bytes:
    lines = data.split(b"\n")
    for _ in range(draw.choice([1, 1, 2, 5])):
        i, j = draw.randrange(len(lines)), draw.randrange(len(lines))
        what = draw.choice(["drop", "repeat", "swap", "copy"])
        if what == "drop":
            del lines[i]
        elif what == "repeat":
            lines.insert(i, lines[i])
        elif what == "swap":
            lines[i], lines[j] = lines[j], lines[i]
        else:
            lines[i] = lines[j]
    return b"\n".join(lines)


def overwrite(data: bytes, draw: random.Random, other: bytes) -> bytes:
    """Overwrite integers of binary files, and random bytes elsewhere."""
    i = draw.randrange(len(data))
    noise = draw.randbytes(draw.choice([4, 8, 64]))
    new = draw.choice([b"\0" * 8, b"\xff" * 4, b"\xff" * 8, noise])
    return data[:i] + new + data[i + len(new) * draw.choice([0, 1]) :]


def splice(data: bytes, draw: random.Random, other: bytes) -> bytes:
    i, j = draw.randrange(len(data)), draw.randrange(len(other))
    return data[:i] + other[j:]


DAMAGE: list[Callable[[bytes, random.Random, bytes], bytes]] = [
    cut_off, flip_bytes, edit_numbers, nudge_numbers, nudge_numbers, nudge_numbers, move_lines,
    overwrite, splice,
]  # fmt: skip


def damaged(good: list[bytes], seed: int) -> tuple[bytes, str]:
    """The file and the scene of a seed."""
    draw = random.Random(seed)
    i, j = draw.randrange(len(good)), draw.randrange(len(good))
    data = good[i]
    binary = FORMATS[i][1]
    for _ in range(draw.choice([1, 1, 2])):
        kind = draw.choice(DAMAGE if not binary else [*DAMAGE, flip_bytes, overwrite])
        data = kind(data, draw, good[j]) or b"\n"
    names = UNNAMED if FORMATS[i][0] == 1 else NAMED
    return data, SCENE.format(element=draw.choice(["T3", "T6"]), **names)


def _tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def run_here(folder: Path, first: int, last: int) -> None:
    """Run scenes in this process; print the start and the end of each."""
    from typer.testing import CliRunner

    from cfmpm.cli.app import app

    good = [(folder / f"good_{i}.msh").read_bytes() for i in range(len(FORMATS))]
    scene, mesh = folder / "scene.yaml", folder / "a.msh"
    runner = CliRunner()
    command = ["run", str(scene), "--overwrite", "--quiet", "--output", str(folder / "result")]
    # What all cases share is compiled first.
    for element in ("T3", "T6"):
        mesh.write_bytes(good[1])
        scene.write_text(SCENE.format(element=element, **NAMED))
        assert runner.invoke(app, command).exit_code == 0
    for seed in range(first, last):
        data, text = damaged(good, seed)
        mesh.write_bytes(data)
        scene.write_text(text)
        _tell(json.dumps({"seed": seed}))
        # The system ends the process where one case takes too long.
        signal.setitimer(signal.ITIMER_PROF, CPU)
        began = time.process_time()
        result = runner.invoke(app, command)
        signal.setitimer(signal.ITIMER_PROF, 0)
        broken = result.exception
        case = {
            "seed": seed,
            "code": result.exit_code,
            "broken": "" if isinstance(broken, SystemExit | None) else repr(broken),
            "text": result.output,
            "cpu": time.process_time() - began,
            "memory": peak_memory(),
        }
        _tell(json.dumps(case))


def run_cases(count: int) -> Iterator[dict]:
    """Run the cases in a child process; start another one after a case that ends it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for i, (version, binary) in enumerate(FORMATS):
            write_good(folder / f"good_{i}.msh", version, binary)
        first = 0
        while first < count:
            with subprocess.Popen(
                [sys.executable, __file__, "--child", str(folder), str(first), str(count)],
                stdout=subprocess.PIPE,
                text=True,
            ) as child:
                seed = -1
                for line in child.stdout or ():
                    case = json.loads(line)
                    seed = case["seed"]
                    if "code" in case:
                        first = seed + 1
                        yield case
            if first < count:
                if seed < first:
                    raise RuntimeError(f"the child ended by itself, with {child.returncode}")
                yield {"seed": seed, "code": child.returncode, "broken": "the process ended"}
                first = seed + 1


def violation(case: dict) -> str:
    """Describe the violation of a case, if any."""
    if case["broken"]:
        return f"seed {case['seed']}: {case['broken']}, code {case['code']}"
    if case["code"] not in (0, 1, 2) or "Traceback" in case["text"]:
        return f"seed {case['seed']}: code {case['code']}, {case['text']}"
    if case["cpu"] > CPU or case["memory"] > MEMORY:
        return f"seed {case['seed']}: {case['cpu']:.1f} s, {case['memory']:.2g} bytes"
    refused = [line for line in case["text"].splitlines() if "scene.yaml:" in line]
    if case["code"] == 2 and not refused:
        return f"seed {case['seed']}: status 2 without a line about the scene: {case['text']}"
    return ""


def main(count: int) -> int:
    """Run the cases and print their outcomes."""
    codes, bad, slowest, most = Counter[int](), [], 0.0, 0.0
    for case in run_cases(count):
        codes[case["code"]] += 1
        slowest, most = max(slowest, case.get("cpu", CPU)), max(most, case.get("memory", 0.0))
        if found := violation(case):
            bad.append(found)
            _tell(found)
    ended = ", ".join(f"{n} with status {code}" for code, n in sorted(codes.items()))
    size = f"at most {slowest:.2f} s, {most:.2g} bytes"
    _tell(f"{count} files: {ended}; {len(bad)} violations; {size}")
    return 1 if bad else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        run_here(Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
    else:
        sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000))
