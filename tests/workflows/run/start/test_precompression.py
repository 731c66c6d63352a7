"""Precompression: static stage compared with closed forms, subsequent wave, and errors."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.optimize import brentq

from granwave._contact_laws import ContactLaw
from granwave.analysis import MissingOutputError, OutputFormatError
from granwave.analysis.result.writer import write_result
from granwave.lammps_inputs import flat_contact, write_deck
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.run import BALANCE_TOLERANCE as TOLERANCE
from granwave.lammps_inputs.contact.law import pair_contact, sphere_contact
from granwave.lammps_inputs.contact.static_load import dead_loads, force_of_contact
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows.run import driver

D = 0.01
FORCE = 2.0  # N; first yield of the chain is at 5.5 N
QUIET = {"end_time": 2e-5}


def make(kind: str = "chain", size: Any = 12, **sections: Any) -> Case:
    packing = {"kind": kind, "size": size, "diameter": D} | sections.pop("packing", {})
    sections.setdefault("precompression", {"kind": "uniaxial", "force": FORCE})
    sections.setdefault("run", QUIET)
    return case_from_dict(
        {"name": "static", "packing": packing, **{"material": "brass", **sections}}
    )


def ran(case: Case, directory: Path, **options: Any) -> dict[str, Any]:
    outcome = driver.run_case(case, directory, figures=False, **options)
    assert outcome.state == "finished"
    return outcome.summary


def table(path: Path) -> dict[str, np.ndarray]:
    lines = path.read_text().splitlines()
    title = [line for line in lines if line.startswith("#")][-1]
    rows = np.array([line.split() for line in lines if not line.startswith("#")], dtype=float)
    return dict(zip(title.lstrip("#").split(), rows.T, strict=True))


def frame(directory: Path, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions in the data file, and displacements of a snapshot."""
    with h5py.File(directory / "result.h5") as file:
        return file["spheres/position"][()], file["particles/spheres/displacement/value"][number]


def initial_forces(directory: Path) -> dict[str, np.ndarray]:
    """Forces of contacts and on walls after the static stage, N."""
    with h5py.File(directory / "result.h5") as file:
        return {name: file[f"{name}/initial_force"][()] for name in ("contacts", "wall_contacts")}


def hertz(case: Case) -> float:
    """Coefficient k of F = k alpha^1.5, N/m^1.5."""
    law = sphere_contact(case)
    return 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> tuple[Case, Path, dict[str, Any]]:
    """Long chain under a force, with an impact so weak that its contacts stay linear."""
    directory = tmp_path_factory.mktemp("static") / "chain"
    case = make(size=80, load={"velocity": 2e-5}, run={"end_time": 2e-3, "frames": 2})
    return case, directory, ran(case, directory)


class TestChain:
    def test_static_overlaps_and_record(self, chain: tuple[Case, Path, dict[str, Any]]) -> None:
        case, directory, summary = chain
        position, displacement = frame(directory, 0)
        overlap = D - np.diff((position + displacement)[:, 2])
        assert overlap == pytest.approx((FORCE / hertz(case)) ** (2 / 3), rel=1e-6)
        gap = assemble(case).bottom() - D / 2 - (position + displacement)[-1, 2]
        wall = flat_contact(case, 1)
        stiff = 4 / 3 * wall.effective_modulus * math.sqrt(wall.effective_radius)
        assert -gap == pytest.approx((FORCE / stiff) ** (2 / 3), rel=1e-6)
        found = table(directory / "dumps" / "prestage.txt")
        assert found["contacts"] == 79 and found["yielded"] == 0 and found["residual"] <= 1e-6
        assert found["largest_force"] == pytest.approx(FORCE, rel=1e-7)
        stored = 79 * 0.4 * FORCE ** (5 / 3) / hertz(case) ** (2 / 3) + 0.4 * FORCE ** (
            5 / 3
        ) / stiff ** (2 / 3)
        assert found["stored"] == pytest.approx(stored, rel=1e-6)
        assert (
            stored > 1e6 * summary["energy_input_J"] and summary["energy_balance_error"] < TOLERANCE
        )

    def test_velocity_of_small_waves(self, chain: tuple[Case, Path, dict[str, Any]]) -> None:
        """Long waves travel at c = D sqrt(k_t/m), k_t = 3/2 k alpha^0.5 (composite source, eq. 3).

        An impulse causes a step of the displacement of height v sqrt(m/k_t), whose front is the
        integral of the Airy function: long waves are at one third of its height.
        """
        case, directory, _ = chain
        with h5py.File(directory / "result.h5") as file:
            time = file["chain/time"][()]
            moved = file["chain/displacement"][()]
        stiffness = 1.5 * hertz(case) ** (2 / 3) * FORCE ** (1 / 3)
        level = case.load.velocity * math.sqrt(case.sphere_mass / stiffness) / 3

        def arrival(bead: int) -> float:
            risen = moved[:, bead] - moved[0, bead]
            first = int(np.argmax(risen > level))
            return float(
                np.interp(level, risen[first - 1 : first + 1], time[first - 1 : first + 1])
            )

        expected = D * math.sqrt(stiffness / case.sphere_mass)
        assert 40 * D / (arrival(60) - arrival(20)) == pytest.approx(expected, rel=2e-3)


