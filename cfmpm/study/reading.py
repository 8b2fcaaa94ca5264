"""Reading of a study file, and its members as checked scenes."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import re
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from cfmpm.errors import Problem, SceneError
from cfmpm.program import program_files
from cfmpm.scene import Scene
from cfmpm.scene.document import Document, Key, Place, parse_key, read_document
from cfmpm.scene.wording import refusals, shown
from cfmpm.study import expansion
from cfmpm.study.blocks import with_blocks
from cfmpm.study.expansion import SAMPLE, Axis
from cfmpm.study.layout import RESERVED
from cfmpm.study.measuring import Measure, find_measure
from cfmpm.study.member import Job
from cfmpm.study.model import Study
from cfmpm.study.scenes import MemberScenes
from cfmpm.versions import DECIDING, versions

# Largest number of reported problems of members; those that differ only in numbers count as one.
MOST_TOLD = 10
# After so many the rest is not checked: of a hundred thousand members that takes minutes.
MOST_REFUSED = 1000
# Time of checking that is announced, and after how long it is [s].
LONG, SOON = 10.0, 2.0
NUMBER = re.compile(r"-?\d[\d.]*(e[+-]?\d+)?")


log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Member:
    """One scene of a study.

    Attributes
    ----------
    index : tuple of int
        Its index along each axis.
    values : mapping of str to value
        Value of each parameter, or the name of the value.
    scene : Scene
    key : str
        Key of its outcome: equal for equal scenes solved and measured by the same program.
    repeats, measure
        As in `Job`.
    """

    index: tuple[int, ...]
    values: Mapping[str, Any]
    scene: Scene
    key: str
    repeats: int = 1
    measure: Measure | None = None

    def job(self) -> Job:
        """Its task."""
        return Job(self.key, self.scene, self.repeats, self.measure)


@dataclass(frozen=True)
class Plan:
    """A study with its checked members.

    Attributes
    ----------
    study : Study
        As given by the user.
    base : mapping
        The scene file of the study, as plain data.
    folder : str
        Absolute folder of relative paths in it.
    axes : tuple of Axis
    members : tuple of Member
        All members or the requested ones; the last axis varies fastest.
    """

    study: Study
    base: Mapping[str, Any]
    folder: str
    axes: tuple[Axis, ...]
    members: tuple[Member, ...]


def load_study(path: str | os.PathLike[str], only: range | None = None) -> Plan:
    """Read a study file and check the scene of every member.

    Parameters
    ----------
    path
        A YAML file.
    only
        Numbers of the requested members, from 0; only these are checked. Default: all.

    Raises
    ------
    SceneError
        With the problems of the study, else of its members, by file, line, member and key.
    """
    path = Path(path)
    return _plan(read_document(path), path.parent, only)


def study_from_dict(data: Mapping[str, Any], folder: str | os.PathLike[str] = ".") -> Plan:
    """Check a study given as nested dictionaries and lists.

    Parameters
    ----------
    data
        Content of a study file.
    folder
        Folder of relative paths; default: the working directory.

    Raises
    ------
    SceneError
        With the problems found, each with its key.
    """
    return _plan(Document(data, Place("<dict>")), Path(folder), None)


def _plan(document: Document, folder: Path, only: range | None) -> Plan:
    document = with_blocks(document, folder)
    study = _study(document)
    base, start = _base(document, study, folder)
    measure = None
    if study.measure is not None:
        try:
            measure = find_measure(study.measure, folder)
        except SceneError as error:
            raise document.error((("measure",), p.reason) for p in error.problems) from None
    axes = expansion.axes(study)
    members = _members(study, document, base, start, axes, only)
    members = tuple(_measured(one, study.repeats, measure) for one in members)
    return Plan(study, base.data, os.path.abspath(start), axes, members)


def _measured(member: Member, repeats: int, measure: Measure | None) -> Member:
    """The member with the measure of its study, and its own key."""
    if repeats == 1 and measure is None:
        return member
    told = "" if measure is None else f"{measure.function} {measure.source}"
    key = hashlib.sha256(f"{member.key} {repeats} {told}".encode()).hexdigest()[:32]
    return replace(member, key=key, repeats=repeats, measure=measure)


def _study(document: Document) -> Study:
    data = document.data
    if not isinstance(data, Mapping):
        reason = f"must be a mapping with keys such as name and base; got {shown(data)}"
        raise document.error([((), reason)])
    if "base" not in data and "material" in data:
        raise document.error([((), "this is a scene: cfmpm run runs it")])
    try:
        study = Study.model_validate(data)
    except ValidationError as error:
        raise document.error(refusals(error, data, Study).items()) from None
    found = [
        (parse_key(key) if key else (), reason)
        for key, reason in expansion.broken_rules(study, RESERVED)
    ]
    if found:
        raise document.error(found)
    return study


def _base(document: Document, study: Study, folder: Path) -> tuple[Document, Path]:
    """The base scene of a study, and the folder of its relative paths."""
    if not isinstance(study.base, str):
        inside = {key[1:]: place for key, place in document.places.items() if key[0] == "base"}
        return Document(study.base, document.place("base"), inside), folder
    file = folder / study.base
    try:
        return read_document(file), file.parent
    except SceneError as error:
        raise document.error((("base",), str(p)) for p in error.problems) from None


def _members(
    study: Study,
    document: Document,
    base: Document,
    folder: Path,
    axes: tuple[Axis, ...],
    only: range | None,
) -> tuple[Member, ...]:
    written, varied = _written(study, document)
    scenes = MemberScenes(study, base, folder, axes, written)
    members: list[Member] = []
    first: dict[Problem, tuple[Problem, str]] = {}  # by the problem without its numbers
    many: Counter[Problem] = Counter()
    bad = 0
    total = expansion.count(axes) if only is None else len(only)
    for index in _announced(expansion.places(axes, only), total):
        try:
            scene, config_hash = scenes.scene(index)
        except SceneError as error:
            bad += 1
            kinds = {replace(p, reason=NUMBER.sub("#", p.reason)): p for p in error.problems}
            for kind, problem in kinds.items():
                if kind in first or len(first) < MOST_TOLD:
                    first.setdefault(kind, (problem, label(axes, index)))
                    many[kind] += 1
            if bad == MOST_REFUSED:
                break
        else:
            called = {
                name: labels[i]
                for axis, i in zip(axes, index, strict=True)
                for name, labels in axis.labels.items()
            }
            members.append(Member(index, called, scene, _key(config_hash)))
    if bad:
        problems = []
        for kind, (problem, member) in first.items():
            n = many[kind]
            named = f"member {member}" if n == 1 else f"in {n} members, such as {member}"
            problems.append(_placed(problem, named, document, varied))
        if bad > 1 or len(first) == MOST_TOLD:
            of = "the first " if bad == MOST_REFUSED else ""
            reason = f"{bad} of {of}{len(members) + bad} members are refused; nothing was run"
            problems.append(Problem(reason, file=document.root.file))
        raise SceneError(problems)
    return tuple(members)


def _announced(places: Iterator[tuple[int, ...]], total: int) -> Iterator[tuple[int, ...]]:
    """Pass the indices of members on, and log how long checking takes if that is long."""
    begin, told = time.process_time(), False
    for number, index in enumerate(places, 1):
        yield index
        passed = time.process_time() - begin
        if passed > SOON and not told:
            told = True
            expected = passed / number * total
            if expected > LONG:
                log.info("checking all %d members first takes about %.0f s", total, expected)


def _written(study: Study, document: Document) -> tuple[dict[str, Place], dict[Key, Place]]:
    """Places in the study file that set a key: all of them, and those of parameters only."""
    written = {key: document.place("replace", key) for key in study.replace}
    varied: dict[Key, Place] = {}
    for section, name, parameter in study.parameters():
        at = document.place(*parse_key(section), name)
        written |= dict.fromkeys(parameter.sets(), at)
        varied |= dict.fromkeys(map(parse_key, parameter.sets()), at)
    return written, varied


def label(axes: tuple[Axis, ...], index: tuple[int, ...]) -> str:
    """Label of a member: its parameters, and the number of its sample."""
    texts = []
    for axis, i in zip(axes, index, strict=True):
        inner = ", ".join(f"{name}={_short(labels[i])}" for name, labels in axis.labels.items())
        texts.append(f"{SAMPLE}={i} ({inner})" if axis.name == SAMPLE else inner)
    return ", ".join(texts)


def _short(value: Any) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.6g}" if isinstance(value, float) else shown(value)


def _placed(
    problem: Problem, called: str, document: Document, varied: Mapping[Key, Place]
) -> Problem:
    """A problem of members, placed in the study file at the parameter that sets a part of its key.

    A problem of the base also keeps its place there.
    """
    file = document.root.file
    key = parse_key(problem.key) if problem.key else ()
    at = next((place for of, place in varied.items() if key and of[: len(key)] == key), None)
    if problem.file == file:
        at = at or Place(file, problem.line, problem.column)
        key_ = f"{called}: {problem.key}" if problem.key else called
        return Problem(problem.reason, key_, file, at.line, at.column)
    at = at or document.place("base")
    return Problem(str(problem), called, file, at.line, at.column)


def _key(config_hash: str) -> str:
    text = f"{config_hash} {program_hash()}"
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@cache
def program_hash() -> str:
    """SHA-256 of everything that affects results: sources of this package, versions of others."""
    installed = {name: versions().get(name) for name in ("cfmpm", *DECIDING)}
    digest = hashlib.sha256(json.dumps(installed).encode())
    root = Path(__file__).parents[1]
    # The modules that run and measure a member determine what is stored of a run.
    stored = (Path(__file__).with_name(name) for name in ("member.py", "measuring.py"))
    for path in (*program_files(), *stored):
        digest.update(str(path.relative_to(root)).encode() + path.read_bytes())
    return digest.hexdigest()
