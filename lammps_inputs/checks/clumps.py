"""Checks of clumps: grains that move as one rigid body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.packing.contact_ways import DAMPED, KEEP, KEY, RELAX, RELAXATION
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import held_ids, start_velocity, struck_of

_APART = 1e-12  # relative difference of velocities of one clump, for rounding
_LARGEST_PART_OF_PERIOD = 0.5  # distance beyond which the image of a grain is ambiguous


def check_clumps(case: Case, errors: ErrorList) -> None:
    """Check that clumps consist of spheres that move together, without features that only single
    grains support.
    """
    grains = case.packing.grains
    if grains is None or not grains.clumps:
        return
    for number, ids in grains.clumps.items():
        if not _check_clump(grains, number, ids, errors):
            return
    if case.boundary.periodic and case.packing.period is not None:
        _check_period(grains, case.packing.period, errors)
    _check_static_load(case, errors)
    for key, entry in numbered("absorb", case.absorb).items():
        _check_free(grains, entry.index or (), f"{key}.index", "absorbs waves of", errors)
    for key, hold in case.held.items():
        _check_free(grains, held_ids(case, hold), key, "holds", errors)


def _check_static_load(case: Case, errors: ErrorList) -> None:
    """Check that a static load on clumps is applied by a damped run, or that clumps start
    unchanged.
    """
    stage = case.precompression
    if stage is None or case.settles_damped or not case.seeks_balance:
        return
    way = case.packing.contact_way
    is_by_contacts = way is not None and way.presses
    found = show(case.packing.contacts if is_by_contacts else stage.kind)
    errors.add(
        KEY if is_by_contacts else "precompression.kind",
        Mismatch(
            f"{found} with clumps, but the minimiser does not move clumps as rigid bodies",
            f'{KEY} = "{RELAX.name}" with packing.{RELAXATION} = "{DAMPED}"',
            f'or use {KEY} = "{KEEP.name}" to start as found',
        ),
    )


def _check_clump(grains: Grains, number: int, ids: Sequence[int], errors: ErrorList) -> bool:
    """Check shapes and velocities of the grains of a clump; return True if they fit."""
    rows = np.array(ids) - 1
    velocity = grains.velocity[rows]
    scale = np.abs(velocity).max(initial=0.0)
    unlike = np.flatnonzero((np.abs(velocity - velocity[0]) > _APART * scale).any(axis=1))
    cylinders = [one for one in ids if grains.shape[one - 1] is not None]
    if cylinders:
        found = f"grain {grains.called(cylinders[0])} of clump {number}, a cylinder"
        fault = Mismatch(found, "clumps of spheres")
        ids = cylinders[:1]
    elif len(unlike):
        other = ids[int(unlike[0])]
        pair = f"grains {grains.called(ids[0])} and {grains.called(other)} of clump {number}"
        found = f"{pair} with different velocities"
        fault = Mismatch(
            found, "one velocity for all grains of a clump, which starts without rotation"
        )
        ids = (ids[0], other)
    else:
        return True
    _add(errors, grains, ids, fault)
    return False


def _add(errors: ErrorList, grains: Grains, ids: Sequence[int], fault: Mismatch) -> None:
    """Add an error about grains of a clump, under the key and the file of the grains."""
    key = grains.key(*ids)
    errors.add(key, f"{grains.file}: {fault}" if key == "packing.file" else fault)


def _check_period(grains: Grains, period: tuple[float, float], errors: ErrorList) -> None:
    """Check that the images of the grains of a clump are unambiguous."""
    for number, ids in grains.clumps.items():
        places = grains.position[np.array(ids) - 1, :2]
        step = places - places[0]
        step -= period * np.round(step / period)
        wide = np.ptp(step, axis=0) > _LARGEST_PART_OF_PERIOD * np.array(period)
        if wide.any():
            axis = int(np.argmax(wide))
            found = f"clump {number}, wider than half the period of {period[axis]:g} m along "
            fault = Mismatch(found + "xy"[axis], "smaller clumps", "repeat the grains")
            _add(errors, grains, ids, fault)
            return


def _check_free(grains: Grains, ids: Sequence[int], key: str, does: str, errors: ErrorList) -> None:
    """Check that none of these grains is part of a clump."""
    for number in ids:
        clump = int(grains.clump[number - 1]) if number <= len(grains) else 0
        if clump in grains.clumps:
            fault = f"{does} grain {grains.called(number)} of clump {clump}; name single grains"
            errors.add(key, fault)
            return


def check_loaded_clumps(assembly: Assembly, errors: ErrorList) -> None:
    """Check that no grain of a clump has a separate motion."""
    case = assembly.case
    grains = case.packing.grains
    if grains is None or not grains.clumps:
        return
    load = case.load
    members = set(assembly.in_clumps.tolist())
    struck = [one for one in struck_of(assembly) if one in members]
    drives = load.prescribes_motion or start_velocity(assembly) is not None
    if struck and drives and not load.moves_grains:
        grain = struck[0]
        found = f"{show(load.kind)} on grain {grain} of clump {grains.clump[grain - 1]}"
        expected = "a load on single grains, or by a striker"
        remedy = (
            'set the velocity of all grains of a clump by columns vx, vy, vz and kind = "grains"'
        )
        errors.add("load.index", Mismatch(found, expected, remedy))
    if case.boundary.bottom_rule.holds_layer:
        layer = [one for one in assembly.lattice.last_layer.tolist() if one in members]
        if layer:
            found = f'"fixed" with grain {layer[0]} of a clump in the last layer'
            errors.add("boundary.bottom", Mismatch(found, "single grains there, or a wall"))
