"""Runs with initial indentations and initial forces."""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from granwave.analysis import MissingOutputError, OutputFormatError, analyse
from granwave.lammps_inputs import pair_contact
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.run import BALANCE_TOLERANCE as TOLERANCE
from granwave.lammps_inputs.contact.initial_dents import contacts_at_start, dents_table
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.run_directory import MARKER
from granwave.workflows.run.driver import run_case
from tests.helpers.bodies.two_spheres import R


def case_of(
    kind: str = "fcc", size: Any = (5, 5, 3), *, contact: Any = None, **sections: Any
) -> Case:
    """Case of a small packing of brass, or of a chain."""
    packing = {
        "kind": kind,
        "size": list(size) if isinstance(size, tuple) else size,
        "diameter": 2 * R,
    }
    packing |= sections.pop("packing", {})
    sections.setdefault("run", {"end_time": 1e-4})
    return case_from_dict(
        {
            "name": "dented",
            "packing": packing,
            "material": "brass",
            "contact": contact or {},
            **sections,
        }
    )


def ran(case: Case, directory: Path, **options: Any) -> dict[str, Any]:
    """Summary of a case that was run to its end."""
    outcome = run_case(case, directory, figures=False, **options)
    assert outcome.state == "finished"
    assert outcome.summary["energy_balance_error"] < TOLERANCE
    return outcome.summary


def dents(text: str) -> dict[tuple[str, int], float]:
    rows = [line.split() for line in text.splitlines() if not line.startswith("#")]
    return {(first, int(second)): float(peak) for first, second, peak in rows}


UPPER = {"overlap": 5e-6}