@pytest.mark.validation
def test_a_long_chain_shortens_by_more_than_a_tenth_of_a_bead(tmp_path: Path) -> None:
    """Overlaps and residual overlaps sum to a displacement that does not count as disorder of the
    packing.
    """
    sections = {"material": "steel", "contact": {"initial_overlap": {"force": 2e3}}}
    ran(
        make(size=150, precompression={"kind": "uniaxial", "force": 100.0}, **sections),
        tmp_path / "r",
    )
    assert table(tmp_path / "r" / "dumps" / "prestage.txt")["displacement"] > 0.1 * D


class TestPackings:
    def test_fcc_under_uniform_pressure(self, tmp_path: Path) -> None:
        """The force of every contact is p D^2/(2 sqrt 2)."""
        case = make("fcc", [6, 6, 4], precompression={"kind": "uniform", "pressure": 1e5})
        assert force_of_contact(assemble(case)) == pytest.approx(1e5 * D**2 / (2 * math.sqrt(2)))
        ran(case, tmp_path / "r")
        found = table(tmp_path / "r" / "dumps" / "prestage.txt")
        assert found["largest_force"] == pytest.approx(force_of_contact(assemble(case)), rel=1e-3)
        assert found["contacts"] == assemble(case).n_contacts
        position, displacement = frame(tmp_path / "r", 0)
        initial = initial_forces(tmp_path / "r")["contacts"]
        assert len(initial) == assemble(case).n_contacts
        assert initial == pytest.approx(force_of_contact(assemble(case)), rel=1e-3)
        assert initial.max() == pytest.approx(found["largest_force"][0], rel=1e-8)
        pairs = assemble(case).contacts() - 1
        apart = np.linalg.norm(np.diff((position + displacement)[pairs], axis=1)[:, 0], axis=1)
        assert D - apart == pytest.approx(
            (force_of_contact(assemble(case)) / hertz(case)) ** (2 / 3), rel=2e-3
        )

    def test_periodic_fcc_under_a_uniaxial_pressure(self, tmp_path: Path) -> None:
        """Three contacts transmit the load of a sphere; layers approach each other, spheres in one
        stay a diameter apart.
        """
        case = make(
            "fcc",
            [4, 4, 6],
            boundary={"sides": "periodic"},
            precompression={"kind": "uniaxial", "pressure": 1e5},
        )
        top = 1e5 * D**2 * math.sqrt(3) / 2

        def excess(height: float) -> float:
            apart = math.hypot(height, D / math.sqrt(3))
            return 3 * hertz(case) * (D - apart) ** 1.5 * height / apart - top

        layer = brentq(excess, 0.8 * D, math.sqrt(2 / 3) * D - 1e-12, xtol=1e-16)
        ran(case, tmp_path / "r")
        position, displacement = frame(tmp_path / "r", 0)
        heights = np.diff((position + displacement)[:, 2].reshape(6, 16), axis=0)
        closer = math.sqrt(2 / 3) * D - heights
        assert closer == pytest.approx(math.sqrt(2 / 3) * D - layer, rel=1e-6)

    def test_dead_loads_of_faces(self) -> None:
        """The force on each face is pressure times area; their sum is zero."""
        for kind, size in (
            ("fcc", [9, 10, 8]),
            ("hcp", [8, 8, 8]),
            ("sc", [5, 6, 7]),
            ("square", [6, 7]),
        ):
            stage = {"kind": "uniform", "pressure": 1e3}
            _, force = dead_loads(
                assemble(make(kind, size, precompression=stage, boundary={"bottom": "free"}))
            )
            assert np.abs(force.sum(axis=0)).max() < 1e-9
        _, force = dead_loads(
            assemble(make("sc", [5, 6, 7], precompression={"kind": "uniform", "pressure": 1000.0}))
        )
        assert force[:, 2].sum() == pytest.approx(1e3 * 30 * D**2)
        assert force[force[:, 0] > 0, 0].sum() == pytest.approx(1e3 * 42 * D**2)

    @pytest.mark.parametrize(
        ("stage", "boundary"),
        [
            ({"kind": "uniform", "pressure": 2e4}, {}),
            ({"kind": "gravity"}, {"sides": "periodic"}),
        ],
    )
    def test_scattered_diameters_settle(self, tmp_path: Path, stage: dict, boundary: dict) -> None:
        case = make(
            "fcc",
            [6, 6, 4],
            packing={"diameter_scatter": 2e-6},
            precompression=stage,
            boundary=boundary,
        )
        summary = ran(case, tmp_path / "r")
        found = table(tmp_path / "r" / "dumps" / "prestage.txt")
        assert found["residual"] <= 1e-6
        assert summary["energy_balance_error"] < TOLERANCE
        if stage["kind"] == "gravity":
            weight = assemble(case).sphere_masses().sum() * 9.81
            assert table(tmp_path / "r" / "dumps" / "walls.txt")["bottom"][0] == pytest.approx(
                weight, rel=1e-6
            )

    def test_few_contacts_under_a_light_load(self, tmp_path: Path) -> None:
        """After the search the minimiser needs almost no iterations; without it, thousands.

        The bottom carries the pressure.
        """
        case = make(
            "fcc", [4, 4, 8], packing={"diameter_scatter": 1e-5}, boundary={"sides": "periodic"},
            precompression={"kind": "uniaxial", "pressure": 3e3},
        )  # fmt: skip
        summary = ran(case, tmp_path / "r")
        found = table(tmp_path / "r" / "dumps" / "prestage.txt")
        assert found["residual"] <= 1e-6
        assert found["iterations"] < 200
        assert summary["energy_balance_error"] < TOLERANCE
        assembly = assemble(case)
        load = dead_loads(assembly)[1][:, 2].sum()
        bottom = table(tmp_path / "r" / "dumps" / "walls.txt")["bottom"][0]
        assert bottom == pytest.approx(load, rel=1e-5)

    def test_scattered_diameters_where_nothing_holds_the_packing(self, tmp_path: Path) -> None:
        """The packing neither drifts nor rotates."""
        case = make(
            "sc", [4, 4, 4], packing={"diameter_scatter": 2e-7}, boundary={"bottom": "free"},
            precompression={"kind": "uniform", "pressure": 2e4},
        )  # fmt: skip
        ran(case, tmp_path / "r")
        found = table(tmp_path / "r" / "dumps" / "prestage.txt")
        assert found["residual"] <= 1e-6
        _, displacement = frame(tmp_path / "r", 0)
        moment = assemble(case).sphere_masses() @ displacement
        assert np.abs(moment).max() < 1e-9 * assemble(case).sphere_masses().sum() * D

    def test_impact_on_top(self, tmp_path: Path) -> None:
        """Energy is balanced with yielding contacts, friction, and a movable plate."""
        case = make(
            "fcc", [6, 6, 4], load={"velocity": 5.0}, contact={"friction": 0.2}, run={"end_time": 1e-4},
            boundary={"bottom": {"plate": {"mass": 0.1, "stiffness": 1e7, "damping": 5.0}}},
            precompression={"kind": "uniform", "pressure": 1e5},
        )  # fmt: skip
        summary = ran(case, tmp_path / "r")
        assert summary["energy_balance_error"] < TOLERANCE
        assert summary["dissipated_fraction"] > 0.5
        ledger = table(tmp_path / "r" / "dumps" / "energy.txt")
        assert ledger["friction"][-1] > 0 and ledger["support"][-1] > 0


