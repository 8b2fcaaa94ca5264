"""Values of a study that stand in another file: ``settings.yaml:block`` in place of a mapping.

Several studies can so share what they replace in their scenes, and a reader finds it in one file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cfmpm.errors import SceneError, did_you_mean
from cfmpm.scene.document import Document, Key, read_document, replaced


def with_blocks(document: Document, folder: Path) -> Document:
    """Put blocks of other files where a study names them.

    Parameters
    ----------
    document : Document
        A study; its `replace` and each of its variants may be ``file.yaml:block``.
    folder : Path
        Folder of relative paths.

    Returns
    -------
    Document
        With mappings in their place, whose keys have their places in the other file.

    Raises
    ------
    SceneError
        If there is no such file or block, or the block is no mapping.
    """
    problems: list[tuple[Key, str]] = []
    data, places = document.data, dict(document.places)
    for key, text in _named(document.data):
        file, _, name = text.rpartition(":")
        try:
            other = read_document(folder / file)
        except SceneError as error:
            problems += ((key, str(problem)) for problem in error.problems)
            continue
        blocks = other.data if isinstance(other.data, Mapping) else {}
        if not isinstance(blocks.get(name), Mapping):
            problems.append((key, f"no block {name} in {file}" + did_you_mean(name, blocks)))
            continue
        data = replaced(data, key, blocks[name])
        inside = {of: place for of, place in other.places.items() if of[0] == name and of[1:]}
        places |= {(*key, *of[1:]): place for of, place in inside.items()}
    if problems:
        raise document.error(problems)
    return Document(data, document.root, places)


def _named(data: Any) -> Iterator[tuple[Key, str]]:
    """Keys of a study under which a block of another file may be named, and the name."""
    if not isinstance(data, Mapping):
        return
    at: list[tuple[Key, Any]] = [(("replace",), data.get("replace"))]
    for section in ("product", "zip"):
        parameters = data.get(section)
        for name, one in parameters.items() if isinstance(parameters, Mapping) else ():
            variants = one.get("variants") if isinstance(one, Mapping) else None
            for label, value in variants.items() if isinstance(variants, Mapping) else ():
                at.append(((section, name, "variants", label), value))
    yield from ((key, value) for key, value in at if isinstance(value, str) and ":" in value)
