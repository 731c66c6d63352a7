"""Runs with cohesion: packings at rest, energies, summary, timestep, pairs, and rejected input."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs import auto_timestep, build_packing
from granwave.lammps_inputs.contact.law import cohesive_laws
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import load_case, run_case

JKR = {"contact.law": "hertz", "contact.cohesion": {"kind": "jkr", "energy": 10.0}}
DMT = {"contact.cohesion": {"kind": "dmt", "energy": 10.0}}
SIZES = {"xyz": [5, 6, 6], "xy": [6, 5], "xz": [6, 6], "z": 9}


def case(kind: str = "fcc", **others: object):
    changes = {
        "packing.kind": kind,
        "packing.size": SIZES[KINDS[kind].axes],
        "run.end_time": 2e-5,
        "run.frames": 3,
    }
    changes |= {"boundary.sides": "free"}
    return load_case("fcc-small", changes | others)


@pytest.mark.parametrize(
    ("kind", "cohesion"), [*((kind, JKR) for kind in KINDS), ("fcc", DMT), ("chain", DMT)]
)
def test_a_packing_begins_at_rest(tmp_path: Path, kind: str, cohesion: dict) -> None:
    """A sphere impacted at 0.1 mm/s: all forces and energies are due to the impact."""
    walls = "wall" if KINDS[kind].axes in ("xyz", "z") else "free"
    quiet = {
        "load.velocity": 1e-4,
        "run.timestep": 1e-8,
        "run.end_time": 1e-6,
        "boundary.bottom": walls,
    }
    pull = next(iter(cohesive_laws(assemble(case(kind, **cohesion, **quiet)))))[0].pull_off_force
    run_case(case(kind, **cohesion, **quiet), tmp_path / "run", figures=False)
    with Result(tmp_path / "run") as result:
        energy = result.ledger
        assert abs(energy["elastic"][0]) < 1e-9 * abs(energy["input"][0]) + 1e-15
        assert energy["largest_force"][0] < 1e-6 * pull
        assert len(result["contacts/i"]) == assemble(result.case).n_contacts


def test_the_spacing_is_that_without_force() -> None:
    bare = build_packing(case())
    held = build_packing(case(**JKR))
    law = next(cohesive_laws(held.assembly))[0]
    overlap = law.balanced_overlap
    assert len(held.contacts) == len(bare.contacts)
    assert held.gaps(held.contacts) == pytest.approx(-overlap, rel=1e-6)
    assert held.positions == pytest.approx(bare.positions * (1 - overlap / 0.01), rel=1e-12)
    bottom = next(wall for wall in held.walls if wall.name == "bottom")
    assert bottom.overlap == pytest.approx(
        2 ** (-1 / 3) * overlap
    )  # R* and E* are twice those of two spheres
    gaps = bottom.gaps(held.positions, np.full(held.n_spheres, 0.005))
    assert gaps.min() == pytest.approx(-bottom.overlap, rel=1e-6)


@pytest.mark.parametrize("cohesion", [JKR, DMT], ids=["jkr", "dmt"])
def test_the_ledger_has_a_column_of_cohesion(tmp_path: Path, cohesion: dict) -> None:
    found = run_case(
        case(**cohesion, **{"load.velocity": 0.3, "run.end_time": 2e-4}),
        tmp_path / "run",
        figures=False,
    ).summary
    assert found["energy_balance_error"] < 1e-5
    with Result(tmp_path / "run") as result:
        lost = result["energy/adhesion"]
        law = next(cohesive_laws(result.assembly))[
            0
        ]  # a jump is booked over two steps, with rounding of their errors
        parting = (
            float(law.elastic_energy(-(1 - 1e-9) * law.neck_length, 1e-6))
            if cohesion is JKR
            else 0.0
        )
        assert np.all(np.diff(lost) >= -0.1 * parting)
        assert (lost[-1] > 1e-4 * result.energy_input) == (cohesion is JKR)
        assert found["adhesion_fraction"] == pytest.approx(lost[-1] / result.energy_input)
        assert found["energy_dissipated_adhesion_J"] == lost[-1]
        assert result.yield_energy.sum() == pytest.approx(
            result.yield_ledger[-1], rel=1e-6, abs=1e-12 * result.energy_input
        )


def test_cohesion_bounds_the_timestep() -> None:
    slow = {"load.velocity": 1e-3}
    assert auto_timestep(case(**JKR, **slow)) < 0.5 * auto_timestep(
        case(**{"contact.law": "hertz"}, **slow)
    )
    fast = {"load.velocity": 20.0}
    assert auto_timestep(case(**JKR, **fast)) == auto_timestep(
        case(**{"contact.law": "hertz"}, **fast)
    )


def test_two_spheres_of_a_file_stick(tmp_path: Path) -> None:
    """Separate grains that collide below the sticking velocity: all energy except their common
    motion is dissipated or stored.
    """
    case = gw.case({
        "name": "two", "material": "brass", "boundary": {"bottom": "free"}, "run": {"end_time": 4e-4, "frames": 5},
        "packing": {"kind": "file", "grains": "x,y,z,diameter,vz\n0,0,0,0.01,0.015\n0,0,0.0100001,0.01,0\n"},
        "contact": {"law": "hertz", "cohesion": {"kind": "jkr", "energy": 100.0}},
    })  # fmt: skip
    found = run_case(case, tmp_path / "run", figures=False).summary
    assert found["energy_balance_error"] < 1e-5
    assert found["energy_elastic_J"] < 0
    assert found["energy_dissipated_adhesion_J"] > 0


def test_single_contacts_in_python() -> None:
    bodies = [{"shape": "sphere", "diameter": 0.01, "material": "steel"}] * 2
    options = {"cohesion": {"kind": "jkr", "energy": 1.0}}
    pull = 1.5 * np.pi * 0.0025
    balanced = gw.contact_overlap("hertz", bodies, 0.0, **options)
    assert gw.contact_force(
        "hertz", bodies, [balanced, 0.0], peak_overlap=1e-6, **options
    ) == pytest.approx([0.0, -8 / 9 * pull], abs=1e-9 * pull)
    assert gw.contact_force("hertz", bodies, -1e-9, peak_overlap=1e-6, **options) < -0.9 * pull
    assert gw.contact_force("hertz", bodies, -1e-9, **options) == 0.0
    assert gw.contact_energy("hertz", bodies, balanced, **options) < 0
    with pytest.raises(InputError, match="cohesion"):
        gw.contact_force("elastoplastic", bodies, 1e-7, **options)
    with pytest.raises(InputError, match="cohesion"):
        gw.contact_force("power", bodies, 1e-7, constant=1e9, exponent=1.5, **options)
