"""Values of a study that stand in another file."""

from __future__ import annotations

from pathlib import Path

import pytest
from study_texts import write_study

from cfmpm.errors import SceneError
from cfmpm.study.reading import load_study

SETTINGS = """\
coarse: {mesh.size: 4}
fine:
  mesh.size: 1
  fracture.radii: [0.5]
wrong: {mesh.sizes: 1}
list: [1]
"""
STUDY = """\
name: blocks
base: small.yaml
replace: settings/all.yaml:coarse
product:
  grid:
    variants:
      as_it_is: {}
      fine: settings/all.yaml:fine
"""


def written(folder: Path, text: str = STUDY) -> Path:
    """A study and its file of settings in a folder beside it."""
    (folder / "settings").mkdir()
    (folder / "settings" / "all.yaml").write_text(SETTINGS)
    return write_study(folder, text)


def test_a_block_stands_for_what_it_holds(tmp_path: Path) -> None:
    plan = load_study(written(tmp_path))
    assert [one.scene.mesh.size for one in plan.members] == [4, 1]
    assert [one.scene.fracture.radii for one in plan.members] == [1, [0.5]]
    # What is stored with the results needs no further file.
    assert plan.study.replace == {"mesh.size": 4}


@pytest.mark.parametrize(
    ("old", "new", "at", "words"),
    [
        ("all.yaml:coarse", "all.yaml:corse", "study.yaml:3:1: replace: ", "did you mean coarse?"),
        ("all.yaml:fine", "none.yaml:fine", "study.yaml:8:7: ", "none.yaml: no such file"),
        ("all.yaml:fine", "all.yaml:list", "study.yaml:8:7: ", "no block list"),
        ("all.yaml:fine", "all.yaml", "study.yaml:8:7: ", "file.yaml:block"),
        ("all.yaml:coarse", "all.yaml:wrong", "study.yaml:2:1: ", "all.yaml:5:9: mesh.sizes"),
    ],
)
def test_a_bad_block(old: str, new: str, at: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        load_study(written(tmp_path, STUDY.replace(old, new)))
    assert at in str(caught.value)
    assert words in str(caught.value)
    assert "pydantic" not in str(caught.value)
