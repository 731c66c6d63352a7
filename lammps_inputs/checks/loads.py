"""Checks of loads, boundaries and damping.

A load that oscillates needs time for the waves to arrive and to become steady, and records that
resolve them: a chain transmits a packet of the frequency f at its group velocity, which is zero at
the edges of a band. A run that ends before the packet has arrived shows a cut-off that does not
exist.
"""

from __future__ import annotations

import logging
import math

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.bodies import MATCHED, Absorb
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.loads.driven import DrivenLoad
from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.contact.initial_dents import LARGEST
from granwave.lammps_inputs.contact.static_load import absorbing_ids, force_of_contact, rise_of
from granwave.lammps_inputs.contact.travel_time import MeasuredRow, measured_row, row_of
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import (
    chain_history,
    held_ids,
    line_history,
    start_velocity,
    struck_of,
)
from granwave.lammps_inputs.packing.places import layout_of, struck_spheres


def check_excluded(case: Case, errors: ErrorList) -> None:
    """Check that the case has no table and no static stage that its load excludes."""
    load = case.load
    beside = f"together with load.kind = {show(load.kind)}"
    for table, reason in load.excludes.items():
        text = f"found {beside}, {reason}; remove one of them"
        errors.check((getattr(case, table), table, text))
    stage = case.precompression
    if stage is None or load.only_stage is None:
        return
    kind, reason = load.only_stage
    text = f"found {show(stage.kind)} {beside}, expected {show(kind)}: {reason}"
    errors.check((stage.kind != kind, "precompression.kind", text))


def check_side_gap(case: Case, errors: ErrorList) -> None:
    """Check that a gap at the sides has side walls, and that a negative gap leaves room for the
    packing.
    """
    gap = case.boundary.gap
    most = LARGEST * case.packing.diameter / 2
    key = "boundary.side_gap"
    errors.check_first(
        (
            gap and not any(map(case.boundary.has_planes, "xy")),
            key,
            Mismatch(f"{gap:g} m, but there are no side walls", 'boundary.sides = "wall"'),
        ),
        (
            gap < -most,
            key,
            Mismatch(f"{gap:g} m", f"{-most:g} m or more: the walls press at most {LARGEST} radii"),
        ),
    )


LEAST_PER_PERIOD = 6  # recorded instants in the shortest period
LEAST_PERIODS = 3  # fewest periods of a fit of sines, in the last half of a run
# fewest periods of a load with a varying amplitude; even, for whole periods of half its frequency
WINDOW_PERIODS = 8
LEAST_WINDOWS = 4

_LOG = logging.getLogger("granwave")
_FREQUENCIES = 201  # frequencies of a broadband load
# fraction of the frequencies below the cut-off: if more of these arrive too late, the case is
# rejected
_PART = 0.5
_TOLERANCE = 1e-9  # tolerance for a run of exactly the required duration
_KEY = "run.end_time"
_STEADY = " (twice that and load.ramp: the last half of the run must be steady)"
_FITTED = ("harmonic", "up-and-down")  # shapes of one frequency, whose amplitudes are fitted

Array = NDArray[np.float64]


def check_driving(assembly: Assembly, errors: ErrorList) -> None:
    """Check that a run with an oscillating load measures the required quantities.

    Weak waves in a chain under a static load that cannot arrive in time are an error, other cases a
    warning.
    """
    case = assembly.case
    load = assembly.case.load
    if not isinstance(load, DrivenLoad) or not load.oscillates:
        return
    if assembly.bars or case.output.history == 0:
        return
    row = measured_row(assembly)
    if row is None:
        return
    if fault := _too_few_periods(load, case.run.longest):
        _LOG.warning("%s: %s", case.name, fault)
    n = chain_history(assembly) if row.group == "chain" else line_history(assembly)
    period = 1 / load.highest_frequency
    least = math.ceil(LEAST_PER_PERIOD / period * case.run.longest * (1 + _TOLERANCE))
    if 0 < n < least:
        _LOG.warning(
            "%s: output.history: found %d instants, expected %d or more: %d in a period of %.4g "
            "s; with fewer instants nothing is measured", case.name, n, least, LEAST_PER_PERIOD,
                period,
        )  # fmt: skip
    if not load.slants:  # the theory of chains applies to waves along z
        _check_arrival(assembly, load, row, errors)


