"""Architecture: layered imports without cycles, size of modules and functions."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LINES_OF_A_MODULE, LINES_OF_A_FUNCTION = 450, 80
NAMES_THAT_SAY_NOTHING = {"utils", "util", "helpers", "helper", "common", "misc"}
SOURCES = sorted(path for name in ("cfmpm", "workflows") for path in (ROOT / name).rglob("*.py"))


def functions_of(path: Path) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def test_imports_run_one_way() -> None:
    """The contracts of pyproject.toml: layers, no cycles."""
    linter = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [linter, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_documented_layers_are_those_of_the_contract() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]
    (layers,) = (one["layers"] for one in contracts["contracts"] if one["type"] == "layers")
    level = {name: i for i, row in enumerate(layers) for name in row.split(" : ")}
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    table = text.partition("## Layers")[2].partition("## ")[0]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    named = [name for row in rows for name in re.findall(r"`(\w+)`", row)]
    assert [level[name] for name in named] == sorted(level[name] for name in named)
    below = level["registry"]
    assert set(named) == {name for name in level if level[name] <= below} - {"__main__"}


def test_a_circle_is_found(tmp_path: Path) -> None:
    """Two modules that import each other break a contract."""
    package = tmp_path / "ring"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "a.py").write_text("import ring.b\n")
    (package / "b.py").write_text("import ring.a\n")
    (tmp_path / ".importlinter").write_text(
        "[importlinter]\nroot_package = ring\n"
        "[importlinter:contract:1]\nname = no circles\ntype = acyclic_siblings\nancestors = ring\n"
    )
    linter = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [linter, "--no-cache"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1, done.stdout + done.stderr


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_size(path: Path) -> None:
    assert len(path.read_text("utf-8").splitlines()) <= LINES_OF_A_MODULE
    long = {
        one.name: one.end_lineno - one.lineno + 1
        for one in functions_of(path)
        if one.end_lineno is not None and one.end_lineno - one.lineno >= LINES_OF_A_FUNCTION
    }
    assert not long


def test_names_say_what_a_module_holds() -> None:
    assert not {path.stem for path in SOURCES} & NAMES_THAT_SAY_NOTHING