class TestTable:
    def test_a_value_is_for_all_that_touch(self) -> None:
        case = case_of(contact={"initial_overlap": 5e-6})
        found = dents(dents_table(assemble(case)))
        between = {(str(i), j) for i, j in assemble(case).contacts().tolist()}
        on_floor = {("bottom", sphere) for sphere in range(51, 76)}
        assert set(found) == between | on_floor
        assert set(found.values()) == {5e-6}

    def test_the_other_side_of_a_periodic_packing(self) -> None:
        case = case_of(
            size=(4, 4, 3),
            contact={"initial_overlap": 5e-6},
            boundary={"sides": "periodic", "bottom": "free"},
        )
        assert len(dents(dents_table(assemble(case)))) == assemble(case).n_contacts

    def test_of_a_force(self) -> None:
        case = case_of(
            "chain",
            4,
            contact={"initial_overlap": {"force": 300.0}},
            replace=[{"index": 2, "diameter": 0.02}],
        )
        found = dents(dents_table(assemble(case)))
        for pair in ((1, 2), (3, 4)):
            law = pair_contact(case, *pair)
            peak = found[str(pair[0]), pair[1]]
            assert float(law.loading_force(np.array([peak]))[0]) == pytest.approx(300.0, rel=1e-9)
        assert found["1", 2] != found["3", 4]

    @pytest.mark.parametrize(
        ("size", "given", "sections", "expected"),
        [
            # contacts at z = 5, 15, 25 and, with the wall, 35 mm; the later region overrules
            (4, [UPPER | {"high": [1, 1, 1.4e-2]}, {"overlap": 9e-6, "low": [-1, -1, 0], "high": [1, 1, 9e-3]}], {},
             {("1", 2): 9e-6}),
            (4, [UPPER | {"high": [1, 1, 1.6e-2]}, {"overlap": 0.0, "high": [1, 1, 9e-3]}], {}, {("2", 3): 5e-6}),
            # what never yields has none; nor has what is below first yield
            (3, 5e-6, {"replace": [{"index": 2, "material": "steel"}],
                       "pair": [{"materials": ["brass", "steel"], "law": "hertz"}]}, {("bottom", 3): 5e-6}),
            (3, 5e-7, {}, {}),
            # faces of bars
            (2, 5e-6, {"bar": {"length": 0.1, "area": 1e-4, "elements": 10}}, {("1", 2): 5e-6, ("3", 2): 5e-6}),
        ],
    )  # fmt: skip
    def test_in_a_chain(self, size: int, given: Any, sections: dict, expected: dict) -> None:
        case = case_of("chain", size, contact={"initial_overlap": given}, **sections)
        assert dents(dents_table(assemble(case))) == expected
        assert case_from_dict(tomllib.loads(case.to_toml())) == case
        if "bar" in sections:
            places = [meetings.place[0, 2] for meetings in contacts_at_start(assemble(case))]
            assert places == pytest.approx([0.005, 0.015])

    def test_scattered_spheres_that_do_not_touch_have_dents_too(self) -> None:
        case = case_of(
            packing={"diameter_scatter": 5e-6, "vacancies": [19]}, contact={"initial_overlap": 5e-6}
        )
        found = dents(dents_table(assemble(case)))
        assert len(found) == assemble(case).n_neighbours + 25
        assert not any(first == "19" or second == 19 for first, second in found)


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A first impact, and its summary."""
    directory = tmp_path_factory.mktemp("dents") / "first"
    return directory, ran(case_of(), directory)


class TestRuns:
    def test_elastic_up_to_the_force_that_was_chosen(
        self, first: tuple[Path, dict[str, Any]], tmp_path: Path
    ) -> None:
        hard = case_of(contact={"initial_overlap": {"force": 2000.0}}, load={"velocity": 2.0})
        summary = ran(hard, tmp_path / "hard")
        assert 5.6 < summary["peak_force_N"] < 2000
        assert summary["n_plastic_contacts"] == 0
        assert summary["energy_dissipated_J"] == pytest.approx(0.0, abs=1e-12)
        harder = case_of(contact={"initial_overlap": {"force": 200.0}}, load={"velocity": 5.0})
        assert (
            0
            < ran(harder, tmp_path / "harder")["n_plastic_contacts"]
            < first[1]["n_plastic_contacts"]
        )

    def test_hit_twice(self, first: tuple[Path, dict[str, Any]], tmp_path: Path) -> None:
        """The second impact starts with the dents of the first, including those on the wall, and
        dissipates less.
        """
        before = shutil.copytree(first[0], tmp_path / "first")
        case = case_of(contact={"initial_overlap": str(before)})
        second = ran(case, tmp_path / "second")
        assert second["energy_dissipated_J"] < 0.9 * first[1]["energy_dissipated_J"]
        with (
            h5py.File(before / "result.h5") as one,
            h5py.File(tmp_path / "second" / "result.h5") as two,
        ):
            for group, least in (("contacts", 100), ("wall_contacts", 5)):
                left = _of(one[group], "peak_overlap", above=sphere_contact(case).yield_overlap)
                found = _of(two[group], "initial_overlap")
                assert len(left) > least
                assert {key: found.get(key) for key in left} == left
        shutil.rmtree(before)  # resume and analysis have all required files
        assert ran(case, tmp_path / "second", resume=True) == second

    def test_with_precompression(self, tmp_path: Path) -> None:
        case = case_of(contact={"initial_overlap": {"force": 100.0}}, load={"velocity": 0.1},
                    precompression={"kind": "uniform", "pressure": 5e5})  # fmt: skip
        summary = ran(case, tmp_path / "r")
        assert summary["n_plastic_contacts"] == 0
        assert summary["energy_dissipated_J"] == pytest.approx(0.0, abs=1e-12)


class TestRefused:
    def test_another_packing(self, tmp_path: Path) -> None:
        short = {"end_time": 1e-6}
        ran(case_of("chain", 4, run=short), tmp_path / "r")
        given = {"initial_overlap": str(tmp_path / "r")}
        for size, packing, message in (
            (5, {}, "found 4 spheres, expected 5"),
            (4, {"diameter": 0.011}, r"found sphere 4 at a distance of 0.003 m"),
            (4, {"diameter_scatter": 1e-6}, r"with a diameter that differs by"),
        ):
            with pytest.raises(InputError, match=f"belongs to another packing: .*{message}"):
                dents_table(assemble(case_of("chain", size, contact=given, packing=packing)))


def _of(group: h5py.Group, name: str, above: float = 0.0) -> dict[tuple[Any, int], float]:
    """Values by contact, if above a limit."""
    first = group["i"][()].tolist() if "i" in group else group["wall"].asstr()[()].tolist()
    second = group["j" if "j" in group else "id"][()].tolist()
    values = zip(first, second, group[name][()].tolist(), strict=True)
    return {(one, other): value for one, other, value in values if value > above}


FORCE = 20.0  # N
COLUMN = "initial_force"


def run(directory: Path, **sections: Any) -> Path:
    packing = {"kind": "chain", "size": 8, "diameter": 0.01}
    tables = {
        "name": "static",
        "packing": packing,
        "material": "steel",
        "run": {"end_time": 2e-6, "frames": 2},
    }
    tables |= {"contact": {"law": "hertz"}}
    case = case_from_dict(
        tables | {"precompression": {"kind": "uniaxial", "force": FORCE}} | sections
    )
    assert run_case(case, directory, figures=False).state == "finished"
    return directory


def table(directory: Path, group: str) -> dict[str, np.ndarray]:
    with h5py.File(directory / "result.h5") as file:
        assert (
            group not in file
            or COLUMN not in file[group]
            or file[group][COLUMN].attrs["unit"] == "N"
        )
        return {name: values[()] for name, values in file[group].items()}


@pytest.fixture(scope="module")
def struck(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Chain under a force, and a striker that rests against it until the run begins."""
    striker = {
        "load": {"kind": "striker"},
        "striker": [{"touches": [1], "velocity": [0.0, 0.0, 1.0]}],
    }
    return run(
        tmp_path_factory.mktemp("initial") / "chain", **striker, run={"end_time": 5e-5, "frames": 2}
    )


