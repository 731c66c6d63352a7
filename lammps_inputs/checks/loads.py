"""Checks of loads, and of what bounds and damps the motion that they cause.

A load that oscillates needs time for the waves to arrive and to become steady, and records that resolve them: a row
passes a packet of the frequency f on at its group velocity, which is zero at the edges of a band. Runs that end before
it has arrived show a row that seems to stop such waves: a cut-off that is not there.
"""

from __future__ import annotations

import logging
import math

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.bodies import MATCHED, Absorb
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.contact.initial_dents import LARGEST
from granwave.lammps_inputs.contact.static_load import absorbing_ids, force_of_contact, rise_of
from granwave.lammps_inputs.contact.travel_time import MeasuredRow, Row, measured_row, row_of
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import chain_history, line_history, struck_of


def check_plate(case: Case, errors: ErrorList) -> None:
    """Check that nothing else is on the top that a plate strikes."""
    if case.load.kind != "plate":
        return
    stage = case.precompression
    beside = 'found beside load.kind = "plate", which covers the whole top; take one of them out'
    errors.check(
        (case.striker, "striker", beside),
        (case.incident_bar, "incident_bar", beside),
        (stage is not None and stage.kind != "walls", "precompression.kind",
         f'found {show(stage.kind if stage else "")} beside load.kind = "plate", expected "walls": the plate is held '
         "while the walls move in, and would bear any other load"),
    )  # fmt: skip


def check_side_gap(case: Case, errors: ErrorList) -> None:
    """Check that there are side walls to leave a gap to, and that a negative gap leaves room for the packing."""
    gap, most, key = case.boundary.gap, LARGEST * case.packing.diameter / 2, "boundary.side_gap"
    errors.check_first(
        (gap and not any(map(case.boundary.has_planes, "xy")), key,
         f'found {gap:g} m, but there are no side walls; expected boundary.sides = "wall"'),
        (gap < -most, key, f"found {gap:g} m, expected {-most:g} m or more: the walls press at most {LARGEST} radii"),
    )  # fmt: skip


LEAST_PER_PERIOD = 6  # recorded instants in the shortest period
LEAST_PERIODS = 3  # that sines are fitted to, in the last half of a run
WINDOW_PERIODS = 8  # of a load whose amplitude rises and falls; even, for whole periods of half of its frequency
LEAST_WINDOWS = 4

_LOG = logging.getLogger("granwave")
_FREQUENCIES = 201  # of a load of many frequencies
_PART = 0.5  # of the frequencies that a row passes: if more arrive too late, the case is refused
_TOLERANCE = 1e-9  # for a run that is as long as it must be
_KEY = "run.end_time"
_STEADY = " (twice that and load.ramp: the last half of the run is to be steady)"
_FITTED = ("harmonic", "up-and-down")  # shapes of one frequency, whose amplitudes are fitted

Array = NDArray[np.float64]


def check_driving(assembly: Assembly, errors: ErrorList) -> None:
    """Check that a run measures what it is to measure of a load that oscillates.

    Weak waves in a row under a static load that surely do not arrive are an error, all else a warning.
    """
    load = assembly.case.load
    if not load.driven or not load.oscillates or assembly.bars or assembly.case.output.history == 0:
        return
    row = measured_row(assembly)
    if row is None:
        return
    if (fault := _too_few_periods(assembly)) is not None:
        _LOG.warning("%s: %s: %s", assembly.case.name, *fault)
    _check_records(assembly, row)
    if not load.slants:  # the theory of a row is that of waves along z
        _check_arrival(assembly, row, errors)


