"""Random changes of data and of files that make them odd or damage them."""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Iterator
from typing import Any

ODD: list[Any] = [
    *(
        None,
        True,
        "",
        "x",
        ".inf",
        "-.inf",
        ".nan",
        0,
        -1,
        1,
        2,
        -0.0,
        1e-300,
        1e300,
        1e31,
        10**400,
    ),
    *(
        [],
        [[]],
        {},
        [1],
        [0, 0],
        [1, 2, 3],
        {"at": [0, 0]},
        {"x": 1},
        "../../x",
        "/",
        "\0",
        "é",
        "a" * 300,
    ),
    *(1e-9, 1e9, 1e-5, 0.5, 3, 7.5, "steel", "T6", "finite", "crack", "auto", "all"),
]


def places(data: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every key of nested plain data."""
    if isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield (*at, key)
            yield from places(value, (*at, key))


def odd(rng: random.Random) -> Any:
    """A random value, which is rarely valid."""
    return copy.deepcopy(rng.choice(ODD))


def spoiled(data: Any, rng: random.Random) -> Any:
    """A copy of plain data with a few unexpected values, keys or lists."""
    data = copy.deepcopy(data)
    for _ in range(rng.choice([1, 1, 2, 3, 6])):
        there = list(places(data))
        if not there:
            return data
        *way, last = rng.choice(there)
        inside = data
        for key in way:
            inside = inside[key]
        kind = rng.randrange(7)
        if kind == 0 and isinstance(inside, dict):
            del inside[last]
        elif kind == 1 and isinstance(inside, dict):
            inside[rng.choice(["x", "name", "base", "__use_yte__", str(last) + "_"])] = rng.choice(
                ODD
            )
        elif kind == 2 and isinstance(inside, list):
            inside.extend(copy.deepcopy([inside[last]]) * rng.choice([1, 2, 50]))
        elif kind == 3 and isinstance(inside[last], float | int) and abs(inside[last]) < 1e99:
            inside[last] = inside[last] * rng.choice([-1, 0, 1e-6, 0.5, 2, 1e3, 1e9, 1 + 1e-7])
        elif kind == 4:
            other = rng.choice(there)
            value = data
            for key in other:
                if not isinstance(value, dict | list):
                    break
                try:
                    value = value[key]
                except LookupError:
                    break
            inside[last] = copy.deepcopy(value)
        else:
            inside[last] = odd(rng)
    return data


def as_yaml(data: Any, rng: random.Random) -> bytes:
    """The data as a YAML file, which sometimes is damaged too."""
    content = json.dumps(data).encode()
    if rng.random() < 0.1:
        return damaged(content, rng)
    return content


def damaged(content: bytes, rng: random.Random) -> bytes:
    """Bytes changed, removed or repeated."""
    kind, size = rng.randrange(6), len(content)
    if kind == 0:
        return content[: rng.randrange(size + 1)]
    some = bytearray(content)
    if kind == 1:
        begin = rng.randrange(size)
        del some[begin : begin + rng.choice([1, 8, 512, 4096])]
    elif kind == 2:
        begin = rng.randrange(size)
        some[begin:begin] = rng.randbytes(rng.choice([1, 8, 512]))
    elif kind == 3:
        begin = rng.randrange(size)
        n = min(rng.choice([8, 512, 4096]), size - begin)
        some[begin : begin + n] = bytes([rng.choice([0, 255])]) * n
    else:
        # The head of a file says what is where.
        reach = size if kind == 4 else min(size, 4096)
        for _ in range(rng.choice([1, 2, 8, 64])):
            some[rng.randrange(reach)] = rng.randrange(256)
    return bytes(some)
