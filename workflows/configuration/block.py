"""What all blocks of the workflow's configuration share."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import BaseModel, ConfigDict


class Block(BaseModel):
    """A frozen model that refuses unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def require(where: str, needed: Iterable[Any], there: Iterable[Any]) -> None:
    """Refuse what lacks something that figures and claims show.

    Raises
    ------
    ValueError
        With `where` and what is missing.
    """
    missing = sorted(set(needed) - set(there))
    if missing:
        raise ValueError(f"{where}: figures and claims need {', '.join(map(str, missing))}")