def _too_few_periods(assembly: Assembly) -> tuple[str, str] | None:
    """Describe a run or a load that is too short for what is measured, with its key; None if there is none."""
    load, end = assembly.case.load, assembly.case.run.longest
    frequency, ends = load.frequencies[1], end * (1 + _TOLERANCE)
    if load.shape == "harmonic" and ends < (least := 2 * LEAST_PERIODS / frequency):
        return _KEY, (
            f"found {end:g} s, expected {_up(least)} s or more: the steady motion is fitted over whole periods in the "
            f"last half of a run, at least {LEAST_PERIODS} of {1 / frequency:.4g} s"
        )
    if load.shape == "up-and-down" and load.lasts < (least := LEAST_WINDOWS * WINDOW_PERIODS / frequency):
        return "load.duration", (
            f"found {load.lasts:g} s, expected {_up(least)} s or more: the amplitudes of {LEAST_WINDOWS} windows of "
            f"{WINDOW_PERIODS} periods at least are compared"
        )
    if math.isfinite(load.lasts) and ends < load.lasts:
        what = "its amplitudes rising and falling are compared" if load.shape == "up-and-down" else "all of it is heard"
        return _KEY, f"found {end:g} s, expected {_up(load.lasts)} s or more: the load lasts so long, and {what} then"
    return None


def _check_records(assembly: Assembly, row: MeasuredRow) -> None:
    """Check that velocities are recorded often enough for the highest frequency of the load."""
    frequency, span = assembly.case.load.frequencies[1], assembly.case.run.longest
    n = chain_history(assembly) if row.group == "chain" else line_history(assembly)
    least = math.ceil(LEAST_PER_PERIOD * frequency * span * (1 + _TOLERANCE))
    if n >= least or not n:
        return
    _LOG.warning(
        "%s: output.history: found %d instants, expected %d or more: %d in a period of %.4g s, or nothing is measured",
        assembly.case.name, n, least, LEAST_PER_PERIOD, 1 / frequency,
    )  # fmt: skip


def _check_arrival(assembly: Assembly, measured: MeasuredRow, errors: ErrorList) -> None:
    """Check that waves have come from the loaded grain to the last one, and are steady where they are to be."""
    row = row_of(assembly)
    case = assembly.case
    if row is None:
        return
    chain = case.packing.kind == "chain"
    first, last = measured.ends
    beads = _beads_between(assembly, measured)
    low, high = case.load.frequencies
    frequency = np.array([low]) if low == high else np.linspace(low, high, _FREQUENCIES)
    travel = beads * row.per_bead(frequency)
    passed = np.isfinite(travel)
    if not passed.any():
        return
    due = _due(case.load, frequency, travel)
    late = passed & (due > case.run.longest * (1 + _TOLERANCE))
    if not late.any():
        return
    of_one, end = case.load.shape in _FITTED, case.run.longest
    if of_one:
        way = abs(float(assembly.centre_of(last)[2] - assembly.centre_of(first)[2]))
        text = (
            f"found {end:g} s, expected {_up(float(due[0]))} s or more: at {frequency[0]:g} Hz waves take "
            f"{travel[0]:.3g} s from sphere {first} to {last}, at a group velocity of {way / travel[0]:.4g} m/s"
            f"{_STEADY if case.load.shape == 'harmonic' else ''}"
        )
    else:
        low, high = float(frequency[late].min()), float(frequency[late].max())
        text = (
            f"found {end:g} s, but waves of {low:.4g} to {high:.4g} Hz, the slower the nearer to the edge of a band, "
            f"come from sphere {first} to {last} after {float(due[late].min()):.3g} to {float(due[late].max()):.3g} s: "
            "their transmission will be too small; give a longer run, fewer spheres between, or other frequencies"
        )
    exact = chain and row.repeats and not case.contact.initial_overlap and case.contact.loss is None
    sure = exact and (float(travel[0]) > end if of_one else late.sum() > _PART * passed.sum())
    unreached = beads * row.of_long_wave > end * (1 + 2 / beads)
    if (sure or unreached) and _is_weak(assembly, row) and case.precompression is not None:
        errors.add(_KEY, f"{text}; output.history = 0 runs without measuring it")
    else:
        _LOG.warning("%s: %s: %s", case.name, _KEY, text)


def _is_weak(assembly: Assembly, row: Row) -> bool:
    """True if the load leaves contacts closed, so that waves run as small ones do."""
    load, force = assembly.case.load, force_of_contact(assembly)
    if load.kind == "force":
        return load.largest <= force
    return load.largest * float(row.stiffness.max()) <= force