def overlap_of(law: ContactLaw, force: float) -> float:
    """Overlap at which a contact carries a force for the first time, m."""
    return brentq(lambda overlap: float(law.loading_force(overlap)) - force, 0, 0.1 * D, xtol=1e-18)


class TestYield:
    """Indentations of the static stage correspond to a load that grows monotonically."""

    def test_chain_under_its_weight(self, tmp_path: Path) -> None:
        """Each contact carries the weight above it; its overlap is that of the loading curve."""
        case = make(precompression={"kind": "gravity", "acceleration": 1100.0})
        ran(case, tmp_path / "r")
        weight = assemble(case).sphere_masses()[0] * 1100.0
        forces = weight * np.arange(1, 12)
        assert forces[-1] > 9 * sphere_contact(case).yield_force
        position, displacement = frame(tmp_path / "r", 0)
        overlaps = D - np.diff((position + displacement)[:, 2])
        law = sphere_contact(case)
        expected = np.array([overlap_of(law, force) for force in forces])
        assert overlaps == pytest.approx(expected, rel=1e-8)
        with h5py.File(tmp_path / "r" / "result.h5") as file:
            assert file["contacts/initial_force"][()] == pytest.approx(forces, rel=1e-8)
            dents = file["contacts/initial_overlap"][()]
            on_bottom = file["wall_contacts/initial_overlap"][0]
        yields = forces > law.yield_force
        assert dents == pytest.approx(np.where(yields, expected, 0.0), rel=1e-8)
        flat = flat_contact(case, 12)
        if 12 * weight > flat.yield_force > 0:
            assert on_bottom == pytest.approx(overlap_of(flat, 12 * weight), rel=1e-8)

    @pytest.mark.parametrize(
        "sections",
        [
            {"kind": "square", "size": [6, 6], "boundary": {"x": "wall"},
             "precompression": {"kind": "walls", "x": 6e-6}},
            {"kind": "fcc", "size": [4, 4, 4], "packing": {"diameter_scatter": 5e-6}, "boundary": {"sides": "periodic"},
             "precompression": {"kind": "uniaxial", "pressure": 1.3e5}},
            {"kind": "fcc", "size": [4, 4, 6], "packing": {"diameter_scatter": 5e-6}, "boundary": {"bottom": "free"},
             "precompression": {"kind": "uniform", "pressure": 1e5}},
            {"kind": "fcc", "size": [4, 4, 6], "packing": {"diameter_scatter": 2e-6}, "boundary": {"sides": "periodic"},
             "precompression": {"kind": "gravity", "acceleration": 1500.0}},
        ],
        ids=["walls", "uniaxial", "uniform", "gravity"],
    )  # fmt: skip
    def test_packings(self, tmp_path: Path, sections: dict) -> None:
        """No indentation is larger than its force causes, also if forces are redistributed."""
        case = make(**sections)
        ran(case, tmp_path / "r")
        assembly = assemble(case)
        with h5py.File(tmp_path / "r" / "result.h5") as file:
            names = ("i", "j", "initial_force", "initial_overlap")
            rows = zip(*(file[f"contacts/{name}"][()] for name in names), strict=True)
            dented = [row for row in rows if row[3] > 0]
        assert len(dented) >= 20
        for i, j, force, dent in dented:
            law = pair_contact(assembly, int(i), int(j))
            assert force > law.yield_force
            assert dent == pytest.approx(overlap_of(law, force), rel=1e-9)


