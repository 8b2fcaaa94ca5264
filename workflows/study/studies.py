"""Parameter studies in the workflow: which there are, and what their rules ask about them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from cfmpm.errors import Problem, SceneError
from cfmpm.scene.document import RUNS_CODE, read_document
from cfmpm.study.batches import batch, batches
from cfmpm.study.model import Study
from cfmpm.study.reading import Plan, load_study
from cfmpm.study.store import read_losses

# How often a batch is tried again after a failure.
RETRIES = 2
DATASET = "results/{study}/study.nc"
BATCH = "results/{study}/members/batch_{batch}.npz"
# Of a batch, in the folder of measured times.
TIMED = "study/{study}/{batch}"


class Studies:
    """The study files of one call of Snakemake; its methods are functions of wildcards.

    Parameters
    ----------
    shipped : Path
        Folder of study files, each of which has the name of its study.
    of_the_paper : Path
        Folder of further ones, which sections of the paper ask for.
    given : mapping of str to Path
        Study files that were given with the call, by the names of their studies.
    whole : bool
        Whether all members are checked even where only some are asked for: not in the processes
        that run one job each.
    """

    def __init__(
        self, shipped: Path, of_the_paper: Path, given: Mapping[str, Path], *, whole: bool
    ) -> None:
        self._shipped = shipped
        self._of_the_paper = of_the_paper
        self._whole = whole
        self._plans: dict[str, Plan] = {}
        self._given = given

    def shipped(self) -> list[str]:
        """The datasets of all studies in the folder."""
        names = sorted(path.stem for path in self._shipped.glob("*.yaml"))
        return [DATASET.format(study=name) for name in names]

    def given(self, wildcards: Any) -> list[str]:
        """The datasets of the studies that were given with the call."""
        if not self._given:
            raise ValueError("no study given: --configfile my_study.yaml")
        return [DATASET.format(study=name) for name in self._given]

    def file(self, wildcards: Any) -> str:
        """The study file of a study."""
        own = f"{wildcards.study}.yaml"
        if wildcards.study in self._given:
            return str(self._given[wildcards.study])
        of_the_paper = self._of_the_paper / own
        return str(of_the_paper if of_the_paper.is_file() else self._shipped / own)

    def parts(self, wildcards: Any) -> list[str]:
        """The files of all batches of a study."""
        count = len(batches(self._plan(wildcards)))
        return [BATCH.format(study=wildcards.study, batch=number) for number in range(count)]

    def members(self, wildcards: Any) -> range:
        """The members of a batch, by their numbers."""
        plan = self._plan(wildcards) if self._whole else load_study(self.file(wildcards), range(0))
        return batch(plan, int(wildcards.batch))

    def keys(self, wildcards: Any) -> list[str]:
        """Keys of the members of a batch, which change with what they depend on."""
        only = self.members(wildcards)
        if self._whole:
            return [one.key for one in self._plan(wildcards).members[only.start : only.stop]]
        return [one.key for one in load_study(self.file(wildcards), only).members]

    def losses(self, wildcards: Any) -> int:
        """How many jobs have lost members of a batch to the machine: one more, and it is due."""
        return read_losses(Path(BATCH.format(study=wildcards.study, batch=wildcards.batch)))

    def definition(self, wildcards: Any) -> dict[str, Any]:
        """All that the dataset of a study depends on."""
        plan = self._plan(wildcards)
        text = " ".join(one.key for one in plan.members)
        return {
            "study": json.dumps(plan.study.model_dump(mode="json")),
            "base": json.dumps(plan.base),
            "members": hashlib.sha256(text.encode()).hexdigest(),
        }

    def _plan(self, wildcards: Any) -> Plan:
        """The study with all its members, each checked."""
        if wildcards.study not in self._plans:
            self._plans[wildcards.study] = load_study(self.file(wildcards))
        return self._plans[wildcards.study]


def dataset_of(path: str) -> str:
    """The dataset of a study file that has the name of its study."""
    return DATASET.format(study=Path(path).stem)


def timed_batches(path: str) -> list[str]:
    """The jobs of a study file, by the names under which they are timed."""
    number = len(batches(load_study(path, range(0))))
    return [TIMED.format(study=Path(path).stem, batch=k) for k in range(number)]


def more_memory(wildcards: Any, attempt: int) -> int:
    """Memory of a job [MB]: more with each attempt, for it may be what the last one lacked."""
    return 2000 * attempt


def is_last_attempt(wildcards: Any, attempt: int) -> int:
    """Whether a batch that fails now is not tried again in this call."""
    return int(attempt > RETRIES)


def given_studies(config_files: Iterable[str | Path]) -> dict[str, Path]:
    """Those of the config files of a call that are studies, by their names, each checked.

    Raises
    ------
    SceneError
        Where one breaks a rule, or has the name of another.
    """
    found: dict[str, Path] = {}
    for path in map(Path, config_files):
        if not _is_study(path):
            continue
        name = load_study(path, range(0)).study.name
        if name in found:
            raise SceneError([Problem(f"is the name of {found[name]} too", "name", str(path))])
        found[name] = path
    return found


def _is_study(path: Path) -> bool:
    """Whether a config file is a study rather than a part of the workflow's configuration.

    Raises
    ------
    SceneError
        Where its values are taken for code.
    """
    try:
        data = read_document(path).data
    except SceneError as error:
        if any(problem.key == RUNS_CODE for problem in error.problems):
            raise
        return False
    return isinstance(data, dict) and not data.keys().isdisjoint(Study.model_fields)
