"""Titles of packing, load and bottom for studies and their tables."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from granwave.analysis.measures.target import period_of
from granwave.lammps_inputs.lattices import kind_of
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.motion import velocities_of

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case

_SQUARE_CM = 1e4
_LAWS = {"hertz": "elastic", "elastoplastic": "elasto-plastic"}


def impact_title(case: Case, *, height: bool = True) -> str:
    """``FCC packing of 12 x 12 x 8 brass spheres of 10 mm, elasto-plastic contacts, 5 m/s``.

    Parameters
    ----------
    height
        False: of packings that differ in it.
    """
    law = _LAWS.get(case.contact.law, case.contact.law)
    return f"{packing_title(case, height=height)}, {law} contacts, {load_label(case)}"


def packing_title(case: Case, *, height: bool = True) -> str:
    """``FCC packing of 12 x 12 x 8 brass spheres of 10 mm``; of a single sphere ``Brass sphere of 10 mm``."""
    packing = case.packing
    own, diameter = case.material.name or "", f"of {1e3 * packing.diameter:.4g} mm"
    if height and assemble(case).lattice.n_spheres == 1:
        words = f"{own} sphere {diameter}".lstrip()
        return words[:1].upper() + words[1:]
    whole = height or packing.kind == "square"  # which lies across the height
    size = " x ".join(map(str, packing.size if whole else packing.size[:-1]))
    kind = "Chain" if packing.kind == "chain" else f"{kind_of(packing.kind).label} packing"
    spheres = " ".join(filter(None, (size, own, "spheres", diameter)))
    return f"{kind} of {spheres}" + ("" if whole or not size else " a layer")


def load_label(case: Case) -> str:
    """Velocity of the fastest sphere, ``5 m/s``; for a force or a prescribed motion, that it acts on top."""
    if case.load.driven:
        return f"{case.load.kind} {f'along {list(case.load.direction or ())}' if case.load.slants else 'on top'}"
    return f"{max((math.hypot(*velocity) for velocity in velocities_of(assemble(case)).values()), default=0.0):g} m/s"


def bottom_label(case: Case) -> str:
    """``rigid wall``, ``concrete half-space``, ``plate of 0.5 kg, 314 µs``."""
    boundary = case.boundary
    support, material = boundary.bottom_support, boundary.bottom_material
    name = (material.name or "elastic") if material else "rigid"
    if support is None:
        return {"fixed": "fixed last layer", "free": "no bottom"}.get(boundary.bottom, f"{name} wall")
    if support.plate:
        damped = ", damped" if support.plate.damping else ""
        return f"plate of {support.plate.mass:g} kg, {time_label(period_of(support.plate))}{damped}"
    if support.damper:
        return f"damper of {support.damper.damping:g} N s/m"
    if support.half_space:
        radius = support.half_space.radius
        return f"{name} half-space" + (f", disc of {1e3 * radius:g} mm" if radius else "")
    assert support.bar is not None
    end = "" if support.bar.end == "infinite" else f", far end {support.bar.end}"
    return f"{name} bar of {_SQUARE_CM * support.bar.area:.3g} cm²{end}"


def time_label(seconds: float) -> str:
    """``314 µs``, ``6.28 ms``."""
    return f"{1e3 * seconds:.3g} ms" if seconds >= 1e-3 else f"{1e6 * seconds:.3g} µs"
