"""Long validations of the physics, and the built-in scans."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import resource
import time
from pathlib import Path

import numpy as np
import pytest

from granwave.analysis import Result
from granwave.analysis.lammps_output.time_series import read_energy
from granwave.analysis.measures.impact import rays
from granwave.analysis.scans.result import ScanResult
from granwave.lammps_inputs import auto_timestep, build_packing, load_case, material, write_deck
from granwave.lammps_inputs.case.parse import apply_overrides
from granwave.lammps_inputs.contact.law import contact_of
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.places import struck_spheres
from granwave.workflows import library, load_scan
from granwave.workflows.run.driver import run_case
from granwave.workflows.scanning.driver import run_scan
from granwave.workflows.scanning.scan_file import Scan, ScanPoint
from granwave.workflows.scanning.suite import is_suite
from granwave.workflows.solvers import GRANULAR
from tests.helpers import second_solver
from tests.helpers.twins.twin import Network

pytestmark = pytest.mark.validation


def test_reference_study(process, tmp_path):
    """155 520 brass spheres, 5 m/s, 1 ms, against the network solution of the second solver."""
    ranks = min(2, os.cpu_count() or 1)
    begin = time.monotonic()
    done = process("run", "fcc-impact", "-o", tmp_path / "r", "--np", ranks, timeout=1200)
    wall = time.monotonic() - begin
    assert done.returncode == 0, done.stderr
    values = json.loads((tmp_path / "r" / "summary.json").read_text())
    print(f"\nreference study: {wall:.0f} s on {ranks} ranks")
    yield_force = contact_of([material("brass")], [0.005]).yield_force
    (solved,) = [row for row in second_solver.table("chapter_5") if row["packing"] == "reference"]
    fraction = float(solved["dissipated_fraction"])
    force = float(solved["peak_force_F_y"])
    yielded = int(solved["yielded_contacts"])
    assert values["dissipated_fraction"] == pytest.approx(fraction, abs=0.005)
    assert values["peak_force_N"] / yield_force == pytest.approx(force, abs=1)
    assert values["n_plastic_contacts"] == pytest.approx(yielded, abs=20)
    assert values["energy_balance_error"] < 3e-6
    assert values["n_steps"] < 8000  # 34 500 of 29 ns
    assert values["contacts_beyond_law"] == 0
    memory = ranks * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 2**20
    assert memory < 4, f"{memory:.2f} GiB"
    with Result(tmp_path / "r") as result:
        assert rays(result).difference.max(initial=0.0) < 1e-7


def test_same_bits_on_any_number_of_ranks(process, tmp_path):
    """Complete impact: all fields of all contacts, spheres and snapshots."""
    words = ["--set", "packing.size=[16,16,10]", "--set", "run.end_time=2e-4"]
    for ranks in (1, 2, 3, 4):
        done = process(
            "run", "fcc-impact", *words, "--np", ranks, "-o", tmp_path / str(ranks), timeout=900
        )
        assert done.returncode == 0, done.stderr
    with Result(tmp_path / "1") as one:
        fields = [
            f"{group}/{name}"
            for group in ("contacts", "spheres", "wall_contacts")
            for name in one.names(group)
        ]
        for ranks in (2, 3, 4):
            with Result(tmp_path / str(ranks)) as other:
                for name in fields:
                    floats = one[name].dtype.kind == "f"
                    assert np.array_equal(one[name], other[name], equal_nan=floats), (ranks, name)
                for frame in range(one.n_frames):
                    for name in ("displacement", "velocity", "contact_force"):
                        assert np.array_equal(one.frame(frame, name), other.frame(frame, name)), (
                            ranks,
                            frame,
                            name,
                        )
                for name in ("kinetic", "elastic", "dissipated"):
                    assert np.allclose(
                        other[f"energy/{name}"],
                        one[f"energy/{name}"],
                        rtol=1e-12,
                        atol=1e-14 * one.energy_input,
                    )


@pytest.mark.parametrize(("velocity", "normalised"), [(4, 37.9), (10, 94.9), (40, 379)])
def test_normalised_velocities(process, tmp_path, velocity, normalised):
    sets = [
        "--set",
        f"load.velocity={velocity}",
        "--set",
        "packing.size=[12,12,6]",
        "--set",
        "run.end_time=5e-5",
        "--set",
        "run.frames=2",
    ]
    assert process("run", "fcc-small", "-o", tmp_path / "r", *sets).returncode == 0
    assert json.loads((tmp_path / "r" / "summary.json").read_text())[
        "velocity_normalised"
    ] == pytest.approx(normalised, rel=2e-3)


def test_timestep_converges_long_before_2_ns(lmp, tmp_path):
    """Dissipated fraction, peak force and yielded contacts against the timestep; the thesis used 2
    ns.
    """
    rows = {}
    for dt in (2e-7, 1e-7, 5e-8, 3e-8, 2e-9):
        case = load_case(
            library.find("fcc-small"),
            ["packing.size=[16,16,8]", "run.end_time=2e-4", "run.frames=2", f"run.timestep={dt}"],
        )
        deck = write_deck(case, tmp_path / f"{dt:g}")
        assert lmp(deck.script, timeout=900).returncode == 0
        e = read_energy(deck.directory)
        error = (
            np.abs(e["kinetic"] + e["elastic"] + e["dissipated"] - e["input"]).max() / e["input"][0]
        )
        rows[dt] = (
            e["dissipated"][-1] / e["input"][0],
            e["largest_force"][-1],
            e["contacts_yielded"][-1],
            error,
        )
        print(
            f"\n{1e9 * dt:6.1f} ns: dissipated {rows[dt][0]:.6f}, peak {rows[dt][1]:.4f} N, yielded {rows[dt][2]:.0f}, balance {error:.1e}",
            end="",
        )
    finest = rows[2e-9]
    for dt in (1e-7, 5e-8, 3e-8):
        assert rows[dt][0] == pytest.approx(finest[0], abs=5e-5)
        assert rows[dt][1] == pytest.approx(finest[1], rel=1e-5)
        assert rows[dt][2] == pytest.approx(finest[2], abs=3)
    assert rows[2e-7][3] > 10 * rows[5e-8][3]


SMALL = ["packing.size=[16,16,8]"]


@pytest.mark.parametrize(
    ("case", "changes"),
    [
        ("fcc-small", SMALL),
        ("fcc-small", [*SMALL, "load.velocity=0.05"]),
        ("fcc-small", [*SMALL, "load.velocity=40"]),
        ("fcc-small", [*SMALL, "load.velocity=100"]),
        ("fcc-small", [*SMALL, "contact.law=hertz"]),
        ("fcc-small", [*SMALL, "contact.friction=0.3"]),
        ("fcc-small", ["packing.kind=bcc", "packing.size=[12,12,12]", "material=aluminium"]),
        (
            "fcc-small",
            ["packing.kind=sc", "packing.size=[10,10,10]", "material=stainless-steel-316"],
        ),
        ("hcp-small", [*SMALL, "material=steel"]),
        ("fcc-small", ["packing.size=[12,12,8]", "material=aluminium-2017", "load.velocity=20"]),
        ("square-out-of-plane", []),
        ("elastoplastic-pulse", ["run.timestep=auto"]),
        ("intruder", []),
        ("split-hopkinson", []),
    ],
)
def test_an_automatic_timestep_changes_nothing_that_matters(tmp_path, case, changes):
    """Compared with a fixed timestep equal to the first one, up to the end, when the spheres
    rattle: weak contacts differ most.
    """
    found = {}
    chosen = library.load_case(case, changes)
    for name, more in (("automatic", {}), ("fixed", {"run.timestep": auto_timestep(chosen)})):
        run = library.load_case(
            case, [*changes, *(f"{key}={value!r}" for key, value in more.items())]
        )
        found[name] = run_case(run, tmp_path / name, figures=False).summary
    one = found["automatic"]
    other = found["fixed"]
    assert one["energy_balance_error"] < chosen.run.energy_tolerance
    assert one["n_steps"] < other["n_steps"]
    assert one["dissipated_fraction"] == pytest.approx(other["dissipated_fraction"], abs=5e-5)
    assert one["n_plastic_contacts"] == pytest.approx(
        other["n_plastic_contacts"], abs=max(1, 1e-3 * other["n_plastic_contacts"])
    )
    forces = {}
    for name in found:
        with Result(tmp_path / name) as result:
            pairs = zip(result["contacts/i"], result["contacts/j"], strict=True)
            forces[name] = dict(zip(pairs, result["contacts/peak_force"], strict=True))
    both = sorted(forces["automatic"].keys() & forces["fixed"].keys())
    new, old = (np.array([forces[name][pair] for pair in both]) for name in ("automatic", "fixed"))
    strong = old > 1e-3 * old.max()
    apart = np.abs(new - old)
    most = apart.max() / old.max()
    median = float(np.median(apart[strong] / old[strong]))
    print(
        f"\n{case} {' '.join(changes)}: steps {other['n_steps']} -> {one['n_steps']}, balance "
        f"{other['energy_balance_error']:.1e} -> {one['energy_balance_error']:.1e}; peak forces apart by {most:.1e} of the largest, "
        f"by {median:.1e} in the median of those above a thousandth",
        end="",
    )
    assert most < 1e-3 and median < 5e-4


@pytest.mark.parametrize(
    ("velocity", "apart"), [(1, 1e-4), (5, 1e-4), (10, 1e-4), (40, 2e-3), (80, 5e-3)]
)
def test_fixed_normals_part_from_true_geometry_at_high_velocity(velocity, apart):
    """Effect of the fixed initial contact normals of the thesis (5.1 to 5.3) on the dissipated
    fraction.
    """
    case = load_case(library.find("fcc-small"), ["packing.size=[12,12,8]", "boundary.bottom=free"])
    packing = build_packing(case)
    struck = struck_spheres(assemble(case).lattice, 1)[0] - 1
    fractions = []
    for fixed in (True, False):
        twin = Network(packing.positions, packing.contacts - 1, 0.005, fixed_normals=fixed)
        twin.v[struck, 2] = velocity
        dt = 1e-7 if velocity < 20 else 5e-8
        twin.run(dt, int(2e-4 / dt))
        fractions.append(twin.dissipated() / (0.5 * twin.mass * velocity**2))
    print(
        f"\n{velocity} m/s: fixed normals {fractions[0]:.5f}, true geometry {fractions[1]:.5f}",
        end="",
    )
    assert abs(fractions[0] - fractions[1]) < apart
    if velocity >= 40:
        assert fractions[0] - fractions[1] > 5e-4


SCANS = [name for name in library.names(library.SCANS) if not is_suite(name)]
_POINTS = 3
_LONGEST = 1.0  # s, of a point
_LEAST = 0.4  # of the end time of a run with a load that is not an impact
_ELEMENTS = 1000  # of a finite-element mesh


def smallest(scan: Scan) -> Scan:
    """The cheapest points, shortened; one of them has the last value of the first key, so that this
    key varies.
    """
    cheap = sorted(scan.distinct.values(), key=lambda point: point.plan.wall_time)
    first = scan.varied[0]
    unlike = [point for point in cheap if point.labels[first] != cheap[0].labels[first]]
    chosen = {point.id: point for point in [cheap[0], *unlike[:1], *cheap[1:]]}
    points = sorted(list(chosen.values())[:_POINTS], key=lambda point: point.number)
    return dataclasses.replace(scan, points=tuple(map(short, points)))


def short(point: ScanPoint) -> ScanPoint:
    """The point shortened to about a second, if its case permits: an earlier end, or a coarser
    mesh.
    """
    tables = point.case.to_dict()
    struck = tables.get("load", {}).get("kind") == "impact"  # other loads may begin late
    share = max(_LONGEST / point.plan.wall_time, 0.0 if struck else _LEAST)
    if share >= 1:
        return point
    end = tables.get("run", {}).get("end_time")
    tries = [{"run.elements": _ELEMENTS}] if point.kind is not GRANULAR else []
    tries += [{"run.end_time": end * share}] if isinstance(end, float) else []
    for changes in tries:
        with contextlib.suppress(InputError):
            tables = point.kind.read(apply_overrides(tables, changes), Path("case.toml")).to_dict()
    case = point.kind.read(tables, Path("case.toml"))
    return dataclasses.replace(
        point, case=case, plan=point.kind.cost(point.kind.assemble(case), 1, False), ranks=1
    )


@pytest.mark.parametrize("name", SCANS)
def test_a_built_in_scan_ends_with_its_report(tmp_path, name):
    scan = smallest(load_scan(name, here=False))
    outcome = run_scan(scan, tmp_path / name, jobs=1)
    reasons = [
        point.reason for point in ScanResult(outcome.directory).points if point.status != "done"
    ]
    assert outcome.complete, reasons
    text = (outcome.directory / "report.html").read_text(encoding="utf-8")
    assert "could not be made" not in text


def test_every_suite_is_made_of_these_scans():
    suites = [name for name in library.names(library.SCANS) if name not in SCANS]
    for suite in suites:
        scans = read_toml(library.find(suite, library.SCANS))["scans"]
        assert {Path(one).stem for one in scans} <= set(SCANS)
