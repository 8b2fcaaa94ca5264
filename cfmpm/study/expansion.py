"""From the parameters of a study to the values of its members."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cfmpm.errors import did_you_mean
from cfmpm.scene.document import parse_key
from cfmpm.study.model import MOST_MEMBERS, LatinHypercube, Parameter, Study, Uncertain

SAMPLE = "sample"

Finding = tuple[str, str]  # dotted key of the study, and reason


@dataclass(frozen=True)
class Axis:
    """A dimension of a study.

    Attributes
    ----------
    name : str
        Of the parameter, or ``sample``.
    values : mapping of str to list
        Of each parameter along it, all of one length.
    """

    name: str
    values: Mapping[str, list[Any]]

    def __len__(self) -> int:
        return len(next(iter(self.values.values())))


def axes(study: Study) -> tuple[Axis, ...]:
    """The dimensions of a study that breaks no rule, in the order of its file."""
    found = [Axis(name, {name: values(one)}) for name, one in study.product.items()]
    if study.zip:
        found.append(Axis(SAMPLE, {name: values(one) for name, one in study.zip.items()}))
    if study.latin_hypercube is not None:
        found.append(Axis(SAMPLE, draws(study.latin_hypercube)))
    return tuple(found)


def count(axes: tuple[Axis, ...]) -> int:
    """How many members there are."""
    return math.prod(len(axis) for axis in axes)


def places(
    axes: tuple[Axis, ...], only: range | None = None
) -> Iterator[tuple[tuple[int, ...], dict[str, Any]]]:
    """Index and values of each member, or of some by their numbers; the last axis runs fastest."""
    sizes = [len(axis) for axis in axes]
    for number in range(count(axes)) if only is None else only:
        index = tuple(int(i) for i in np.unravel_index(number, sizes))
        yield (
            index,
            {
                name: along[i]
                for axis, i in zip(axes, index, strict=True)
                for name, along in axis.values.items()
            },
        )


def values(parameter: Parameter) -> list[Any]:
    """The values that a parameter takes, plain numbers and text."""
    if parameter.values is not None:
        return list(parameter.values)
    if parameter.linspace is not None:
        return [float(value) for value in np.linspace(*parameter.linspace)]
    assert parameter.geomspace is not None
    return [float(value) for value in np.geomspace(*parameter.geomspace)]


def draws(cube: LatinHypercube) -> dict[str, list[float]]:
    """Draw the uncertain parameters: in each of them one draw from each of equal probabilities.

    McKay, Beckman and Conover, Technometrics 21 (1979) 239, by `scipy.stats.qmc`.
    """
    from scipy.stats import qmc

    sampler = qmc.LatinHypercube(d=len(cube.parameters), rng=np.random.default_rng(cube.seed))
    probability = sampler.random(cube.samples)
    return {
        name: [float(value) for value in _distribution(one).ppf(along)]
        for (name, one), along in zip(cube.parameters.items(), probability.T, strict=True)
    }


def broken_rules(study: Study, reserved: set[str]) -> Iterator[Finding]:
    """Every rule that a valid study model breaks.

    Parameters
    ----------
    study : Study
    reserved : set of str
        Names that the dataset has for other things.
    """
    names: set[str] = set()
    keys: dict[tuple[str | int, ...], str] = {}
    for section, name, parameter in study.parameters():
        place = f"{section}.{name}"
        if name in names:
            yield place, "is the name of another parameter too"
        if name in reserved:
            yield place, f"{name} is a name in the dataset of every study; take another"
        names.add(name)
        key = parse_key(parameter.key)
        for other, owner in keys.items():
            if key[: len(other)] == other or other[: len(key)] == key:
                yield f"{place}.key", f"{parameter.key} is what {owner} sets, or a part of it"
        keys[key] = name
    for name, one in study.product.items():
        listed = values(one)
        if any(value in listed[:i] for i, value in enumerate(listed)):
            yield f"product.{name}", "has a value twice"
    lengths = {name: len(values(one)) for name, one in study.zip.items()}
    if len(set(lengths.values())) > 1:
        said = ", ".join(f"{name} {length}" for name, length in lengths.items())
        yield "zip", f"goes side by side, but the numbers of values differ: {said}"
    if study.latin_hypercube is not None:
        for name, uncertain in study.latin_hypercube.parameters.items():
            for key_, reason in _broken_distribution(uncertain):
                yield f"latin_hypercube.parameters.{name}.{key_}", reason
    members = math.prod(len(values(one)) for one in study.product.values())
    cube = study.latin_hypercube
    members *= max([cube.samples if cube else 1, *lengths.values()])
    if members > MOST_MEMBERS:
        yield "", f"would have {members} members; the limit is {MOST_MEMBERS}"


def _broken_distribution(uncertain: Uncertain) -> Iterator[Finding]:
    from scipy import stats

    found = getattr(stats, uncertain.distribution, None)
    if not isinstance(found, stats.rv_continuous):
        known = [n for n in dir(stats) if isinstance(getattr(stats, n), stats.rv_continuous)]
        close = did_you_mean(uncertain.distribution, known).partition("; known")[0].rstrip(";")
        yield (
            "distribution",
            f"unknown distribution {uncertain.distribution}{close}; known are the continuous ones "
            "of scipy.stats",
        )
        return
    shapes = found.shapes.split(", ") if found.shapes else []
    allowed = [*shapes, "loc", "scale"]
    wrong = False
    for name in uncertain.arguments:
        if name not in allowed:
            wrong = True
            yield f"arguments.{name}", "unknown argument" + did_you_mean(name, allowed)
    for name in shapes:
        if name not in uncertain.arguments:
            wrong = True
            yield "arguments", f"{name} is missing: {uncertain.distribution} has no default for it"
    if not wrong and not np.isfinite(_distribution(uncertain).ppf([0.1, 0.5, 0.9])).all():
        yield "arguments", f"no distribution {uncertain.distribution} has these: scale must be > 0"


def _distribution(uncertain: Uncertain) -> Any:
    from scipy import stats

    return getattr(stats, uncertain.distribution)(**uncertain.arguments)
