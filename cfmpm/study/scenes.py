"""The scenes of the members of a study; what members have in common is checked once."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from cfmpm.scene import Scene, scene_from_document
from cfmpm.scene.document import Document, Place, parse_key, replaced
from cfmpm.scene.material import Material
from cfmpm.scene.reading import config_texts, hash_of_texts
from cfmpm.scene.rules import BODY_KEYS, rules_of_body, rules_of_keys
from cfmpm.study.expansion import Axis
from cfmpm.study.model import Study

Index = tuple[int, ...]


class _Part(NamedTuple):
    """Validated value of a top-level key of a scene, and its text in the config hash."""

    value: Any
    text: str | None


class MemberScenes:
    """Makes the scenes of members.

    The value of a top-level key of a scene, such as material, depends on the indices along the axes
    that set it or a part of it. It is validated once for each combination of these indices, and
    scenes share it. The same holds for the rules of the body, which take most of the time.

    Parameters
    ----------
    study : Study
    base : Document
        The base scene.
    folder : Path
        Start of relative paths in the base scene.
    axes : tuple of Axis
        Of the study.
    written : mapping of str to Place
        Where overrides stand in the study file, by dotted key.
    """

    def __init__(
        self,
        study: Study,
        base: Document,
        folder: Path,
        axes: tuple[Axis, ...],
        written: Mapping[str, Place],
    ) -> None:
        self._base, self._folder, self._written = base, folder, written
        self._axes, self._replace = axes, study.replace
        self._parameters = {name: one for _, name, one in study.parameters()}
        setting: dict[str, set[int]] = {}
        for position, axis in enumerate(axes):
            for key in (key for name in axis.values for key in self._parameters[name].sets()):
                setting.setdefault(str(parse_key(key)[0]), set()).add(position)
        # Positions of the axes that set a top-level key, and of those that set the body.
        self._setting = {top: tuple(sorted(found)) for top, found in setting.items()}
        of_body = [found for top, found in setting.items() if top in BODY_KEYS]
        self._setting_body = tuple(sorted(set().union(*of_body)))
        self._shared: dict[str, _Part] = {}
        self._parts: dict[str, dict[Index, _Part]] = {top: {} for top in self._setting}
        # Materials of the regions of sound bodies.
        self._bodies: dict[Index, Mapping[str, Material]] = {}

    def scene(self, index: Index) -> tuple[Scene, str]:
        """Make the scene of a member.

        Parameters
        ----------
        index : tuple of int
            Of the member along the axes.

        Returns
        -------
        scene : Scene
        config_hash : str

        Raises
        ------
        SceneError
            With all problems found, by file, line and key.
        """
        overrides = dict(self._replace)
        for axis, i in zip(self._axes, index, strict=True):
            for name, values in axis.values.items():
                overrides |= self._parameters[name].replaced(values[i])
        at = {top: _at(setting, index) for top, setting in self._setting.items()}
        at_body = _at(self._setting_body, index)
        scene = self._from_parts(at, at_body, overrides) if self._shared else None
        if scene is None:
            document = self._base.overridden(overrides, self._written)
            scene = scene_from_document(document, self._folder)
            self._bodies[at_body] = rules_of_body(scene).regions
        return scene, self._hash(at, scene)

    def _from_parts(
        self, at: Mapping[str, Index], at_body: Index, overrides: Mapping[str, Any]
    ) -> Scene | None:
        """Make a scene from known parts and from new ones; None if it cannot be made or is wrong.

        Why it is wrong is then found from the whole document, with the places of its keys.
        """
        data = {top: part.value for top, part in self._shared.items()}
        data |= {top: self._parts[top][i].value for top, i in at.items() if i in self._parts[top]}
        new = [top for top in at if top not in data]
        if "mesh_file" in new:  # a file to be read
            return None
        try:
            data |= {top: self._base.data.get(top) for top in new}
            for key, value in overrides.items() if new else ():
                top, *inner = parse_key(key)
                if top in new:
                    data[str(top)] = replaced(data[str(top)], tuple(inner), value)
            scene = Scene.model_validate(data)
            if at_body not in self._bodies:
                body = rules_of_body(scene)
                if body.found:
                    return None
                self._bodies[at_body] = body.regions
        except (ValidationError, LookupError):
            return None
        return None if rules_of_keys(scene, self._bodies[at_body]) else scene

    def _hash(self, at: Mapping[str, Index], scene: Scene) -> str:
        """Return the config hash of a checked scene, and remember its parts."""
        # Another member may set a key that no scene has, and is refused for it.
        at = {top: i for top, i in at.items() if top in Scene.model_fields}
        if not self._shared:
            texts = config_texts(scene)
            tops = (top for top in Scene.model_fields if top not in at)
            self._shared = {top: _Part(getattr(scene, top), texts.get(top)) for top in tops}
        new = [top for top, i in at.items() if i not in self._parts[top]]
        if new:
            texts = config_texts(scene, new)
            for top in new:
                self._parts[top][at[top]] = _Part(getattr(scene, top), texts.get(top))
        found = {top: part.text for top, part in self._shared.items()}
        found |= {top: self._parts[top][i].text for top, i in at.items()}
        return hash_of_texts({top: text for top, text in found.items() if text is not None})


def _at(axes: tuple[int, ...], index: Index) -> Index:
    """Return the indices along some axes."""
    return tuple([index[i] for i in axes])
