"""Configuration of all tests."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# A shell in the background has its processes ignore Ctrl-C, and these theirs: what tests of
# interrupts send would be lost, and they would wait for it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Groups of tests (CONTRIBUTING.md): by folder, but for those that are slow.
PHYSICS, WORKFLOWS = ("verification",), ("workflows", "study", "cli", "plotting")

# A busy machine is no fault of the code: no limit on time, neither on an example nor on drawing it.
# By default the examples are the same in every run, so that a red test stays red until mended;
# `pytest --hypothesis-profile=search` draws new ones. Both print how to repeat what they find.
settings.register_profile(
    "same",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    print_blob=True,
    derandomize=True,
)
settings.register_profile("search", settings.get_profile("same"), derandomize=False)
settings.load_profile("same")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Do not even import the folders of other groups, for it takes seconds."""
    if collection_path.parent != Path(__file__).parent or not collection_path.is_dir():
        return None
    folder = collection_path.name
    others = {
        "unit": folder in PHYSICS + WORKFLOWS,
        "physics": folder not in PHYSICS,
        "workflows": folder in PHYSICS,
    }
    return others.get(config.option.markexpr) or None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give each test the marker of its group."""
    root = Path(__file__).parent
    for item in items:
        if not item.path.is_relative_to(root):
            item.add_marker("unit")  # examples in docstrings
            continue
        folder = item.path.relative_to(root).parts[0]
        slow = item.get_closest_marker("slow") is not None
        if folder in PHYSICS:
            item.add_marker("physics")
        elif folder in WORKFLOWS or slow:
            item.add_marker("workflows")
        else:
            item.add_marker("unit")
