"""First section of a report: the main result, in a sentence, a figure and a table."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from itertools import chain, product
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granwave.analysis.document.model import (
    Beside,
    Block,
    Cell,
    DocumentTable,
    Figure,
    Gallery,
    Group,
    Note,
    Part,
    TableColumn,
    column_table,
    in_unit,
    spread_cell,
    unit_of_value,
    value_column,
)
from granwave.analysis.formatting.numbers import column_unit, quantity_in
from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.measures.bead_wave import crest_speed
from granwave.analysis.measures.force_decay import ForceDecay, force_decay
from granwave.analysis.measures.incomplete_values import DISSIPATED_FRACTION, incomplete_in
from granwave.analysis.measures.leading_wave import stretch_speeds
from granwave.analysis.measures.regions import stretches
from granwave.analysis.measures.target_record import momentum_in_words, reached
from granwave.analysis.measures.zone_resolution import (
    error_of,
    is_unresolved,
    percent_with_error,
)
from granwave.analysis.quantities import SIZES_BY_LAYERS
from granwave.analysis.reports.comparison.blocks import comparison_blocks
from granwave.analysis.reports.comparison.comparison import Comparison
from granwave.analysis.reports.figures import picture_in
from granwave.analysis.reports.first_wave import course_of_beads, course_of_peaks
from granwave.analysis.reports.inputs import ReportInputs, ReportScan
from granwave.analysis.reports.kinds import ReportRun
from granwave.analysis.reports.results import value_rows
from granwave.analysis.reports.sentences import by_part, printed, sentences, share, value_table
from granwave.analysis.reports.setting import is_chain, origin_of, target_of
from granwave.analysis.result.reader import Result
from granwave.analysis.scans.headline import headline
from granwave.analysis.scans.keys import VariedKey
from granwave.analysis.scans.means import WORTH, Means
from granwave.analysis.summary_table import has_no_pairs
from granwave.lammps_inputs.case.added_grains import has_added_to_chain
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.files import regular
from granwave.lammps_inputs.packing.cylinders import in_grains
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY, RESULT_FILE

_MOST_COLUMNS = 5  # most columns of the table of means, keys and quantities together
_MOST_NAMED = 4  # most runs with a sentence each
_MOST_ROWS = 14  # most rows of the table of means; two keys with more are crossed
_MOST_OPEN = 3  # most scans whose figures and tables are not folded
_OF_THICK_PACKINGS = ("packing_3d", "wave_front", "peak_force_principal")
_THIN = 40.0  # length over width of a packing above which images of its grains are lines
#: Values of a run, in order; a row is shown if all its values are present.
_SENTENCES = (
    "The coefficient of restitution was {restitution}.",
    "The peak force on the target was {target_bore}.",
    "The peak force on the ground below it was {ground_bore}.",
    "The wave speed was {along_chain}.",
    "The wave speed along the beads was {along_beads} in the deeper half.",
    "The speed of the wave crest along the beads was {crest_along_beads} in the deeper half.",
    "The peak force between beads {decay_of_beads}.",
    "The peak force between beads above the static force {dynamic_decay_of_beads}.",
    "It {fit_of_beads}.",
    "The peak force of the wave {decay}.",
    "The peak force of the wave above the static force {dynamic_decay}.",
    "{absorbed_fraction} of the input energy of {energy_input_J} was absorbed by the absorbing "
    "boundary.",
    "{absorbed_so_far} of the input energy of {energy_input_J} was absorbed by the absorbing "
    "boundary by the end of the run, and this fraction still rises.",
    "{lost} of the input energy of {energy_input_J} was dissipated.",
    "{lost_so_far} of the input energy of {energy_input_J} was dissipated by the end of the run, "
    "and this fraction still rises.",
    "{transmission} of the velocity of the driven end, {driven_velocity_m_s}, was transmitted.",
    "The largest contact force was {peak_force_N}.",
    "The largest force between two spheres was {between_spheres}.",
    "The largest contact force, including walls, was {with_walls}.",
    "Contact forces {static}.",
    "90 % of the plastic dissipation is within {whole_depth} below the impact and {whole_radius} "
    "from its axis (whole layers and shells); interpolated between them, the 90 % depth is "
    "{zone_depth_90_interpolated_m} and the 90 % radius {zone_radius_90_interpolated_m}.",
    "90 % of the plastic dissipation is within {only_depth} below the impact and {only_radius} "
    "from its axis.",
    "The plate {plate}.",
    "None of the input energy of {kept} was dissipated.",
    "{n_loaded_contacts} of {n_contacts} contacts were loaded.",
    "{new_contacts} contacts were loaded.",
)
_ALONG_LINE = "Along the line {0} the front speed is {{line_{0}_front_speed_m_s}}."
_ONE_DECAY = "Its peak speed decays by {{line_{0}_decay_per_m}}."
_TWO_DECAYS = (
    "Its peak speed decays by {{line_{0}_decay_first_per_m}} up to "
    "{{line_{0}_decay_border_m}} from its first grain, and by "
    "{{line_{0}_decay_second_per_m}} beyond."
)
_SAME_DECAY = 0.1  # relative difference of two rates that are given as one
_SENSORS = (  # values of the sensors with the largest and smallest signal, with their names
    "Sensors recorded at most {{sensor_{0}_peak_velocity_m_s}} ({0}) and at least "
    "{{sensor_{1}_peak_velocity_m_s}} ({1})."
)
_ABSORBED = "absorbed_fraction"
_AT_BOTTOM = "The peak force on the bottom was {bottom_bore}."


def answer_blocks(
    inputs: ReportInputs,
    studied: Figure | None = None,
    comparison: Comparison | None = None,
    *,
    judged: bool = False,
) -> list[Block]:
    """Return the blocks: of each scan the dependence of its main quantity; of runs their main
    values.

    Parameters
    ----------
    studied
        Main figure of the studies of a scan, shown instead of the scan's figure.
    comparison
        Comparison of the runs, if there are several.
    judged
        True if studies state their result, so that a single scan does not.
    """
    found = [_of_scan(scan, inputs, studied) for scan in inputs.scans]
    if judged and len(inputs.items) == 1:
        found = [
            tuple(block for block in blocks if not isinstance(block, Note)) for blocks in found
        ]
    answers = [blocks for blocks in found if blocks]
    opened = answers if len(answers) <= _MOST_OPEN else answers[:1]
    blocks: list[Block] = []
    for answer in opened:
        blocks.extend(answer)
    if others := answers[len(opened) :]:
        parts = tuple(chain.from_iterable(others))
        blocks.append(Group(f"Main quantity of the other {len(others)} scans", parts, folded=True))
    if len(inputs.runs) == 1:
        return [*blocks, *_of_run(inputs.runs[0], inputs)]
    runs = [run for run in inputs.runs if run.has_balance]
    if len(runs) == 1:
        blocks += _of_run(runs[0], inputs)
    elif comparison is not None:
        blocks += comparison_blocks(comparison)
    for alike in by_part(inputs.runs):
        said = [f"{run.label}: {in_words(run)}" for run in alike[:_MOST_NAMED]]
        table = value_table(alike, alike[0].kind.title(alike[0]))
        blocks += [*(Note(text, "lead") for text in said), table]
    return blocks


def main_figures(inputs: ReportInputs, studied: Figure | None) -> set[Path]:
    """Return the paths of the figures that the blocks show, without a suffix; ``studied`` as of
    `answer_blocks`.
    """
    if studied:
        return set()
    items = inputs.items if len(inputs.runs) < 2 else inputs.scans
    paths = set[Path]()
    for item in items:
        paths.update(item.directory / FIGURES_DIRECTORY / name for name in _names(item)[:1])
    return paths


def _main_figure(item: ReportRun | ReportScan, inputs: ReportInputs) -> Figure | None:
    names = _names(item)
    return picture_in(item, names[0], inputs) if names else None


def _names(item: ReportRun | ReportScan) -> list[str]:
    """Return the names of the existing figures of the main quantity of a scan, or of a run, the
    best first.
    """
    if isinstance(item, ReportRun):
        left_out = item.kind.figures_of_others(item)
        if _is_thin(item):
            left_out = left_out.union(_OF_THICK_PACKINGS)
        first = ("target",) if target_of(item.case) else ()
        names = [name for name in (*first, *item.kind.main_figures) if name not in left_out]
    else:
        means = item.means
        main = [name for name, key in means.quantities()[:1] if means.varies(key)]
        keys = sorted(means.keys, key=lambda key: (not key.numeric, -len(set(key.values))))
        names = [f"{name}_vs_{key.slug}" for name, key in product(main, keys)]
    return [
        name for name in names if (item.directory / FIGURES_DIRECTORY / f"{name}.png").is_file()
    ]


def _is_thin(run: ReportRun) -> bool:
    """Return True for a long chain of grains; False for results without grains, or that cannot be
    read.
    """
    try:
        with h5py.File(regular(run.directory / RESULT_FILE), "r") as file:
            extents = np.sort(
                np.ptp(file["spheres/position"][()], axis=0)
                + 2 * np.max(file["spheres/radius"][()])
            )
    except (OSError, KeyError, ValueError):
        return False
    return bool(extents[-1] > _THIN * extents[-2])


# ---------------------------------------------------------------------- scans


def _of_scan(scan: ReportScan, inputs: ReportInputs, studied: Figure | None) -> tuple[Part, ...]:
    """Return the sentence, and, if anything varies, the figure and the table."""
    means = scan.means
    shown = means.quantities()
    pictures = (Gallery((studied,)),) if studied else ()
    if not shown:
        return pictures
    main = shown[0][1]
    name_of_scan = f"Scan {scan.label}: " if len(inputs.items) > 1 else ""
    sentence = Note(name_of_scan + headline(means), "lead")
    if not means.varies(main):
        return (sentence, *pictures)
    others = [key for _, key in shown[1:] if key != main][
        : max(_MOST_COLUMNS - 1 - len(means.keys), 1)
    ]
    # number of positions in the grid
    places = math.prod(len(set(key.values)) for key in means.keys)
    crossed = len(means.keys) == 2 and _MOST_ROWS < len(means.counts) >= places / 2
    table = _crossed(means, main) if crossed else _table(means, [main, *others])
    picture = studied or _main_figure(scan, inputs)
    if picture and picture.wide:
        return sentence, Gallery((picture,)), table
    return sentence, Beside(Gallery((picture,)), table) if picture else table


def _table(means: Means, shown: Sequence[str]) -> DocumentTable:
    rows = range(len(means.counts))
    columns = [
        (_column(key, means), [Cell(key.tick(row), key.values[row]) for row in rows])
        for key in means.keys
    ]
    columns += [_mean_column(means, name) for name in shown]
    return column_table(_caption(means, shown), columns, sortable=True)


def _mean_column(means: Means, name: str) -> tuple[TableColumn, list[Cell]]:
    """Return the column of the means of a quantity."""
    unit, size = column_unit(unit_of_value(name), means.values[name])
    cells = [_mean(means, name, row, size) for row in range(len(means.counts))]
    return value_column(name, means.called, unit), cells


def _crossed(means: Means, main: str) -> DocumentTable:
    """Make a table of the main quantity: rows by the key with more values, columns by the other."""
    down, across = sorted(means.keys, key=lambda key: len(set(key.values)), reverse=True)
    rows = range(len(means.counts))
    unit, size = column_unit(unit_of_value(main), means.values[main])
    cells = {(down.tick(row), across.tick(row)): _mean(means, main, row, size) for row in rows}
    first = {down.tick(row): Cell(down.tick(row), down.values[row]) for row in rows}
    columns = [(_column(down, means), list(first.values()))]
    for head in dict.fromkeys(across.tick(row) for row in rows):
        heading = (
            f"{in_grains(across.naming.label, means.called)} {head} {across.naming.unit}".rstrip()
        )
        column = (
            TableColumn(heading, numeric=True),
            [cells.get((name, head), Cell("")) for name in first],
        )
        columns.append(column)
    return column_table(
        f"{value_column(main, means.called, unit).title}. {_caption(means, [main])}",
        columns,
        sortable=True,
    )


def _mean(means: Means, name: str, row: int, size: float) -> Cell:
    """Return the mean of a quantity with its interval, in a unit of a size, with its marks."""
    mean = in_unit(means.values[name][row], size)
    cell = spread_cell(mean, in_unit(means.half_widths[name][row], size))
    marks = means.marks(name, row)
    return dataclasses.replace(cell, text=f"{cell.text} {marks}") if marks else cell


def _column(key: VariedKey, means: Means) -> TableColumn:
    return TableColumn(
        in_grains(key.naming.label, means.called), key.naming.unit, numeric=key.numeric, key=True
    )


def _caption(means: Means, shown: Sequence[str]) -> str:
    least = min(means.counts, default=1)
    most = max(means.counts, default=1)
    count = f"{least} to {most}" if least < most else str(most)
    caption = f"Means of {count} replicates, with 95 % confidence intervals"
    if most < 2:
        caption = "All points"
    remark = means.remark(shown)
    return f"{caption}. {remark}" if remark else caption


# ---------------------------------------------------------------------- runs


def _of_run(run: ReportRun, inputs: ReportInputs) -> list[Block]:
    said = in_grains(in_words(run), grains_called_in([run.summary]))
    blocks: list[Block] = [Note(said, "lead")] if said else []
    table = value_rows(run)
    picture = _main_figure(run, inputs)
    if not table.rows:
        return blocks
    return [*blocks, Beside(Gallery((picture,)), table) if picture else table]


def in_words(run: ReportRun) -> str:
    """Return the results of a run; the main result comes first."""
    if not run.has_balance:
        return run.kind.in_words(run)
    summary = run.summary
    values = printed(run.summary)
    lost = run.number(DISSIPATED_FRACTION)
    absorbed = run.number("absorbed_fraction") or 0.0
    if lost:
        error = error_of(DISSIPATED_FRACTION, summary)
        values["lost"] = percent_with_error(lost, error) if error else share(lost - absorbed)
    elif lost == 0:
        values["kept"] = values["energy_input_J"]
    if absorbed <= WORTH:
        values.pop("absorbed_fraction", None)
    _name_growing(summary, values)
    run.kind.name_values(run, values)
    _name_zone(run, values)
    _name_forces(run, values)
    _name_contacts(run, values)
    if "transmission" not in values:
        _name_wave(run, values)
    if (plate := run.number("plate_velocity_m_s")) is not None:
        values["plate"] = f"{'rebounds' if plate < 0 else 'still moves in'} at {abs(plate):.4g} m/s"
    values = {name: text for name, text in values.items() if text}
    lines = list[str]()
    for name in _named(summary, "line_", "_front_speed_m_s"):
        decay = _TWO_DECAYS if _has_two_decays(run, name) else _ONE_DECAY
        lines += [text.format(name) for text in (_ALONG_LINE, decay)]
    seen = {name: summary[f"sensor_{name}_peak_velocity_m_s"] or 0.0
            for name in _named(summary, "sensor_", "_peak_velocity_m_s")}  # fmt: skip
    ends = (
        [choose(seen, key=lambda name: seen[name]) for choose in (max, min)]
        if len(seen) > 1
        else []
    )
    sensors = [_SENSORS.format(*ends)] if ends else []
    return sentences([*_SENTENCES, *lines, *sensors, _AT_BOTTOM], values)


def _name_growing(summary: Mapping[str, Any], values: dict[str, str]) -> None:
    """Rename the fractions of the input energy that still grow at the end of a run."""
    growing = {name for name in incomplete_in(summary) if name.endswith("_fraction")}
    if _ABSORBED in growing and _ABSORBED in values:
        values["absorbed_so_far"] = values.pop(_ABSORBED)
    parts = growing - {DISSIPATED_FRACTION, _ABSORBED}
    has_growing_losses = DISSIPATED_FRACTION in growing and (
        bool(parts) or _ABSORBED not in growing
    )
    if has_growing_losses and "lost" in values:
        values["lost_so_far"] = values.pop("lost")


def _has_two_decays(run: ReportRun, line: str) -> bool:
    """Return True if the peak speed along a line decays by different rates in two regions."""
    first = run.number(f"line_{line}_decay_first_per_m")
    second = run.number(f"line_{line}_decay_second_per_m")
    if first is None or second is None:
        return False
    return abs(second - first) > _SAME_DECAY * max(abs(first), abs(second))


def _name_wave(run: ReportRun, values: dict[str, str]) -> None:
    """Add the speed of the wave along a chain, and the course of its peak forces; those of the
    beads if grains were added next to them.
    """
    if has_added_to_chain(origin_of(run.case)):
        values |= _of_beads(run, values.get("wave_speed_m_s", ""))
    elif is_chain(run.case):
        values["dynamic_decay" if _is_precompressed(run) else "decay"] = course_of_peaks(run)
        values["along_chain"] = _speeds(run, values.get("wave_speed_m_s", ""))


def _of_beads(run: ReportRun, speed: str) -> dict[str, str]:
    """Return the values of the sentences on the beads of a chain with added grains: speed of the
    wave, or of its crest where contacts are loaded from the start, and decay of the peak forces.

    Parameters
    ----------
    speed
        Of the front of the wave; empty if it is unknown.
    """
    values: dict[str, str] = {}
    try:
        with Result(run.results) as result:
            course = course_of_beads(result)
            crest = crest_speed(result)
            decay = force_decay(result)
    except (GranwaveError, KeyError, ValueError, IndexError):
        return values
    if speed:
        values["along_beads"] = speed
    elif crest is not None:
        values["crest_along_beads"] = quantity_in(crest, "m/s")
    if course and isinstance(decay, ForceDecay):
        values["fit_of_beads"] = (
            f"falls exponentially with the depth, by {decay.rate:.3g} per m (fit)"
        )
    values["dynamic_decay_of_beads" if _is_precompressed(run) else "decay_of_beads"] = course
    return values


def _name_forces(run: ReportRun, values: dict[str, str]) -> None:
    """Add the forces on the bottom and on the ground, compared with those without the packing.

    The compared force is the dynamic one, as in ``peak_reduction``: without the static force before
    the load.
    """
    force = run.number("wall_peak_force_N")
    if not force:
        return
    bare = run.number("unprotected_peak_force_N") if run.number("peak_reduction") else None
    if has_no_pairs(run.summary):
        bare = None
    dynamic = run.number("wall_dynamic_peak_force_N")
    reduction = run.number("peak_reduction")
    if dynamic is None and bare and reduction and _is_precompressed(run):
        dynamic = bare / reduction  # results of 1.0 and earlier
    bore = values["wall_peak_force_N"] + _compared(force, dynamic, bare) + _rise(run)
    values["target_bore" if target_of(run.case) else "bottom_bore"] = bore
    ground = run.number("ground_peak_force_N")
    bare = run.number("unprotected_ground_peak_force_N")
    if "target_bore" in values and ground and bare and ground != force:
        reduction = run.number("ground_peak_reduction")
        rise = bare / reduction if dynamic is not None and reduction else None
        values["ground_bore"] = values["ground_peak_force_N"] + _compared(ground, rise, bare)


def _name_contacts(run: ReportRun, values: dict[str, str]) -> None:
    """Leave out values of contacts between spheres where there are none, and say what the forces
    of a packing under a static load include.
    """
    if run.summary.get("n_contacts") == 0 and has_no_pairs(run.summary):
        values.pop("n_contacts", None)
    n_start = run.number("n_contacts") or 0.0
    if (run.number("n_loaded_contacts") or 0.0) > n_start and "n_contacts" in values:
        # some of these contacts were open at the start
        values.pop("n_contacts")
        values["new_contacts"] = values["n_loaded_contacts"]
    if _is_precompressed(run) and ("between_spheres" in values or "peak_force_N" in values):
        values["static"] = "include the static force"


def _name_zone(run: ReportRun, values: dict[str, str]) -> None:
    """Add the sizes of the plastic zone for the sentence with the interpolated sizes, or for the
    sentence of results of 1.0 and earlier, which lack them; none for a zone without depth or
    radius, or that is not resolved.
    """
    has_both = run.number("zone_depth_90_m") and run.number("zone_radius_90_m") is not None
    is_known = has_both and not is_unresolved(run.summary)
    has_interpolated = all(name in values for name in SIZES_BY_LAYERS.values())
    beginning = "whole" if has_interpolated else "only"
    for name in SIZES_BY_LAYERS:
        size = "depth" if "depth" in name else "radius"
        if is_known:
            values[f"{beginning}_{size}"] = values[name]


def _is_precompressed(run: ReportRun) -> bool:
    """Return True for a run under a static load."""
    return run.number("precompression_residual") is not None


def _compared(force: float, dynamic: float | None, bare: float | None) -> str:
    """Compare a force, or its dynamic part where it has a static one, with the force without the
    packing; empty if that is unknown.
    """
    if dynamic is None or not bare:
        return _beside(force, bare)
    comparison = _beside(dynamic, bare).removeprefix(", ")
    return f"; its dynamic part of {quantity_in(dynamic, 'N')} is {comparison}"


def _speeds(run: ReportRun, speed: str) -> str:
    """Return the wave speed of a chain, and in each stretch of one with several materials or
    diameters; empty if it is unknown.
    """
    if not speed:
        return ""
    try:
        with Result(run.results) as result:
            parts = stretch_speeds(result)
            is_uniform = not stretches(result)
    except (GranwaveError, KeyError, ValueError, IndexError):
        return speed
    if is_uniform:
        return speed
    named = "; ".join(f"{quantity_in(each, 'm/s')} in {name}" for name, each in parts.items())
    return f"{speed} in the deeper half of the chain" + (f" ({named})" if named else "")


def _beside(force: float, bare: float | None) -> str:
    """Compare a force with the force without the packing; empty if it is unknown."""
    if not bare:
        return ""
    change = force / bare - 1
    without = quantity_in(bare, "N")
    return f", {share(abs(change))} {'less' if change < 0 else 'more'} than the {without} without the packing"


def _rise(run: ReportRun) -> str:
    """Return a clause on a force on the bottom that may rise further after the end of a run; empty
    if it does not, or is not recorded.
    """
    try:
        with Result(run.results) as result:
            record = reached(result)
    except (GranwaveError, KeyError, ValueError):
        return ""
    if record is None:
        return ""
    if record.rises_at_end:
        return "; it is largest at the end of the run, and may rise further"
    return f"; {momentum_in_words(record)}" if record.awaits_momentum else ""


def _named(summary: Mapping[str, Any], start: str, end: str) -> list[str]:
    """Return the names of sensors or lines in keys of a summary with a common beginning and end."""
    return [
        key[len(start) : -len(end)]
        for key in summary
        if key.startswith(start) and key.endswith(end)
    ]
