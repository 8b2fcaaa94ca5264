"""Expansion of the parameters of a study to the values of its members."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from cfmpm.errors import did_you_mean
from cfmpm.scene.base import takes_list_or_count
from cfmpm.scene.document import parse_key
from cfmpm.scene.model import Scene
from cfmpm.study.model import MOST_MEMBERS, LatinHypercube, Parameter, Study, Uncertain

SAMPLE = "sample"

Finding = tuple[str, str]  # dotted key of the study, and reason


@dataclass(frozen=True)
class Axis:
    """A dimension of a study.

    Attributes
    ----------
    name : str
        Name of the parameter, or ``sample``.
    values : mapping of str to list
        Values of each parameter along it, all of the same length.
    labels : mapping of str to list
        Labels of the values: the value itself, or its name.
    """

    name: str
    values: Mapping[str, list[Any]]
    labels: Mapping[str, list[Any]]

    @classmethod
    def of(cls, name: str, parameters: Mapping[str, Parameter]) -> Self:
        """The axis along which parameters change together."""
        return cls(
            name,
            {key: values(one) for key, one in parameters.items()},
            {key: labels(one) for key, one in parameters.items()},
        )

    def __len__(self) -> int:
        return len(next(iter(self.values.values())))


def axes(study: Study) -> tuple[Axis, ...]:
    """The dimensions of a valid study, in the order of its file."""
    found = [Axis.of(name, {name: one}) for name, one in study.product.items()]
    if study.zip:
        found.append(Axis.of(SAMPLE, study.zip))
    if study.latin_hypercube is not None:
        drawn = draws(study.latin_hypercube)
        found.append(Axis(SAMPLE, drawn, drawn))
    return tuple(found)


def count(axes: tuple[Axis, ...]) -> int:
    """Number of members."""
    return math.prod(len(axis) for axis in axes)


def places(axes: tuple[Axis, ...], only: range | None = None) -> Iterator[tuple[int, ...]]:
    """Indices of members along the axes, of all or by number; the last axis varies fastest."""
    sizes = [len(axis) for axis in axes]
    for number in range(count(axes)) if only is None else only:
        yield tuple(int(i) for i in np.unravel_index(number, sizes))


def size(parameter: Parameter) -> int:
    """Number of values of a parameter."""
    listed = parameter.values if parameter.variants is None else parameter.variants
    if listed is not None:
        return len(listed)
    spaced = parameter.linspace or parameter.geomspace
    assert spaced is not None
    return spaced[2]


def values(parameter: Parameter) -> list[Any]:
    """The values of a parameter as plain data; for variants the values that each replaces."""
    if parameter.variants is not None:
        return list(parameter.variants.values())
    if isinstance(parameter.values, Mapping):
        return list(parameter.values.values())
    if parameter.values is not None:
        return list(parameter.values)
    if parameter.linspace is not None:
        return [float(value) for value in np.linspace(*parameter.linspace)]
    assert parameter.geomspace is not None
    return [float(value) for value in np.geomspace(*parameter.geomspace)]


def labels(parameter: Parameter) -> list[Any]:
    """Labels of the values of a parameter: numbers and text themselves, other values as JSON."""
    if parameter.variants is not None:
        return list(parameter.variants)
    if isinstance(parameter.values, Mapping):
        return list(parameter.values)
    listed = values(parameter)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in listed):
        return listed
    return [value if isinstance(value, str) else json.dumps(value) for value in listed]


def labelled(parameter: Parameter | Uncertain, label: Any) -> Any:
    """The value of a parameter for a label; a number is its own label."""
    if isinstance(parameter, Uncertain) or not isinstance(label, str):
        return label
    return values(parameter)[labels(parameter).index(label)]


def draws(cube: LatinHypercube) -> dict[str, list[float]]:
    """Sample the uncertain parameters, with one draw from each of intervals of equal probability.

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
    """Violations of rules by a study that agrees with its model.

    Parameters
    ----------
    study : Study
    reserved : set of str
        Names with another meaning in the dataset.
    """
    members = math.prod(size(one) for one in study.product.values())
    lengths = {name: size(one) for name, one in study.zip.items()}
    cube = study.latin_hypercube
    members *= max([cube.samples if cube else 1, *lengths.values()])
    if members > MOST_MEMBERS:
        yield "", f"would have {members} members; the limit is {MOST_MEMBERS}"
        return
    names: set[str] = set()
    keys: dict[tuple[str | int, ...], str] = {}
    for section, name, parameter in study.parameters():
        place = f"{section}.{name}"
        if name in names:
            yield place, "is the name of another parameter too"
        if name in reserved:
            yield place, f"{name} is a name in the dataset of every study; take another"
        names.add(name)
        variants = isinstance(parameter, Parameter) and parameter.variants is not None
        at = f"{place}.variants" if variants else f"{place}.key"
        own = {parse_key(key): key for key in parameter.sets()}
        for key, text in own.items():
            for other, owner in keys.items():
                if key[: len(other)] == other or other[: len(key)] == key:
                    yield at, f"{text} is what {owner} sets, or a part of it"
            for replaced in study.replace:
                # A variant may replace a value of `replace`.
                if not variants and parse_key(replaced)[: len(key)] == key:
                    yield at, f"sets {text}, and {replaced} of replace is lost"
        keys |= dict.fromkeys(own, name)
        if isinstance(parameter, Parameter):
            yield from ((place, reason) for reason in _broken_values(parameter))
        if isinstance(parameter, Uncertain) or (parameter.key and parameter.values is None):
            yield from ((f"{place}.key", reason) for reason in _ambiguous(str(parameter.key)))
    for name, one in study.product.items():
        if one.variants is None and len({_hashable(value) for value in values(one)}) < size(one):
            yield f"product.{name}", "has a value twice"
    if len(set(lengths.values())) > 1:
        said = ", ".join(f"{name} {length}" for name, length in lengths.items())
        yield "zip", f"goes side by side, but the numbers of values differ: {said}"
    if study.latin_hypercube is not None:
        for name, uncertain in study.latin_hypercube.parameters.items():
            for key_, reason in _broken_distribution(uncertain):
                yield f"latin_hypercube.parameters.{name}.{key_}", reason


def _broken_values(parameter: Parameter) -> Iterator[str]:
    """Numbers in quotes, which would convert the other numbers to text."""
    for value in values(parameter) if parameter.values is not None else ():
        if isinstance(value, str) and _is_number(value):
            yield f"{value!r} is text: write the number without quotes"


def _ambiguous(key: str) -> Iterator[str]:
    """Check that the numbers of a range or of a distribution cannot be both counts and lengths."""
    if takes_list_or_count(parse_key(key), Scene):
        yield (
            f"{key} is a count or a list: for counts write them as values, such as [1, 2, 4]; for "
            f"numbers of the list take {key}[0]"
        )


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _hashable(value: Any) -> Any:
    """A key that is equal for equal values only."""
    return json.dumps(value, sort_keys=True) if isinstance(value, list | Mapping) else value


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
    if wrong or np.isfinite(_distribution(uncertain).ppf([0.1, 0.5, 0.9])).all():
        return
    if uncertain.arguments.get("scale", 1.0) <= 0.0:
        yield "arguments.scale", "must be greater than 0"
    else:
        given = ", ".join(f"{name}: {value:g}" for name, value in uncertain.arguments.items())
        place = f"arguments.{shapes[0]}" if len(shapes) == 1 else "arguments"
        yield place, f"no distribution {uncertain.distribution} has {given}"


def _distribution(uncertain: Uncertain) -> Any:
    from scipy import stats

    return getattr(stats, uncertain.distribution)(**uncertain.arguments)
