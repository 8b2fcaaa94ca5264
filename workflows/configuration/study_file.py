"""Study files of the paper, as the workflow's configuration names them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cfmpm.study.expansion import labelled
from cfmpm.study.model import Parameter, Study
from cfmpm.study.reading import load_study


def read_study(path: str) -> Study:
    """Read a study file without its members."""
    return load_study(path, range(0)).study


def parameter(path: str, name: str) -> Parameter:
    """Return a parameter of a study.

    Raises
    ------
    ValueError
        Where the study has no such parameter.
    """
    found = read_study(path).product.get(name)
    if found is None:
        raise ValueError(f"{path}: figures and claims need a parameter {name}")
    return found


def labels(path: str, name: str) -> list[str]:
    """What the values of a parameter are called."""
    one = parameter(path, name)
    return list(one.variants or one.values)


def replaced(path: str, name: str, label: str) -> dict[str, Any]:
    """What a value of a parameter puts into the scene, by dotted keys."""
    one = parameter(path, name)
    return one.replaced(labelled(one, label))


def scene_of(path: str) -> str:
    """Return the scene file that a study starts from, relative to where the study file is named."""
    base = read_study(path).base
    if not isinstance(base, str):
        raise ValueError(f"{path}: base must be the path of a scene file")
    parts: list[str] = []
    for part in (Path(path).parent / base).parts:
        if part == "..":
            parts.pop()
        else:
            parts.append(part)
    return str(Path(*parts))
