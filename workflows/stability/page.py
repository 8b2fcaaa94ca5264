"""The page of the stability study: what happened in each case, in tables and pictures."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from cfmpm.plotting import curves
from cfmpm.plotting.style import BLUE, GREY, VERMILLION, panels
from workflows.reporting.html_page import html_image, html_page, html_table, write_text
from workflows.stability.cases import TOUCH

COLUMNS = (
    *("case", "what happened", "J [N/mm]", "known", "error", "allowed"),
    *("iterations / steps", "unbalanced", "as it should be"),
)
# What is known, where it is not J.
SAID = {
    "load_reached": "load factor ",
    "elongation": "elongation ",
    "K_I": "K_I ",
    "K_II": "K_II ",
    "aside": "aside ",
    "cycles": "cycles ",
}
# The paths of load that are drawn: cases by panel with their labels.
PATHS: Mapping[str, Mapping[str, str]] = {
    "Dead load past the limit point": {
        "dead_load/hencky_no_crack": "Hencky, no crack",
        "dead_load/hencky": "Hencky",
        "dead_load/ciarlet_many": "Ciarlet's",
    },
    "Compression until the plate buckles": {
        "compression/buckling_no_crack": "no crack",
        "compression/buckling": "crack, closed",
    },
    "Reversal": {
        "reversal/there_and_back": "Ciarlet's, 10 %",
        "reversal/plastic_many": "plastic, 1 %",
    },
}


def write_page(
    data: str | Path,
    titles: Mapping[str, str],
    errors: str | Path,
    paths: str | Path,
    page: str | Path,
) -> None:
    """Draw the study and write its page, with the pictures inside.

    Parameters
    ----------
    data : Path
        From `cases.write_cases`.
    titles : mapping of str to str
        Of the groups.
    errors, paths : Path
        PNG files to be written: errors with iterations, and paths of load.
    page : Path
        The HTML file.
    """
    dataset = xr.load_dataset(data)
    _draw_errors(dataset, Path(errors))
    _draw_paths(dataset, Path(paths))
    held = int(dataset.held.sum())
    parts = [
        f"<p>{held} of {dataset.sizes['case']} cases ended as they should. Cases in which crack "
        f"faces overlap by more than {TOUCH:g} elements: {int((dataset.overlap > TOUCH).sum())}. "
        "Unknown numbers (nan) in steps that are called solved: "
        f"{int(dataset.not_known.sum())}.</p>\n",
        f"<p>{html_image(errors, 'errors and iterations')}</p>\n",
        f"<p>{html_image(paths, 'paths of load')}</p>\n",
    ]
    for group, title in titles.items():
        rows = dataset.isel(case=np.flatnonzero(dataset.group == group))
        parts.append(f"<h2>{html.escape(title)}</h2>\n{_table(rows)}")
    write_text(html_page("Extreme cases", "".join(parts)), page)


def _table(rows: xr.Dataset) -> str:
    lines, marks = [], []
    for name in rows.case.values:
        row = rows.sel(case=name)
        marks.append("yes" if row.held else "no")
        effort = [_number(row[count], ".0f") for count in ("newton_iterations", "substeps")]
        lines.append(
            [
                str(name).split("/")[1],
                _what_happened(row),
                _number(row.J, ".6g"),
                _known(row),
                _number(row.error, ".1e"),
                _number(row.within, "g"),
                " / ".join(filter(None, effort)),
                _number(row.residual, ".0e"),
                marks[-1],
            ]
        )
    return html_table(COLUMNS, lines, marks)


def _what_happened(row: xr.Dataset) -> str:
    """The words in which the program said it; of a solved case, its warnings."""
    status, message = row.status.item(), row.message.item()
    if status == "solved":
        # Of a growing crack, the word for its end.
        return "; ".join([message.split(":")[0], *json.loads(row.warnings.item())])
    return message if status == "unstable" else f"{status}: {message}"


def _known(row: xr.Dataset) -> str:
    if row.reference.isnull():
        return ""
    what = SAID.get(row.compared.item(), "")
    return f"{what}{float(row.reference):.6g} ({row.reference_from.item()})"


def _number(value: xr.DataArray, form: str) -> str:
    return f"{float(value):{form}}" if value.notnull() else ""


def _draw_errors(dataset: xr.Dataset, path: Path) -> None:
    """Draw the error of each compared case beside what is allowed, and the iterations."""
    compared = dataset.isel(case=np.flatnonzero(dataset.error.notnull()))
    solved = dataset.isel(case=np.flatnonzero(dataset.newton_iterations > 0))
    with panels(path, (13.0, 10.0), 1, 2) as axes:
        a, b = axes.flat
        rows = np.arange(compared.sizes["case"])
        a.hlines(rows, 1e-17, compared.within, color=GREY, lw=0.5)
        a.plot(compared.within, rows, "|", color=GREY, ms=9.0, mew=1.5, label="allowed")
        # An error of nothing at all is drawn at the left end.
        a.plot(np.maximum(compared.error, 1e-17), rows, "o", color=BLUE, ms=4.0, label="error")
        a.set_xscale("log")
        a.set_xlim(1e-17, 1.0)
        a.set_title("error against what is known")
        a.set_xlabel("relative error [1]")
        a.legend(loc="upper center", bbox_to_anchor=(0.5, -0.06), ncols=2)
        rows = np.arange(solved.sizes["case"])
        b.barh(rows, solved.newton_iterations, color=BLUE, height=0.6, label="Newton iterations")
        b.plot(solved.substeps, rows, "|", color=VERMILLION, ms=7.0, mew=1.5, label="steps")
        b.set_xscale("log")
        b.set_title("finite deformation: iterations and steps")
        b.set_xlabel("number [1]")
        b.legend(loc="upper center", bbox_to_anchor=(0.5, -0.06), ncols=2)
        for one, drawn in ((a, compared), (b, solved)):
            _name_rows(one, drawn)


def _name_rows(axes: Axes, dataset: xr.Dataset) -> None:
    axes.set_yticks(np.arange(dataset.sizes["case"]), dataset.case.values, fontsize=6.5)
    axes.set_ylim(dataset.sizes["case"] - 0.5, -0.5)


def _draw_paths(dataset: xr.Dataset, path: Path) -> None:
    """Draw force against elongation for some cases."""
    with panels(path, (12.0, 4.0), 1, 3) as axes:
        for one, (title, cases) in zip(axes.flat, PATHS.items(), strict=True):
            for k, (name, label) in enumerate(cases.items()):
                row = dataset.sel(case=name)
                longer, force = (np.append(0.0, row[key].values) for key in ("elongation", "force"))
                # Each in parts of its largest, where cases of two sizes share a picture.
                scale = np.nanmax(np.abs(force)) if title == "Reversal" else 1.0
                far = np.nanmax(np.abs(longer)) if title == "Reversal" else 1.0
                curves.draw_curve(one, longer / far, force / scale, label, k)
                if row.status == "unstable":
                    last = np.flatnonzero(np.isfinite(force))[-1]
                    one.plot(longer[last], force[last], "x", color="k", ms=9.0, mew=1.6)
            one.set_title(title)
            reverse = title == "Reversal"
            one.set_xlabel("elongation" + (" / its largest [1]" if reverse else " [mm]"))
            one.set_ylabel("force" + (" / its largest [1]" if reverse else " [N/mm]"))
            one.legend(loc="best")
