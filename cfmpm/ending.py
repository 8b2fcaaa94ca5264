"""How a run ends: a word for programs, a text for people, and what it has found out by ending."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the words are read where no kernel is loaded
    from cfmpm.body.body import Grown
    from cfmpm.body.grid import Triangulation

# What became of a run, in the order of the flag values of `run_status`.
RUN_STATUS = (
    "unfinished",  # broken off: it can go on
    "failed",  # a solve failed, and nothing can be done about it by going on
    "solved",  # all load steps, of stationary cracks
    "arrived",  # no crack ends inside the body any more
    "stopped",  # no tip meets the criterion
    "arrested",  # no tip is above the threshold of fatigue
    "increments",  # as many as were allowed
    "fractured",  # a tip reaches its toughness under fatigue
    "severed",  # a part of the body is cut off and driven away
    "met_point",  # a crack ran into the point of a load or a support
    "unstable",  # no stable state goes on from the last one
    "unsolvable",  # the stiffness that holds the nodes is lost
)
# Of those, the ones that a command answers with a failure.
LOST = ("failed", "unstable", "unsolvable")


@dataclass(frozen=True)
class Ending:
    """How a run ended.

    Attributes
    ----------
    status : str
        One of `RUN_STATUS`.
    text : str
        Why, for people.
    values : mapping of str to float
        What is known by the end only, by the names of `output.variables`.
    """

    status: str
    text: str
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class LastCracks:
    """The cracks of a body that cannot be solved any more.

    Attributes
    ----------
    triangulation : Triangulation
        The grid with these cracks.
    grown : Grown
    """

    triangulation: Triangulation
    grown: Grown


class RunEnded(Exception):  # noqa: N818  (no error: every run ends by it)
    """A run goes no further.

    Attributes
    ----------
    ending : Ending
    cracks : LastCracks or None
        Where the cracks came to after the last state of balance; None where they stayed.
    """

    def __init__(
        self,
        status: str,
        text: str,
        *,
        values: Mapping[str, float] | None = None,
        cracks: LastCracks | None = None,
    ) -> None:
        self.ending = Ending(status, text, values or {})
        self.cracks = cracks
        super().__init__(text)
