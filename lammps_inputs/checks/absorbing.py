"""Checks of ``[[absorb]]`` against the rest of a case."""

from __future__ import annotations

from granwave.lammps_inputs.case.absorb import MATCHED, Absorb
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.contact.absorbing import absorbing_ids, rise_of
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import struck_of


def check_absorbing(assembly: Assembly, errors: ErrorList) -> None:
    """Check which spheres absorb waves, and by what."""
    seen: dict[int, int] = {}
    for number, entry in enumerate(assembly.case.absorb, start=1):
        key = f"absorb.{number}"
        before = len(errors.lines)
        _check_entry(assembly, entry, key, errors)
        if len(errors.lines) > before:
            continue
        chosen = absorbing_ids(assembly, entry)
        _check_motion(assembly, chosen, key, errors)
        for one in chosen:
            if one in seen:
                errors.add(key, f"damps sphere {one}, which absorb.{seen[one]} damps too; expected each sphere once")
                break
            seen[one] = number


def _check_entry(assembly: Assembly, entry: Absorb, key: str, errors: ErrorList) -> None:
    case, lattice = assembly.case, assembly.lattice
    if (entry.index is None) == (entry.layers is None):
        errors.add(key, f"found {'both' if entry.index else 'neither'} of index and layers, expected one of them")
    elif entry.index is not None and max(entry.index) > lattice.n_spheres:
        n = lattice.n_spheres
        errors.add(f"{key}.index", f"found {max(entry.index)}, expected ids from 1 to {n}, the end of the packing")
    elif entry.layers is not None and case.packing.grains is not None:
        errors.add(f"{key}.layers", "found for grains of a file, which have no layers; give index")
    elif entry.layers is not None and entry.layers >= max(2, lattice.shape[2]):
        errors.add(f"{key}.layers", f"found {entry.layers}, expected fewer than all {lattice.shape[2]} layers")
    if (entry.rate is None) == (entry.impedance is None):
        errors.add(key, f"found {'both' if entry.rate else 'neither'} of rate and impedance, expected one of them")
    elif entry.impedance == MATCHED and (
        case.precompression is None or case.precompression.kind == "walls" or not len(lattice.rule.supports)
    ):
        errors.add(
            f"{key}.impedance",
            f"found {show(MATCHED)} for a packing whose contacts bear no known static force along z, so that there is "
            "no impedance of long waves; expected a number, N s/m, or a precompression",
        )
    if entry.impedance is not None and entry.towards != Absorb.towards:
        errors.add(f"{key}.towards", "belongs to a rate; an impedance is the same for each sphere")


def _check_motion(assembly: Assembly, chosen: tuple[int, ...], key: str, errors: ErrorList) -> None:
    """Check that no prescribed motion is damped, and that a rate has a way to rise."""
    case = assembly.case
    if case.load.kind == "displacement" and (driven := set(chosen) & set(struck_of(assembly))):
        errors.add(key, f"damps sphere {min(driven)}, whose displacement is prescribed; expected others")
    entry = case.absorb[int(key.split(".")[1]) - 1]
    if entry.rate is not None and (rise := rise_of(assembly, entry)) is not None and rise[0] == rise[1]:
        errors.add(f"{key}.towards", 'found spheres without extent in this direction, expected "none"')
