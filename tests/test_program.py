"""Modules that are excluded from the version of a result are not imported by its computation."""

from __future__ import annotations

import ast
from pathlib import Path

import cfmpm
from cfmpm.program import APART, program_files


def imported(path: Path) -> set[str]:
    """All imports of a file, also inside functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def test_what_makes_a_result_imports_none_of_the_rest() -> None:
    root = Path(cfmpm.__file__).parent
    assert all((root / name).exists() for name in APART)
    apart = tuple(f"cfmpm.{name.removesuffix('.py')}." for name in APART)
    # But for the methods by which a history that is open is drawn.
    for path in set(program_files()) - {root / "accessor.py"}:
        assert not [name for name in imported(path) if f"{name}.".startswith(apart)], path


def test_what_makes_a_result() -> None:
    names = [path.name for path in program_files()]
    assert {"simulation.py", "stretch.py", "model.py"} <= set(names)
    assert not {"cli.py", "summary.py", "style.py", "batches.py"} & set(names)
