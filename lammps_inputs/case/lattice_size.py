"""Sizes of lattices: the axes that a kind has, rows with a grain at least, and room in the memory."""

from __future__ import annotations

from granwave.lammps_inputs.case.packing import PackingSection
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.lattices import kind_of
from granwave.lammps_inputs.memory import available_memory
from granwave.lammps_inputs.plane_lattices import is_plane_crystal

_KEY = "packing.size"


def check_size(packing: PackingSection, errors: ErrorList) -> bool:
    """Check that a packing has a size of its kind; return True if it has, or if its grains come from a file."""
    axes = kind_of(packing.kind).axes
    if packing.grains is not None:
        return True
    if len(packing.size) != len(axes):
        form = "a number n" if len(axes) == 1 else "[" + ", ".join(f"n{axis}" for axis in axes) + "]"
        errors.add(_KEY, f"found {show(packing.size)}, expected {form} for {packing.kind}")
        return False
    if is_plane_crystal(packing.kind) and packing.top_row != "equal" and packing.size[0] <= 1:
        errors.add(_KEY, f"found {show(packing.size)}: the short rows would be empty; expected 2 or more in a row")
        return False
    return True


def check_memory_of_sites(packing: PackingSection, n_sites: int, bytes_of_site: float, errors: ErrorList) -> bool:
    """Check that the memory suffices for arrays over so many sites of a lattice; return True if it does."""
    needed, available = n_sites * bytes_of_site, available_memory()
    if needed <= available:
        return True
    errors.add(
        _KEY,
        f"found {show(packing.size)}: {packing.lattice().n_spheres} spheres need more than {needed / 2**30:.1f} GiB of "
        f"memory, there is {available / 2**30:.1f} GiB; make the packing smaller or change machine",
    )
    return False
