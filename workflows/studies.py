"""Which studies the workflow knows, and what its rules ask about them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from cfmpm.errors import SceneError
from cfmpm.scene.document import read_document
from cfmpm.study.batches import batches
from cfmpm.study.reading import Plan, load_study


class Studies:
    """The study files of one call of Snakemake.

    Parameters
    ----------
    shipped : Path
        Folder of study files, each of which has the name of its study.
    given : iterable of Path
        Config files of the call, in which those that are studies are looked for.
    whole : bool
        Whether all members are checked even where only some are asked for: not in the processes
        that run one job each.
    """

    def __init__(self, shipped: Path, given: Iterable[Path], *, whole: bool) -> None:
        self._shipped = shipped
        self._whole = whole
        self._plans: dict[str, Plan] = {}
        self.given = {_name(path): path for path in given if _is_study(path)}

    @property
    def shipped(self) -> list[str]:
        """Names of the studies in the folder."""
        return sorted(path.stem for path in self._shipped.glob("*.yaml"))

    def file(self, name: str) -> str:
        """The study file of a study."""
        return str(self.given.get(name, self._shipped / f"{name}.yaml"))

    def plan(self, name: str) -> Plan:
        """The study with all its members, each checked."""
        if name not in self._plans:
            self._plans[name] = load_study(self.file(name))
        return self._plans[name]

    def batches(self, name: str) -> range:
        """The batches of a study, by their numbers."""
        return range(len(batches(self.plan(name))))

    def members(self, name: str, batch: int) -> range:
        """The members of a batch, by their numbers."""
        plan = self._plans.get(name) or load_study(self.file(name), range(0))
        return batches(plan)[batch]

    def keys(self, name: str, batch: int) -> list[str]:
        """Keys of the members of a batch, which change with what they depend on."""
        only = self.members(name, batch)
        if self._whole:
            return [one.key for one in self.plan(name).members[only.start : only.stop]]
        return [one.key for one in load_study(self.file(name), only).members]

    def definition(self, name: str) -> dict[str, Any]:
        """All that the dataset of a study depends on."""
        plan = self.plan(name)
        text = " ".join(one.key for one in plan.members)
        return {
            "study": json.dumps(plan.study.model_dump(mode="json"), sort_keys=True),
            "base": json.dumps(plan.base, sort_keys=True),
            "members": hashlib.sha256(text.encode()).hexdigest(),
        }


def _is_study(path: Path) -> bool:
    """Whether a config file is a study rather than a part of the workflow's configuration."""
    try:
        data = read_document(path).data
    except SceneError:
        return False
    return isinstance(data, dict) and "base" in data


def _name(path: Path) -> str:
    return str(load_study(path, range(0)).study.name)
