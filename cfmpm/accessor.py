"""User interface of histories: `open_history`, and the accessor ``ds.cfmpm``.

Importing this module registers the accessor. `open_history` and :func:`cfmpm.run` import it.
``import cfmpm`` alone does not, since importing xarray takes a hundred times as long; a dataset
opened by xarray needs ``import cfmpm.accessor``.
"""

from __future__ import annotations

import json
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from cfmpm.errors import Problem, SceneError
from cfmpm.output.analysis import energy_balance, tip_path
from cfmpm.output.reading import read_result

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from matplotlib.axes import Axes

    from cfmpm.body.grid import Grid
    from cfmpm.scene import Scene

_DIMENSIONS = {"step", "tip", "radius", "boundary", "phase"}


def open_history(path: str | Path) -> xr.Dataset:
    """Read the history of a run into memory.

    Parameters
    ----------
    path : str or Path
        The folder of the run, or its history.nc.

    Returns
    -------
    xarray.Dataset
        With the accessor `History` as ``cfmpm``.

    Raises
    ------
    SceneError
        If there is no history.
    """
    path = Path(path)
    return read_result(path / "history.nc" if path.is_dir() else path, "domain_radius")


@xr.register_dataset_accessor("cfmpm")
class History:
    """Methods for the history of one run: ``ds.cfmpm``.

    Parameters
    ----------
    dataset : xarray.Dataset
        History of one run, or of one member of a study.

    Notes
    -----
    Methods raise ValueError if the dataset is not a history or has several runs. Those that need
    the scene also raise it if a member of a study lacks the coordinate of a parameter.
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset

    @cached_property
    def _history(self) -> xr.Dataset:
        """The dataset as that of one run, with the dimensions step and tip."""
        dataset = self._dataset
        if "tip_x" not in dataset:
            raise ValueError("not the history of a run: it has no variable tip_x")
        several = [str(name) for name in dataset["tip_x"].dims if name not in _DIMENSIONS]
        if several:
            raise ValueError(
                f"has several runs: select one along {', '.join(several)}, such as "
                f"ds.isel({several[0]}=0).cfmpm"
            )
        lost = [name for name in ("step", "tip") if name not in dataset["tip_x"].dims]
        return dataset.expand_dims(lost)

    @property
    def scene(self) -> Scene:
        """The scene of the run, from the configuration in the history.

        For a member of a study it is the base with the values of the member's parameters.

        Raises
        ------
        SceneError
            If the configuration is damaged.
        """
        from cfmpm.scene import scene_from_dict

        attributes = self._history.attrs
        of_study = "base" in attributes
        name = "base" if of_study else "config"
        place = str(self._history.encoding.get("source", "history"))
        try:
            config: dict[str, Any] = json.loads(attributes[name])
        except ValueError:
            raise SceneError([Problem(f"its attribute {name} is damaged", file=place)]) from None
        values = self._parameters() if of_study else {}
        folder = attributes.get("base_folder", ".")
        scene = scene_from_dict(config, f"{place}: {name}", values, folder)
        if of_study and scene.mesh_file is not None:
            path = scene.mesh_file.path
            if json.loads(attributes["mesh_files"]).get(path) != scene.mesh_file.sha256:
                raise SceneError([Problem("has changed since the study", file=path)])
        return scene

    def _parameters(self) -> dict[str, Any]:
        """The values of a member of a study that replace those of the base, by key."""
        from cfmpm.study.expansion import labelled
        from cfmpm.study.model import Study

        study = Study.model_validate(json.loads(self._history.attrs["study"]))
        values = dict(study.replace)
        for _, name, parameter in study.parameters():
            if name not in self._history.coords:
                raise ValueError(f"lacks the coordinate {name}, a parameter of the study")
            values |= parameter.replaced(labelled(parameter, self._history[name].item()))
        return values

    def path(self) -> dict[str, NDArray[np.float64]]:
        """Return the path of each tip.

        Returns
        -------
        dict of str to (k, 2) float
            Distinct positions of each tip [mm], from the start of the run; a single one for a tip
            that has not grown.
        """
        names = self._history["tip"].values
        return {str(name): tip_path(self._history, str(name)) for name in names}

    def plot_path(
        self,
        axes: Axes | None = None,
        reference: ArrayLike | Mapping[str, ArrayLike] | None = None,
    ) -> Axes:
        """Draw the paths of the tips over the body.

        Parameters
        ----------
        axes : Axes, optional
            Default: axes of a new figure.
        reference : (k, 2) float or mapping of str to (k, 2) float, optional
            Points of other paths for comparison [mm], by their name in the legend.

        Returns
        -------
        Axes
        """
        from cfmpm.plotting import draw_paths

        return self._drawn(draw_paths, axes, reference)

    def plot_cf(self, axes: Axes | None = None) -> Axes:
        """Draw the configurational force at each position of each tip.

        Parameters
        ----------
        axes : Axes, optional
            Default: axes of a new figure.

        Returns
        -------
        Axes
        """
        from cfmpm.plotting import draw_tip_cf

        return self._drawn(draw_tip_cf, axes)

    def energy_balance(self) -> xr.Dataset:
        """Return the energy balance; see `output.analysis.energy_balance`."""
        return energy_balance(self._history)

    def _drawn(self, draw: Callable[..., Axes], axes: Axes | None, *more: Any) -> Axes:
        """Draw over the body, by default in a new figure of suitable size, shown in notebooks."""
        body = self._body()
        if axes is not None:
            return draw(axes, self._history, body, *more)
        import matplotlib.pyplot as plt

        from cfmpm.plotting.paths import corners_of
        from cfmpm.plotting.style import LEGEND, RC, size_around

        with plt.rc_context(RC):
            size = size_around(corners_of(body), LEGEND)
            _, axes = plt.subplots(figsize=size, layout="constrained")
            return draw(axes, self._history, body, *more)

    def _body(self) -> Scene | Grid:
        """The scene with its geometry; for a mesh file its grid before growth."""
        scene = self.scene
        if scene.mesh_file is not None:
            from cfmpm.build import build

            return build(scene).grid
        from cfmpm.scene import expand

        return expand(scene)
