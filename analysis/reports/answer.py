"""First section of a report: what came out, in a sentence, a figure and a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.model import (
    Beside,
    Block,
    Cell,
    Column,
    Figure,
    Gallery,
    Group,
    Note,
    Part,
    Table,
    label_of,
    spread_cell,
    value_column,
)
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.quantities import quantity
from granwave.analysis.reports import other_kinds
from granwave.analysis.reports.figures import of_other_kinds, overlay, picture_in
from granwave.analysis.reports.inputs import Inputs, Run, Scan
from granwave.analysis.reports.other_kinds import by_kind, share
from granwave.analysis.reports.results import compact_table, value_rows
from granwave.analysis.reports.setting import target_of
from granwave.analysis.result.reader import Result
from granwave.analysis.scans.keys import WORTH, Key, Means
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.packing.cylinders import in_grains
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY, RESULT_FILE

_MOST_COLUMNS = 5  # of the table of means, keys and quantities together
_MOST_NAMED = 4  # runs whose values a sentence lists
_MOST_ROWS = 14  # of that table; two keys with more are crossed
_MOST_OPEN = 3  # scans whose figures and tables are not folded away
_MAIN_FIGURES = (
    "bands", "density_of_states", "amplitude_sweep", "transmission", "packing_3d", "force_map", "wave_front",
    "peak_force_principal", "along_chain", "plastic_strain", "von_mises", "force_network", "peak_force_depth",
    "energies",
)  # fmt: skip
_OF_THICK_PACKINGS = ("packing_3d", "wave_front", "peak_force_principal")
_THIN = 40.0  # length over width of a row from which pictures of its grains are lines
_FEW = 0.5  # of the contacts
_KEPT = 0.1  # relative change of a peak force along a chain that is none
_REACHED = 1e-3  # of the largest peak force: contacts that the wave has reached


def answer_blocks(inputs: Inputs, studied: Figure | None = None, *, judged: bool = False) -> list[Block]:
    """Return the blocks: of each scan the dependence of its main quantity; of runs their main values.

    Parameters
    ----------
    studied
        Main figure of the studies of a scan, shown in place of its own.
    judged
        Studies have said what they come to, so that a scan alone need not.
    """
    found = [_of_scan(scan, inputs, studied) for scan in inputs.scans]
    if judged and len(inputs.items) == 1:
        found = [tuple(block for block in blocks if not isinstance(block, Note)) for blocks in found]
    answers = [blocks for blocks in found if blocks]
    opened = answers if len(answers) <= _MOST_OPEN else answers[:1]
    blocks: list[Block] = [block for answer in opened for block in answer]
    if others := answers[len(opened) :]:
        parts = tuple(block for answer in others for block in answer)
        blocks.append(Group(f"The other {len(others)} scans, each by its main quantity", parts, folded=True))
    if len(inputs.runs) == 1:
        return [*blocks, *_of_run(inputs.runs[0], inputs)]
    if runs := [run for run in inputs.runs if run.has_balance]:
        blocks += [Note(text, "lead") for text in [_of_runs_in_words(runs)] if text]
        table = compact_table(runs)
        drawn = overlay(runs)
        galleries = [block for block in drawn if isinstance(block, Gallery)]
        blocks += [Beside(galleries[0], table) if galleries else table]
        blocks += [block for block in drawn if not isinstance(block, Gallery)]
    for alike in by_kind(inputs.runs):
        said = [f"{run.label}: {in_words(run)}" for run in alike[:_MOST_NAMED]]
        blocks += [*(Note(text, "lead") for text in said), compact_table(alike)]
    return blocks


def main_figures(inputs: Inputs, studied: Figure | None) -> set[Path]:
    """Return the paths of the figures that the blocks show, without a suffix; ``studied`` as of `answer_blocks`."""
    if studied:
        return set()
    items = inputs.items if len(inputs.runs) < 2 else inputs.scans
    return {item.directory / FIGURES_DIRECTORY / name for item in items for name in _names(item)[:1]}


def _main_figure(item: Run | Scan, inputs: Inputs) -> Figure | None:
    names = _names(item)
    return picture_in(item, names[0], inputs) if names else None


def _names(item: Run | Scan) -> list[str]:
    """Return the names of the figures there are that show the main quantity of a scan, or a run, best first."""
    thin = isinstance(item, Run) and _is_thin(item)
    names = [name for name in _MAIN_FIGURES if not (thin and name in _OF_THICK_PACKINGS)]
    if isinstance(item, Run):
        others = of_other_kinds(item)
        names = [name for name in ("target",) * bool(target_of(item.case)) + tuple(names) if name not in others]
    if isinstance(item, Scan):
        means = item.means
        if not any(means.varies(key) for _, key in means.quantities()[:1]):
            return []
        keys = sorted(means.keys, key=lambda key: (not key.numeric, -len(set(key.values))))
        names = [f"{name}_vs_{key.slug}" for name, _ in means.quantities()[:1] for key in keys]
    return [name for name in names if (item.directory / FIGURES_DIRECTORY / f"{name}.png").is_file()]


def _is_thin(run: Run) -> bool:
    """Return True for a long row of grains; False for what has no grains, or cannot be read."""
    try:
        with h5py.File(run.directory / RESULT_FILE, "r") as file:
            extents = np.sort(np.ptp(file["spheres/position"][()], axis=0) + 2 * np.max(file["spheres/radius"][()]))
    except (OSError, KeyError, ValueError):
        return False
    return bool(extents[-1] > _THIN * extents[-2])


# ---------------------------------------------------------------------- scans


def _of_scan(scan: Scan, inputs: Inputs, studied: Figure | None) -> tuple[Part, ...]:
    """Return the sentence, and the figure and the table where anything varies."""
    means = scan.means
    shown = means.quantities()
    pictures = (Gallery((studied,)),) if studied else ()
    if not shown:
        return pictures
    main = shown[0][1]
    name_of_scan = f"Scan {scan.label}: " if len(inputs.items) > 1 else ""
    sentence = Note(name_of_scan + means.sentence(main), "lead")
    if not means.varies(main):
        return (sentence, *pictures)
    others = [key for _, key in shown[1:] if key != main][: max(_MOST_COLUMNS - 1 - len(means.keys), 1)]
    places = math.prod(len(set(key.values)) for key in means.keys)  # of their grid
    crossed = len(means.keys) == 2 and _MOST_ROWS < len(means.counts) >= places / 2
    table = _crossed(means, main) if crossed else _table(means, [main, *others])
    picture = studied or _main_figure(scan, inputs)
    if picture and picture.wide:
        return sentence, Gallery((picture,)), table
    return sentence, Beside(Gallery((picture,)), table) if picture else table


def _table(means: Means, shown: Sequence[str]) -> Table:
    columns = (*(_column(key, means) for key in means.keys), *(value_column(name, means.called) for name in shown))
    rows = []
    for row in range(len(means.counts)):
        cells = [Cell(key.tick(row), key.values[row]) for key in means.keys]
        cells += [spread_cell(means.values[name][row], means.half_widths[name][row]) for name in shown]
        rows.append(tuple(cells))
    return Table(_caption(means), columns, tuple(rows), sortable=True)


def _crossed(means: Means, main: str) -> Table:
    """Make a table of the main quantity: rows by the key with more values, columns by the other."""
    down, across = sorted(means.keys, key=lambda key: len(set(key.values)), reverse=True)
    heads = list(dict.fromkeys(across.tick(row) for row in range(len(means.counts))))
    unit = f" {across.naming.unit}" if across.naming.unit else ""
    columns = [_column(down, means)]
    label = in_grains(across.naming.label, means.called)
    columns += [Column(f"{label} {head}{unit}", numeric=True) for head in heads]
    rows: dict[str, dict[str, Cell]] = {}
    for row in range(len(means.counts)):
        cell = spread_cell(means.values[main][row], means.half_widths[main][row])
        rows.setdefault(down.tick(row), {})[across.tick(row)] = cell
    first = {down.tick(row): Cell(down.tick(row), down.values[row]) for row in range(len(means.counts))}
    cells = tuple((first[name], *(found.get(head, Cell("")) for head in heads)) for name, found in rows.items())
    name, unit = label_of(main, means.called), quantity(main).unit
    what = f"{name} ({unit})" if unit else name
    return Table(f"{what}. {_caption(means)}", tuple(columns), cells, sortable=True)


def _column(key: Key, means: Means) -> Column:
    return Column(in_grains(key.naming.label, means.called), key.naming.unit, numeric=key.numeric, key=True)


def _caption(means: Means) -> str:
    least, most = min(means.counts, default=1), max(means.counts, default=1)
    if most < 2:
        return "All points"
    count = f"{least} to {most}" if least < most else str(most)
    return f"Means of {count} replicates, with 95 % confidence intervals"


# ---------------------------------------------------------------------- runs


def _of_run(run: Run, inputs: Inputs) -> list[Block]:
    said = in_grains(in_words(run), grains_called_in([run.summary]))
    blocks: list[Block] = [Note(said, "lead")] if said else []
    table = value_rows(run)
    picture = _main_figure(run, inputs)
    if not table.rows:
        return blocks
    return [*blocks, Beside(Gallery((picture,)), table) if picture else table]


def _of_runs_in_words(runs: Sequence[Run]) -> str:
    """Return how much of the load came through several driven rows, or of the input was dissipated, in each of them."""
    for key, what in (("transmission", "Transmission"), ("dissipated_fraction", "Dissipated of the input")):
        values = [(run.number(key), run.label) for run in runs]
        found = sorted((value, label) for value, label in values if value is not None)
        if len(found) < len(runs):
            continue
        if len(found) <= _MOST_NAMED:
            listed = ", ".join(f"{share(value or 0.0)} ({label})" for value, label in values)
            return f"{what}: {listed}."
        return f"{what}: from {share(found[0][0])} ({found[0][1]}) to {share(found[-1][0])} ({found[-1][1]})."
    return ""


def in_words(run: Run) -> str:
    """Return what came out of a run; the answer that it was made for comes first."""
    if not run.has_balance:
        return other_kinds.in_words(run)
    target = bool(target_of(run.case))
    bottom, chain = _bottom(run, target=target), _chain(run)
    energy = [*_energies(run), *_transmission(run)]
    parts = [*([bottom] if target else []), *chain, *energy]
    force = run.number("peak_force_N") or run.number("max_force_N")
    if force is not None:
        parts.append(f"The largest contact force was {_four(force)} N.")
    depth, radius = run.number("zone_depth_90_m"), run.number("zone_radius_90_m")
    if depth and radius is not None:
        parts.append(
            f"90 % of the energy of yielding stays within {1e3 * depth:.4g} mm below the impact and "
            f"{1e3 * radius:.4g} mm beside it."
        )
    plate = run.number("plate_velocity_m_s")
    if plate is not None:
        parts.append(f"The plate {'rebounds' if plate < 0 else 'still goes in'} with {abs(plate):.4g} m/s.")
    parts += [_line(run, name) for name in _lines(run)]
    parts += [_loaded(run), _sensors(run)]
    parts += [] if target else [bottom]
    return " ".join(part for part in parts if part)


def _four(value: float) -> str:
    """Return a number with four digits, without an exponent for common magnitudes."""
    return plain(f"{float(f'{value:.4g}'):g}")


def _bottom(run: Run, *, target: bool) -> str:
    """Return what the bottom or the target bore, and how much less than without the packing."""
    force, bare = run.number("wall_peak_force_N"), run.number("unprotected_peak_force_N")
    if not force:
        return ""
    text = f"The {'target' if target else 'bottom'} bore {_four(force)} N at most"
    reduction = run.number("peak_reduction")
    if bare and reduction:
        text += f", {_less(force, bare)} {_four(bare)} N without the packing"
    ground, without = run.number("ground_peak_force_N"), run.number("unprotected_ground_peak_force_N")
    if target and ground and without and ground != force:
        text += f"; the ground bore {_four(ground)} N, {_less(ground, without)} {_four(without)} N without it"
    return f"{text}."


def _less(force: float, bare: float) -> str:
    change = force / bare - 1
    return f"{share(abs(change))} {'less' if change < 0 else 'more'} than the"


def _chain(run: Run) -> list[str]:
    """Return speed and decay of the wave along a chain."""
    if run.case.get("packing.kind") != "chain" or run.number("transmission") is not None:
        return []
    speed, text = run.number("wave_speed_m_s"), _decay(run)
    parts = [f"The wave ran at {_four(speed)} m/s."] if speed is not None else []
    return [*parts, text] if text else parts


def _decay(run: Run) -> str:
    """Return how the peak force of a wave changes along a chain; empty where that is not known."""
    peaks = _peaks(run)
    reached = np.flatnonzero(peaks > _REACHED * peaks.max(initial=0.0))
    if len(reached) < 2:
        return ""
    numbers, forces = reached + 1, peaks[reached]
    first, last = f"{_four(forces[0])} N in contact {numbers[0]}", f"{_four(forces[-1])} N in contact {numbers[-1]}"
    if abs(forces[-1] / forces[0] - 1) < _KEPT:
        return f"Its peak force is about the same at both ends: {first}, {last}."
    if forces[-1] > forces[0]:
        return f"Its peak force grows from {first} to {last}."
    below = [(words, numbers[forces <= part * forces[0]]) for words, part in (("half", 0.5), ("a tenth", 0.1))]
    steps = [f"{words} of it in contact {found[0]}" for words, found in below if len(found)]
    return f"Its peak force falls from {first} to {' and '.join(steps) if len(steps) > 1 else last}."


def _peaks(run: Run) -> NDArray[np.float64]:
    """Return the largest force of each contact along a chain beyond the static one: (n_contacts,), N; or nothing."""
    try:
        with Result(run.directory) as result:
            if "chain" not in result:
                return np.empty(0)
            static = result["chain/contact_force"][0] if result.case.precompression is not None else 0.0
            return np.maximum(result.along_chain("peak_force") - static, 0.0)
    except (GranwaveError, KeyError, ValueError, IndexError):
        return np.empty(0)


def _energies(run: Run) -> list[str]:
    given, lost = run.number("energy_input_J"), run.number("dissipated_fraction")
    if given is None or lost is None:
        return []
    absorbed = run.number("absorbed_fraction") or 0.0
    of_it = f"of the {plain(f'{given:.4g}')} J put in"
    dissipated = share(lost - absorbed) if lost - absorbed > WORTH else "Nothing"
    if absorbed <= WORTH:
        return [f"{dissipated} {of_it} was dissipated."]
    rest = f", and {dissipated} was dissipated" if lost - absorbed > WORTH else ""
    return [f"{share(absorbed)} {of_it} was taken by absorbing spheres{rest}."]


def _transmission(run: Run) -> list[str]:
    passed, driven = run.number("transmission"), run.number("driven_velocity_m_s")
    if passed is None or driven is None:
        return []
    return [f"{share(passed)} of the driven end's velocity, {plain(f'{driven:.4g}')} m/s, came through."]


def _loaded(run: Run) -> str:
    """Return how many contacts bore a force, where most did not."""
    loaded, contacts = run.number("n_loaded_contacts"), run.number("n_contacts")
    few = loaded is not None and contacts and loaded < _FEW * contacts and run.case.get("packing.kind") != "chain"
    return f"{loaded:.0f} of {contacts:.0f} contacts bore a force." if few else ""


def _sensors(run: Run) -> str:
    """Return the largest and the smallest peak velocity of the sensors."""
    start, end = "sensor_", "_peak_velocity_m_s"
    seen = {key[len(start) : -len(end)]: run.number(key) or 0.0 for key in run.summary if key.endswith(end)}
    if len(seen) < 2:
        return ""
    most, least = max(seen, key=lambda name: seen[name]), min(seen, key=lambda name: seen[name])
    return f"Sensors saw at most {seen[most]:.4g} m/s ({most}) and at least {seen[least]:.4g} m/s ({least})."


def _lines(run: Run) -> list[str]:
    """Return the names of the lines of grains along which a wave was followed."""
    ending = "_front_speed_m_s"
    return [key[5 : -len(ending)] for key in run.summary if key.startswith("line_") and key.endswith(ending)]


def _line(run: Run, name: str) -> str:
    speed, decay = (run.number(f"line_{name}_{what}") for what in ("front_speed_m_s", "decay_per_m"))
    if speed is None:
        return ""
    text = f"Along the line {name} the front runs at {_four(speed)} m/s"
    if decay is None or decay <= 0:
        return f"{text}."
    return f"{text}, and the peak speed falls by half in {1e3 * np.log(2) / decay:.3g} mm."
