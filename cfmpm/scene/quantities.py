"""Numbers, points, names and flags as the fields of a scene and a study take them; lengths in mm.

A field takes the kind it is of alone: true or false, a whole number written as one, text. A number
may be text besides, as 210e3 is to a reader of YAML 1.1. Models have these types in place of bool,
int, float and str, which pydantic converts to each other.
"""

from __future__ import annotations

import math
import unicodedata
from numbers import Integral, Real
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, Strict

# Larger numbers are typing errors, and their squares overflow. A body is at most a thousand
# kilometres long.
LARGEST = 1e30
LARGEST_LENGTH = 1e9


def _number(value: Any) -> float:
    """Refuse booleans and non-finite numbers, which pydantic would take for floats."""
    if isinstance(value, bool):
        raise ValueError("must be a number, not true or false")
    if not isinstance(value, str | Real):
        raise ValueError("must be a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    except ValueError:
        raise ValueError("must be a number") from None
    if not math.isfinite(number):
        raise ValueError("must be a finite number")
    if abs(number) > LARGEST:
        raise ValueError(f"must be at most {LARGEST:g} in size")
    return number + 0.0  # -0.0 becomes 0.0: equal scenes have equal hashes


def _pair(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("must be two numbers in brackets, such as [0, 10]")
    return value


def _group(value: str) -> str:
    """Take a name as gmsh does, but for how its accents are made up."""
    if any(unicodedata.category(letter).startswith("C") for letter in value):
        raise ValueError("must be one line of text without control characters")
    return unicodedata.normalize("NFC", value)


def is_whole(value: Any) -> bool:
    """Whether a value is a whole number as it is written: neither true nor 5.0 nor text."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def _count(value: Any) -> int:
    if not is_whole(value):
        raise ValueError("must be a whole number without point, exponent or quotes")
    _number(value)  # the limit of its size
    return int(value)


def _count_beside_list(value: Any) -> int:
    if not is_whole(value):
        raise ValueError("must be a whole number, which counts, or a list of numbers in brackets")
    return _count(value)


Number = Annotated[float, BeforeValidator(_number)]
Positive = Annotated[Number, Field(gt=0)]
Length = Annotated[Number, Field(gt=0, le=LARGEST_LENGTH)]
Coordinate = Annotated[Number, Field(ge=-LARGEST_LENGTH, le=LARGEST_LENGTH)]
Vector = Annotated[tuple[Number, Number], BeforeValidator(_pair)]
Point = Annotated[tuple[Coordinate, Coordinate], BeforeValidator(_pair)]
Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict()]
Name = Annotated[Text, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$", max_length=64)]
# The name of a physical group of a mesh file: gmsh takes any text.
GroupName = Annotated[Text, Field(min_length=1, max_length=127), AfterValidator(_group)]
Count = Annotated[int, BeforeValidator(_count)]
CountBesideList = Annotated[int, BeforeValidator(_count_beside_list)]
