"""Output files of an inference: forces.csv, grains.csv, summary.json and figures."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection

from granwave.analysis.figures.style import (
    BLUE,
    FORCE_MAP,
    GREY,
    ORANGE,
    WIDTH,
    Columns,
    Drawing,
    FigureFolder,
    new_figure,
    style,
    write_csv,
)
from granwave.analysis.inference.grains import Array
from granwave.analysis.inference.infer import Inference
from granwave.analysis.inference.tables import force_columns, grain_columns
from granwave.lammps_inputs.files import plain, replace_text, replacing
from granwave.lammps_inputs.ownership import claim, clear, figure_files
from granwave.lammps_inputs.run_directory import (
    INFERENCE,
    INFERRED_FORCES,
    INFERRED_GRAINS,
    MADE_CASE,
    MADE_MEASUREMENT,
    SUMMARY_FILE,
)

FIGURES = ("force_network", "residuals", "force_errors", "modulus", "noise")
FILES = (INFERRED_FORCES, INFERRED_GRAINS, MADE_MEASUREMENT, MADE_CASE, SUMMARY_FILE)
WRITTEN = (*FILES, *(file for name in FIGURES for file in figure_files(name)))
_WIDEST = 5.0  # line of the largest force, points
_TALLEST = 8.0  # figure, inches
_OUTLINE = "#b8b8b8"
_DEPTH = 2  # axis along which depth is measured, as everywhere


@dataclasses.dataclass(frozen=True, eq=False)
class Inferred:
    """Forces inferred from a table of grains, or from measurements made of a run, before they are written.

    Attributes
    ----------
    found, times
        Inference at each instant, s; NaN for a table without times. Of a run only one, from the first measurement with
        the largest noise.
    summary
        Content of summary.json.
    measurement, case
        Columns of measurement.csv, of that measurement, and tables of the case that it is inferred with; None for a
        table.
    true
        True forces of a run, components as in `Inference.force`: (m, d), N.
    noise
        Noise, and mean and standard deviation of the error of the forces over the repetitions: (3, n).
    """

    found: Sequence[Inference]
    times: Sequence[float]
    summary: Mapping[str, Any]
    measurement: Columns | None = None
    case: Mapping[str, Any] | None = None
    true: Array | None = None
    noise: Array | None = None

    @property
    def forces(self) -> Columns:
        """Columns of forces.csv, of a run with the true forces."""
        columns = dict(force_columns(self.found, self.times))
        if self.true is not None:
            shear = self.true[:, 1] if self.true.shape[1] == 2 else np.linalg.norm(self.true[:, 1:], axis=1)
            columns |= {"true_normal_force_N": self.true[:, 0], "true_tangential_force_N": shear}
        return columns

    @property
    def grains(self) -> Columns:
        """Columns of grains.csv."""
        return grain_columns(self.found, self.times)

    def write(self, directory: Path, *, figures: bool = True) -> None:
        """Write the files into a directory, created if necessary; earlier ones are replaced.

        Figures show the instant with the largest force.

        Raises
        ------
        InputError
            A file of such a name exists, and granwave did not write it.
        """
        directory.mkdir(parents=True, exist_ok=True)
        clear(directory, WRITTEN)
        written = {INFERRED_FORCES: self.forces, INFERRED_GRAINS: self.grains}
        if self.measurement is not None:
            written[MADE_MEASUREMENT] = self.measurement
        texts = {SUMMARY_FILE: json.dumps(plain(dict(self.summary)), indent=2, allow_nan=False) + "\n"}
        if self.case is not None:
            texts[MADE_CASE] = tomli_w.dumps(plain(dict(self.case)))
        claim(directory, [*written, *texts], kind=INFERENCE)
        for name, columns in written.items():
            with replacing(directory / name) as scratch:
                write_csv(columns, scratch, exact=True)
        for name, text in texts.items():
            replace_text(directory / name, text)
        if not figures:
            return
        shown = max(self.found, key=lambda one: float(one.force.max(initial=0.0)))
        folder = FigureFolder(directory)
        with style():
            for name, draw in zip(FIGURES, (network, residuals, errors, modulus), strict=False):
                folder.draw(partial(draw, shown), name)
            if self.noise is not None:
                folder.draw(partial(against_noise, *self.noise), FIGURES[-1])


def network(found: Inference) -> Drawing:
    """Draw the grains and the forces between them; lines are as wide as the force is large."""
    first, second = _shown_axes(found)
    x, radius, contacts = found.grains.position[:, [first, second]], found.grains.radius, found.contacts
    size = np.linalg.norm(found.force, axis=1)
    figure, axes = _map(x, radius)
    _discs(axes, x, radius, facecolors="#f4f4f4")
    point = found.grains.position[contacts.first] + contacts.arm
    ends = point.copy()
    pairs = contacts.second >= 0
    ends[pairs] = found.grains.position[contacts.second[pairs]]
    lines = np.stack([found.grains.position[contacts.first], ends], axis=1)[:, :, [first, second]]
    order = np.argsort(size)
    widths = _WIDEST * size / (float(size.max(initial=0.0)) or 1.0)
    drawn = LineCollection(
        list(1e3 * lines[order]), linewidths=widths[order], cmap=FORCE_MAP, capstyle="round", zorder=2
    )
    drawn.set_array(size[order])
    axes.add_collection(drawn)
    figure.colorbar(drawn, ax=axes, label="Contact force (N)", shrink=0.8, pad=0.02)
    ids = found.grains.ids
    _label(axes, first, second)
    columns = {"i": ids[contacts.first], "j": np.array(contacts.partners(ids), dtype=np.str_), "force_N": size}
    return Drawing(figure, columns)


def residuals(found: Inference) -> Drawing:
    """Draw the residuals of each grain's equations, over the root mean square of the forces."""
    first, second = _shown_axes(found)
    x, radius = found.grains.position[:, [first, second]], found.grains.radius
    motion, stress = found.residual_of_grains()
    total = np.sqrt(np.nan_to_num(motion) ** 2 + np.nan_to_num(stress) ** 2)
    total[np.isnan(motion) & np.isnan(stress)] = np.nan
    scale = float(np.sqrt(np.mean(found.force[:, 0] ** 2))) or 1.0
    figure, axes = _map(x, radius)
    drawn = _discs(axes, x, radius, cmap="cividis")
    drawn.set_array(total / scale)
    figure.colorbar(drawn, ax=axes, label="Residual / rms normal force", shrink=0.8, pad=0.02)
    _label(axes, first, second)
    return Drawing(figure, {"id": found.grains.ids, "residual_motion_N": motion, "residual_stress_N": stress})