def _too_few_periods(load: DrivenLoad, end: float) -> str:
    """Describe a run or a load that is too short for the measurement, with its key; empty if there
    is none.
    """
    period = 1 / load.highest_frequency
    ends = end * (1 + _TOLERANCE)
    if load.shape == "harmonic" and ends < (least := 2 * LEAST_PERIODS * period):
        return (
            f"{_KEY}: found {end:g} s, expected {_up(least)} s or more: the steady motion is "
            "fitted over whole periods in the last half of the run, over at least "
            f"{LEAST_PERIODS} of {period:.4g} s"
        )
    if load.shape == "up-and-down" and load.lasts < (
        least := LEAST_WINDOWS * WINDOW_PERIODS * period
    ):
        return (
            f"load.duration: found {load.lasts:g} s, expected {_up(least)} s or more: amplitudes "
            f"are compared in at least {LEAST_WINDOWS} windows of {WINDOW_PERIODS} periods"
        )
    if ends < load.lasts < math.inf:
        what = (
            "rising and falling amplitudes are compared"
            if load.shape == "up-and-down"
            else "the whole signal is recorded"
        )
        text = (
            f"found {end:g} s, expected {_up(load.lasts)} s or more: this is the duration of "
            f"the load, in which {what}"
        )
        return f"{_KEY}: {text}"
    return ""


def _check_arrival(
    assembly: Assembly, load: DrivenLoad, measured: MeasuredRow, errors: ErrorList
) -> None:
    """Check that waves reach the last grain from the loaded grain, and become steady where
    required.
    """
    row = row_of(assembly)
    case = assembly.case
    first, last = measured.ends
    if row is None:
        return
    end = case.run.longest
    chain = case.packing.rule.is_chain
    way = abs(float(assembly.centre_of(last)[2] - assembly.centre_of(first)[2]))
    beads = max(
        abs(last - first)
        if chain
        else way / (assembly.lattice.rule.layer_spacing * case.packing.diameter),
        1,
    )
    low, high = load.frequencies
    frequency = np.array([low]) if low == high else np.linspace(low, high, _FREQUENCIES)
    travel = beads * row.per_bead(frequency)
    passed = np.isfinite(travel)
    due = _due(load, frequency, travel)
    late = passed & (due > end * (1 + _TOLERANCE))
    if not late.any():
        return
    if of_one := load.shape in _FITTED:
        text = (
            f"found {end:g} s, expected {_up(float(due[0]))} s or more: at {frequency[0]:g} Hz waves take "
            f"{travel[0]:.3g} s from sphere {first} to {last}, at a group velocity of {way / travel[0]:.4g} m/s"
            f"{_STEADY if load.shape == 'harmonic' else ''}"
        )
    else:
        low = float(frequency[late].min())
        high = float(frequency[late].max())
        text = (
            f"found {end:g} s, but waves of {low:.4g} to {high:.4g} Hz, which are slow near the "
            f"edge of a band, arrive from sphere {first} at sphere {last} after "
            f"{float(due[late].min()):.3g} to {float(due[late].max()):.3g} s: their transmission "
            "will be too small; use a longer run, fewer spheres between these two, or other "
            "frequencies"
        )
    exact = chain and row.repeats and not case.contact.initial_overlap and case.contact.loss is None
    sure = exact and (float(travel[0]) > end if of_one else late.sum() > _PART * passed.sum())
    unreached = beads * row.of_long_wave > end * (1 + 2 / beads)
    # weak loads keep contacts closed, so that waves propagate as small ones
    on_contact = load.force_on_contact(float(row.stiffness.max()))
    if (
        (sure or unreached)
        and case.precompression is not None
        and on_contact <= force_of_contact(assembly)
    ):
        errors.add(_KEY, f"{text}; set output.history = 0 to run without this measurement")
    else:
        _LOG.warning("%s: %s: %s", case.name, _KEY, text)


def _due(load: DrivenLoad, frequency: Array, travel: Array) -> Array:
    """Return the time after which each frequency has arrived; for a harmonic load, the time after
    which half of the run is steady: (n,), s.
    """
    if load.shape == "harmonic":
        return 2 * travel + load.rise
    if load.shape == "sweep":
        start = load.frequency or 0.0
        end = load.last_frequency or 0.0
        sent = load.lasts * (frequency - start) / (end - start) if end != start else 0.0 * frequency
        return np.asarray(sent + travel)
    return travel + (load.lasts if load.shape == "burst" else 0.0)


