"""Figures of a sphere contact from its ``result.h5``, each written as NAME.png, .pdf and .csv."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import h5py
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from numpy.typing import NDArray

from granwave.analysis.figures.series import label, one_panel, panels
from granwave.analysis.figures.style import BLUE, FORCE_MAP, GREEN, GREY, ORANGE, PURPLE, Drawing
from granwave.extensions.continuum.runner import ElementResult
from granwave.extensions.continuum.sphere_contact.case import SphereContactCase
from granwave.extensions.continuum.sphere_contact.deviations import (
    LOADING,
    RELOADING,
    RESOLVED,
    UNLOADING,
)

Array = NDArray[np.float64]

_CURVE = 500  # points of a curve of a law
_MILLI = 1e3
_MEGA = 1e-6
_BESIDE: dict[str, Any] = {
    "loc": "center left",
    "bbox_to_anchor": (1.0, 0.5),
    "fontsize": 7,
}  # names in a legend
_SHOWN = 2.5  # half-width of the section, contact radii


class SphereContactResult(ElementResult):
    """The ``result.h5`` of a sphere contact, with quantities for its figures; raise as
    `ElementResult`.
    """

    def _read(self, file: h5py.File) -> None:
        super()._read(file)
        self.case = SphereContactCase.from_dict(self.tables)
        profiles = sorted(file.get("pressure", {}), key=int)
        self.profiles = [
            (float(file[f"pressure/{n}"].attrs["overlap"]), f"pressure/{n}") for n in profiles
        ]

    @property
    def units(self) -> tuple[float, float]:
        """Overlap (m) and force (N) for normalisation: values at first yield, or at the substitute
        overlap.
        """
        unit = self.case.yield_unit
        return unit, float(self.hertz(np.array([unit]))[0])

    @property
    def plastic(self) -> bool:
        """True if first yield is reached."""
        return self.case.law.yield_overlap < self.case.max_overlap

    @property
    def overlap_label(self) -> str:
        """Axis label of normalised overlaps."""
        if self.plastic:
            return r"Overlap $\alpha/\alpha_\mathrm{y}$"
        return r"Overlap, 400 $\alpha/\alpha_\mathrm{max}$"

    @property
    def strength(self) -> float:
        """Yield strength of the softer sphere, Pa; without yielding, the Hertzian mean pressure at
        the unit overlap.
        """
        strength = self.case.law.yield_strength
        if math.isfinite(strength):
            return strength
        overlap, force = self.units
        return force / (math.pi * self.case.law.effective_radius * overlap)

    def hertz(self, overlap: Array) -> Array:
        """Return the force of Hertz's law at overlaps (m), N."""
        law = self.case.law
        stiffness = 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)
        return stiffness * overlap**1.5

    def branch(self, branch: int, cycle: int = 0) -> NDArray[np.int64]:
        """Return the indices of the entries of one branch; unloading includes the entry where it
        begins.
        """
        rows = np.flatnonzero((self["history/branch"] == branch) & (self["history/cycle"] == cycle))
        return np.append(rows[0] - 1, rows) if branch == UNLOADING else rows

    @property
    def cycles(self) -> list[int]:
        """Numbers of the cycles."""
        return [int(number) for number in self["cycles/number"]]


def force_overlap(result: SphereContactResult) -> Drawing:
    """Draw force against overlap with all cycles, the law, Hertz and Thornton."""
    unit, force_unit = result.units
    overlap = result["history/overlap"] / unit
    force = result["history/force"] / force_unit
    curve = np.linspace(0, result["loading/overlap"].max(), _CURVE)
    law = result.case.law
    figure, axes = one_panel(3.0, result.overlap_label, r"Force $F/F_\mathrm{y}$")
    for cycle in result.cycles:
        for branch, line, colour, name in (
            (UNLOADING, "-", ORANGE, "unloading"),
            (RELOADING, ":", BLUE, "reloading"),
        ):
            rows = result.branch(branch, cycle)
            title = name if cycle == result.cycles[0] else None
            axes.plot(overlap[rows], force[rows], line, color=colour, linewidth=0.8, label=title)
    rows = result.branch(LOADING)
    rows = rows[np.argsort(overlap[rows], kind="stable")]
    axes.plot(overlap[rows], force[rows], color="black", label="loading")
    curves: list[tuple[str, str, Array, dict[str, Any]]] = [
        ("law", "contact law", law.loading_force(curve), {"linestyle": "--", "color": GREEN})
    ]
    if result.case.yields:
        values = result.case.contact_law("thornton").loading_force(curve)
        curves.append(("thornton", "Thornton", values, {"linestyle": "-.", "color": PURPLE}))
    curves.append(("hertz", "Hertz", result.hertz(curve), {"color": GREY, "linewidth": 0.8}))
    columns: dict[str, NDArray] = {"overlap_normalised": overlap, "force_normalised": force}
    columns |= {"branch": result["history/branch"], "cycle": result["history/cycle"]}
    columns["curve_overlap_normalised"] = curve / unit
    for column, name, values, look in curves:
        columns[f"{column}_normalised"] = values / force_unit
        axes.plot(curve / unit, values / force_unit, label=name, **look)
    axes.set(xlim=(0, None), ylim=(0, 1.15 * force.max()))
    axes.legend(loc="upper left", fontsize=7)
    return Drawing(figure, columns)


