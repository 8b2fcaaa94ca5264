"""Summary of a study before and after its run, as plain text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from cfmpm.study.member import Outcome
from cfmpm.study.reading import Plan, label

# Largest number of listed members that are not done; the dataset has them all.
MOST_TOLD = 5


def of_plan(plan: Plan) -> str:
    """List the members of a study, one on each line.

    Parameters
    ----------
    plan : Plan
    """
    lines = [f"{plan.study.name}: {_size(plan)}"]
    lines += [f"  {label(plan.axes, one.index)}" for one in plan.members]
    return "\n".join(lines)


def of_study(plan: Plan, outcomes: Mapping[str, Outcome], known: int, written: Path) -> str:
    """Summarize the outcomes of a study.

    Parameters
    ----------
    plan : Plan
    outcomes : mapping of str to Outcome
        By the keys of the members.
    known : int
        Number of different members with earlier outcomes.
    written : Path
        The dataset.
    """
    count = Counter(outcomes[one.key].status for one in plan.members)
    facts = [f"{count['done']} done"]
    facts += [f"{count[status]} {status}" for status in ("failed", "unstable") if count[status]]
    facts += [f"{known} of them known from before"] if known else []
    lines = [f"{plan.study.name}: {_size(plan)}; {', '.join(facts)}"]
    marked = [one for one in plan.members if outcomes[one.key].reason]
    for one in marked[:MOST_TOLD]:
        reason = outcomes[one.key].reason
        lines.append(f"  {label(plan.axes, one.index)}: {reason}")
    if len(marked) > MOST_TOLD:
        lines.append(f"  and {len(marked) - MOST_TOLD} more: see reason in the dataset")
    lines.append(f"written  {written}")
    return "\n".join(lines)


def _size(plan: Plan) -> str:
    count = len(plan.members)
    if len(plan.axes) == 1:
        return f"{count} members along {plan.axes[0].name}"
    return f"{count} members, " + " x ".join(f"{len(axis)} {axis.name}" for axis in plan.axes)
