"""A scene file in a working directory of its own."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import SCENE


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small scene file, in a working directory of its own."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "small.yaml"
    path.write_text(SCENE)
    return path
