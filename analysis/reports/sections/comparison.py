"""Section comparing runs with each other, and granular with continuum, as in thesis chapter 5."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from granwave.analysis.document.cells import BLANK, percent, show, spread_cell, value_cell
from granwave.analysis.document.model import Block, Cell, Column, Figure, Gallery, Note, Section, Table, Tone
from granwave.analysis.document.pictures import picture_of
from granwave.analysis.figures.style import style
from granwave.analysis.measures.zone.marks import Mark, bounds_in_words
from granwave.analysis.quantities import SHARES
from granwave.analysis.reports.inputs import Inputs
from granwave.analysis.studies.granular_continuum import both, continuum, forces, granular, zone
from granwave.analysis.studies.granular_continuum.drawings import drawings, lowest_velocity
from granwave.analysis.studies.granular_continuum.impacts import Continuum, Granular, Impacts, collect
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY

SLUG = "comparison"
_LAYERS = (1, 4, 8, 16)  # layers below the struck one for which the uniformity is given
_FIT_REMARK = (
    "The constants that the source prints cannot be those of its figure: at a normalised velocity of 94.9 they give "
    "more dissipation than there is input. With powers of ten that fit its units they are 9.45, -3.04 and 0.500; the "
    "last is the input itself, v0^2/2."
)
_CUT_REMARK = (
    "Where the zone reaches a bound (open marks in the figure), or still grew when the run ended, the outermost yield "
    "lies farther out than found: ≥. What holds 50 and 90 % lies far inside: between 36 x 36 x 18 and 72 x 72 x 36 "
    "spheres, struck at 10 and 40 m/s, its depth and radius differ by a layer at most and its volume by 5 %, that of "
    "99 % by 11 %."
)
_WAVE_REMARK = (
    "Half open marks: a wave could be back from a bound while the last part of the energy was dissipated. It matters "
    "little: in a block twice as wide and high, struck by 0.1 kg at 24 m/s, depth and radius differ by an element at "
    "most, 2 %, and the volume by 0.3 %."
)
_TONES: Mapping[Mark, Tone] = {Mark.NONE: "", Mark.WAVE: "note", Mark.CUT: "note"}


def comparison_section(inputs: Inputs) -> Section:
    """Make the section of the report; without blocks if there is nothing to compare."""
    impacts = impacts_of(inputs)
    figures = tuple(_pictures(impacts, inputs))
    tables = [table for table in _tables(impacts) if table is not None]
    if not figures:
        return Section("Comparison", SLUG, ())
    blocks: list[Block] = [Note(_lead(impacts)), Gallery(figures), *tables]
    return Section("Comparison", SLUG, tuple(blocks))


def impacts_of(inputs: Inputs) -> Impacts:
    """Return the impacts among the runs of a report that can be compared."""
    return collect((run.label, run.directory, run.summary) for run in inputs.whole())


def _lead(impacts: Impacts) -> str:
    parts = []
    if impacts.reference:
        case, many = impacts.reference[0].case, len(impacts.reference)
        size = " x ".join(map(str, case.packing.size))
        material = case.material.name or "one material"
        parts.append(
            f"Granular reference: {case.packing.kind} {size}, D = {show(1e3 * case.packing.diameter)} mm, {material}, "
            f"{many} {'velocities' if many > 1 else 'velocity'}; energies are normalised by F_y alpha_y = "
            f"{show(impacts.reference[0].law.yield_force * impacts.reference[0].law.yield_overlap)} J."
        )
    if impacts.continuum_reference:
        first = impacts.continuum_reference[0].case
        parts.append(
            f"Continuum reference: a punch of {show(1e3 * first.punch.diameter)} mm and {show(first.punch.mass)} kg on "
            f"{first.material.name or 'one material'}, {first.run.elements} elements; energies are normalised by "
            f"sigma_y^2 D^3/E = {show(first.energy_unit)} J."
        )
    summaries = [run.summary for run in impacts.granular] + [run.summary for run in impacts.continuum]
    seconds = sum(float(summary.get("wall_time_s") or 0) for summary in summaries)
    who = f"All {len(summaries)} runs" if len(summaries) > 1 else "The run"
    parts.append(f"{who} took {show(round(seconds))} s of computing.")
    return " ".join(parts)


def _pictures(impacts: Impacts, inputs: Inputs) -> Iterable[Figure]:
    with style():
        for name, caption, drawing in drawings(impacts):
            data = inputs.base / FIGURES_DIRECTORY / f"{name}.csv"
            link = inputs.link(data, f"{FIGURES_DIRECTORY}/{data.name}") if data.is_file() else None
            yield picture_of(drawing, f"comparison-{name.replace('_', '-')}", caption, link)


def _tables(impacts: Impacts) -> Iterable[Block | None]:
    yield _specific(impacts)
    yield from _zones(impacts)
    yield from _quadratic(impacts)
    yield _granular_scaling(impacts)
    yield _areas(impacts)
    yield _linear(impacts)
    yield _fronts(impacts)
    yield _continuum_scaling(impacts)
    yield _tapers(impacts)


def _specific(impacts: Impacts) -> Table | None:
    rows = tuple(
        (
            Cell(row.label, row.label),
            Cell(row.what),
            *map(value_cell, (row.energy, row.fraction, row.mass, 1e6 * row.bulk, row.per_mass, 1e-6 * row.per_volume)),
        )
        for row in both.specific(impacts)
    )
    columns = (
        Column("Run", key=True),
        Column("What"),
        Column("Input", "J", numeric=True),
        Column("Dissipated fraction", numeric=True),
        Column("Mass involved", "kg", numeric=True),
        Column("Volume involved, voids included", "cm³", numeric=True),
        Column("Dissipated per mass", "J/kg", numeric=True),
        Column("Dissipated per volume", "MJ/m³", numeric=True),
    )
    title = f"Dissipation per mass and volume of the material that does {100 * both.SHARE:.0f} % of it"
    return Table(title, columns, rows, sortable=True) if rows else None


def _quadratic(impacts: Impacts) -> Iterable[Block]:
    fit = granular.quadratic_fit(impacts)
    if fit is None:
        return
    columns = (
        Column("Constant", key=True),
        Column("Source, as printed", numeric=True),
        Column("Source, powers of ten put right", numeric=True),
        Column("Ours, with its standard deviation", numeric=True),
    )
    values = zip(granular.SOURCE_FIT, granular.SOURCE_FIT_RIGHT, fit.constants, fit.deviations, strict=True)
    rows = tuple(
        (Cell(f"D{n}"), value_cell(printed), value_cell(right), spread_cell(float(ours), float(deviation)))
        for n, (printed, right, ours, deviation) in enumerate(values)
    )
    yield Table(
        "Quadratic law of dissipation: D0 + D1 v0 + D2 v0² where the input is v0²/2 (thesis 5.17)", columns, rows,
        by_row=True,
    )  # fmt: skip
    yield Note(
        f"Fitted from a normalised velocity of {show(fit.lowest)} on, with equal relative weights; the largest misfit "
        f"there is {percent(100 * fit.misfit).lstrip('+')}. {_FIT_REMARK}"
    )


def _granular_scaling(impacts: Impacts) -> Table | None:
    rows = tuple(
        (Cell(row.name, row.name), value_cell(row.n), value_cell(row.largest)) for row in granular.collapse(impacts)
    )
    columns = (
        Column("Differs from the reference in", key=True), Column("Points", numeric=True),
        Column("Largest difference in dissipated fraction", numeric=True),
    )  # fmt: skip
    return Table("Granular scaling: at equal normalised velocity", columns, rows) if rows else None


def _zones(impacts: Impacts) -> Iterable[Block]:
    found = [*zone.packing_zones(impacts), *zone.continuum_zones(impacts)]
    if not found:
        return
    columns = (
        Column("Run", key=True),
        Column("What", key=True),
        Column("Input over sigma_y^2 D^3/E", numeric=True, key=True),
        *(Column(f"Depth {percent} %", "D", numeric=True) for percent in SHARES),
        Column("Outermost depth", "D", numeric=True),
        *(Column(f"Radius {percent} %", "D", numeric=True) for percent in SHARES),
        Column("Outermost radius", "D", numeric=True),
        *(Column(f"Volume {percent} %", "pi D^3/6", numeric=True) for percent in SHARES),
        Column("Zone reaches"),
        Column("Dissipated after waves came back", numeric=True),
    )
    rows = []
    for one in found:
        summary, tone = one.run.summary, _TONES[one.mark]
        depth, radius = (_size(*size, tone) for size in zip(one.outermost, one.open_ended, strict=True))
        rows.append(
            (
                Cell(one.run.label, one.run.label),
                Cell("granular" if isinstance(one.run, Granular) else "continuum"),
                value_cell(one.energy),
                *(_size(size, False, tone) for size in one.depth),
                depth,
                *(_size(size, False, tone) for size in one.radius),
                radius,
                *(_size(size, False, tone) for size in one.volume),
                Cell(bounds_in_words(summary.get("zone_cut")), tone=tone),
                value_cell(summary.get("wave_return_share"), tone=tone),
            )
        )
    title = "Plastic zone: what holds 50, 90 and 99 % of the energy of yielding, and the outermost yield"
    yield Table(title, columns, tuple(rows), sortable=True)
    if any(any(one.open_ended) for one in found):
        yield Note(_CUT_REMARK, "note")
    if any(one.mark is Mark.WAVE and isinstance(one.run, Continuum) for one in found):
        yield Note(_WAVE_REMARK, "note")


def _size(value: float | None, open_ended: bool, tone: Tone) -> Cell:
    """Return the cell of a size with four digits; ``open_ended``: the size is a lower bound."""
    if value is None:
        return value_cell(None)
    text = show(float(f"{value:.4g}"))
    return Cell(f"≥ {text}" if open_ended else text, value, tone)


def _areas(impacts: Impacts) -> Table | None:
    found = granular.area_table(impacts)
    spheres = sorted({count for _, fractions in found for count in fractions})
    columns = (
        Column("Input over F_y alpha_y", numeric=True, key=True),
        *(Column(f"Fraction, W = {count}", numeric=True) for count in spheres),
        Column("Largest difference", numeric=True),
    )
    rows = tuple(
        (
            value_cell(energy),
            *(value_cell(fractions[count]) if count in fractions else Cell(BLANK) for count in spheres),
            value_cell(max(fractions.values()) - min(fractions.values())),
        )
        for energy, fractions in found
    )
    return Table("Loading area: dissipated fraction at equal input energy", columns, rows) if rows else None


def _linear(impacts: Impacts) -> Table | None:
    found = forces.linearity(impacts, lowest=lowest_velocity(impacts))
    if found is None:
        return None
    columns = (
        Column("Depth from", "mm", numeric=True, key=True),
        Column("to", "mm", numeric=True),
        Column("Contacts", numeric=True),
        Column("5 %", numeric=True),
        Column("Median", numeric=True),
        Column("95 %", numeric=True),
    )
    rows = tuple(
        tuple(map(value_cell, (1e3 * row.top, 1e3 * row.bottom, row.n, row.low, row.median, row.high)))
        for row in forces.exponents_by_depth(found)
    )
    title = (
        f"Peak force against impulse: exponent over normalised velocities from {show(float(found.velocity[0]))} to "
        f"{show(float(found.velocity[-1]))} (1: proportional, as the thesis has it)"
    )
    return Table(title, columns, rows)


def _fronts(impacts: Impacts) -> Table | None:
    found = forces.fronts(impacts)
    columns = (
        Column("Normalised velocity", numeric=True, key=True), Column("Elastic from a depth of", "mm", numeric=True),
        *(Column(f"Uniformity, layer {n}", numeric=True) for n in _LAYERS),
    )  # fmt: skip
    rows = tuple(
        (
            value_cell(front.velocity),
            value_cell(None if front.elastic_from is None else 1e3 * front.elastic_from),
            *(value_cell(float(front.uniformity[n]) if n < len(front.uniformity) else None) for n in _LAYERS),
        )
        for front in found
    )
    title = "The front: mean over largest peak force of a layer, within the cone of the preferred directions"
    return Table(title, columns, rows) if rows else None


def _continuum_scaling(impacts: Impacts) -> Table | None:
    rows = tuple(
        (Cell(row.name, row.name), value_cell(row.energy), _percent(row.fraction), _percent(row.volume))
        for row in continuum.collapse(impacts)
    )
    columns = (
        Column("Differs from the reference in", key=True),
        Column("Input over sigma_y^2 D^3/E", numeric=True, key=True),
        Column("Difference in fraction", numeric=True),
        Column("Difference in volume", numeric=True),
    )
    return Table("Continuum scaling: at equal normalised energy", columns, rows, sortable=True) if rows else None


def _tapers(impacts: Impacts) -> Table | None:
    found = continuum.tapers(impacts)
    columns = (
        Column("Taper", "mm", numeric=True, key=True), Column("Dissipated fraction", numeric=True),
        Column("Plastic volume", "mm³", numeric=True), Column("Volume that ever yielded", "mm³", numeric=True),
    )  # fmt: skip
    rows = tuple(
        (
            value_cell(1e3 * taper),
            value_cell(run.fraction),
            value_cell(1e9 * float(run.summary["plastic_zone_volume_m3"])),
            value_cell(1e9 * float(run.summary["plastic_zone_volume_ever_m3"])),
        )
        for taper, run in found
    )
    title = "Continuum: taper of the punch's edge, two elements or more across it"
    return Table(title, columns, rows) if len(rows) > 1 else None


def _percent(share: float) -> Cell:
    return Cell(percent(100 * share), share)
