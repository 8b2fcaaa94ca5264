"""Read and check scenes from files and dictionaries, and write them as plain data."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from cfmpm.errors import SceneError
from cfmpm.scene.document import Document, Place, parse_key, read_document
from cfmpm.scene.families import key_as_written
from cfmpm.scene.model import Scene
from cfmpm.scene.rules import broken_rules
from cfmpm.scene.wording import refusals, shown


def load_scene(path: str | os.PathLike[str], overrides: Mapping[str, Any] | None = None) -> Scene:
    """Read and check a scene file.

    Parameters
    ----------
    path : path-like
        A YAML file; units are mm, N, MPa, N/mm.
    overrides : mapping of str to object, optional
        Values that replace those of the file, by dotted key: ``{"loads[0].traction": [0, 5]}``.
        For ``key=value`` from a command line see :func:`cfmpm.scene.parse_override`.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        With every problem found, each with line and key.
    """
    document = read_document(Path(path)).overridden(overrides or {})
    return scene_from_document(document, Path(path).parent)


def scene_from_dict(
    data: Mapping[str, Any],
    source: str = "<dict>",
    overrides: Mapping[str, Any] | None = None,
    folder: str | os.PathLike[str] = ".",
) -> Scene:
    """Check a scene given as nested dictionaries and lists.

    Parameters
    ----------
    data : mapping of str to object
        Contents of a scene file.
    source : str
        Name of the data in error messages.
    overrides : mapping of str to object, optional
        As for :func:`load_scene`.
    folder : path-like
        Start of a relative path of a mesh file; default: the working directory.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        With every problem found, each with its key.
    """
    document = Document(data, Place(source)).overridden(overrides or {})
    return scene_from_document(document, Path(folder))


def placed(
    error: SceneError,
    scene: Scene,
    path: str | os.PathLike[str],
    overrides: Mapping[str, Any] | None = None,
) -> SceneError:
    """Add places in the scene file to problems that were found after reading, on the grid.

    Parameters
    ----------
    error : SceneError
        Its problems have keys of the expanded scene.
    scene : Scene
        As returned by `load_scene` for `path` and `overrides`.
    path : path-like
        The scene file.
    overrides : mapping of str to object, optional
        As for :func:`load_scene`.

    Returns
    -------
    SceneError
        The same problems with file, line and column.
    """
    document = read_document(Path(path)).overridden(overrides or {})
    found = document.error(
        (parse_key(key_as_written(scene, problem.key)), problem.reason)
        for problem in error.problems
        if problem.key
    )
    # Problems without a key concern files other than the scene file.
    return SceneError([*(p for p in error.problems if not p.key), *found.problems])


def effective_config(scene: Scene) -> dict[str, Any]:
    """Return the scene as plain data with all defaults.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    dict of str to object
        Contents of an equal scene for `scene_from_dict`; mm, N, MPa.
    """
    return scene.model_dump(mode="json", exclude_none=True)


def config_hash(scene: Scene) -> str:
    """Return the SHA-256 of the effective config: equal scenes have equal hashes.

    The contents of a mesh file are part of the hash, its path is not.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    str
        Hexadecimal digits.
    """
    return hash_of_texts(config_texts(scene))


def config_texts(scene: Scene, keys: Collection[str] | None = None) -> dict[str, str]:
    """Return what `config_hash` takes of each top-level key, as JSON.

    Parameters
    ----------
    scene : Scene
    keys : collection of str or None
        Top-level keys; default: all.

    Returns
    -------
    dict of str to str
        Without the keys that have no value.
    """
    content = _content(scene, keys)
    return {
        key: json.dumps(value, sort_keys=True, separators=(",", ":"))
        for key, value in content.items()
    }


def hash_of_texts(texts: Mapping[str, str]) -> str:
    """Return the config hash of a scene.

    Parameters
    ----------
    texts : mapping of str to str
        All texts of `config_texts`, in any order.

    Returns
    -------
    str
        Hexadecimal digits.
    """
    text = ",".join(f'"{key}":{texts[key]}' for key in sorted(texts))
    return hashlib.sha256(f"{{{text}}}".encode()).hexdigest()


def changed_keys(one: Scene, other: Scene) -> list[str]:
    """Return the top-level keys in which two scenes differ.

    Parameters
    ----------
    one, other : Scene

    Returns
    -------
    list of str
    """
    a, b = _content(one), _content(other)
    return [key for key in dict.fromkeys([*a, *b]) if a.get(key) != b.get(key)]


def _content(scene: Scene, keys: Collection[str] | None = None) -> dict[str, Any]:
    """Return the effective config, or some of its keys, without the path of a mesh file."""
    include = None if keys is None else set(keys)
    config = scene.model_dump(mode="json", exclude_none=True, include=include)
    if "mesh_file" in config:
        del config["mesh_file"]["file"], config["mesh_file"]["folder"]
    return config


def scene_from_document(document: Document, folder: Path) -> Scene:
    """Check a scene that has been read.

    Parameters
    ----------
    document : Document
    folder : Path
        Start of a relative path of a mesh file.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        With every problem found, each with its place and key.
    """
    data = document.data
    if not isinstance(data, Mapping):
        reason = f"must be a mapping with keys such as name and material; got {shown(data)}"
        raise document.error([((), reason)])
    if "base" in data:
        raise document.error([((), "this is a study: cfmpm study runs it")])
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        raise document.error(refusals(error, data).items()) from None
    if scene.mesh_file is not None:
        start = os.path.abspath(folder / scene.mesh_file.folder)
        mesh_file = scene.mesh_file.model_copy(update={"folder": start})
        scene = scene.model_copy(update={"mesh_file": mesh_file})
    try:
        found = [(parse_key(key), reason) for key, reason in broken_rules(scene)]
    except ValidationError as error:  # raised by the geometry of a family
        said = error.errors(include_url=False)[0]["msg"]
        found = [(("family",), f"its parameters give an invalid geometry: {said}")]
    if found:
        raise document.error(found)
    if scene.mesh_file is not None:
        mesh_file = scene.mesh_file.model_copy(update={"sha256": scene.mesh_file.digest()})
        scene = scene.model_copy(update={"mesh_file": mesh_file})
    return scene