def _up(value: float) -> str:
    """Write a bound with three digits, rounded up."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.ceil(value / scale * (1 - _TOLERANCE)) * scale:.3g}"


def check_absorbing(assembly: Assembly, errors: ErrorList) -> None:
    """Check the absorbing spheres and their damping."""
    case = assembly.case
    lattice = assembly.lattice
    seen = dict[int, str]()
    driven = struck_of(assembly) if case.absorb and case.load.prescribes_motion else ()
    stage = case.precompression
    no_force = stage is None or stage.rule.across_alone or not len(lattice.rule.supports)
    for key, entry in numbered("absorb", case.absorb).items():
        before = len(errors.items)
        layers = entry.layers or 0
        by_rate = entry.rate is not None
        errors.check_first(
            (
                (entry.index is None) == (entry.layers is None),
                key,
                Mismatch(
                    f"{'both' if entry.index else 'neither'} of index and layers", "one of them"
                ),
            ),
            (
                layers and case.packing.grains is not None,
                f"{key}.layers",
                Mismatch("for grains of a file, which have no layers", remedy="use index"),
            ),
            (
                layers >= max(2, lattice.shape[2]),
                f"{key}.layers",
                Mismatch(f"{layers}", f"fewer than {lattice.shape[2]}, the number of layers"),
            ),
        )
        errors.check(
            (
                by_rate == (entry.impedance is not None),
                key,
                Mismatch(
                    f"{'both' if by_rate else 'neither'} of rate and impedance", "one of them"
                ),
            ),
            (
                entry.impedance == MATCHED and no_force and not by_rate,
                f"{key}.impedance",
                Mismatch(
                    f"{show(MATCHED)} for a packing without a known static force along z, for "
                    "which the impedance of long waves is undefined",
                    "a number (N s/m), or a precompression",
                ),
            ),
            (
                entry.impedance is not None and entry.towards != Absorb.towards,
                f"{key}.towards",
                "applies only to rate; the impedance is uniform",
            ),
        )
        if len(errors.items) > before:
            continue
        chosen = absorbing_ids(assembly, entry)
        low, high = rise_of(assembly, entry) or (0.0, 1.0)
        moved = sorted(set(chosen).intersection(driven))
        twice = [one for one in chosen if one in seen]
        errors.check(
            *(
                (
                    True,
                    key,
                    f"damps sphere {one}, whose displacement is prescribed; remove it from this "
                    "list",
                )
                for one in moved[:1]
            ),
            (
                low == high,
                f"{key}.towards",
                Mismatch("spheres without extent in this direction", '"none"'),
            ),
            *(
                (
                    True,
                    key,
                    f"damps sphere {one}, which {seen[one]} also damps; remove it from one of the "
                    "two",
                )
                for one in twice[:1]
            ),
        )
        seen |= dict.fromkeys(chosen, key)


def check_struck_spheres(case: Case, errors: ErrorList) -> None:
    """Check that the packing has the number of impacted spheres in the middle of its top."""
    if not case.load.hits_spheres or case.load.index is not None:
        return
    try:
        struck_spheres(layout_of(case.packing, case.boundary), case.load.spheres)
    except ValueError as error:
        found = f"{case.load.spheres}, but {error}"
        errors.add("load.spheres", Mismatch(found, remedy="use 1, or another packing"))


def check_struck(assembly: Assembly, errors: ErrorList) -> None:
    """Check that no impacted sphere is held in a direction in which the load moves it."""
    case = assembly.case
    load = case.load
    if not load.hits_spheres or case.incident_bar:
        return
    velocity = start_velocity(assembly) or load.way
    moved = {axis for axis, part in zip("xyz", velocity, strict=True) if part}
    struck = set(struck_of(assembly))
    for key, hold in case.held.items():
        held = sorted(struck & set(held_ids(case, hold)))
        along = sorted(moved & set(hold.axes))
        if held and along:
            table = key.partition(".")[0]
            fault = (
                f"holds sphere {held[0]} along {' and '.join(along)}, but the load moves it in "
                f"this direction; remove it from [[{table}]], or load another sphere (load.index)"
            )
            errors.add(key, fault)
    held = sorted(struck & set(assembly.lattice.last_layer.tolist()))
    if held and case.boundary.bottom_rule.holds_layer:
        found = f'{held[0]}, a sphere of the last layer, which boundary.bottom = "fixed" holds'
        errors.add("load.index", Mismatch(found))
