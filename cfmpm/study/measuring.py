"""Further quantities of a member, by a function given in the study."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cfmpm.errors import Problem, SceneError
from cfmpm.input_file import MOST_TEXT, read_file
from cfmpm.study.layout import DIMENSIONS, RESERVED

if TYPE_CHECKING:
    import xarray as xr

    from cfmpm.state import Result

Quantity = tuple[tuple[str, ...], NDArray[Any], dict[str, Any]]  # dimensions, values, attributes


@dataclass(frozen=True)
class Measure:
    """A function from the result of a member to a dataset, as given in a study.

    Attributes
    ----------
    module : str
        A module that can be imported, or the absolute path of a Python file.
    function : str
    source : str
        Source text of its module, since a change of it may change the results.
    """

    module: str
    function: str
    source: str

    def __call__(self, result: Result) -> xr.Dataset:
        """Call the function, in the process of the member."""
        if self.module.endswith(".py"):
            spec = spec_from_file_location(Path(self.module).stem, self.module)
            assert spec is not None
            assert spec.loader is not None
            module = module_from_spec(spec)
            spec.loader.exec_module(module)
        else:
            module = importlib.import_module(self.module)
        found: xr.Dataset = getattr(module, self.function)(result)
        return found


def find_measure(place: str, folder: Path) -> Measure:
    """Find the function given in a study, without executing its module.

    Parameters
    ----------
    place : str
        ``file.py:function`` or ``package.module:function``.
    folder : Path
        Folder of a relative path.

    Raises
    ------
    SceneError
        If there is no such file, module or function.
    """
    where, _, function = place.rpartition(":")
    path = folder / where
    if not where.endswith(".py"):
        try:
            spec = find_spec(where)
        except ModuleNotFoundError:
            spec = None
        if spec is None or not spec.origin:
            raise SceneError([Problem(f"no module {where} can be imported", "measure")])
        path = Path(spec.origin)
    try:
        source = read_file(path, MOST_TEXT).decode()
        defined = ast.parse(source).body
    except (OSError, ValueError, SyntaxError) as error:
        raise SceneError([Problem(f"{path} cannot be read: {error}", "measure")]) from None
    if not any(isinstance(one, ast.FunctionDef) and one.name == function for one in defined):
        raise SceneError([Problem(f"there is no function {function} in {path}", "measure")])
    return Measure(str(path.absolute()) if where.endswith(".py") else where, function, source)


def measured(
    measure: Measure, result: Result
) -> tuple[Mapping[str, Quantity], Mapping[str, list[Any]]]:
    """Quantities of a member by its measure, and the labels of their additional dimensions.

    Numbers are converted to floating point, so that missing ones can be nan.

    Raises
    ------
    ValueError
        If a quantity has the name of another one, or is not a number.
    """
    dataset = measure(result)
    quantities = {}
    for name, one in dataset.data_vars.items():
        if name in RESERVED:
            raise ValueError(f"{name} is a name in the dataset of every study; take another")
        if one.dtype.kind not in "fiub":
            raise ValueError(f"{name} is no number")
        dims = tuple(map(str, one.dims))
        quantities[str(name)] = (dims, np.asarray(one.values, float), dict(one.attrs))
    labels = {
        str(dim): dataset[dim].values.tolist()
        for dim in dataset.dims
        if dim in dataset.coords and dim not in DIMENSIONS
    }
    return quantities, labels