def _due(load: Load, frequency: Array, travel: Array) -> Array:
    """Time after which each frequency has come, of a harmonic load when half of the run is steady: (n,), s."""
    if load.shape == "harmonic":
        return 2 * travel + load.rise
    if load.shape == "sweep":
        start, end = load.frequency or 0.0, load.last_frequency or 0.0
        sent = load.lasts * (frequency - start) / (end - start) if end != start else 0.0 * frequency
        return np.asarray(sent + travel)
    return travel + (load.lasts if load.shape == "burst" else 0.0)


def _beads_between(assembly: Assembly, measured: MeasuredRow) -> float:
    first, last = measured.ends
    if assembly.case.packing.kind == "chain":
        return float(max(abs(last - first), 1))
    depth = abs(float(assembly.centre_of(last)[2] - assembly.centre_of(first)[2]))
    return max(depth / (assembly.lattice.rule.layer_spacing * assembly.lattice.diameter), 1.0)


def _up(value: float) -> str:
    """Write a bound with three digits, rounded up."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.ceil(value / scale * (1 - _TOLERANCE)) * scale:.3g}"


def check_absorbing(assembly: Assembly, errors: ErrorList) -> None:
    """Check which spheres absorb waves, and by what."""
    case, seen = assembly.case, dict[int, str]()
    driven = struck_of(assembly) if case.absorb and case.load.kind == "displacement" else ()
    for key, entry in numbered("absorb", case.absorb).items():
        before = len(errors.lines)
        _check_entry(assembly, entry, key, errors)
        if len(errors.lines) > before:
            continue
        chosen = absorbing_ids(assembly, entry)
        rise = None if entry.rate is None else rise_of(assembly, entry)
        moved, twice = sorted(set(chosen).intersection(driven)), [one for one in chosen if one in seen]
        errors.check(
            *((True, key, f"damps sphere {one}, whose displacement is prescribed; expected others")
              for one in moved[:1]),
            (rise is not None and rise[0] == rise[1], f"{key}.towards",
             'found spheres without extent in this direction, expected "none"'),
            *((True, key, f"damps sphere {one}, which {seen[one]} damps too; expected each sphere once")
              for one in twice[:1]),
        )  # fmt: skip
        seen |= dict.fromkeys(chosen, key)


def _check_entry(assembly: Assembly, entry: Absorb, key: str, errors: ErrorList) -> None:
    case, lattice = assembly.case, assembly.lattice
    n, layers, both = lattice.n_spheres, entry.layers or 0, (entry.index is None) == (entry.layers is None)
    unknown = entry.impedance == MATCHED and (
        case.precompression is None or case.precompression.kind == "walls" or not len(lattice.rule.supports)
    )
    last = max(entry.index or (0,))
    errors.check_first(
        (both, key, f"found {'both' if entry.index else 'neither'} of index and layers, expected one of them"),
        (layers and case.packing.grains is not None, f"{key}.layers",
         "found for grains of a file, which have no layers; give index"),
        (layers >= max(2, lattice.shape[2]), f"{key}.layers",
         f"found {layers}, expected fewer than all {lattice.shape[2]} layers"),
        (last > n, f"{key}.index", f"found {last}, expected ids from 1 to {n}, the end of the packing"),
    )  # fmt: skip
    errors.check(
        ((entry.rate is None) == (entry.impedance is None), key,
         f"found {'both' if entry.rate else 'neither'} of rate and impedance, expected one of them"),
        (unknown and entry.rate is None, f"{key}.impedance",
         f"found {show(MATCHED)} for a packing whose contacts bear no known static force along z, so that there is "
         "no impedance of long waves; expected a number, N s/m, or a precompression"),
        (entry.impedance is not None and entry.towards != Absorb.towards, f"{key}.towards",
         "belongs to a rate; an impedance is the same for each sphere"),
    )  # fmt: skip
