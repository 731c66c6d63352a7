"""What the tables of a case must satisfy together, and what deserves a warning."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from granwave.lammps_inputs.keys import Faults, show
from granwave.lammps_inputs.lattices import KINDS, Lattice
from granwave.lammps_inputs.laws import fault_of_constants
from granwave.lammps_inputs.materials import Material
from granwave.lammps_inputs.sections import Boundary, Contact, Load, Output, PackingSection, Run
from granwave.lammps_inputs.struck import struck_spheres
from granwave.lammps_inputs.yield_factor import FITTED_POISSON_RATIO, hertz_von_mises_yield_factor

if TYPE_CHECKING:
    from granwave.lammps_inputs.case import Case

_LOG = logging.getLogger("granwave")
_LEAST_PERIODIC = 3  # fewer spheres would touch their own images, or one neighbour twice


def check_together(parts: Mapping[str, Any], faults: Faults) -> None:
    """Check what concerns several keys; a part that is missing or itself wrong is None and passed over."""
    packing: PackingSection | None = parts.get("packing")
    boundary: Boundary | None = parts.get("boundary")
    run: Run | None = parts.get("run")
    output: Output | None = parts.get("output")
    _check_yield(parts.get("material"), parts.get("contact"), faults)
    _check_constants(parts.get("contact"), faults)
    if run is not None:
        _check_times(run, output, faults)
    if packing is None or not _size_fits(packing, faults):
        return
    if output is not None:
        _check_probes(output, Lattice(packing.kind, packing.size, packing.diameter).n_spheres, faults)
    if boundary is not None and _boundary_fits(packing, boundary, faults):
        _check_load(parts.get("load"), packing, boundary, faults)


def warn_about(case: Case, *, chose_yield_factor: bool) -> None:
    """Log what is allowed but may not be meant."""
    ratio = case.material.poisson_ratio
    uses_factor = case.contact.law in ("elastoplastic", "thornton")
    if uses_factor and not chose_yield_factor and ratio != FITTED_POISSON_RATIO:
        _LOG.warning(
            "%s: the contact law was fitted for a Poisson's ratio of %.2f, found %g; "
            "its exact Hertz-von Mises yield factor is C = %.4f (contact.yield_factor is %g)",
            case.name,
            FITTED_POISSON_RATIO,
            ratio,
            hertz_von_mises_yield_factor(ratio),
            case.contact.yield_factor,
        )
    for probe in case.output.probes:
        if probe.contact is not None and probe.contact[1] not in case.lattice.neighbours(probe.contact[0]):
            _LOG.warning("%s: the spheres of the probed contact %s do not touch at the start", case.name, probe.contact)
    if case.run.end_time == "auto" and not case.contact.yields:
        _LOG.warning('%s: a Hertz packing dissipates nothing, so run.end_time = "auto" ends after 50 us', case.name)


def _check_yield(material: Material | None, contact: Contact | None, faults: Faults) -> None:
    if material is not None and contact is not None and contact.yields and material.yield_strength is None:
        faults.add(
            "material.yield_strength",
            f'missing; the {contact.law} law needs it: give a number in Pa, or set contact.law = "hertz"',
        )


def _check_constants(contact: Contact | None, faults: Faults) -> None:
    if contact is None or not contact.constants:
        return
    if (contact.law, contact.variant) != ("elastoplastic", "continuous"):
        for name in contact.constants:
            faults.add(
                f"contact.{name}",
                f"belongs to law elastoplastic, variant continuous; found {contact.law}, {contact.variant}",
            )
        return
    if fault := fault_of_constants(contact):
        faults.add("contact", f"{', '.join(contact.constants)}: no passive law: {fault}")


def _check_times(run: Run, output: Output | None, faults: Faults) -> None:
    ends = f"run.end_time, {run.longest:g} s"
    if not isinstance(run.timestep, str) and run.timestep > run.longest:
        faults.add("run.timestep", f"found {run.timestep:g} s, expected at most {ends}")
    if isinstance(run.frames, tuple) and run.frames[-1] > run.longest:
        faults.add("run.frames", f"found a time of {run.frames[-1]:g} s, expected none beyond {ends}")
    if output is not None and not isinstance(output.probe_interval, str) and output.probe_interval > run.longest:
        faults.add("output.probe_interval", f"found {output.probe_interval:g} s, expected at most {ends}")


def _size_fits(packing: PackingSection, faults: Faults) -> bool:
    axes = KINDS[packing.kind].axes
    if len(packing.size) == len(axes):
        return True
    form = "a number n" if len(axes) == 1 else "[" + ", ".join(f"n{axis}" for axis in axes) + "]"
    faults.add("packing.size", f"found {show(packing.size)}, expected {form} for {packing.kind}")
    return False


def _check_probes(output: Output, n_spheres: int, faults: Faults) -> None:
    for probe in output.probes:
        for sphere in probe.spheres:
            if sphere > n_spheres:
                faults.add("output.probes", f"found sphere {sphere}, expected an id from 1 to {n_spheres}")
        if probe.contact is not None and probe.contact[0] == probe.contact[1]:
            faults.add("output.probes", f"found contact {show(probe.contact)}, expected two different spheres")


def _boundary_fits(packing: PackingSection, boundary: Boundary, faults: Faults) -> bool:
    before = len(faults.lines)
    rule = KINDS[packing.kind]
    nx, ny, nz = Lattice(packing.kind, packing.size, packing.diameter).shape
    if boundary.bottom == "fixed" and nz == 1:
        faults.add(
            "boundary.bottom",
            'found "fixed" with a single layer, which is struck; expected two layers or more',
        )
    if boundary.sides == "periodic":
        if packing.kind == "chain":
            faults.add("boundary.sides", 'found "periodic" for a chain, expected "free" or "wall"')
        elif min(nx, ny) < _LEAST_PERIODIC:
            faults.add(
                "packing.size",
                f"found {nx} x {ny} spheres in a layer, expected at least {_LEAST_PERIODIC} each way "
                'for boundary.sides = "periodic"',
            )
        elif rule.hexagonal and ny % 2:
            faults.add("packing.size", f"found {ny} rows, expected an even number for periodic {packing.kind} layers")
    return len(faults.lines) == before


def _check_load(load: Load | None, packing: PackingSection, boundary: Boundary, faults: Faults) -> None:
    if load is None:
        return
    lattice = Lattice(packing.kind, packing.size, packing.diameter, boundary.sides == "periodic")
    try:
        struck_spheres(lattice, load.spheres)
    except ValueError as error:
        faults.add("load.spheres", f"found {load.spheres}, but {error}; use 1, or another packing")
