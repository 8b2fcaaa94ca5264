"""Provenance of a dataset: global attributes by CF and ACDD."""

from __future__ import annotations

import json
import os
import time
from datetime import UTC, datetime
from typing import Any

from cfmpm.scene import config_hash, effective_config
from cfmpm.scene.model import Scene
from cfmpm.versions import versions


def provenance(scene: Scene) -> dict[str, Any]:
    """Return global attributes by CF and ACDD, with the data needed to run the scene again."""
    import numba  # already loaded after a solve, and not needed before

    return {
        **origin(scene.name, scene.description or f"Crack tips of scene {scene.name}", "run"),
        "comment": "lists are JSON text; no number depends on the number of threads",
        "threads": numba.get_num_threads(),
        "config": json.dumps(effective_config(scene), sort_keys=True),
        "config_hash": config_hash(scene),
    }


def origin(title: str, summary: str, command: str) -> dict[str, Any]:
    """Return global attributes by CF and ACDD that are common to all datasets.

    Parameters
    ----------
    title, summary : str
    command : str
        The ``cfmpm`` command that makes the dataset.
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    now = datetime.fromtimestamp(float(epoch) if epoch else time.time(), UTC)
    stamp = now.strftime("%Y-%m-%dT%H:%M:%SZ")
    return {
        "Conventions": "CF-1.11, ACDD-1.3",
        "title": title,
        "summary": summary,
        "source": f"cfmpm {versions()['cfmpm']}",
        "references": "Zhou et al., Theor. Appl. Fract. Mech. 117 (2022) 103186",
        "keywords": "fracture mechanics, material point method, configurational force",
        "history": f"{stamp} cfmpm {command}",
        "date_created": stamp,
        "versions": json.dumps(versions()),
    }
