"""The workflow's configuration as typed models; nothing runs on a bad one.

Each subject owns the model of its block. Snakemake reads the files by YAML 1.1, in which 1e-9 is
text: use the validated models only.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cfmpm.scene import load_scene
from cfmpm.study.model import Study
from cfmpm.study.reading import load_study
from workflows.configuration.block import Block
from workflows.configuration.scene_with_grid import scene_with
from workflows.growth.settings import Growth
from workflows.large_strain.settings import LargeStrain
from workflows.performance.settings import (
    NewtonCost,
    Scaling,
    StudyOverhead,
    WorkPrecision,
    each_value,
)
from workflows.section_5_1.settings import Section51
from workflows.stability.settings import Stability


class Settings(Block):
    """All blocks of configs/workflow."""

    section_5_1: Section51
    growth: Growth
    large_strain: LargeStrain
    work_precision: WorkPrecision
    scaling: Scaling
    newton_cost: NewtonCost
    study_overhead: StudyOverhead
    stability: Stability


def read_settings(config: Mapping[str, Any]) -> Settings:
    """Check the configuration and every scene that it stands for.

    Parameters
    ----------
    config : mapping
        As Snakemake has merged it.

    Raises
    ------
    pydantic.ValidationError
        Where a block does not fit its model.
    SceneError
        Where a grid does not fit the scene.
    """
    # A study given as --configfile has found its way into it, and has been checked by itself.
    blocks = {key: value for key, value in config.items() if key not in Study.model_fields}
    settings = Settings.model_validate(blocks)
    growing = settings.growth.studies().values()
    studies = [path for one in growing for path in (one.study, one.scatter)]
    for path in (settings.section_5_1.study, *studies, settings.large_strain.study):
        load_study(path)
    for group in settings.stability.groups.values():
        for case in group.cases.values():
            if case.grid is None and case.ends != "refused":
                load_scene(settings.stability.scene, {**group.replaced, **case.replaced})
    for listed in settings.scaling.series.values():
        for mesh in listed:
            scene_with(settings.scaling.scene, mesh)
    work = settings.work_precision
    for problem in (*work.stationary.values(), *work.paths.values()):
        for axes in problem.all_axes():
            # All combinations would take seconds: the job reads them, before it runs any.
            for replaced in each_value(axes):
                load_scene(problem.scene, replaced)
    return settings
