"""The nine steps of the method (paper section 4.2)."""

from __future__ import annotations

from collections.abc import Callable

from cfmpm import steps
from cfmpm.clock import Clock
from cfmpm.ending import RunEnded
from cfmpm.output.checkpoint import Start
from cfmpm.output.record import Record
from cfmpm.scene import Scene
from cfmpm.state import Result, State
from cfmpm.threads import one_blas_thread


@one_blas_thread()
def run(
    scene: Scene,
    announce: Callable[[str], None] = lambda phase: None,
    observe: Callable[[State, Record], None] = lambda state, record: None,
    start: Start | None = None,
) -> Result:
    """Take the nine steps until the run ends; parameters and errors are those of `api.run`.

    Notes
    -----
    Small strain and linear elasticity need one solve for all load steps: Newton's loop (5) ends
    after one iteration, positions do not change (6), and the grid is not reset (9). Step 9 keeps
    the grid and step 8 the points, so that their order does not matter; segments are aligned on a
    grid at rest.
    """
    clock = Clock(announce)
    with clock("grid"):
        start = start or _beginning(scene)  # step 1
    at, record, state = start.stage, start.record, None
    try:
        while True:
            at = steps.locate(at, clock)  # step 2
            balance = steps.solve(at, state, clock)  # steps 3 to 6
            state = steps.evaluate(at, balance, clock)  # step 7
            record.add(state, clock.lap())
            observe(state, record)
            steps.check_end(at, balance, state)
            at = steps.reset(at, balance, clock)  # step 9
            if state.decision.running:
                at = steps.release(at, state, clock)  # step 8
            else:
                at = steps.advance(at, state)
    except RunEnded as end:
        assert state is not None
        return Result(**vars(state), history=record.close(end, clock.lap()))


def _beginning(scene: Scene) -> Start:
    stage = steps.begin(scene)
    return Start(stage, Record.of(scene, stage))