def errors(found: Inference) -> Drawing | None:
    """Draw the standard errors of normal and tangential forces against the force; None if there are none."""
    if found.spread is None:
        return None
    size = np.linalg.norm(found.force, axis=1)
    figure = new_figure(2.6)
    axes = figure.subplots()
    shear = np.linalg.norm(found.spread[:, 1:], axis=1) / math.sqrt(found.spread.shape[1] - 1)
    axes.plot(size, found.spread[:, 0], ".", color=BLUE, ms=4, label="normal force")
    if found.settings.friction > 0:
        axes.plot(size, shear, "+", color=ORANGE, ms=4, mew=0.7, label="tangential force")
    axes.plot([0, size.max()], [0, 0.1 * size.max()], "--", color=GREY, lw=0.8, label="10 % of the force")
    axes.set_xlim(0, None)
    axes.set_ylim(0, 1.25 * max(float(found.spread[:, 0].max()), float(shear.max()), 1e-30))
    axes.set_xlabel("Contact force (N)")
    axes.set_ylabel("Standard error (N)")
    axes.legend(loc="upper right")
    return Drawing(figure, {"force_N": size, "normal_error_N": found.spread[:, 0], "tangential_error_N": shear})


def modulus(found: Inference) -> Drawing | None:
    """Draw chi^2 against Young's modulus; None if it was not searched for."""
    if found.search is None or found.grains.modulus is None:
        return None
    scale = float(found.grains.modulus[0])
    values = scale * found.search.factors
    best = scale * found.factor
    figure = new_figure(2.4)
    axes = figure.subplots()
    axes.semilogx(values / 1e6, found.search.chi2, "o-", color=BLUE, ms=3, lw=0.8)
    axes.set_yscale("log")
    axes.axvline(best / 1e6, color=ORANGE, lw=0.8)
    error = 100 * found.search.error
    axes.set_title(f"{best / 1e6:.4g} MPa ± {error:.2g} %")
    axes.set_xlabel("Young's modulus (MPa)")
    axes.set_ylabel(r"$\chi^2$")
    return Drawing(figure, {"youngs_modulus_Pa": values, "chi2": found.search.chi2})


def against_noise(noise: Array, error: Array, spread: Array) -> Drawing:
    """Draw the error of the forces against the noise of measurements made of a run.

    Parameters
    ----------
    noise
        Noise over the root mean square: (n,).
    error, spread
        Errors of the forces over the forces, means of the repetitions, and their standard deviations: (n,).
    """
    figure = new_figure(2.4)
    axes = figure.subplots()
    axes.errorbar(100 * noise, 100 * error, yerr=100 * spread, fmt="o-", color=BLUE, ms=3, lw=0.8, capsize=2)
    axes.set_xlim(0, None)
    axes.set_ylim(0, None)
    axes.set_xlabel("Noise of strains and accelerations (%)")
    axes.set_ylabel("Error of the forces (%)")
    return Drawing(figure, {"noise": noise, "error": error, "standard_deviation": spread})


def _shown_axes(found: Inference) -> tuple[int, int]:
    """Return the axes of the view: in space those along which forces are largest, in their order."""
    if found.grains.dimension == 2:
        return 0, 1
    along = np.abs(found.contacts.vectors(found.force)).sum(axis=0)
    first, second = sorted(np.argsort(-along, kind="stable")[:2].tolist())
    return first, second


def _map(x: Array, radius: Array) -> tuple:
    low, high = (x - radius[:, None]).min(axis=0), (x + radius[:, None]).max(axis=0)
    width, height = high - low
    tall = min(_TALLEST, max(1.6, 0.75 * WIDTH * height / width + 0.5))
    figure = new_figure(tall)
    axes = figure.subplots()
    margin = 0.03 * max(width, height)
    axes.set_xlim(1e3 * (low[0] - margin), 1e3 * (high[0] + margin))
    axes.set_ylim(1e3 * (low[1] - margin), 1e3 * (high[1] + margin))
    axes.set_aspect("equal")
    return figure, axes


def _discs(axes: Axes, x: Array, radius: Array, **options: object) -> EllipseCollection:
    """Draw grains as discs, in mm."""
    size = 2e3 * radius
    found = EllipseCollection(
        size, size, np.zeros(len(size)), units="xy", offsets=1e3 * x, transOffset=axes.transData,
        edgecolors=_OUTLINE, linewidths=0.4, **options,  # type: ignore[arg-type]
    )  # fmt: skip
    axes.add_collection(found)
    return found


def _label(axes: Axes, first: int, second: int) -> None:
    """Label the axes; z, the depth below the top of a packing, goes down."""
    axes.set_xlabel(f"${'xyz'[first]}$ (mm)")
    axes.set_ylabel("Depth $z$ (mm)" if second == _DEPTH else f"${'xyz'[second]}$ (mm)")
    if second == _DEPTH:
        axes.invert_yaxis()
