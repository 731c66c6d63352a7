"""Output files of an inference: forces.csv, grains.csv, summary.json and figures."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import tomli_w
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

from granwave.analysis.figures.series import one_panel
from granwave.analysis.figures.style import (
    BLUE,
    FORCE_MAP,
    GREY,
    ORANGE,
    WIDTH,
    Columns,
    Drawing,
    FigureFolder,
    style,
    write_csv,
)
from granwave.extensions.inference.files import (
    INFERENCE,
    INFERRED_FORCES,
    INFERRED_GRAINS,
    MADE_CASE,
    MADE_MEASUREMENT,
)
from granwave.extensions.inference.forces.grains import NORMAL, TANGENTIAL, Array
from granwave.extensions.inference.forces.infer import Inference
from granwave.lammps_inputs.files import plain, replace_text, replacing
from granwave.lammps_inputs.own_files import AnyPath, figure_files
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import SUMMARY_FILE

FIGURES = ("force_network", "residuals", "force_errors", "modulus", "noise")
FILES = (INFERRED_FORCES, INFERRED_GRAINS, MADE_MEASUREMENT, MADE_CASE, SUMMARY_FILE)
WRITTEN = (*FILES, *itertools.chain.from_iterable(map(figure_files, FIGURES)))
_WIDEST = 5.0  # width of the line of the largest force, points
_TALLEST = 8.0  # largest height of a figure, inches
_OUTLINE = "#b8b8b8"
_DEPTH = 2  # axis along which depth is measured


@dataclasses.dataclass(frozen=True, eq=False)
class Inferred:
    """Forces inferred from a table of grains, or from simulated measurements of a run.

    Attributes
    ----------
    found, times
        Inferences and their instants, s; NaN for a table without times. A run has only one table,
        from the first measurement with the largest noise.
    summary
        Content of summary.json.
    measurement, case
        Columns of measurement.csv, and tables of the case for its inference; None for a table.
    true
        True forces of a run, components as in `Inference.force`: (m, d), N.
    noise
        Noise, and the mean and standard deviation of the error of the forces over repetitions:
        (3, n).
    """

    found: Sequence[Inference]
    times: Sequence[float]
    summary: Mapping[str, Any]
    measurement: Columns | None = None
    case: Mapping[str, Any] | None = None
    true: Array | None = None
    noise: Array | None = None

    @property
    def forces(self) -> pd.DataFrame:
        """Columns of forces.csv, with the true forces for a run: a row for each possible contact.

        Forces act on the grain with the id ``i``, into which the normal points; ``j`` is the id of
        the partner or the name of a wall. In the plane a tangential force is positive along
        (-ny, nx); in space it is a magnitude, and the components of the force are in further
        columns.
        """
        tables = []
        for inference in self.found:
            contacts = inference.contacts
            ids = inference.grains.ids
            axes = list("xyz"[: inference.grains.dimension])
            table = pd.DataFrame({"i": ids[contacts.first], "j": contacts.partners(ids)})
            table[[f"n{axis}" for axis in axes]] = contacts.normal
            table["normal_force_N"] = inference.force[:, NORMAL]
            table["tangential_force_N"] = _tangential(inference.force)
            if inference.spread is not None:
                normal_error, tangential_error = inference.errors
                table["normal_error_N"] = normal_error
                table["tangential_error_N"] = tangential_error
            table[[f"f{axis}_N" for axis in axes]] = contacts.vectors(inference.force)
            points = inference.grains.position[contacts.first] + contacts.arm
            table[[f"{axis}_m" for axis in axes]] = points
            tables.append(table)
        table = self._joined(tables)
        if self.true is not None:
            table["true_normal_force_N"] = self.true[:, NORMAL]
            table["true_tangential_force_N"] = _tangential(self.true)
        return table

    @property
    def grains(self) -> pd.DataFrame:
        """Columns of grains.csv: residuals of the equations of each grain, NaN if nothing was
        measured.
        """
        tables = []
        for inference in self.found:
            motion, stress = inference.residual_of_grains()
            columns = {
                "id": inference.grains.ids,
                "residual_motion_N": motion,
                "residual_stress_N": stress,
            }
            tables.append(pd.DataFrame(columns))
        return self._joined(tables)

    def _joined(self, tables: Sequence[pd.DataFrame]) -> pd.DataFrame:
        """Concatenate the tables of the instants, after a column of times if these are known."""
        for table, time in zip(tables, self.times, strict=True):
            if not math.isnan(time):
                table.insert(0, "time_s", time)
        return pd.concat(tables, ignore_index=True)

    def write(self, directory: AnyPath, *, figures: bool = True) -> None:
        """Write the files into a directory, created if necessary; earlier ones are replaced.

        Figures show the instant with the largest force.

        Raises
        ------
        InputError
            A file of such a name exists, and granwave did not write it.
        """
        results = ResultDirectory.at(directory)
        results.path.mkdir(parents=True, exist_ok=True)
        results.clear(WRITTEN)
        written: dict[str, Columns] = {
            INFERRED_FORCES: dict(self.forces),
            INFERRED_GRAINS: dict(self.grains),
        }
        if self.measurement is not None:
            written[MADE_MEASUREMENT] = self.measurement
        texts = {
            SUMMARY_FILE: json.dumps(plain(dict(self.summary)), indent=2, allow_nan=False) + "\n"
        }
        if self.case is not None:
            texts[MADE_CASE] = tomli_w.dumps(plain(dict(self.case)))
        results.claim([*written, *texts], kind=INFERENCE)
        for name, columns in written.items():
            with replacing(results / name) as scratch:
                write_csv(columns, scratch, exact=True)
        for name, text in texts.items():
            replace_text(results / name, text)
        if not figures:
            return
        shown = max(self.found, key=lambda inference: float(inference.force.max(initial=0.0)))
        folder = FigureFolder(results)
        with style():
            for name, draw in zip(FIGURES, (network, residuals, errors, modulus), strict=False):
                folder.draw(partial(draw, shown), name)
            if self.noise is not None:
                folder.draw(partial(against_noise, *self.noise), FIGURES[-1])


def _tangential(force: Array) -> Array:
    """Tangential forces from components (m, d): with a sign in the plane, magnitudes in space."""
    if force.shape[1] == 2:
        return force[:, 1]
    return np.asarray(np.linalg.norm(force[:, TANGENTIAL], axis=1))


def network(inference: Inference) -> Drawing:
    """Draw the grains and the forces between them; the width of a line is proportional to the
    force.
    """
    contacts = inference.contacts
    ids = inference.grains.ids
    position = inference.grains.position
    size = np.linalg.norm(inference.force, axis=1)
    figure, axes, shown, _ = _map(inference, facecolors="#f4f4f4")
    ends = position[contacts.first] + contacts.arm
    pairs = contacts.second >= 0
    ends[pairs] = position[contacts.second[pairs]]
    order = np.argsort(size)
    lines = 1e3 * np.stack([position[contacts.first], ends], axis=1)[order][:, :, shown]
    widths = _WIDEST * size[order] / (float(size.max(initial=0.0)) or 1.0)
    drawn = LineCollection(
        list(lines),
        linewidths=widths,
        array=size[order],
        cmap=FORCE_MAP,
        capstyle="round",
        zorder=2,
    )
    axes.add_collection(drawn)
    figure.colorbar(drawn, ax=axes, label="Contact force (N)", shrink=0.8, pad=0.02)
    columns = {
        "i": ids[contacts.first],
        "j": np.array(contacts.partners(ids), dtype=np.str_),
        "force_N": size,
    }
    return Drawing(figure, columns)


def residuals(inference: Inference) -> Drawing:
    """Draw the residuals of the equations of each grain, divided by the root mean square of the
    forces.
    """
    motion, stress = inference.residual_of_grains()
    total = np.sqrt(np.nan_to_num(motion) ** 2 + np.nan_to_num(stress) ** 2)
    total[np.isnan(motion) & np.isnan(stress)] = np.nan
    scale = float(np.sqrt(np.mean(inference.force[:, NORMAL] ** 2))) or 1.0
    figure, axes, _, discs = _map(inference, cmap="cividis", array=total / scale)
    figure.colorbar(discs, ax=axes, label="Residual / rms normal force", shrink=0.8, pad=0.02)
    return Drawing(
        figure,
        {"id": inference.grains.ids, "residual_motion_N": motion, "residual_stress_N": stress},
    )


def errors(inference: Inference) -> Drawing | None:
    """Draw the standard errors of normal and tangential forces against the force; None if there are
    none.
    """
    if inference.spread is None:
        return None
    size = np.linalg.norm(inference.force, axis=1)
    figure, axes = one_panel(2.6, "Contact force (N)", "Standard error (N)")
    normal, shear = inference.errors
    axes.plot(size, normal, ".", color=BLUE, ms=4, label="normal force")
    if inference.settings.friction > 0:
        axes.plot(size, shear, "+", color=ORANGE, ms=4, mew=0.7, label="tangential force")
    axes.plot(
        [0, size.max()], [0, 0.1 * size.max()], "--", color=GREY, lw=0.8, label="10 % of the force"
    )
    axes.set(xlim=(0, None), ylim=(0, 1.25 * max(float(normal.max()), float(shear.max()), 1e-30)))
    axes.legend(loc="upper right")
    return Drawing(figure, {"force_N": size, "normal_error_N": normal, "tangential_error_N": shear})


def modulus(inference: Inference) -> Drawing | None:
    """Draw chi^2 against Young's modulus; None if the modulus was given."""
    if inference.search is None or inference.grains.modulus is None:
        return None
    scale = float(inference.grains.modulus[0])
    values = scale * inference.search.factors
    best = scale * inference.factor
    figure, axes = one_panel(2.4, "Young's modulus (MPa)", r"$\chi^2$")
    axes.loglog(values / 1e6, inference.search.chi2, "o-", color=BLUE, ms=3, lw=0.8)
    axes.axvline(best / 1e6, color=ORANGE, lw=0.8)
    axes.set_title(f"{best / 1e6:.4g} MPa ± {100 * inference.search.error:.2g} %")
    return Drawing(figure, {"youngs_modulus_Pa": values, "chi2": inference.search.chi2})


