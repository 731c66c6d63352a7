"""Cases of short chains of brass beads."""

from __future__ import annotations

from typing import Any

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.load_case import case_from_dict

BRASS = {"youngs_modulus": 115e9, "poisson_ratio": 0.30, "density": 8500.0, "yield_strength": 550e6}
DIAMETER = 9.52e-3
PULSE = {"kind": "force", "shape": "half-sine", "amplitude": 4e3, "duration": 2e-5}


def case_of(size: int = 12, **tables: Any) -> Case:
    """A chain of brass beads, free at the bottom where the tables do not say otherwise."""
    tables = {"boundary": {"bottom": "free"}, "contact": {"law": "elastoplastic"}, "run": {"end_time": 1.5e-4}} | tables
    packing = {"kind": "chain", "size": size, "diameter": DIAMETER}
    return case_from_dict({"name": "chain", "material": BRASS, "packing": packing} | tables)
