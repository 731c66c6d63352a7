"""Checks of loads that oscillate: time for the waves to arrive and to become steady, records that resolve them.

A row passes a packet of the frequency f on at its group velocity, which is zero at the edges of a band. Runs that end
before it has arrived show a row that seems to stop such waves: a cut-off that is not there.
"""

from __future__ import annotations

import logging
import math

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.contact.measured_row import MeasuredRow, measured_row
from granwave.lammps_inputs.contact.static_load import force_of_contact
from granwave.lammps_inputs.contact.travel_time import Row, row_of
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.records import chain_history, line_history

LEAST_PER_PERIOD = 6  # recorded instants in the shortest period
LEAST_PERIODS = 3  # that sines are fitted to, in the last half of a run
WINDOW_PERIODS = 8  # of a load whose amplitude rises and falls; even, for whole periods of half of its frequency
LEAST_WINDOWS = 4

_LOG = logging.getLogger("granwave")
_FREQUENCIES = 201  # of a load of many frequencies
_PART = 0.5  # of the frequencies that a row passes: if more arrive too late, the case is refused
_TOLERANCE = 1e-9  # for a run that is as long as it must be
_KEY = "run.end_time"
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
    frequency = _frequencies(case.load)
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
            f"{_reason(case.load)}"
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


def _reason(load: Load) -> str:
    if load.shape == "harmonic":
        return " (twice that and load.ramp: the last half of the run is to be steady)"
    return ""


def _frequencies(load: Load) -> Array:
    low, high = load.frequencies
    if low == high:
        return np.array([low])
    return np.linspace(low, high, _FREQUENCIES)


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