def against_noise(noise: Array, error: Array, spread: Array) -> Drawing:
    """Draw the error of the forces against the noise of synthetic measurements of a run.

    Parameters
    ----------
    noise
        Noise / root mean square: (n,).
    error, spread
        Relative errors of the forces: means and standard deviations of the repetitions, (n,).
    """
    figure, axes = one_panel(
        2.4, "Noise of strains and accelerations (%)", "Error of the forces (%)"
    )
    axes.errorbar(
        100 * noise, 100 * error, yerr=100 * spread, fmt="o-", color=BLUE, ms=3, lw=0.8, capsize=2
    )
    axes.set(xlim=(0, None), ylim=(0, None))
    return Drawing(figure, {"noise": noise, "error": error, "standard_deviation": spread})


def _map(inference: Inference, **options: Any) -> tuple[Figure, Axes, list[int], EllipseCollection]:
    """Draw the grains as discs, in mm; z, the depth below the top of a packing, points down.

    Returns
    -------
    figure, axes, shown, discs
        ``shown`` are the axes of the view: in space those along which forces are largest, in their
        order.
    """
    shown = [0, 1]
    if inference.grains.dimension == 3:
        along = np.abs(inference.contacts.vectors(inference.force)).sum(axis=0)
        shown = sorted(np.argsort(-along, kind="stable")[:2].tolist())
    x = 1e3 * inference.grains.position[:, shown]
    radius = 1e3 * inference.grains.radius
    low = (x - radius[:, None]).min(axis=0)
    high = (x + radius[:, None]).max(axis=0)
    width, height = high - low
    margin = 0.03 * max(width, height)
    vertical = "Depth $z$ (mm)" if shown[1] == _DEPTH else f"${'xyz'[shown[1]]}$ (mm)"
    figure, axes = one_panel(
        min(_TALLEST, max(1.6, 0.75 * WIDTH * height / width + 0.5)),
        f"${'xyz'[shown[0]]}$ (mm)",
        vertical,
        xlim=(low[0] - margin, high[0] + margin),
        ylim=(low[1] - margin, high[1] + margin),
        aspect="equal",
    )
    if shown[1] == _DEPTH:
        axes.invert_yaxis()
    discs = EllipseCollection(
        2 * radius, 2 * radius, np.zeros(len(radius)), units="xy", offsets=x, offset_transform=axes.transData,
        edgecolors=_OUTLINE, linewidths=0.4, **options,
    )  # fmt: skip
    axes.add_collection(discs)
    return figure, axes, shown, discs
