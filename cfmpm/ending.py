"""The end of a run: status, text, and values that are known only at the end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # these words are also read where the kernels are not loaded
    from cfmpm.body.body import Grown
    from cfmpm.body.grid import Triangulation

# Status of a run, in the order of the flag values of `run_status`.
RUN_STATUS = (
    "unfinished",  # interrupted; it can be resumed
    "failed",  # a solve failed, and resuming does not help
    "solved",  # all load steps are solved; stationary cracks
    "arrived",  # no crack tip is left inside the body
    "stopped",  # no tip meets the criterion
    "arrested",  # no tip is above the threshold of fatigue
    "increments",  # the largest number of increments is reached
    "fractured",  # a tip reaches its toughness under fatigue
    "severed",  # a part of the body is severed, and no support holds it
    "met_point",  # a crack has reached the point of a load or a support
    "unstable",  # no stable state follows the last one
    "unsolvable",  # the stiffness matrix is singular, or the load of growth cannot be computed
)
# Those for which a command exits with status 1.
LOST = ("failed", "unstable", "unsolvable")


@dataclass(frozen=True)
class Ending:
    """The end of a run.

    Attributes
    ----------
    status : str
        One of `RUN_STATUS`.
    text : str
        The reason, for the user.
    values : mapping of str to float
        Values that are known only at the end, by the names of `output.variables`.
    """

    status: str
    text: str
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class LastCracks:
    """The cracks of a body that is no longer solved.

    Attributes
    ----------
    triangulation : Triangulation
        The grid with these cracks.
    grown : Grown
    """

    triangulation: Triangulation
    grown: Grown


class RunEnded(Exception):  # noqa: N818  (no error: every run ends by it)
    """Raised to end a run.

    Attributes
    ----------
    ending : Ending
    cracks : LastCracks or None
        The cracks after growth beyond the last state of equilibrium; None if they did not grow.
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