@pytest.fixture
def copied(struck: Path, tmp_path: Path) -> Path:
    return shutil.copytree(struck, tmp_path / "run")


def test_chain_under_a_force(struck: Path) -> None:
    contacts, walls = (table(struck, group) for group in ("contacts", "wall_contacts"))
    of_striker = contacts["j"] == 9
    assert contacts[COLUMN][~of_striker] == pytest.approx(np.full(7, FORCE), rel=1e-7)
    assert walls["id"].tolist() == [8] and walls[COLUMN] == pytest.approx([FORCE], rel=1e-7)
    assert contacts[COLUMN][of_striker].tolist() == [0.0] and contacts["peak_force"][of_striker] > 0


def test_chain_on_a_bar(tmp_path: Path) -> None:
    """The contact with the face of a bar belongs to the pair style."""
    bar = {"length": 0.1, "area": 1e-4, "elements": 20, "end": "fixed"}
    walls = table(
        run(tmp_path, boundary={"bottom": {"bar": bar, "material": "steel"}}), "wall_contacts"
    )
    assert walls["id"].tolist() == [8] and walls[COLUMN] == pytest.approx([FORCE], rel=1e-6)


def test_planes_that_touch_spheres_of_two_materials(tmp_path: Path) -> None:
    """Each material has a separate fix; two chains are pressed by a force on each lateral wall."""
    directory = run(
        tmp_path,
        packing={"kind": "sc", "size": [3, 2, 2], "diameter": 0.01},
        replace=[{"index": [1, 6], "material": "brass"}],
        boundary={"sides": "wall"},
        precompression={"kind": "walls", "x_force": FORCE},
    )
    walls = table(directory, "wall_contacts")
    for name in (b"xlo", b"xhi"):
        on_wall = walls["wall"] == name
        assert on_wall.sum() == 4 and walls[COLUMN][on_wall].sum() == pytest.approx(FORCE, rel=1e-6)
    assert (directory / "dumps" / "initial_forces_xlo_2.dump").exists()


def test_results_of_a_version_that_did_not_write_them(copied: Path) -> None:
    marker = json.loads((copied / MARKER).read_text())
    own = [name for name in marker["files"] if "initial_forces" in name]
    assert own == ["dumps/initial_forces.dump", "dumps/initial_forces_bottom.dump"]
    for name in own:
        (copied / name).unlink()
        del marker["files"][name]
    (copied / MARKER).write_text(json.dumps(marker))
    before = table(copied, "contacts")
    analyse(copied, figures=False)
    after = table(copied, "contacts")
    assert before.keys() - after.keys() == {COLUMN} and COLUMN not in table(copied, "wall_contacts")
    assert all(np.array_equal(after[name], before[name], equal_nan=True) for name in after)


@pytest.mark.parametrize("name", ["initial_forces.dump", "initial_forces_bottom.dump"])
def test_missing_or_cut(copied: Path, name: str) -> None:
    path = copied / "dumps" / name
    text = path.read_text()
    path.write_text(text[:-3])
    with pytest.raises(
        OutputFormatError, match=rf"{name}: (differs from the file that the run wrote|.* cut short)"
    ):
        analyse(copied, figures=False)
    path.unlink()
    with pytest.raises(
        MissingOutputError, match=rf"{name} is missing; run the case again with force=True"
    ):
        analyse(copied, figures=False)


@pytest.mark.parametrize(("name", "old", "new"), [("", "1 2 ", "1 77 "), ("_bottom", "8 ", "3 ")])
def test_of_another_run(copied: Path, name: str, old: str, new: str) -> None:
    path = copied / "dumps" / f"initial_forces{name}.dump"
    path.write_text(path.read_text().replace(f"\n{old}", f"\n{new}"))
    with pytest.raises(
        OutputFormatError,
        match=rf"{path.name}: (differs from the file that the run wrote|"
        "found .* belong to different runs)",
    ):
        analyse(copied, figures=False)
