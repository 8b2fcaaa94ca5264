"""Which files of this package the numbers of a result depend on."""

from __future__ import annotations

from pathlib import Path

# Commands, figures, and collection of results: these do not change numbers.
APART = ("__main__.py", "cli", "plotting", "study", "output/summary.py", "output/vtu.py")


def program_files() -> list[Path]:
    """Return the sources that make a result: where one changes, results are computed again."""
    root = Path(__file__).parent
    files = sorted(root.glob("**/*.py"))
    return [path for path in files if not _stands_apart(path.relative_to(root).as_posix())]


def _stands_apart(path: str) -> bool:
    return any(path == name or path.startswith(f"{name}/") for name in APART)
