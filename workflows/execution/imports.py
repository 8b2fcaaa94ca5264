"""Of which modules of the workflow a script is made: inputs of its rule."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = "workflows"
# It changes no result.
SURROUNDINGS = Path(PACKAGE, "execution", "job.py")


def modules_of(script: Path, root: Path) -> list[str]:
    """The modules of the workflow that a script imports, and those that they import.

    Parameters
    ----------
    script, root : Path
        The script, and the repository.

    Returns
    -------
    list of str
        Relative to the repository. `workflows.execution.job` is left out: it changes no result.
    """
    found: set[Path] = set()
    due = [script]
    while due:
        new = _imported(due.pop(), root) - found
        found |= new
        due += new
    return sorted(str(path.relative_to(root)) for path in found - {root / SURROUNDINGS})


@cache
def _imported(path: Path, root: Path) -> frozenset[Path]:
    names = _names(ast.parse(path.read_text(encoding="utf-8")))
    paths = (root.joinpath(*name.split(".")).with_suffix(".py") for name in names)
    return frozenset(path for path in paths if path.is_file())


def _names(tree: ast.Module) -> Iterator[str]:
    """Modules that are imported, and what is imported from packages, which may be modules."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == PACKAGE:
            yield str(node.module)
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
