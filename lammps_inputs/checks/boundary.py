"""Checks of the boundaries of a packing: bottom, sides, bars and guide."""

from __future__ import annotations

import math

from granwave.lammps_inputs.case.bodies import Bar
from granwave.lammps_inputs.case.case import Case, WrongTable
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.bodies import BAR, INCIDENT_BAR

_LONGEST_ELEMENT = 10  # length of an element of a bar, in bead diameters
# spheres along a period; with fewer, a sphere would touch its own image, or a neighbour twice
_LEAST_PERIODIC = 3


def check_boundary(case: Case, errors: ErrorList) -> None:
    """Check that a packing can have such a bottom and such sides."""
    if case.packing.grains is not None:
        _check_period(case, errors)
        return
    nz = case.packing.lattice().shape[2]
    errors.check(
        (
            case.boundary.bottom_rule.holds_layer and nz == 1,
            "boundary.bottom",
            Mismatch('"fixed" with a single layer, which is impacted', "two layers or more"),
        )
    )
    if case.boundary.bottom_rule.repeats and not case.packing.rule.is_chain:
        _check_endless(case, errors)
    if case.boundary.periodic:
        _check_periodic_sides(case, errors)


def _check_period(case: Case, errors: ErrorList) -> None:
    """Check that grains of a file that repeat have a period."""
    found = '"periodic" with packing.kind = "file"'
    if case.boundary.bottom_rule.repeats:
        errors.add(
            "boundary.bottom", Mismatch(found, remedy="use packing.cell to define how they repeat")
        )
    if case.boundary.periodic and case.packing.period is None:
        raise WrongTable("packing.period")  # see `grains.check_places`


def _check_endless(case: Case, errors: ErrorList) -> None:
    """Check that a packing can repeat in depth."""
    kind = case.packing.kind
    rule = case.packing.rule
    nz = case.packing.lattice().shape[2]
    errors.check_first(
        (
            "z" not in rule.axes,
            "boundary.bottom",
            Mismatch(f'"periodic" for {kind}, a single layer', '"free"'),
        ),
        (
            not case.boundary.periodic,
            "boundary.sides",
            Mismatch(
                f'{show(case.boundary.sides)} with boundary.bottom = "periodic"',
                '"periodic": both or none',
            ),
        ),
        (
            nz % rule.layer_period,
            "packing.size",
            Mismatch(f"{nz} layers", f"a multiple of {rule.layer_period} for a periodic {kind}"),
        ),
    )


def _check_periodic_sides(case: Case, errors: ErrorList) -> None:
    """Check that the layers of a packing can repeat sideways."""
    rule = case.packing.rule
    nx, ny, _ = case.packing.lattice().shape
    across = [n for n, axis in zip((nx, ny), "xy", strict=True) if axis in rule.axes]
    errors.check_first(
        (
            rule.is_chain,
            "boundary.sides",
            Mismatch('"periodic" for a chain', '"free" or "wall"'),
        ),
        (
            rule.is_plane_crystal and case.packing.top_row != "equal",
            "packing.top_row",
            Mismatch(f'{show(case.packing.top_row)} with boundary.sides = "periodic"', '"equal"'),
        ),
        (
            min(across, default=_LEAST_PERIODIC) < _LEAST_PERIODIC,
            "packing.size",
            Mismatch(
                f"{nx} × {ny} spheres in a layer",
                f'at least {_LEAST_PERIODIC} each way for boundary.sides = "periodic"',
            ),
        ),
        (
            ny % rule.row_period,
            "packing.size",
            Mismatch(f"{ny} rows", f"an even number for periodic {case.packing.kind} layers"),
        ),
    )


def check_bars(case: Case, errors: ErrorList) -> None:
    """Check that bars are at the ends of a chain, with loads and bottoms that they allow."""
    for name, bar in ((BAR, case.bar), (INCIDENT_BAR, case.incident_bar)):
        if bar is not None:
            _check_bar(case, name, bar, errors)
    load = case.load
    has_bar = case.bar or case.incident_bar
    errors.check(
        (
            case.bar and case.boundary.bottom_rule.bears,
            "boundary.bottom",
            Mismatch(
                f"{show(case.boundary.bottom)} together with [bar]",
                '"free": the bar supports the chain',
            ),
        ),
        (
            case.incident_bar and case.striker,
            "striker",
            Mismatch("together with [incident_bar]", remedy="remove one of them"),
        ),
        (
            case.incident_bar and not load.takes_incident_bar,
            "load.kind",
            Mismatch(
                show(load.kind), 'kind = "force", which acts on the free end of the incident_bar'
            ),
        ),
        (
            has_bar and any(load.way[:2]),
            "load.direction",
            Mismatch(
                f"{show(load.keys().get('direction'))} with a bar, which moves only along z",
                "[0, 0, 1]",
            ),
        ),
    )


def _check_bar(case: Case, name: str, bar: Bar, errors: ErrorList) -> None:
    """Check that a packing is a chain, and the elements of its bar short enough."""
    longest = _LONGEST_ELEMENT * case.packing.diameter
    errors.check_first(
        (
            not case.packing.rule.is_chain,
            name,
            Mismatch(f"with packing.kind = {show(case.packing.kind)}", "a chain"),
        ),
        (
            bar.length > longest * bar.elements,
            f"{name}.elements",
            Mismatch(
                f"{bar.elements} in {bar.length:g} m",
                f"{math.ceil(bar.length / longest)} or more: elements longer than "
                f"{_LONGEST_ELEMENT} bead diameters cannot carry the pulses of a chain",
            ),
        ),
    )


def check_holder(case: Case, errors: ErrorList) -> None:
    """Check that a guide with friction supports the weight of a chain."""
    friction = case.boundary.holder_friction or 0.0
    key = "boundary.holder_friction"
    upright = case.precompression is not None and case.precompression.rule.grows_with_depth
    errors.check(
        (
            friction and not case.packing.rule.is_chain,
            key,
            Mismatch(f"{friction:g} for {case.packing.kind}", "0: only chains lie in a guide"),
        ),
        (
            friction and upright,
            key,
            Mismatch(
                f'{friction:g} under precompression.kind = "gravity"',
                "0: an upright chain has no guide",
            ),
        ),
    )
