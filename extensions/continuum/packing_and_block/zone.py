"""Size of the plastic zone against energy, of packings and of the continuum: regions with 50, 90
and 99 % of the plastic dissipation.

Lengths are in diameters D of the spheres or of the punch, volumes in pi D^3/6, energies in
sigma_y^2 D^3/E.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray
from pandas import DataFrame, concat

from granwave.analysis.document.model import (
    Cell,
    DocumentTable,
    Note,
    TableColumn,
    Tone,
    named,
    show,
    value_cell,
)
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, ORANGE, Drawing
from granwave.analysis.measures.zone_resolution import is_unresolved
from granwave.analysis.measures.zone_size import Mark, bounds_in_words, mark_of
from granwave.analysis.quantities import SHARES
from granwave.analysis.scans.drawing import draw_marks, marked_marker, marks_of
from granwave.analysis.studies.study import Picture, numeric, table_of
from granwave.extensions.continuum.packing_and_block.figures import GRANULAR_ENERGY
from granwave.extensions.continuum.packing_and_block.impacts import (
    SAME,
    Impacts,
    energy_unit,
    omitted_in_words,
    rising,
)

UNRESOLVED = "not resolved"
_LEAST_DRAWN = 2  # zones of a figure
_ROUNDING = 1e-9  # relative difference of equal sizes
_MARKERS = "os^"  # markers of the fractions
_SIZES = {"depth": "Depth $/D$", "radius": "Radius $/D$", "volume": r"Volume $/(\pi D^3/6)$"}
_LOOKS: Mapping[str, tuple[str, str]] = {"packing": (BLUE, "-"), "continuum": (ORANGE, "--")}
_CUT_REMARK = (
    "Where the zone reaches a boundary{}, or was still growing at the end of the run, the total "
    "extent is a lower limit (≥)."
)
_IN_FIGURE = " (open markers in the figure)"
_WAVE_REMARK = (
    "{}a reflection from a boundary could arrive while the last part of the energy was dissipated, "
    "at most {:.2g} % of the plastic dissipation."
)
_WAVE_IN_FIGURE = "Half-open markers: "
_WAVE_IN_TABLE = "In some blocks "
_COMPARED_REMARK = (
    "Influence of the boundaries: {} computed in {} of different sizes. The largest differences "
    "between the two largest of each are, {}."
)
_NOT_COMPARED_REMARK = (
    "Influence of the boundaries: no impact was computed in two {} of different sizes, so that "
    "these runs do not show how much the boundaries change the extent with 50, 90 and 99 %."
)


def zones(impacts: Impacts) -> dict[str, DataFrame]:
    """Plastic zones by energy, of packings and of blocks.

    The packings consist of the spheres of the reference, and one sphere is impacted; for each
    energy the largest packing is used, of equal ones the packing of the reference.

    Returns
    -------
    dict
        Rows of runs under ``packing`` and ``continuum``, with the columns of the figure's data and
        of the run. Runs without sizes of the zone in their summaries are omitted.
    """
    zones_by_side = {
        "packing": _sizes("packing", _comparable(impacts)),
        "continuum": _sizes("continuum", impacts.continuum_reference),
    }
    if len(packings := zones_by_side["packing"]):
        is_other = ~packings["shape"].isin(impacts.reference["shape"])
        ranked = packings.assign(n_smaller=-packings.n_spheres, is_other=is_other)
        ranked = ranked.sort_values(["n_smaller", "is_other"], kind="stable")
        zones_by_side["packing"] = rising(ranked, "energy_J")
    return zones_by_side


def pictures(impacts: Impacts) -> Iterator[Picture]:
    """Sizes of the zone against energy, of packings and of blocks."""
    sides = {what: _resolved(side) for what, side in zones(impacts).items()}
    if sizes := _sizes_drawn(sides):
        markers = "Open markers"
        if (sides["packing"]["mark"] == Mark.CUT).all():
            markers = "Open markers, here all of packings"
        caption = (
            "Size of the plastic zone: extent of 50, 90 and 99 % of the plastic dissipation, in "
            "packings and blocks of the reference material with one impacted sphere. Depths and "
            "radii are those of whole layers and shells, not interpolated. "
            f"{markers}: the zone reaches a boundary. {_drawn_in_words(impacts, sides)}"
        )
        yield Picture("plastic_zone", caption, partial(_zone_sizes, sides, sizes))


def _drawn_in_words(impacts: Impacts, sides: Mapping[str, DataFrame]) -> str:
    """Return the runs of the lines, the packings that stand apart, and the runs of packings that
    are not drawn with their reasons.
    """
    packings = sides["packing"]
    lines = [packings[packings["shape"].isin(impacts.reference["shape"])], sides["continuum"]]
    names = [name for side in lines if len(side) for name in side["label"]]
    text = f"Lines join runs that differ only in the velocity. Reference: {named(names) or 'none'}"
    if apart := list(_apart(impacts, packings)):
        text += f"; other packings: {named(apart)}"
    omitted = omitted_in_words(impacts, packings)
    return f"{text}. Not drawn: {omitted}" if omitted else text


def _apart(impacts: Impacts, packings: DataFrame) -> Iterator[str]:
    """Return the names of other packings than that of the reference, a line each."""
    others = packings[~packings["shape"].isin(impacts.reference["shape"])]
    for _, runs in others.groupby("shape", sort=False):
        yield _name_of(runs)


def _name_of(runs: DataFrame) -> str:
    """Return the name of the runs of a line: their packing, for a single one the run."""
    return str(runs["label" if len(runs) == 1 else "packing"].iloc[0])


def _sizes_drawn(sides: Mapping[str, DataFrame]) -> list[str]:
    """Return the sizes that the figure shows, of resolved zones; empty if there is no figure."""
    every = concat(sides.values())
    if not len(sides["packing"]) or len(every) < _LEAST_DRAWN:
        return []
    return [name for name in _SIZES if (every.filter(regex=rf"^{name}_\d") > 0).any(axis=None)]


def _resolved(zones: DataFrame) -> DataFrame:
    """Return the zones whose sizes are not those of single elements."""
    return zones[zones["is_resolved"]] if len(zones) else zones


def tables(impacts: Impacts) -> Iterator[DocumentTable | Note]:
    """Sizes of all runs, and remarks on sizes limited by a boundary or by the end of the run."""
    rows: list[dict[str, Any]] = []
    sides = zones(impacts)
    is_drawn = bool(_sizes_drawn({what: _resolved(side) for what, side in sides.items()}))
    for side in sides.values():
        rows += side.to_dict("records")
    shown = {id(zone["run"]) for zone in rows}
    others = _sizes("packing", concat([impacts.other_substances, impacts.other_packings]))
    rows += [zone for zone in others.to_dict("records") if id(zone["run"]) not in shown]
    if not rows:
        return
    columns = (
        TableColumn("Run", key=True),
        TableColumn("What", key=True),
        *numeric("Input / (sigma_y^2 D^3/E)", key=True),
        *numeric(*((f"Depth {percent} %", "D") for percent in SHARES), ("Outermost depth", "D")),
        *numeric(*((f"Radius {percent} %", "D") for percent in SHARES), ("Outermost radius", "D")),
        *numeric(*((f"Volume {percent} %", "pi D^3/6") for percent in SHARES)),
        TableColumn("Zone reaches"),
        *numeric("Dissipated after reflections returned"),
    )
    caption = (
        "Plastic zone: extent with 50, 90 and 99 % of the plastic dissipation (whole layers and "
        "shells, not interpolated), and total extent"
    )
    yield table_of(caption, columns, map(_row, rows), sortable=True)
    is_open = [
        zone["outermost_depth_open_ended"] or zone["outermost_radius_open_ended"] for zone in rows
    ]
    if any(is_open):
        remark = _CUT_REMARK.format(_IN_FIGURE if is_drawn else "")
        yield Note(f"{remark} {_influence_of_bounds(impacts, 'packing')}", "note")
    shares = [
        zone["run"].value("wave_return_share")
        for zone in rows
        if zone["mark"] == Mark.WAVE and zone["what"] == "continuum"
    ]
    if shares:
        first = _WAVE_IN_FIGURE if is_drawn else _WAVE_IN_TABLE
        text = _WAVE_REMARK.format(first, 100 * max(shares))
        yield Note(f"{text} {_influence_of_bounds(impacts, 'continuum')}", "note")


def what_of(what: str, packing: str, material: object) -> str:
    """Describe a run for a row of a table: ``granular, fcc 24 x 24 x 12, brass``.

    Parameters
    ----------
    material
        Its name; anything but a text where it has none.
    """
    parts = [what, packing, material if isinstance(material, str) else ""]
    return ", ".join(filter(None, parts))


def _comparable(impacts: Impacts) -> DataFrame:
    """Return the runs in packings of any size that consist of the spheres of the reference and have
    one impacted sphere.
    """
    grains = impacts.granular
    first = impacts.reference[:1]
    alike = (
        (grains.struck_spheres == 1)
        & grains.substance.isin(first.substance)
        & grains.held.isin(first.held)
    )
    return grains[alike]


def differences_by_size(impacts: Impacts, what: str) -> DataFrame:
    """Return the relative differences of the sizes of the zone between the two largest packings, or
    blocks, for the same impact.

    Parameters
    ----------
    what
        ``packing`` or ``continuum``.

    Returns
    -------
    DataFrame
        A row for each impact, with columns ``depth_50``, ..., ``volume_99``; NaN where a size does
        not apply.
    """
    if what == "packing":
        runs = _comparable(impacts)
        extent = "n_spheres"
    else:
        runs = impacts.continuum
        runs = runs[runs.but_for_block.isin(impacts.continuum_reference.but_for_block)]
        extent = "block_volume"
    names = _columns()
    sizes = _sizes(what, runs)
    rows = []
    while len(sizes):
        energy = sizes.energy_J.iloc[0]
        alike = np.abs(sizes.energy_J / energy - 1) < SAME
        by_extent = sizes[alike].sort_values(extent, ascending=False, kind="stable")
        by_extent = by_extent.drop_duplicates(extent)
        sizes = sizes[~alike]
        if len(by_extent) > 1:
            largest = by_extent[names].iloc[0].to_numpy(float)
            smaller = by_extent[names].iloc[1].to_numpy(float)
            least = np.where(largest > 0, largest, math.nan)
            rows.append(np.abs(smaller / least - 1))
    return DataFrame(rows, columns=names)


def _influence_of_bounds(impacts: Impacts, what: str) -> str:
    """Return the changes of the sizes of the zone with the size of the packings or blocks."""
    bodies = {"packing": "packings", "continuum": "blocks"}[what]
    changes = differences_by_size(impacts, what).max()
    parts = []
    for share in SHARES:
        influences = []
        for name in _SIZES:
            change = changes[f"{name}_{share}"]
            if not math.isnan(change):
                percent = 100 * change if change > _ROUNDING else 0.0
                influences.append(f"{percent:.2g} % ({name})")
        if influences:
            parts.append(f"for {share} % of the dissipation, {', '.join(influences)}")
    if not parts:
        return _NOT_COMPARED_REMARK.format(bodies)
    n_impacts = len(differences_by_size(impacts, what))
    count = f"{n_impacts} impacts were" if n_impacts > 1 else "1 impact was"
    return _COMPARED_REMARK.format(count, bodies, "; ".join(parts))


def _sizes(what: str, runs: DataFrame) -> DataFrame:
    """Return the zones of runs; summaries of an older version without sizes are omitted."""
    rows = []
    for run in runs.to_dict("records"):
        summary = run["run"].summary
        diameter = run["diameter"]
        if summary.get(f"zone_volume_{SHARES[0]}_m3") is None:
            continue
        cut = summary.get("zone_cut") or ()
        growing = summary.get("zone_growing") or ()
        sphere_volume = math.pi * diameter**3 / 6
        sizes: dict[str, float] = {}
        for share in SHARES:
            sizes[f"depth_{share}"] = run["run"].value(f"zone_depth_{share}_m") / diameter
            sizes[f"radius_{share}"] = run["run"].value(f"zone_radius_{share}_m") / diameter
            sizes[f"volume_{share}"] = run["run"].value(f"zone_volume_{share}_m3") / sphere_volume
        for name, end in (("depth", "bottom"), ("radius", "sides")):
            outermost = run["run"].value(f"plastic_zone_{name}_m")
            sizes[f"outermost_{name}"] = outermost / diameter
            sizes[f"outermost_{name}_open_ended"] = int(end in cut or name in growing)
        is_resolved = not is_unresolved(summary)
        if not is_resolved:
            sizes = {name: 0 if name.endswith("open_ended") else math.nan for name in sizes}
        over = run["energy_J"] / energy_unit(DataFrame([run]).iloc[0])
        more = {"energy": over, "mark": int(mark_of(summary)), "is_resolved": is_resolved}
        rows.append(run | sizes | {"side": what} | more)
    return DataFrame(rows)


def _columns() -> list[str]:
    """Return the names of the columns of sizes: ``depth_50``, ..., ``volume_99``."""
    return [f"{name}_{share}" for name, share in itertools.product(_SIZES, SHARES)]


def _row(zone: dict[str, Any]) -> Iterator[Cell]:
    summary = zone["run"].summary
    tone: Tone = "note" if zone["mark"] else ""
    what = Cell(what_of(zone["what"], zone["packing"], zone["material"]))
    yield from (value_cell(zone["label"]), what, value_cell(zone["energy"]))
    for name in _SIZES:
        for column in (*(f"{name}_{share}" for share in SHARES), f"outermost_{name}"):
            if column in zone:
                value = zone[column]
                if not zone["is_resolved"]:
                    yield Cell(UNRESOLVED)
                    continue
                before = "≥ " if zone.get(f"{column}_open_ended") else ""
                text = before + show(float(f"{value:.4g}"))
                yield value_cell(None) if math.isnan(value) else Cell(text, value, tone)
    yield Cell(bounds_in_words(summary.get("zone_cut")), tone=tone)
    yield value_cell(summary.get("wave_return_share"), tone=tone)


def _zone_sizes(sides: Mapping[str, DataFrame], sizes: list[str]) -> Drawing:
    """Draw the depth, radius and volume with 50, 90 and 99 % of the plastic dissipation against the
    input energy; lines of several packings have their names.
    """
    figure, *axes_of_sizes = panels(3.1, len(sizes))
    sides_with_zones = {what: side for what, side in sides.items() if len(side)}
    for axes, name in zip(axes_of_sizes, sizes, strict=True):
        for what, side in sides_with_zones.items():
            for _, runs in side.groupby("shape", sort=False):
                _curves(axes, name, runs, *_LOOKS[what])
                if what == "packing" and side["shape"].nunique() > 1:
                    is_right = runs.energy.max() > side.energy.median()
                    _name_line(axes, runs, name, is_right=is_right)
        label(axes, r"$e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D^3)$", _SIZES[name], log="xy")
        _axis_of_contacts(axes, sides["packing"].iloc[0])
    lines: list[dict[str, Any]] = [
        {"color": _LOOKS[what][0], "linestyle": _LOOKS[what][1], "label": what}
        for what in sides_with_zones
    ]
    lines += [
        {
            "color": "black",
            "marker": marker,
            "linestyle": "none",
            "markersize": 4,
            "label": f"{percent} %",
        }
        for marker, percent in zip(_MARKERS, SHARES, strict=True)
    ]
    lines.append({"color": "black", "linestyle": ":", "linewidth": 0.9, "label": "outermost yield"})
    marks = marks_of(concat(sides_with_zones.values())["mark"].tolist())
    lines += [
        {"label": text, **marked_marker(mark, "o", 4, "black")} for mark, text in marks.items()
    ]
    handles = [Line2D([], [], **line) for line in lines]
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=len(handles),
        fontsize=6.5,
        columnspacing=1.0,
    )
    names = ["side", "energy", "mark", *_columns()]
    for name in ("depth", "radius"):
        names += [f"outermost_{name}", f"outermost_{name}_open_ended"]
    table = concat(sides_with_zones.values())[names].rename(
        columns={"side": "what", "energy": "energy_normalised"}
    )
    return Drawing(figure, table.to_dict("list"))


def _curves(axes: Axes, name: str, zones: DataFrame, colour: str, line: str) -> None:
    """Draw one size of the zones of packings or blocks, and the distance of the outermost yielding;
    gaps where nothing yielded.
    """
    for share, marker in zip(SHARES, _MARKERS, strict=True):
        y = zones[f"{name}_{share}"].replace(0.0, math.nan)
        axes.plot(
            zones.energy,
            y,
            linestyle=line,
            color=colour,
            marker=marker,
            markersize=4,
            linewidth=0.8,
        )
        draw_marks(axes, zones.energy, y, zones["mark"], marker, 4, colour)
    if name != "volume":
        axes.plot(
            zones.energy,
            zones[f"outermost_{name}"].replace(0.0, math.nan),
            ":",
            color=colour,
            linewidth=0.9,
        )


def _name_line(axes: Axes, runs: DataFrame, name: str, *, is_right: bool) -> None:
    """Write the name of a line next to its last point with 99 % of the dissipation.

    Parameters
    ----------
    is_right
        True for a point in the right half, whose name is to its left.
    """
    last = runs.iloc[-1]
    height = last[f"{name}_{SHARES[-1]}"]
    if height > 0:
        axes.annotate(
            _name_of(runs),
            (last.energy, height),
            xytext=(-5, 0) if is_right else (5, 0),
            textcoords="offset points",
            fontsize=6.5,
            ha="right" if is_right else "left",
            va="center",
        )


def _axis_of_contacts(axes: Axes, packing: Any) -> None:
    """Add an axis at the top with the energies of the packing in F_y alpha_y."""
    factor = packing.energy_normalised / packing.energy
    axes.tick_params(axis="x", which="both", top=False)

    def forward(energy: ArrayLike) -> NDArray[np.float64]:
        return factor * np.asarray(energy, float)

    def inverse(normalised: ArrayLike) -> NDArray[np.float64]:
        return np.asarray(normalised, float) / factor

    top = axes.secondary_xaxis("top", functions=(forward, inverse))
    top.set_xlabel(GRANULAR_ENERGY.removeprefix("Input energy ") + ", packing", fontsize=7)
    top.tick_params(labelsize=7)
    low, high = forward(axes.get_xlim())
    # otherwise the interval of the axis below is updated only when the figure is drawn
    top.xaxis.set_view_interval(low, high, ignore=True)