def pressure_profiles(result: SphereContactResult) -> Drawing:
    """Draw the contact pressure along the surface."""
    effective = result.case.law.effective_radius
    curves = {}
    for overlap, name in result.profiles:
        radius = result[f"{name}/radius"] / effective
        pressure = result[f"{name}/pressure"] / result.strength
        end = int(np.flatnonzero(pressure).max(initial=0)) + 2
        curves[f"{overlap / effective:.3g}"] = radius[:end], pressure[:end]
    drawing, axes = _family(curves, ("r_over_R*", "pressure_normalised"))
    label(
        axes,
        "Distance from the axis $r/R^*$",
        r"Contact pressure $p/\sigma_\mathrm{y}$",
        xlim=(0, None),
        ylim=(0, None),
    )
    axes.legend(title=r"$\alpha/R^*$", **_BESIDE)
    return drawing


def _family(curves: dict[str, tuple[Array, Array]], names: tuple[str, str]) -> tuple[Drawing, Axes]:
    """Draw curves in the colours of a map; ``names`` are the columns of the axes."""
    figure, axes = one_panel(2.9, "", "")
    shares = np.linspace(0, 0.92, len(curves))
    for (name, (x, y)), share in zip(curves.items(), shares, strict=True):
        axes.plot(x, y, color=colormaps[FORCE_MAP](share), linewidth=0.9, label=name)
    abscissa, ordinate = names
    columns = {}
    for name, (x, y) in curves.items():
        columns[f"{abscissa}_{name}"] = x
        columns[f"{ordinate}_{name}"] = y
    return Drawing(figure, columns), axes


def _compared(
    result: SphereContactResult, columns: dict[str, Array], ylabel: str
) -> tuple[Drawing, Axes]:
    """Draw columns against the first column, the overlap: finite elements, the law, and Hertz."""
    overlap, *curves = columns.values()
    order = np.argsort(overlap)
    figure, axes = one_panel(2.5, result.overlap_label, ylabel)
    looks = (
        ("finite elements", "-", BLUE, 0.9),
        ("contact law", "--", GREEN, None),
        ("Hertz", "-", GREY, 0.8),
    )
    for values, (name, line, colour, width) in zip(curves, looks, strict=False):
        axes.plot(overlap[order], values[order], line, color=colour, linewidth=width, label=name)
    return Drawing(figure, columns), axes


def mean_pressure(result: SphereContactResult) -> Drawing:
    """Draw the mean contact pressure against overlap."""
    unit, _ = result.units
    overlap = result["loading/overlap"]
    pressure = result["loading/mean_pressure"] / result.strength
    area = math.pi * result["loading/law_contact_radius"] ** 2
    law = result["loading/law_force"] / area / result.strength
    hertz = (
        result.hertz(overlap)
        / (math.pi * result.case.law.effective_radius * overlap)
        / result.strength
    )
    columns = {
        "overlap_normalised": overlap / unit,
        "finite_elements": pressure,
        "law": law,
        "hertz": hertz,
    }
    drawing, axes = _compared(result, columns, r"Mean pressure $\bar p/\sigma_\mathrm{y}$")
    axes.set(
        xscale="log",
        xlim=(RESOLVED, None),
        ylim=(0, 1.15 * pressure[overlap > unit].max(initial=pressure.max())),
    )
    axes.legend(loc="lower right")
    return drawing


