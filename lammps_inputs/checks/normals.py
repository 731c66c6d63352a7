"""Checks of contacts whose forces keep their initial directions."""

from __future__ import annotations

from granwave.lammps_inputs.case.contact.contact import INITIAL
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly

_KEY = "contact.normals"


def check_normals(assembly: Assembly, errors: ErrorList) -> None:
    """Check that contacts neither rotate nor open if the force directions are fixed."""
    case = assembly.case
    if case.contact.normals != INITIAL:
        return
    unlike = [
        ("friction", case.has_rotation),
        ("cohesion", case.has_cohesion),
        ("cylinders", assembly.has_cylinders),
        ("clumps", bool(assembly.clumps)),
        ("periodic sides", case.boundary.periodic),
        ('packing.kind = "restart"', case.packing.restart is not None),
    ]
    expected = "spheres without friction and cohesion between free sides or walls"
    for name, is_there in unlike:
        if is_there:
            errors.add(_KEY, Mismatch(f'"{INITIAL}" with {name}', expected))
