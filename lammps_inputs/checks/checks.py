"""Checks of the tables of a case against each other, and warnings."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable

import numpy as np

from granwave._contact_laws import FE_RANGE
from granwave.lammps_inputs.case.case import Case, WrongTable
from granwave.lammps_inputs.case.contact import FITTED_POISSON_RATIO, hertz_von_mises_yield_factor
from granwave.lammps_inputs.case.law_parameters import OF_MATERIAL, RATE, is_set, laws_with
from granwave.lammps_inputs.case.loads.driven import DrivenLoad
from granwave.lammps_inputs.case.material import Material, check_shape
from granwave.lammps_inputs.case.packing import check_memory_of_sites, check_size
from granwave.lammps_inputs.case.run import RunSettings
from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.checks import grains, loads, packing, precompression
from granwave.lammps_inputs.contact.initial_dents import KEY, error_in_dents
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.bodies import BAR, INCIDENT_BAR, echoes
from granwave.lammps_inputs.packing.cylinders import extents
from granwave.lammps_inputs.packing.motion import held_ids, start_velocity, struck_of
from granwave.lammps_inputs.packing.places import layout_of, struck_spheres
from granwave.lammps_inputs.packing.walls import untouched, walls

_LOG = logging.getLogger("granwave")
_STEPS_IN_A_PERIOD = 10  # at least
_FAR_LONGER = 100.0  # times the run: a load that lasts so long is in another unit
_SMALL_GAP = 1e-3  # diameters; gaps that dents leave are larger
_OVERLAP = 1e-6  # diameters; largest overlap of a striker with the bottom, for rounding
_LONGEST_ELEMENT = 10  # length of an element of a bar, in bead diameters
_MEMORY_OF_SITE = 40.0  # bytes a site; measured 34 to 68 for 1e7 spheres
# spheres along a period; fewer would touch their own images, or one neighbour twice
_LEAST_PERIODIC = 3

Check = Callable[[Case, ErrorList], None]


def check_together(case: Case, errors: ErrorList) -> None:
    """Check keys of different tables against each other, as far as the tables are right."""
    _fit(case, errors, packing.check_pairs, packing.check_contact, _check_times, _check_probe_interval,
         _check_resolution)  # fmt: skip
    if not _fit(case, errors, _check_size):
        return
    _fit(
        case, errors,
        grains.check_columns, grains.check_places, grains.check_loaded, grains.check_held,
        _check_ids, _check_strikers, _check_history,
    )  # fmt: skip
    if _fit(case, errors, _check_boundary):
        _fit(
            case, errors,
            _check_struck_spheres, _check_bars, loads.check_side_gap, loads.check_excluded,
            precompression.check_precompression, _check_holder,
        )  # fmt: skip
    _fit(case, errors, packing.check_disorder, packing.check_vacancies)


def _fit(case: Case, errors: ErrorList, *checks: Check) -> bool:
    """Return True if a case passes some checks; one that needs a table that is wrong ends there."""
    before = len(errors.items)
    complete = True
    for check in checks:
        try:
            check(case, errors)
        except WrongTable:
            complete = False
    return complete and len(errors.items) == before


def check_case(case: Case, errors: ErrorList) -> Assembly | None:
    """Check the whole case: space for larger spheres, places of strikers, support, static load and
    dents.
    """
    packing.check_room(case, errors)
    grains.check_cylinders(case, errors)
    if not grains.check_touched(case, errors):
        return None
    grains.check_tube(case, errors)
    try:
        assembly = assemble(case)
    except ValueError as error:
        errors.add("striker", str(error))
        return None
    grains.check_lines(assembly, errors)
    grains.check_restart(assembly, errors)
    for check in (
        precompression.check_plates,
        _check_struck,
        precompression.check_first_yield,
        loads.check_absorbing,
    ):
        check(assembly, errors)
    if not errors.items:
        loads.check_driving(assembly, errors)
    if fault := error_in_dents(assembly):
        errors.add(KEY, fault)
    for check in (packing.check_losses, packing.check_rates, packing.check_cohesion, _check_below,
                  _check_held_strikers):  # fmt: skip
        check(assembly, errors)
    return assembly


def _check_size(case: Case, errors: ErrorList) -> None:
    """Check size and memory; grains of a file were read into memory, a lattice needs arrays over
    sites.
    """
    if not check_size(case.packing, errors) or case.packing.grains is not None:
        return
    nx, ny, nz = case.packing.lattice().shape
    unlike = case.packing.diameter_scatter or case.packing.vacancies or case.replace
    check_memory_of_sites(case.packing, nx * ny * (nz if unlike else 1), _MEMORY_OF_SITE, errors)


def _check_ids(case: Case, errors: ErrorList) -> None:
    """Check that ids are those of grains of the packing, or also of strikers, and names those of
    one sensor alone.
    """
    n = case.packing.n_spheres
    known = vars(case)
    last = n + len(case.striker)
    lists = ("replace", "hold", "guide", "absorb")
    entries = [item for name in lists for item in numbered(name, getattr(case, name)).items()]
    probes = case.output.probes if "output" in known else ()
    named = [
        ("load.index", case.load.index or () if "load" in known else (), n),
        *((f"{key}.index", entry.index or (), n) for key, entry in entries),
        *((f"striker.{k}.touches", striker.touches, n + k - 1) for k, striker in enumerate(case.striker, start=1)),
        *((f"{key}.id", (sensor.id,), last) for key, sensor in numbered("sensor", case.sensor).items()),
        *(("output.probes", probe.spheres, last) for probe in probes),
        *((f"{key}.index", line.index if isinstance(line.index, tuple) else (), last)
          for key, line in numbered("line", case.line).items()),
        *((f"{key}.start", (line.start or 1,), last) for key, line in numbered("line", case.line).items()),
    ]  # fmt: skip

    def up_to(most: int) -> str:
        end = "the end of the packing" if most == n else "strikers included"
        return f"ids from 1 to {most}, {end}"

    errors.check(
        *(
            (
                max(ids, default=0) > most,
                key,
                Mismatch(f"{max(ids, default=0)}", up_to(most)),
            )
            for key, ids, most in named
        ),
        *(
            (
                len(set(probe.spheres)) < len(probe.spheres),
                "output.probes",
                Mismatch(f"contact {show(probe.contact)}", "two different spheres"),
            )
            for probe in probes
        ),
    )
    errors.check_names(numbered("sensor", case.sensor))


def _check_strikers(case: Case, errors: ErrorList) -> None:
    no_effect = "a striker starts in contact, so that a shift along its way has no effect"
    for key, striker in numbered("striker", case.striker).items():
        check_shape(striker, key, errors)
        for name, shift in (("offset", striker.offset), ("misalignment", striker.misalignment)):
            along = (
                any(striker.velocity) and any(shift) and not np.cross(shift, striker.velocity).any()
            )
            found = Mismatch(f"{show(shift)} along its way", f"a part across it: {no_effect}")
            errors.check((along, f"{key}.{name}", found))


def _check_history(case: Case, errors: ErrorList) -> None:
    history = case.output.history
    has_one = case.packing.rule.is_chain or case.line
    found = Mismatch(f"{history} for {case.packing.kind}", "0: only chains and [[line]]s have one")
    errors.check((not has_one and history not in (0, "auto"), "output.history", found))


def _check_boundary(case: Case, errors: ErrorList) -> None:
    """Check that a packing can have such a bottom and such sides."""
    kind = case.packing.kind
    bottom = case.boundary.bottom_rule
    periodic = case.boundary.periodic
    if case.packing.grains is not None:
        remedy = "packing.cell says how they repeat"
        found = Mismatch('"periodic" with packing.kind = "file"', remedy=remedy)
        errors.check((bottom.repeats, "boundary.bottom", found))
        if periodic and case.packing.period is None:
            raise WrongTable("packing.period")  # see `grains.check_places`
        return
    rule = case.packing.rule
    nx, ny, nz = case.packing.lattice().shape
    endless = bottom.repeats and not rule.is_chain
    across = min(
        (n for n, axis in zip((nx, ny), "xy", strict=True) if axis in rule.axes),
        default=_LEAST_PERIODIC,
    )
    errors.check(
        (
            bottom.holds_layer and nz == 1,
            "boundary.bottom",
            Mismatch('"fixed" with a single layer, which is struck', "two layers or more"),
        )
    )
    errors.check_first(
        (
            endless and "z" not in rule.axes,
            "boundary.bottom",
            Mismatch(f'"periodic" for {kind}, a single layer', '"free"'),
        ),
        (
            endless and not periodic,
            "boundary.sides",
            Mismatch(
                f'{show(case.boundary.sides)} with boundary.bottom = "periodic"',
                '"periodic": both or none',
            ),
        ),
        (
            endless and nz % rule.layer_period,
            "packing.size",
            Mismatch(f"{nz} layers", f"a multiple of {rule.layer_period} for an endless {kind}"),
        ),
    )
    errors.check_first(
        (
            periodic and rule.is_chain,
            "boundary.sides",
            Mismatch('"periodic" for a chain', '"free" or "wall"'),
        ),
        (
            periodic and rule.is_plane_crystal and case.packing.top_row != "equal",
            "packing.top_row",
            Mismatch(f'{show(case.packing.top_row)} with boundary.sides = "periodic"', '"equal"'),
        ),
        (
            periodic and across < _LEAST_PERIODIC,
            "packing.size",
            Mismatch(
                f"{nx} x {ny} spheres in a layer",
                f'at least {_LEAST_PERIODIC} each way for boundary.sides = "periodic"',
            ),
        ),
        (
            periodic and ny % rule.row_period,
            "packing.size",
            Mismatch(f"{ny} rows", f"an even number for periodic {kind} layers"),
        ),
    )


def _check_struck_spheres(case: Case, errors: ErrorList) -> None:
    if case.load.hits_spheres and case.load.index is None:
        try:
            struck_spheres(layout_of(case.packing, case.boundary), case.load.spheres)
        except ValueError as error:
            errors.add(
                "load.spheres",
                Mismatch(f"{case.load.spheres}, but {error}", remedy="use 1, or another packing"),
            )


def _check_bars(case: Case, errors: ErrorList) -> None:
    longest = _LONGEST_ELEMENT * case.packing.diameter
    kind = case.packing.kind
    for name, bar in ((BAR, case.bar), (INCIDENT_BAR, case.incident_bar)):
        if bar is not None:
            errors.check_first(
                (
                    not case.packing.rule.is_chain,
                    name,
                    Mismatch(f"with packing.kind = {show(kind)}", "a chain"),
                ),
                (
                    bar.length > longest * bar.elements,
                    f"{name}.elements",
                    Mismatch(
                        f"{bar.elements} in {bar.length:g} m",
                        f"{math.ceil(bar.length / longest)} or more: elements of at most "
                        f"{_LONGEST_ELEMENT} bead diameters, or they cannot carry a chain's "
                        "pulses",
                    ),
                ),
            )
    errors.check(
        (
            case.bar and case.boundary.bottom_rule.bears,
            "boundary.bottom",
            Mismatch(
                f"{show(case.boundary.bottom)} beside [bar]", '"free": the bar is what is below'
            ),
        ),
        (
            case.incident_bar and case.striker,
            "striker",
            Mismatch("beside [incident_bar]", remedy="take one of them out"),
        ),
    )
    load = case.load
    errors.check(
        (
            case.incident_bar and not load.takes_incident_bar,
            "load.kind",
            Mismatch(show(load.kind), "a force: it acts on the free end of the incident_bar"),
        ),
        (
            (case.bar or case.incident_bar) and any(load.way[:2]),
            "load.direction",
            Mismatch(
                f"{show(load.keys().get('direction'))} beside a bar, which moves along z alone",
                "[0, 0, 1]",
            ),
        ),
    )


def _check_holder(case: Case, errors: ErrorList) -> None:
    """Check that a holder that rubs bears the weight of a chain."""
    friction = case.boundary.holder_friction or 0.0
    key = "boundary.holder_friction"
    upright = case.precompression is not None and case.precompression.rule.grows_with_depth
    errors.check(
        (
            friction and not case.packing.rule.is_chain,
            key,
            Mismatch(f"{friction:g} for {case.packing.kind}", "0: only chains lie in a holder"),
        ),
        (
            friction and upright,
            key,
            Mismatch(
                f'{friction:g} under precompression.kind = "gravity"',
                "0: a chain that stands has no holder",
            ),
        ),
    )


def _check_times(case: Case, errors: ErrorList) -> None:
    """Check times against the end of the run, and the bounds of an automatic timestep, which a
    fixed one lacks.
    """
    run = case.run
    end = run.longest
    ends = f"run.end_time, {run.longest:g} s"
    step = 0.0 if isinstance(run.timestep, str) else run.timestep
    last = run.frame_times[-1] if run.frame_times else 0.0
    no_end = (
        isinstance(run.frames, tuple)
        and isinstance(run.frames[0], str)
        and isinstance(run.end_time, str)
    )
    names = ("smallest_timestep", "largest_timestep", "energy_tolerance")
    given = {
        name: getattr(run, name)
        for name in names
        if getattr(run, name) != getattr(RunSettings, name)
    }
    least = given.get("smallest_timestep", 0.0)
    most = given.get("largest_timestep", math.inf)
    errors.check(
        (step > end, "run.timestep", Mismatch(f"{step:g} s", f"at most {ends}")),
        (
            least > most,
            "run.smallest_timestep",
            Mismatch(f"{least:g} s", f"at most run.largest_timestep, {most:g} s"),
        ),
        *(
            (
                not run.adaptive,
                f"run.{name}",
                Mismatch(
                    f"{value:g} beside run.timestep, a fixed one of {step:g} s",
                    remedy="take one of them out",
                ),
            )
            for name, value in given.items()
        ),
        (
            no_end,
            "run.frames",
            Mismatch(
                "shares of an end that is not known: give times in s, or "
                'run.end_time as a number, not "auto"'
            ),
        ),
        (
            not no_end and last > end,
            "run.frames",
            Mismatch(f"a time of {last:g} s", f"none beyond {ends}"),
        ),
    )


def _check_probe_interval(case: Case, errors: ErrorList) -> None:
    interval = case.output.probe_interval
    end = case.run.longest
    if not isinstance(interval, str) and interval > end:
        errors.add(
            "output.probe_interval",
            Mismatch(f"{interval:g} s", f"at most run.end_time, {end:g} s"),
        )


def _check_resolution(case: Case, errors: ErrorList) -> None:
    """Check that a fixed timestep resolves the oscillation of the load."""
    load = case.load
    step = case.run.timestep
    if not isinstance(load, DrivenLoad) or not load.oscillates or isinstance(step, str):
        return
    highest = load.frequencies[1]
    most = 1 / (_STEPS_IN_A_PERIOD * step)
    errors.check(
        (
            highest > most,
            load.highest_key,
            Mismatch(
                f"{highest:g} Hz",
                f"at most {most:.4g} Hz, a period of {_STEPS_IN_A_PERIOD} timesteps of {step:g} s",
                'make run.timestep shorter, or "auto"',
            ),
        ),
    )


def _check_struck(assembly: Assembly, errors: ErrorList) -> None:
    """Check that no struck sphere is held in a direction in which the load moves it."""
    case = assembly.case
    load = assembly.case.load
    if not load.hits_spheres or case.incident_bar:
        return
    velocity = start_velocity(assembly) or load.way
    moved = {axis for axis, part in zip("xyz", velocity, strict=True) if part}
    struck = set(struck_of(assembly))
    for key, hold in case.held.items():
        held = sorted(struck & set(held_ids(case, hold)))
        along = sorted(moved & set(hold.axes))
        if held and along:
            errors.add(key, f"holds sphere {held[0]} along {' and '.join(along)}, in which the load moves it; leave it "
                       f"out of [[{key.partition('.')[0]}]], or strike another (load.index)")  # fmt: skip
    held = sorted(struck & set(assembly.lattice.last_layer.tolist()))
    if held and case.boundary.bottom_rule.holds_layer:
        errors.add(
            "load.index",
            Mismatch(
                f'{held[0]}, a sphere of the last layer, which boundary.bottom = "fixed" holds'
            ),
        )


def _check_below(assembly: Assembly, errors: ErrorList) -> None:
    """Check that no striker overlaps the wall or bar below a chain; walls of other packings do not
    act on strikers.
    """
    case = assembly.case
    has_plane = case.boundary.bottom_rule.has_plane or case.bar is not None
    if not case.packing.rule.is_chain or not has_plane:
        return
    what = "bar" if case.bar is not None else "wall at the bottom"
    for n, (_, centre) in enumerate(assembly.strikers, start=1):
        beyond = (
            centre[2] + assembly.diameter_of(assembly.lattice.n_spheres + n) / 2 - assembly.bottom()
        )
        if beyond > _OVERLAP * case.packing.diameter:
            errors.add(
                f"striker.{n}",
                f"the {what} cuts through it, {beyond:.3g} m deep; take one of them away",
            )


def outside_fit(material: Material) -> str:
    """Tell what of a material lies outside the range of law elastoplastic-fe; empty if nothing
    does.
    """
    ratio = (
        math.inf
        if material.yield_strength is None
        else material.youngs_modulus / material.yield_strength
    )
    ranges = (
        ("Poisson's ratio", material.poisson_ratio, FE_RANGE["poisson_ratio"]),
        ("Young's modulus over yield strength", ratio, FE_RANGE["modulus_over_strength"]),
        ("hardening", material.hardening or 0.0, FE_RANGE["hardening"]),
    )
    outside = [
        f"{name} {value:.3g}, expected {low:g} to {high:g}"
        for name, value, (low, high) in ranges
        if math.isfinite(value) and not low <= value <= high
    ]
    if not outside:
        return ""
    return (
        f"law elastoplastic-fe is used beyond its fit, where it states no error bar: "
        f"{'; '.join(outside)}"
    )


def _check_held_strikers(assembly: Assembly, errors: ErrorList) -> None:
    """Check that walls can hold the strikers that they are to hold: at rest, acting on all, clear
    of them at first.
    """
    case = assembly.case
    first = assembly.lattice.n_spheres + 1
    planes = [wall for wall in walls(assembly) if not wall.held_layer]
    for number, (striker, centre) in enumerate(assembly.strikers):
        if not striker.walls:
            continue
        key = f"striker.{number + 1}.walls"
        sphere = first + number
        reach = extents(np.array([assembly.diameter_of(sphere) / 2]), [assembly.shape_of(sphere)])[
            0
        ]
        depth = {one.name: -float(one.gaps(centre[None], reach[:1] if one.tube else reach[one.axis : one.axis + 1])[0])
                 for one in planes}  # fmt: skip
        deepest = max(depth, key=depth.__getitem__, default="")
        stage = case.precompression
        errors.check_first(
            (not planes, key, Mismatch("true, but there are no walls", "false")),
            (
                case.boundary.sides_touch is not None,
                key,
                Mismatch(
                    "true beside boundary.sides_touch: those walls act on chosen "
                    "grains of the packing alone"
                ),
            ),
            (
                stage is not None and (stage.moves or stage.presses),
                key,
                Mismatch(
                    "true beside walls that move in (precompression): they would press "
                    "the striker too"
                ),
            ),
            (
                depth.get(deepest, 0.0) > _OVERLAP * case.packing.diameter,
                key,
                Mismatch(
                    f"true, but it stands in the wall {deepest}, "
                    f"{depth.get(deepest, 0.0):.3g} m deep",
                    remedy="place it inside, or leave walls out",
                ),
            ),
        )


def warn_about(assembly: Assembly, *, chose_yield_factor: bool) -> None:
    """Log warnings about values that are valid but may not be meant."""
    case = assembly.case
    warnings = list[str]()
    ratio = case.material.poisson_ratio
    n = assembly.lattice.n_spheres
    law = case.contact
    end = case.run.longest
    if law.takes("yield_factor") and not chose_yield_factor and ratio != FITTED_POISSON_RATIO:
        warnings.append(
            f"the contact law was fitted for a Poisson's ratio of {FITTED_POISSON_RATIO:.2f}, found {ratio:g}; its "
            f"exact Hertz-von Mises yield factor is C = {hertz_von_mises_yield_factor(ratio):.4f} "
            f'(contact.yield_factor is {law.yield_factor:g}); law = "elastoplastic-fe" holds for ratios of 0 to 0.45'
        )
    materials = {id(one.material): one.material for one in assembly.species}.values()
    if law.takes("hardening"):
        warnings += filter(None, map(outside_fit, materials))
    for parameter in OF_MATERIAL:
        if law.takes(parameter.name) or parameter.keyword == RATE:  # of rates see `check_rates`
            continue
        if any(is_set(material, parameter) for material in materials):
            laws = " or ".join(laws_with(parameter))
            text = (
                f"expected law {laws} for a material with {parameter.name}, which others leave out"
            )
            warnings.append(f"contact.law: found {law.law}, {text}")
    if law.yields and assembly.has_cylinders:
        text = "contacts along a line, of parallel cylinders and of cylinders on walls, stay elastic: contact.law ="
        warnings.append(f"{text} {law.law} holds for the others")
    for wall, grain, depth in untouched(assembly):
        text = (
            f"grain {grain} reaches {depth:.3g} m into the wall {wall}, which does not act on it:"
        )
        warnings.append(f"{text} boundary.sides_touch")
    for contact in (probe.contact for probe in case.output.probes if probe.contact is not None):
        low, high = sorted(contact)
        near = (
            assembly.striker_contacts
            if high > n
            else [(low, one) for one in assembly.lattice.neighbours(low)]
        )
        if (low, high) not in near:
            warnings.append(
                f"the spheres of the probed contact {contact} do not touch at the start"
            )
    for name, echo in echoes(assembly.bars).items():
        if end > echo:
            text = f"an echo of the end of the {name} can reach the chain after {echo:.3g} s, the run lasts"
            warnings.append(f"{text} {end:.3g} s: make the bar longer, or the run shorter")
    if law.initial_overlap and case.precompression and case.boundary.forget_gap < _SMALL_GAP:
        gap = case.boundary.forget_gap * case.packing.diameter
        text = f"boundary.forget_gap: dents from before the run are forgotten beyond gaps of {gap:.3g} m, so that the"
        warnings.append(
            f"{text} packing may never come to rest under its static load; give {_SMALL_GAP:g} or more"
        )
    if case.load.first_time >= end:
        text = (
            f"load.table: the load begins at {case.load.first_time:.3g} s, when the run has ended:"
        )
        warnings.append(f"{text} give run.end_time a later time")
    if end * _FAR_LONGER < case.load.lasts < math.inf:
        of_table = case.load.table is not None
        key = "load.table" if of_table else "load.duration"
        text = f"{key}: the load lasts {case.load.lasts:.3g} s, the run {end:.3g} s"
        ask = "are its times in seconds?" if of_table else "is it in seconds?"
        warnings.append(f"{text}: {ask}")
    if case.run.end_time == "auto" and not law.yields and not case.has_cohesion:
        warnings.append(
            'a Hertz packing dissipates nothing, so run.end_time = "auto" ends after 50 us'
        )
    for text in warnings:
        _LOG.warning("%s: %s", case.name, text)