def contact_area(result: SphereContactResult) -> Drawing:
    """Draw the contact area against overlap."""
    unit, _ = result.units
    overlap = result["loading/overlap"] / unit
    area_unit = result.case.law.effective_radius * unit
    area, law = (
        result[f"loading/{name}"] ** 2 / area_unit
        for name in ("contact_radius", "law_contact_radius")
    )
    columns = {"overlap_normalised": overlap, "finite_elements": area, "law": law}
    drawing, axes = _compared(result, columns, r"Contact area $A/A_\mathrm{y}$")
    axes.axline((0, 0), slope=1, color=GREY, linewidth=0.8, label="Hertz, Thornton")
    axes.set(xlim=(0, overlap.max()), ylim=(0, None))
    axes.legend(loc="upper left")
    return drawing


def unloading(result: SphereContactResult) -> Drawing | None:
    """Draw the normalised unloading curves; None without any."""
    curves = {}
    for n, cycle in enumerate(result.cycles):
        peak, residual, most = (
            result[f"cycles/{name}"][n]
            for name in ("peak_overlap", "residual_overlap", "peak_force")
        )
        overlap, force = (
            result[f"history/{name}"][result.branch(UNLOADING, cycle)]
            for name in ("overlap", "force")
        )
        scaled = (overlap - residual) / (peak - residual)
        curves[f"{peak / result.case.law.effective_radius:.3g}"] = scaled, force / most
    if not curves:
        return None
    drawing, axes = _family(curves, ("scaled_overlap", "force_over_peak"))
    if result.case.yields:
        grid = np.linspace(0, 1, 101)
        axes.plot(grid, grid**1.35, "--", color="black", label="$n$ = 1.35")
    abscissa = r"$(\alpha-\alpha_\mathrm{R})/(\alpha_\mathrm{max}-\alpha_\mathrm{R})$"
    label(axes, abscissa, r"Force $F/F_\mathrm{max}$", xlim=(0, 1), ylim=(0, 1))
    axes.legend(title=r"$\alpha_\mathrm{max}/R^*$", **_BESIDE)
    return drawing


def residual_overlap(result: SphereContactResult) -> Drawing | None:
    """Draw residual overlap and unloading exponent against the largest overlap; None without
    plastic unloading.
    """
    if not result.cycles or not result.plastic:
        return None
    unit, _ = result.units
    peak, residual, exponent = (
        result[f"cycles/{name}"] for name in ("peak_overlap", "residual_overlap", "exponent")
    )
    curve = np.geomspace(min(unit, peak.min()), peak.max(), _CURVE)
    figure, upper, lower = panels(3.6, rows=2, sharex=True, height_ratios=(2, 1))
    law = result.case.law.residual_overlap(curve)
    upper.loglog(
        peak / unit, residual / unit, "o", color=BLUE, markersize=4, label="finite elements"
    )
    upper.loglog(curve / unit, law / unit, "--", color=GREEN, label="contact law")
    label(
        upper,
        y=r"Residual overlap $\alpha_\mathrm{R}/\alpha_\mathrm{y}$",
        ylim=(0.3 * max(residual.min() / unit, 1e-2), None),
    )
    upper.legend(loc="upper left")
    lower.semilogx(peak / unit, exponent, "o", color=BLUE, markersize=4)
    lower.semilogx(curve / unit, result.case.law.unloading_exponent(curve), "--", color=GREEN)
    label(
        lower,
        r"Largest overlap $\alpha_\mathrm{max}/\alpha_\mathrm{y}$",
        "Exponent $n$",
        ylim=(1.2, 1.6),
    )
    columns = {"peak_overlap_m": peak, "residual_overlap_m": residual, "exponent": exponent}
    return Drawing(figure, columns | {"law_peak_overlap_m": curve, "law_residual_overlap_m": law})


def deviation(result: SphereContactResult) -> Drawing:
    """Draw the loading force with the law, and its deviation."""
    unit, force_unit = result.units
    overlap, force, law = (result[f"loading/{name}"] for name in ("overlap", "force", "law_force"))
    order = np.argsort(overlap)
    order = order[overlap[order] >= RESOLVED * unit]
    x = overlap[order] / unit
    figure, upper, lower = panels(3.8, rows=2, sharex=True, height_ratios=(3, 2))
    upper.loglog(x, force[order] / force_unit, color=BLUE, label="finite elements")
    upper.loglog(x, law[order] / force_unit, "--", color=GREEN, label="contact law")
    upper.set_ylabel(r"Force $F/F_\mathrm{y}$")
    upper.legend(loc="upper left")
    lower.axhline(0, color="black", linewidth=0.5)
    columns: dict[str, NDArray] = {
        "overlap_normalised": x,
        "force_N": force[order],
        "law_force_N": law[order],
    }
    for name, colour in (("force", BLUE), ("contact_radius", ORANGE)):
        values = result[f"deviation/{name}"][order]
        lower.semilogx(x, values, color=colour, linewidth=0.8, label=name.replace("_", " "))
        columns[f"{name}_deviation_percent"] = values
    label(
        lower, result.overlap_label, "Deviation from\nthe law (%)", xlim=(RESOLVED, float(x.max()))
    )
    lower.legend(loc="upper right", fontsize=7)
    return Drawing(figure, columns)


