"""Checks of the tables of a case against each other, and warnings."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.bodies import Bar, Striker
from granwave.lammps_inputs.case.boundary import Boundary
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact import FITTED_POISSON_RATIO, hertz_von_mises_yield_factor
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.case.material import check_shape
from granwave.lammps_inputs.case.packing import PackingSection, check_memory_of_sites, check_size
from granwave.lammps_inputs.case.run import ENERGY_TOLERANCE, Output, Run
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.checks.grains import (
    check_chosen,
    check_cylinders,
    check_grains,
    check_lines,
    check_touched,
    check_tube,
)
from granwave.lammps_inputs.checks.loads import check_absorbing, check_driving, check_plate, check_side_gap, check_top
from granwave.lammps_inputs.checks.packing import check_contacts, check_dents, check_disorder, check_losses, check_room
from granwave.lammps_inputs.checks.precompression import check_first_yield, check_precompression, check_support
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.bodies import BAR, INCIDENT_BAR, echoes
from granwave.lammps_inputs.packing.motion import held_ids, struck_of
from granwave.lammps_inputs.packing.places import layout_of, struck_spheres
from granwave.lammps_inputs.packing.walls import untouched
from granwave.lammps_inputs.plane_lattices import is_plane_crystal

_LOG = logging.getLogger("granwave")
_STEPS_IN_A_PERIOD = 10  # at least
_SMALL_GAP = 1e-3  # diameters; gaps that dents leave are larger
_OVERLAP = 1e-6  # diameters; largest overlap of a striker with the bottom, for rounding
_LONGEST_ELEMENT = 10  # length of an element of a bar, in bead diameters
_MEMORY_OF_SITE = 40.0  # bytes a site; measured 34 to 68 for 1e7 spheres
_LEAST_PERIODIC = 3  # spheres along a period; fewer would touch their own images, or one neighbour twice


def check_together(parts: Mapping[str, Any], errors: ErrorList) -> None:
    """Check keys of different tables against each other; parts that are None (missing or wrong) are skipped."""
    packing: PackingSection | None = parts.get("packing")
    boundary: Boundary | None = parts.get("boundary")
    run: Run | None = parts.get("run")
    output: Output | None = parts.get("output")
    check_contacts(parts, errors)
    if run is not None:
        _check_times(run, output, errors)
        _check_resolution(parts.get("load"), run, errors)
    if packing is None or not check_size(packing, errors):
        return
    if packing.grains is None:  # those were read into memory; reading a lattice needs arrays over sites, a run more
        nx, ny, nz = packing.lattice().shape
        unlike = packing.diameter_scatter or packing.vacancies or parts.get("replace")
        if not check_memory_of_sites(packing, nx * ny * (nz if unlike else 1), _MEMORY_OF_SITE, errors):
            return
    n_spheres = len(packing.grains) if packing.grains is not None else packing.lattice().n_spheres
    check_grains(parts, packing, errors)
    held = {f"hold.{place}": hold for place, hold in enumerate(parts.get("hold", ()), start=1)}
    held |= {f"guide.{place}": guide.hold(n_spheres) for place, guide in enumerate(parts.get("guide", ()), start=1)}
    check_chosen(parts.get("load"), held, packing, n_spheres, errors)
    strikers, sensors = parts.get("striker", ()), parts.get("sensor", ())
    _check_strikers(strikers, n_spheres, errors)
    n_spheres += len(strikers)
    for n, sensor in enumerate(sensors, start=1):
        twice = sensor.name in [other.name for other in sensors[: n - 1]]
        errors.check(
            (sensor.id > n_spheres, f"sensor.{n}.id", f"found {sensor.id}, expected an id from 1 to {n_spheres}"),
            (twice, f"sensor.{n}.name", f"found {show(sensor.name)} twice, expected a name of its own"),
        )
    for probe in output.probes if output is not None else ():
        errors.check(
            *((one > n_spheres, "output.probes", f"found sphere {one}, expected an id from 1 to {n_spheres}")
              for one in probe.spheres),
            (len(set(probe.spheres)) < len(probe.spheres), "output.probes",
             f"found contact {show(probe.contact)}, expected two different spheres"),
        )  # fmt: skip
    if output is not None and packing.kind != "chain" and not parts.get("line") and output.history not in (0, "auto"):
        found = f"found {output.history} for {packing.kind}"
        errors.add("output.history", f"{found}, expected 0: only chains and [[line]]s have one")
    if boundary is not None and _boundary_fits(packing, boundary, errors):
        load: Load | None = parts.get("load")
        if load is not None and load.hits_spheres and load.index is None:
            try:
                struck_spheres(layout_of(packing, boundary), load.spheres)
            except ValueError as error:
                errors.add("load.spheres", f"found {load.spheres}, but {error}; use 1, or another packing")
        _check_bars(parts, packing, boundary, errors)
        check_side_gap(packing, boundary, errors)
        check_plate(parts, errors)
        check_precompression(parts, packing, boundary, errors)
        _check_holder(parts, packing, boundary, errors)
    if packing.grains is None:
        check_disorder(parts, errors)


def check_case(case: Case, errors: ErrorList) -> Assembly | None:
    """Check the whole case: space for larger spheres, places of strikers, support, static load and dents."""
    check_room(case, errors)
    check_cylinders(case, errors)
    if not check_touched(case, errors):
        return None
    check_tube(case, errors)
    try:
        assembly = assemble(case)
    except ValueError as error:
        errors.add("striker", str(error))
        return None
    check_lines(assembly, errors)
    check_support(assembly, errors)
    check_top(assembly, errors)
    _check_struck(assembly, errors)
    check_first_yield(assembly, errors)
    check_absorbing(assembly, errors)
    if not errors.lines:
        check_driving(assembly, errors)
    check_dents(assembly, errors)
    check_losses(assembly, errors)
    if case.packing.kind == "chain" and (case.boundary.bottom == "wall" or case.bar is not None):
        _check_below(assembly, errors)
    return assembly


def _check_struck(assembly: Assembly, errors: ErrorList) -> None:
    """Check that no struck sphere is held in a direction in which the load moves it."""
    load = assembly.case.load
    if not load.hits_spheres or assembly.case.incident_bar:
        return
    velocity = load.initial_velocity if load.kind == "impact" else (0, 0, 1)
    moved = {axis for axis, part in zip("xyz", velocity, strict=True) if part}
    struck = set(struck_of(assembly))
    for name, hold in assembly.case.holds.items():
        held, entry = sorted(struck & set(held_ids(assembly.case, hold))), name.rstrip("0123456789")
        if held and (along := sorted(moved & set(hold.axes))):
            errors.add(
                f"{entry}.{name.removeprefix(entry)}",
                f"holds sphere {held[0]} along {' and '.join(along)}, in which the load moves it; leave it out of "
                f"[[{entry}]], or strike another (load.index)",
            )
    held = sorted(struck & set(assembly.lattice.last_layer.tolist()))
    if held and assembly.case.boundary.bottom == "fixed":
        errors.add("load.index", f'found {held[0]}, a sphere of the last layer, which boundary.bottom = "fixed" holds')


def _check_below(assembly: Assembly, errors: ErrorList) -> None:
    """Check that no striker overlaps the wall or bar below a chain; walls of other packings do not act on strikers."""
    case = assembly.case
    bottom = assembly.bottom()
    what = "bar" if case.bar is not None else "wall at the bottom"
    for n, (_, centre) in enumerate(assembly.strikers, start=1):
        beyond = centre[2] + assembly.diameter_of(assembly.lattice.n_spheres + n) / 2 - bottom
        if beyond > _OVERLAP * case.packing.diameter:
            errors.add(f"striker.{n}", f"the {what} cuts through it, {beyond:.3g} m deep; take one of them away")


def warn_about(assembly: Assembly, *, chose_yield_factor: bool) -> None:
    """Log warnings about values that are valid but may not be meant."""
    case = assembly.case
    ratio, n = case.material.poisson_ratio, assembly.lattice.n_spheres
    uses_factor = case.contact.takes("yield_factor")
    if uses_factor and not chose_yield_factor and ratio != FITTED_POISSON_RATIO:
        exact = hertz_von_mises_yield_factor(ratio)
        _LOG.warning(
            "%s: the contact law was fitted for a Poisson's ratio of %.2f, found %g; its exact Hertz-von Mises yield "
            "factor is C = %.4f (contact.yield_factor is %g)",
            case.name, FITTED_POISSON_RATIO, ratio, exact, case.contact.yield_factor,
        )  # fmt: skip
    if case.contact.yields and assembly.has_cylinders:
        text = "%s: contacts along a line, of parallel cylinders and of cylinders on walls, stay elastic: "
        _LOG.warning(text + "contact.law = %s holds for the others", case.name, case.contact.law)
    for wall, grain, depth in untouched(assembly):
        text = "%s: grain %d reaches %.3g m into the wall %s, which does not act on it: boundary.sides_touch"
        _LOG.warning(text, case.name, grain, depth, wall)
    for contact in (probe.contact for probe in case.output.probes if probe.contact is not None):
        low, high = sorted(contact)
        near = assembly.striker_contacts if high > n else [(low, one) for one in assembly.lattice.neighbours(low)]
        if (low, high) not in near:
            _LOG.warning("%s: the spheres of the probed contact %s do not touch at the start", case.name, contact)
    for name, echo in echoes(assembly.bars).items():
        if case.run.longest > echo:
            text = "%s: an echo of the end of the %s can reach the chain after %.3g s, the run lasts %.3g s: "
            _LOG.warning(f"{text}make the bar longer, or the run shorter", case.name, name, echo, case.run.longest)
    if case.contact.initial_overlap and case.precompression and case.boundary.forget_gap < _SMALL_GAP:
        text = "%s: boundary.forget_gap: dents from before the run are forgotten beyond gaps of %.3g m, so that the "
        gap = case.boundary.forget_gap * case.packing.diameter
        _LOG.warning(
            text + "packing may never come to rest under its static load; give %g or more", case.name, gap, _SMALL_GAP
        )
    if case.load.first_time >= case.run.longest:
        text = "%s: load.table: the load begins at %.3g s, when the run has ended: give run.end_time a later time"
        _LOG.warning(text, case.name, case.load.first_time)
    if case.run.end_time == "auto" and not case.contact.yields:
        _LOG.warning('%s: a Hertz packing dissipates nothing, so run.end_time = "auto" ends after 50 us', case.name)


def _check_strikers(strikers: tuple[Striker, ...], n_spheres: int, errors: ErrorList) -> None:
    for n, striker in enumerate(strikers, start=1):
        check_shape(striker, f"striker.{n}", errors)
        known = n_spheres + n - 1
        beyond = [sphere for sphere in striker.touches if sphere > known]
        moves, no_effect = (
            any(striker.velocity),
            "a striker starts in contact, so that a shift along its way has no effect",
        )
        errors.check(
            *((True, f"striker.{n}.touches",
               f"found {one}, expected ids from 1 to {known}: spheres of the packing, and earlier strikers")
              for one in beyond[:1]),
            *((any(shift) and moves and not np.cross(shift, striker.velocity).any(), f"striker.{n}.{key}",
               f"found {show(shift)} along its way, expected a part across it: {no_effect}")
              for key, shift in (("offset", striker.offset), ("misalignment", striker.misalignment))),
        )  # fmt: skip


def _check_bars(parts: Mapping[str, Any], packing: PackingSection, boundary: Boundary, errors: ErrorList) -> None:
    bars: dict[str, Bar | None] = {name: parts.get(name) for name in (BAR, INCIDENT_BAR)}
    load: Load | None = parts.get("load")
    longest = _LONGEST_ELEMENT * packing.diameter
    for name, bar in bars.items():
        if bar is not None and packing.kind != "chain":
            errors.add(name, f"found with packing.kind = {show(packing.kind)}, expected a chain")
        elif bar is not None and bar.length > longest * bar.elements:
            errors.add(
                f"{name}.elements",
                f"found {bar.elements} in {bar.length:g} m, expected {math.ceil(bar.length / longest)} or more: "
                f"elements of at most {_LONGEST_ELEMENT} bead diameters, or they cannot carry a chain's pulses",
            )
    errors.check(
        (bars[BAR] and boundary.bottom != "free", "boundary.bottom",
         f'found {show(boundary.bottom)} beside [bar], expected "free": the bar is what is below'),
        (bars[INCIDENT_BAR] and load and load.kind != "force", "load.kind",
         f"found {show(load.kind if load else '')}, expected a force: it acts on the free end of the incident_bar"),
        (bars[INCIDENT_BAR] and parts.get("striker"), "striker",
         "found beside [incident_bar]; take one of them out"),
    )  # fmt: skip


def _check_times(run: Run, output: Output | None, errors: ErrorList) -> None:
    """Check times against the end of the run, and the bounds of an automatic timestep, which a fixed one lacks."""
    end, ends = run.longest, f"run.end_time, {run.longest:g} s"
    step = 0.0 if isinstance(run.timestep, str) else run.timestep
    interval = 0.0 if output is None or isinstance(output.probe_interval, str) else output.probe_interval
    last = run.frame_times[-1] if run.frame_times else 0.0
    no_end = isinstance(run.frames, tuple) and isinstance(run.frames[0], str) and isinstance(run.end_time, str)
    given = {name: value for name in ("smallest_timestep", "largest_timestep", "energy_tolerance")
             if not isinstance(value := getattr(run, name), str)}  # fmt: skip
    if run.energy_tolerance == ENERGY_TOLERANCE:
        del given["energy_tolerance"]
    least, most = given.get("smallest_timestep", 0.0), given.get("largest_timestep", math.inf)
    errors.check(
        (step > end, "run.timestep", f"found {step:g} s, expected at most {ends}"),
        (least > most, "run.smallest_timestep",
         f"found {least:g} s, expected at most run.largest_timestep, {most:g} s"),
        *((not run.adaptive, f"run.{name}",
           f"found {value:g} beside run.timestep, a fixed one of {step:g} s; take one of them out")
          for name, value in given.items()),
        (no_end, "run.frames",
         'found shares of an end that is not known: give times in s, or run.end_time as a number, not "auto"'),
        (not no_end and last > end, "run.frames", f"found a time of {last:g} s, expected none beyond {ends}"),
        (interval > end, "output.probe_interval", f"found {interval:g} s, expected at most {ends}"),
    )  # fmt: skip


def _boundary_fits(packing: PackingSection, boundary: Boundary, errors: ErrorList) -> bool:
    """Check that a packing can have such a bottom and such sides; return True if it can."""
    bottom, sides, kind = boundary.bottom, boundary.sides, packing.kind
    if packing.grains is not None:
        text = 'found "periodic" with packing.kind = "file"; packing.cell says how they repeat'
        fits = errors.check_first((bottom == "periodic", "boundary.bottom", text))
        return fits and (sides != "periodic" or packing.period is not None)
    rule, before = KINDS[kind], len(errors.lines)
    nx, ny, nz = packing.lattice().shape
    endless, periodic = bottom == "periodic" and kind != "chain", sides == "periodic"
    across = min((n for n, axis in zip((nx, ny), "xy", strict=True) if axis in rule.axes), default=_LEAST_PERIODIC)
    errors.check((bottom == "fixed" and nz == 1, "boundary.bottom",
                  'found "fixed" with a single layer, which is struck; expected two layers or more'))  # fmt: skip
    errors.check_first(
        (endless and "z" not in rule.axes, "boundary.bottom",
         f'found "periodic" for {kind}, a single layer; expected "free"'),
        (endless and not periodic, "boundary.sides",
         f'found {show(sides)} with boundary.bottom = "periodic", expected "periodic": both or none'),
        (endless and nz % rule.layer_period, "packing.size",
         f"found {nz} layers, expected a multiple of {rule.layer_period} for an endless {kind}"),
    )  # fmt: skip
    errors.check_first(
        (periodic and kind == "chain", "boundary.sides",
         'found "periodic" for a chain, expected "free" or "wall"'),
        (periodic and is_plane_crystal(kind) and packing.top_row != "equal", "packing.top_row",
         f'found {show(packing.top_row)} with boundary.sides = "periodic", expected "equal"'),
        (periodic and across < _LEAST_PERIODIC, "packing.size",
         f"found {nx} x {ny} spheres in a layer, expected at least {_LEAST_PERIODIC} each way "
         'for boundary.sides = "periodic"'),
        (periodic and ny % rule.row_period, "packing.size",
         f"found {ny} rows, expected an even number for periodic {kind} layers"),
    )  # fmt: skip
    return len(errors.lines) == before


def _check_resolution(load: Load | None, run: Run, errors: ErrorList) -> None:
    """Check that a fixed timestep resolves the oscillation of the load."""
    if load is None or not load.driven or not load.oscillates or isinstance(run.timestep, str):
        return
    key = "last_frequency" if load.last_frequency and load.last_frequency > (load.frequency or 0.0) else "frequency"
    highest, most = load.frequencies[1], 1 / (_STEPS_IN_A_PERIOD * run.timestep)
    errors.check(
        (highest > most, f"load.{key}",
         f"found {highest:g} Hz, expected at most {most:.4g} Hz, a period of {_STEPS_IN_A_PERIOD} timesteps of "
         f'{run.timestep:g} s; make run.timestep shorter, or "auto"'),
    )  # fmt: skip


def _check_holder(parts: Mapping[str, Any], packing: PackingSection, boundary: Boundary, errors: ErrorList) -> None:
    """Check that a holder that rubs bears the weight of a chain."""
    found, key = f"found {boundary.holder_friction or 0.0:g}", "boundary.holder_friction"
    stage = parts.get("precompression") if boundary.holder_friction else None
    upright = stage is not None and stage.kind == "gravity"
    errors.check(
        (boundary.holder_friction and packing.kind != "chain", key,
         f"{found} for {packing.kind}, expected 0: only chains lie in a holder"),
        (upright, key, f'{found} under precompression.kind = "gravity", expected 0: a chain that stands has no holder'),
    )  # fmt: skip
