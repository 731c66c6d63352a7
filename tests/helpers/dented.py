"""Spheres with initial dents: collisions in LAMMPS, and cases, for the tests of preconditioning."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.checks import TOLERANCE
from granwave.workflows.run.driver import run_case
from tests.conftest import script_of
from tests.helpers.two_spheres import LAW, PAIR, R

D = 2 * R
MASS = 8500 * 4 / 3 * np.pi * R**3
REPORTS = """compute one all gran/hysteretic/contact 1 2
compute dents all gran/hysteretic/local
compute grains all gran/hysteretic/atom
compute en all gran/hysteretic/energy
thermo_style custom step c_ke c_en c_en[*] c_one[1]
"""
_LOCAL, _ARRAY, _ROWS = 2, 2, 4  # styles and types of LAMMPS's library


def start(lmp, speed=2.0, extra="", **options) -> None:
    """Input script of two touching spheres that are about to collide head-on."""
    velocities = [(0, 0, speed / 2), (0, 0, -speed / 2)]
    lmp.commands_string(script_of(PAIR, velocities=velocities, extra=REPORTS + extra, **options))


def meeting_in(dent: float) -> str:
    """Command that places the second sphere where it just touches the first with a dent between them."""
    return f"set atom 2 z {2 * R - LAW.residual_overlap(dent):.17g}"


def reading(directory: Path, text: str) -> str:
    """Command that reads these lines of dents from a file."""
    path = directory / "dents.txt"
    path.write_text(text, encoding="utf-8")
    return f"gran/dents read {path}"


def table(lmp) -> np.ndarray:
    """Values of ``compute gran/hysteretic/local``: (n_contacts, 16)."""
    if not lmp.extract_compute("dents", _LOCAL, _ROWS):  # for LAMMPS 29 Aug 2024, which fails at an array without rows
        return np.empty((0, 16))
    return lmp.numpy.extract_compute("dents", _LOCAL, _ARRAY).copy()


def case_of(kind: str = "fcc", size: Any = (5, 5, 3), *, contact: Any = None, **sections: Any) -> Case:
    """Case of a small packing of brass, or of a chain."""
    packing = {"kind": kind, "size": list(size) if isinstance(size, tuple) else size, "diameter": D}
    packing |= sections.pop("packing", {})
    sections.setdefault("run", {"end_time": 1e-4})
    return case_from_dict(
        {"name": "dented", "packing": packing, "material": "brass", "contact": contact or {}, **sections}
    )


def ran(case: Case, directory: Path, **options: Any) -> dict[str, Any]:
    """Summary of a case that was run to its end."""
    outcome = run_case(case, directory, figures=False, **options)
    assert outcome.state == "finished"
    assert outcome.summary["energy_balance_error"] < TOLERANCE
    return outcome.summary