def quasi_static(result: SphereContactResult) -> Drawing:
    """Draw the non-static energies divided by the internal energy, and the force balance, during
    loading.
    """
    rows = result.branch(LOADING)
    overlap = result["history/overlap"] / result.units[0]
    rows = rows[(overlap[rows] >= RESOLVED) & (result["history/force"][rows] > 0)]
    rows = rows[np.argsort(overlap[rows], kind="stable")]
    x = overlap[rows]
    internal = (result["energy/elastic"] + result["energy/plastic"])[rows]
    figure, upper, lower = panels(3.6, rows=2, sharex=True, height_ratios=(3, 2))
    columns: dict[str, NDArray] = {"overlap_normalised": x}
    for name, colour in (
        ("kinetic", BLUE),
        ("hourglass", ORANGE),
        ("damping", GREEN),
        ("contact", PURPLE),
    ):
        columns[f"{name}_over_internal"] = share = result[f"energy/{name}"][rows] / internal
        upper.loglog(x, share, color=colour, linewidth=0.8, label=name)
    upper.set(ylabel="Energy / internal energy", ylim=(1e-6, None))
    upper.legend(ncols=2, fontsize=7)
    difference = (
        100 * (result["history/face_force"] / np.maximum(result["history/force"], 1e-300) - 1)[rows]
    )
    lower.semilogx(x, difference, color=GREY, linewidth=0.6)
    lower.axhline(0, color="black", linewidth=0.5)
    label(
        lower,
        result.overlap_label,
        "Force at the face /\ncontact force - 1 (%)",
        xlim=(RESOLVED, float(x.max())),
    )
    return Drawing(figure, columns | {"face_force_difference_percent": difference})


def von_mises(result: SphereContactResult) -> Drawing | None:
    """Draw the von Mises stress in both spheres at the largest overlap; None if the run did not
    reach it.
    """
    if "fields/von_mises" not in result.values:
        return None
    position = result["fields/position"] * _MILLI
    elements = result["fields/elements"]
    body = result["fields/body"]
    stress = result["fields/von_mises"] * _MEGA
    radius = result.summary["contact_radius_m"] * _MILLI
    scale = Normalize(0, float(stress.max()))
    reach = min(_SHOWN * radius, 1.05 * _MILLI * max(result.case.radii))
    figure, axes = one_panel(3.2, "r (mm)", "z (mm)")
    corners = position[elements]
    for half, up in (
        (0, 1),
        (int(body.max()), -1),
    ):  # the second half of equal spheres is a mirror image
        own = body == half
        quads = corners[own] - [
            0.0,
            position[elements[own].min(), 1],
        ]  # its first node is the contact point
        for side in (-1, 1):
            points = quads * [side, up]
            colours = {"array": stress[own], "cmap": FORCE_MAP, "norm": scale, "edgecolors": "face"}
            axes.add_collection(PolyCollection(points, linewidths=0.2, rasterized=True, **colours))
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    figure.colorbar(
        ScalarMappable(scale, FORCE_MAP), ax=axes, label="Von Mises stress (MPa)", shrink=0.8
    )
    axes.set_title(
        rf"$\alpha/R^*$ = {result['history/overlap'].max() / result.case.law.effective_radius:.3g}"
    )
    centre = corners.mean(axis=1) / _MILLI
    return Drawing(
        figure,
        {"body": body, "r_m": centre[:, 0], "z_m": centre[:, 1], "von_mises_Pa": stress / _MEGA},
    )


RESULT = SphereContactResult
#: Functions that draw a figure of a result, by name.
FIGURES: dict[str, Callable[[SphereContactResult], Drawing | None]] = {
    draw.__name__: draw
    for draw in (force_overlap, pressure_profiles, mean_pressure, contact_area, unloading, residual_overlap, deviation,
                 quasi_static, von_mises)
}  # fmt: skip
