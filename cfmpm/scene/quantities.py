"""Types of the numbers, points, names and flags in a scene and in a study; lengths in mm.

Each type accepts values of its own kind only: true or false, integers, text. A number may also be
text, since YAML 1.1 reads 210e3 as text. Models use these types in place of bool, int, float and
str, between which pydantic converts.
"""

from __future__ import annotations

import math
import unicodedata
from numbers import Integral, Real
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, Strict

# Larger numbers are typing errors, and their powers can overflow. A length is at most 1000 km.
LARGEST = 1e30
LARGEST_LENGTH = 1e9


def _number(value: Any) -> float:
    """Refuse booleans and non-finite numbers, which pydantic accepts as floats."""
    if isinstance(value, bool):
        raise ValueError("must be a number, not true or false")
    if not isinstance(value, float | int | str | Real):  # Real last: it is slow to ask for
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
        raise ValueError(f"must have a magnitude of at most {LARGEST:g}")
    return number + 0.0  # -0.0 becomes 0.0: equal scenes have equal hashes


def _pair(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("must be two numbers in brackets, such as [0, 10]")
    return value


def _group(value: str) -> str:
    """Accept any name that gmsh accepts, in Unicode normal form C.

    Accented letters can be written with one or two code points; equal names must compare equal.
    """
    if any(unicodedata.category(letter).startswith("C") for letter in value):
        raise ValueError("must be one line of text without control characters")
    return unicodedata.normalize("NFC", value)


def is_whole(value: Any) -> bool:
    """Whether a value is an integer; True, 5.0 and text are not."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def _count(value: Any) -> int:
    if not is_whole(value):
        raise ValueError("must be a whole number without point, exponent or quotes")
    _number(value)  # the limit of its size
    return int(value)


def _count_beside_list(value: Any) -> int:
    if not is_whole(value):
        raise ValueError("must be a whole number (a count) or a list of numbers in brackets")
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
# Name of a physical group of a mesh file: gmsh accepts any text.
GroupName = Annotated[Text, Field(min_length=1, max_length=127), AfterValidator(_group)]
Count = Annotated[int, BeforeValidator(_count)]
CountBesideList = Annotated[int, BeforeValidator(_count_beside_list)]
