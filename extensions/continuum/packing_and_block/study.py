"""Impacts on packings and on blocks in one report: their comparison, and the scaling of both."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from pandas import DataFrame

from granwave.analysis.document.model import (
    Cell,
    DocumentTable,
    Note,
    TableColumn,
    named,
    percent,
    show,
    spread_cell,
)
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.incomplete_values import DISSIPATED_FRACTION
from granwave.analysis.measures.zone_resolution import error_of, is_unresolved
from granwave.analysis.studies.runs import AnyRun, FinishedRun
from granwave.analysis.studies.study import Picture, numeric, table_of
from granwave.extensions.continuum.packing_and_block import figures, zone
from granwave.extensions.continuum.packing_and_block.impacts import (
    Curves,
    Impacts,
    QuadraticLaw,
    area_table,
    by_area,
    collect,
    energy_unit,
    equal,
    involved,
    largest,
    masses,
    materials,
    not_ideal,
    omitted_in_words,
    quadratic_fit,
    rising,
    variants,
)

TITLE = "Comparison"
_ELSEWHERE = (
    "Impacts on ideal packings are compared here; all other runs are in the tables above and below"
)
_REFERENCE_ONLY = (
    "The quadratic law, the peak force against impulse and the front are computed for the "
    "reference ({}). Excluded: {}."
)
_NOT_LISTED = "Not in the table of the dissipation per mass and volume"
_NOTHING = "nothing was dissipated"
_UNRESOLVED_REMARK = (
    "Plastic zones of a few elements are not resolved: {}. Their size, and the dissipation per "
    "mass and volume, would be those of the elements, and are omitted. Use more run.elements, or "
    "a smaller run.edge_size."
)
_OF_VOLUME = 4  # values of a run that follow from the volume of its zone
SHARE = 0.9  # fraction of the dissipation that takes place in the material called involved
_HOW_MANY = {1: "The run", 2: "Both runs"}  # by number of runs, in a sentence
_FEWEST_ON_CURVE = 3  # smallest number of impacts on a curve of a figure of similarity
_GRANULAR_SHOWN = 3  # largest number of packings in the figure of volumes
_GRANULAR_LISTED = 6  # largest number of packings in the table
_FEW_VOLUMES = f"only {_GRANULAR_SHOWN} runs of the reference are drawn"
_OTHERS_LISTED = 24  # largest number of impacts with other materials, diameters or loading areas
_FIT_REMARK = (
    "D2 is 0.5 if fast impacts dissipate all their energy: {:.3g} to {:.3g} of the input in the "
    "fitted runs. A constant is undetermined if its standard deviation is as large as its value."
)
_CAPTIONS = {
    "dissipated_fraction": "Dissipated fraction, granular and continuum. At equal input the higher "
    "curve dissipates a larger fraction",
    "plastic_volume": "Volume involved, granular and continuum. At equal dissipated fraction the "
    "higher curve spreads the dissipation over more material",
    "granular_scaling": "Granular: runs with other diameters, densities, moduli or yield "
    "strengths. Where similarity holds, all points lie on the curve of the reference on the normalised axis",
    "granular_velocity": "Granular: dissipation against velocity. The curve is the quadratic law, fitted to "
    "the fast impacts; where D2 is 0.5 the fraction of faster impacts tends to 1",
    "loading_area": "Granular: number of impacted spheres. If points differ from the curve of "
    "one sphere, the loading area has an effect at equal input",
    "continuum_scaling": "Continuum: modulus and yield strength. Where similarity holds, all points lie on "
    "one curve on the normalised axis",
    "continuum_mass": "Continuum: mass of the punch. If curves differ at equal input, the "
    "velocity has an effect in addition to the energy",
}


def can_compare(runs: Sequence[AnyRun[Any]]) -> bool:
    """Return True if there are impacts to compare."""
    impacts = collect(runs)
    return len(impacts.granular) + len(impacts.continuum) > 1


def remarks(runs: Sequence[AnyRun[Any]]) -> Iterator[Note]:
    """Name the runs of packings that are not compared, grouped by the reason."""
    left_out: dict[str, list[str]] = {}
    for run in runs:
        if isinstance(run, FinishedRun) and (reason := not_ideal(run)):
            left_out.setdefault(reason, []).append(run.label)
    if left_out:
        listed = "; ".join(f"{named(labels)} ({reason})" for reason, labels in left_out.items())
        yield Note(f"{_ELSEWHERE}: {listed}.", "note")


def select(runs: Sequence[AnyRun[Any]]) -> list[Impacts]:
    """All comparable impacts, as one group."""
    impacts = collect(runs)
    return [impacts] if len(impacts.granular) or len(impacts.continuum) else []


def text(impacts: Impacts) -> str:
    """The references, the units of energy, and the wall time."""
    parts = []
    many = len(impacts.reference)
    if many:
        first = impacts.reference.iloc[0]
        packing = first.run.case.packing
        parts.append(
            f"Granular reference: {packing.kind} {' × '.join(map(str, packing.size))}, D = "
            f"{show(1e3 * packing.diameter)} mm, {first.material or 'one material'}, {many} "
            f"{'velocities' if many > 1 else 'velocity'}; energies are normalised by F_y alpha_y = "
            f"{show(float(first.energy_J / first.energy_normalised))} J."
        )
    if len(impacts.continuum_reference):
        first = impacts.continuum_reference.iloc[0]
        parts.append(
            f"Continuum reference: a punch of {show(1e3 * first.diameter)} mm and "
            f"{show(first.mass_kg)} kg on {first.material or 'one material'}, "
            f"{first.run.case['run']['elements']} elements; energies are normalised by sigma_y^2 "
            f"D^3/E = {show(float(energy_unit(first)))} J."
        )
    runs: list[Any] = []
    for table in (impacts.granular, impacts.continuum):
        if len(table):
            runs += list(table.run)
    seconds = sum(float(run.summary.get("wall_time_s") or 0) for run in runs)
    if seconds >= 1:
        who = _HOW_MANY.get(len(runs), f"The {len(runs)} runs")
        parts.append(f"{who} took {show(round(seconds))} s of computing time.")
    return " ".join(parts)


def pictures(impacts: Impacts) -> Iterator[Picture]:
    """Packings and blocks side by side, then packings and blocks alone with their varied
    parameters.
    """
    grains = impacts.reference
    blocks = impacts.continuum_reference
    if len(grains) and len(blocks):
        picture = _picture("dissipated_fraction", figures.dissipated_fraction, impacts)
        yield figures.with_runs(picture, figures.drawn_fractions(impacts), "")
        shown = _dissipating(grains, _GRANULAR_SHOWN)
        resolved = blocks[blocks.resolved]
        if len(shown) and len(resolved):
            picture = _picture("plastic_volume", figures.plastic_volume, shown, resolved)
            omitted = omitted_in_words(impacts, shown, _FEW_VOLUMES)
            yield figures.with_runs(picture, pd.concat([shown, resolved]), omitted)
    yield from zone.pictures(impacts)
    if len(grains):
        yield from _pictures_of_packings(impacts)
    yield from figures.pictures(impacts)
    if len(blocks):
        yield from _pictures_of_blocks(impacts)


def _pictures_of_packings(impacts: Impacts) -> Iterator[Picture]:
    """Dissipation of packings whose material, velocity or loading area was varied."""
    curves = variants(impacts)
    if _show_scaling(curves):
        yield _picture("granular_scaling", figures.scaling, curves, figures.GRANULAR_ENERGY, "log")
    fit = quadratic_fit(impacts)
    if fit:
        picture = _picture("granular_velocity", figures.against_velocity, impacts.reference, fit)
        yield figures.with_runs(
            picture, impacts.reference, omitted_in_words(impacts, impacts.reference)
        )
    areas = by_area(impacts)
    if len(areas) > 1:
        yield _picture("loading_area", figures.loading_area, areas)


def _pictures_of_blocks(impacts: Impacts) -> Iterator[Picture]:
    """Dissipation of blocks whose material or punch was varied."""
    curves = materials(impacts)
    if _show_scaling(curves):
        yield _picture(
            "continuum_scaling", figures.scaling, curves, figures.CONTINUUM_ENERGY, "linear"
        )
    curves = masses(impacts)
    if len(curves) > 1:
        yield _picture("continuum_mass", figures.by_mass, curves)


def _show_scaling(curves: Curves) -> bool:
    """Return True for several curves, of which the reference has enough points to be one."""
    reference = next(iter(curves.values()), ())
    return len(curves) > 1 and len(reference) >= _FEWEST_ON_CURVE


def _picture(name: str, draw: Callable[..., Drawing], *arguments: Any) -> Picture:
    """Picture with this name and its caption."""
    return Picture(name, _CAPTIONS[name], partial(draw, *arguments))


def tables(impacts: Impacts) -> Iterator[DocumentTable | Note]:
    """Packings and blocks side by side, then packings and blocks alone, with notes."""
    listed = pd.concat(
        [
            _dissipating(impacts.reference, _GRANULAR_LISTED),
            impacts.other_substances[:_OTHERS_LISTED],
            impacts.other_packings,
            impacts.continuum_reference,
        ]
    )
    rows = list(_rows_per_mass(listed))
    numbers = numeric(
        ("Input", "J"), "Dissipated fraction", ("Mass involved", "kg"), ("Volume involved, voids included", "cm³"),
        ("Dissipated per mass", "J/kg"), ("Dissipated per volume", "MJ/m³"),
    )  # fmt: skip
    if rows:
        caption = f"Dissipation per mass and volume of the material with {100 * SHARE:.0f} % of the dissipation"
        yield table_of(
            caption,
            (TableColumn("Run", key=True), TableColumn("What"), *numbers),
            rows,
            sortable=True,
        )
        if omitted := _unlisted(impacts, listed, {row[0] for row in rows}):
            yield Note(f"{_NOT_LISTED}: {omitted}.", "note")
    yield from _resolution(impacts.continuum)
    yield from zone.tables(impacts)
    if len(impacts.reference):
        yield from _of_packings(impacts)
    yield from figures.tables(impacts)
    if len(impacts.reference) and (omitted := omitted_in_words(impacts, impacts.reference)):
        names = named(impacts.reference["label"].tolist())
        yield Note(_REFERENCE_ONLY.format(names, omitted))
    if len(impacts.continuum):
        yield from _of_blocks(impacts)


def _unlisted(impacts: Impacts, listed: DataFrame, labels: Collection[str]) -> str:
    """Return the names of the runs without a row, with their reasons; empty if there is none.

    Parameters
    ----------
    listed
        Runs of the table, also without dissipation.
    labels
        Names of the rows.
    """
    omitted: dict[str, list[str]] = {}
    runs = pd.concat([impacts.granular, impacts.continuum])
    for _, run in runs[~runs["label"].isin(labels)].iterrows():
        omitted.setdefault(_why_unlisted(impacts, listed, run), []).append(run.label)
    return "; ".join(f"{named(names)} ({reason})" for reason, names in omitted.items())


def _why_unlisted(impacts: Impacts, listed: DataFrame, run: pd.Series) -> str:
    """Return the reason for which a run has no row; parameters as of `_unlisted`."""
    if not run.dissipated_fraction:
        return _NOTHING
    if run.label in set(listed["label"]):
        return f"{_NOTHING} by yielding, or the result cannot be read"
    if run.what == "continuum":
        return "not among the reference of the blocks, or an equal impact is"
    if run.label not in set(impacts.like_reference["label"]):
        return "another packing"
    if run.label in set(impacts.other_substances["label"]):
        return f"only {_OTHERS_LISTED} runs outside the reference are listed"
    rows = listed[listed["label"].isin(impacts.reference["label"])]
    if run.energy_J < rows.energy_J.min() and len(rows) >= _GRANULAR_LISTED:
        return f"of the reference only {_GRANULAR_LISTED} runs of high input energy are listed"
    return "its input energy is within a factor of 2 of that of a listed run"


def _resolution(blocks: DataFrame) -> Iterator[Note]:
    """Name the blocks whose plastic zone the mesh does not resolve."""
    if not len(blocks):
        return
    unresolved = blocks[~blocks.resolved]
    if len(unresolved):
        labels = named(unresolved["label"].tolist())
        yield Note(_UNRESOLVED_REMARK.format(labels), "note")


def _dissipating(reference: DataFrame, most: int) -> DataFrame:
    """Runs that dissipate, with the largest energy among them, whose energies are a factor of two
    or more apart; in rising order.
    """
    chosen: list[int] = []
    energy = reference.get("energy_J", pd.Series(dtype=float)).to_numpy()
    for n in reversed(range(len(reference))):
        apart = not chosen or energy[n] < 0.5 * energy[chosen[-1]]
        if apart and len(chosen) < most and reference.dissipated_fraction.iloc[n] > 0:
            chosen.append(n)
    return reference.iloc[chosen[::-1]]


def _per_mass(run: Any) -> tuple[Any, ...] | None:
    """Row of the table of dissipation per mass and volume; None if nothing was dissipated."""
    elements = involved(run)
    if elements is None:
        return None
    what = Cell(zone.what_of(run.what, run.packing, run.material))
    if is_unresolved(run.run.summary):
        lost = spread_cell(run.dissipated_fraction, error_of(DISSIPATED_FRACTION, run.run.summary))
        return run.label, what, run.energy_J, lost, *[Cell(zone.UNRESOLVED)] * _OF_VOLUME
    fraction, volume = elements.part(SHARE)
    energy = fraction * run.energy_J
    mass = volume * run.density
    bulk = volume / run.solid_fraction
    values = (
        run.energy_J,
        run.dissipated_fraction,
        mass,
        1e6 * bulk,
        energy / mass,
        1e-6 * (energy / bulk),
    )
    return run.label, what, *values


def _rows_per_mass(runs: DataFrame) -> Iterator[tuple[Any, ...]]:
    """Rows of the runs for which `Impacts.involved` is known."""
    for run in runs.itertuples():
        row = _per_mass(run)
        if row:
            yield row


def _of_packings(impacts: Impacts) -> Iterator[DocumentTable | Note]:
    """Quadratic law, collapse of the curves on normalised axes, and loading area."""
    fit = quadratic_fit(impacts)
    if fit:
        yield from _fit_of_velocities(impacts, fit)
    rows: list[tuple[Any, ...]] = []
    for name, runs in list(variants(impacts).items())[1:]:
        pairs = equal(runs, impacts.reference, "velocity_normalised")
        if len(pairs):
            gaps = (pairs.dissipated_fraction - pairs.dissipated_fraction_).abs()
            rows.append((name, len(pairs), float(gaps.max())))
    if rows:
        numbers = numeric("Points", "Largest difference in dissipated fraction")
        columns = (TableColumn("Differs from the reference in", key=True), *numbers)
        yield table_of("Granular scaling: at equal normalised velocity", columns, rows)
    areas = area_table(by_area(impacts))
    if len(areas):
        numbers = numeric(*(f"Fraction, W = {count}" for count in areas), "Largest difference")
        rows = []
        for energy, fractions in areas.iterrows():
            cells = [None if math.isnan(fraction) else fraction for fraction in fractions]
            rows.append((energy, *cells, float(np.ptp(fractions.dropna()))))
        columns = (*numeric("Input / (F_y alpha_y)", key=True), *numbers)
        yield table_of("Loading area: dissipated fraction at equal input energy", columns, rows)


def _fit_of_velocities(impacts: Impacts, fit: QuadraticLaw) -> Iterator[DocumentTable | Note]:
    """Constants of the quadratic law, and their range of velocities."""
    caption = "Quadratic law of dissipation: D0 + D1 v0 + D2 v0² where the input is v0²/2"
    value = numeric("Value, with its standard deviation")
    columns = (TableColumn("Constant", key=True), *value)
    cells = map(spread_cell, fit.constants.tolist(), fit.deviations.tolist())
    yield table_of(caption, columns, zip(("D0", "D1", "D2"), cells, strict=True), by_row=True)
    fractions = impacts.fast.dissipated_fraction
    remark = _FIT_REMARK.format(fractions.min(), fractions.max())
    yield Note(
        f"Fitted from a normalised velocity of {show(fit.lowest)} on, with equal relative weights; "
        f"the largest misfit there is {percent(100 * fit.misfit).lstrip('+')}. {remark}"
    )


def _of_blocks(impacts: Impacts) -> Iterator[DocumentTable]:
    """Collapse of the curves on normalised axes, and influence of the taper.

    At the same ratio of yield strength to modulus the differences are rounding errors. At another
    ratio the rounded edge of the punch is larger or smaller relative to the displacements. This
    matters if little more than the edge touches.
    """
    rows: list[tuple[Any, ...]] = []
    for name, runs in list(materials(impacts).items())[1:]:
        pairs = equal(runs, impacts.continuum_reference, "energy_normalised")
        for pair in pairs.itertuples():
            if pair.dissipated_fraction_ and pair.volume_over_sphere_volume_:
                fraction = pair.dissipated_fraction / pair.dissipated_fraction_ - 1
                volume = pair.volume_over_sphere_volume / pair.volume_over_sphere_volume_ - 1
                rows.append((name, pair.energy_normalised, _percent(fraction), _percent(volume)))
    if rows:
        columns = (
            TableColumn("Differs from the reference in", key=True),
            *numeric("Input / (sigma_y^2 D^3/E)", key=True),
            *numeric("Difference in fraction", "Difference in volume"),
        )
        yield table_of(
            "Continuum scaling: at equal normalised energy", columns, rows, sortable=True
        )
    fine = impacts.continuum[(impacts.continuum.taper != 0) & impacts.continuum.fine]
    tapers = rising(largest(fine, "but_for_taper"), "taper")
    if len(tapers) > 1:
        numbers = numeric(
            "Dissipated fraction", ("Plastic volume", "mm³"), ("Volume that ever yielded", "mm³")
        )
        rows = []
        for run in tapers.itertuples():
            volume = run.run.value("plastic_zone_volume_m3")
            volume_ever = run.run.value("plastic_zone_volume_ever_m3")
            rows.append((1e3 * run.taper, run.dissipated_fraction, 1e9 * volume, 1e9 * volume_ever))
        caption = "Continuum: taper of the punch's edge, two elements or more across it"
        yield table_of(caption, (*numeric(("Taper", "mm"), key=True), *numbers), rows)


def _percent(share: float) -> Cell:
    return Cell(percent(100 * share), share)