class TestContinuation:
    def stopped(self, case: Case, directory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        looks = iter(range(100))
        with monkeypatch.context() as patched:
            patched.setattr(driver.StopRequest, "wanted", lambda _: next(looks) == 1)
            patched.setattr(driver, "_PIECE", 1e-3)
            assert driver.run_case(case, directory, figures=False).state == "interrupted"

    @pytest.mark.parametrize("contact", [{}, {"friction": 0.3, "loss": {"time": 5e-7}}])
    def test_resumed_run_gives_the_same_bits(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, contact: dict
    ) -> None:
        case = make(
            "fcc", [6, 6, 4], packing={"diameter_scatter": 1e-6}, precompression={"kind": "uniform", "pressure": 5e4},
            load={"velocity": 5.0, "angle": 20.0}, contact=contact, run={"end_time": 6e-5},
            output={"dump_format": "text"},
        )  # fmt: skip
        ran(case, tmp_path / "whole")
        self.stopped(case, tmp_path / "cut", monkeypatch)
        assert 0 < json.loads((tmp_path / "cut" / "run.json").read_text())["n_steps"] < 1000
        ran(case, tmp_path / "cut", resume=True)
        names = [
            "energy.txt",
            "spheres.dump",
            "contacts.dump",
            "walls.txt",
            "wall_bottom.dump",
            "prestage.txt",
        ]
        names += ["initial_forces.dump", "initial_forces_bottom.dump"]
        for name in names:
            whole, cut = ((tmp_path / one / "dumps" / name).read_text() for one in ("whole", "cut"))
            rows = [
                {line for line in text.splitlines() if line[:1] != "#"} for text in (whole, cut)
            ]
            assert rows[0] == rows[1], name  # the row of the checkpoint step may occur twice
        whole, cut = (initial_forces(tmp_path / one) for one in ("whole", "cut"))
        assert all(
            len(forces) and np.array_equal(forces, cut[name]) for name, forces in whole.items()
        )

    @pytest.mark.validation
    def test_two_ranks(self, granwave, tmp_path: Path) -> None:
        case = make(
            "fcc",
            [4, 4, 3],
            precompression={"kind": "uniform", "pressure": 1e5},
            load={"velocity": 5.0},
        )
        (tmp_path / "case.toml").write_text(case.to_toml())
        for ranks in (1, 2):
            both = ["--np", 2, "--set", "output.parts=true"] * (ranks - 1)
            done = granwave(
                "run", tmp_path / "case.toml", "-o", tmp_path / str(ranks), "--no-figures", *both
            )
            assert done.returncode == 0, done.stderr
        ledgers = [table(tmp_path / str(ranks) / "dumps" / "energy.txt") for ranks in (1, 2)]
        for name in ("kinetic", "elastic", "dissipated"):
            assert ledgers[1][name][-1] == pytest.approx(ledgers[0][name][-1], rel=1e-7, abs=1e-12)
        one, two = (initial_forces(tmp_path / str(ranks)) for ranks in (1, 2))
        dumps = tmp_path / "2" / "dumps"
        assert [file.name for file in dumps.glob("initial_forces.*.dump")] == [
            "initial_forces.0.dump"  # of one node
        ]
        for name, forces in one.items():
            assert forces.min() > 0 and two[name] == pytest.approx(forces, rel=1e-6), name
        noted = tmp_path / "2" / "dumps" / "initial_forces.txt"
        noted.write_text(f"{int(noted.read_text()) + 1}\n")
        with pytest.raises(
            OutputFormatError,
            match=r"initial_forces\.N\.dump \(N = 0, 1, \.\.\.\): found \d+ contacts, initial_",
        ):
            write_result(tmp_path / "2")
        (tmp_path / "2" / "dumps" / "initial_forces.0.dump").unlink()
        with pytest.raises(MissingOutputError, match=r"initial_forces\.N\.dump .* is missing"):
            write_result(tmp_path / "2")

    def test_deck_runs_by_hand(self, lmp, tmp_path: Path) -> None:
        deck = write_deck(make(run={"end_time": 1e-6}), tmp_path)
        assert sorted(path.name for path in tmp_path.glob("*.txt")) == ["preload_z.txt"]
        done = lmp(deck.script)
        assert done.returncode == 0, done.stdout[-2000:]
        assert table(tmp_path / "dumps" / "prestage.txt")["contacts"] == 11


class TestRefused:
    @pytest.mark.parametrize("sides", ["free", "wall"])
    def test_a_pile_without_sides_spreads(self, tmp_path: Path, sides: str) -> None:
        """Walls at the sides do not support rows that are offset by half a sphere."""
        case = make(
            "fcc", [4, 4, 4], packing={"vacancies": [1]}, boundary={"sides": sides},
            precompression={"kind": "uniaxial", "pressure": 1e5},
        )  # fmt: skip
        advice = r'boundary.sides = "periodic", or precompression.kind = "uniform"'
        with pytest.raises(
            RunError,
            match=rf"moved by .* diameters.*not confined: use {advice} .*walls.*support\)$",
        ):
            driver.run_case(case, tmp_path / "r", figures=False)

    def test_a_bottom_that_gave_way(self, tmp_path: Path) -> None:
        plate = {"plate": {"mass": 0.1, "stiffness": 1e2, "damping": 0.0}}
        with pytest.raises(RunError, match=r"or the bottom moved: use a stiffer boundary.bottom$"):
            driver.run_case(make(boundary={"bottom": plate}), tmp_path / "r", figures=False)

    def test_what_can_be_in_balance_is_accepted(self) -> None:
        """Under gravity some contacts never yield; walls may support a pile."""
        chain = make("chain", 2000, precompression={"kind": "gravity"})
        assert chain.packing.n_spheres == 2000
        stage = {"kind": "uniaxial", "force": 1.0}
        sides = {"sides": "wall", "bottom": "fixed"}
        for case in (
            make("fcc", [5, 5, 2], precompression=stage, boundary=sides),
            make("sc", [4, 4, 4], precompression=stage),
        ):
            assert case.precompression.force == 1.0
