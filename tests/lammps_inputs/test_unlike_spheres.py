"""Vacancies and replaced spheres."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.packing import build_packing
from granwave.lammps_inputs.packing.places import struck_spheres
from tests.helpers.disordered import BALL, INNER, D, all_gaps, around, case_of


class TestVacancies:
    def test_ids_are_those_of_the_lattice(self, tmp_path: Path) -> None:
        case = case_of(packing={"vacancies": [1, 17, 300]})
        packing, full = build_packing(case), build_packing(case_of())
        kept = np.setdiff1d(full.ids, [1, 17, 300])
        np.testing.assert_array_equal(packing.ids, kept)
        np.testing.assert_array_equal(packing.positions, full.positions[kept - 1])
        np.testing.assert_array_equal(packing.rows(packing.ids), np.arange(len(kept)))
        expected = full.contacts[~np.isin(full.contacts, [1, 17, 300]).any(axis=1)]
        np.testing.assert_array_equal(packing.contacts, expected)
        assert (assemble(case).n_spheres, assemble(case).n_contacts) == (333, len(expected))
        assert assemble(case).last_sphere == 336 and not assemble(case).plain
        np.testing.assert_array_equal(packing.coordination, np.bincount(expected.ravel(), minlength=337)[kept])
        write_data(assemble(case), tmp_path / "data")
        text = (tmp_path / "data").read_text().split("Atoms # sphere: id type diameter density x y z")
        assert "\n333 atoms\n" in text[0]
        rows = np.array([row.split() for row in text[1].split("\n") if row], dtype=float)
        np.testing.assert_array_equal(rows[:, 0], kept)
        np.testing.assert_array_equal(rows[:, 4:], packing.positions)

    @pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "chain"])
    def test_a_share_never_takes_what_the_case_names(self, kind: str) -> None:
        case = case_of(
            kind,
            packing={"vacancies": 0.5},
            replace=[{"index": [2, 3], "material": "steel"}],
            sensor=[{"name": "one", "id": 5}],
            output={"probes": [{"sphere": 7}, {"contact": [8, 9]}]},
            striker=[{"touches": 4}],
            load={"kind": "impact"},
        )
        n = assemble(case).lattice.n_spheres
        assert assemble(case).sites.count == n - round(n / 2)
        named = {*struck_spheres(assemble(case).lattice, 1), 2, 3, 4, 5, 7, 8, 9}
        assert named <= set(assemble(case).ids.tolist())
        assert assemble(case).ids[-1] == n + 1 and len(assemble(case).positions()) == assemble(case).n_spheres

    def test_a_striker_can_sit_in_one(self) -> None:
        """Striker between the two spheres next to a vacancy at the edge of a square packing, as near as diameters permit."""
        tables = {"vacancies": [5], "diameter_scatter": 1e-6}
        case = case_of("square", packing=tables, striker=[{"touches": [4, 6], "diameter": 0.012}])
        packing = build_packing(case)
        assert packing.ids[-1] == 73 and packing.n_spheres == 72
        assert packing.positions[-1] == pytest.approx([4 * D, -math.sqrt(0.011**2 - D**2), 0], abs=1e-6)
        assert packing.contacts.tolist() == [[4, 73], [6, 73]]

    def test_they_are_anywhere(self) -> None:
        case = case_of(size=(40, 40, 25), packing={"vacancies": 0.1})
        gone = np.setdiff1d(np.arange(1, 40_001), assemble(case).ids)
        assert len(gone) == 4000
        assert stats.kstest(gone / 40_000, "uniform").pvalue > 1e-3
        assert stats.chisquare(np.bincount((gone - 1) % 40, minlength=40)).pvalue > 1e-3


class TestReplaced:
    def test_later_entries_overrule_earlier_ones(self) -> None:
        box = {"low": [0, 0, 0], "high": [1, 1, 0.001]}
        case = case_of(replace=[box | {"material": "steel", "diameter": 0.009}, {"index": 3, "material": "ptfe"}],
                       contact={"law": "hertz"})  # fmt: skip
        top = assemble(case).lattice.n_spheres // 6
        names = [assemble(case).material_of(sphere).name for sphere in (1, 2, 3, top, top + 1)]
        assert names == ["steel", "steel", "ptfe", "steel", "brass"]
        assert [assemble(case).diameter_of(sphere) for sphere in (1, 3, top, top + 1)] == [0.009, D, 0.009, D]
        sites = assemble(case).sites
        assert [np.count_nonzero(one) for one in (sites.nominal != D, sites.body)] == [top - 1, top]

    def test_smaller_ones_leave_gaps(self) -> None:
        case = case_of(replace=[{"index": INNER, "diameter": 0.009}])
        packing = build_packing(case)
        assert (
            packing.coordination[INNER - 1] == 0
            and assemble(case).n_contacts == assemble(case_of()).lattice.n_contacts - 12
        )
        assert np.sort(all_gaps(packing)[INNER - 1])[:12] == pytest.approx(0.0005, rel=1e-9)

    def test_larger_ones_next_to_vacancies_can_touch_beyond_neighbours(self) -> None:
        case = case_of(packing={"vacancies": around(INNER)}, replace=[BALL])
        packing = build_packing(case)
        gaps = all_gaps(packing)
        assert gaps.min() > -1e-15
        pairs = np.argwhere(gaps <= 1e-6 * D)
        expected = packing.ids[pairs[pairs[:, 0] < pairs[:, 1]]]
        np.testing.assert_array_equal(packing.contacts, expected)
        assert np.count_nonzero(expected == INNER) == 6 and assemble(case).n_contacts == len(expected)

    def test_images_of_larger_ones_count(self) -> None:
        """Sphere 61 is at two faces of the box: its neighbors across them must be removed, too."""
        periodic = {"sides": "periodic"}
        ball, near = [{"index": 61, "diameter": 0.018}], around(61, case_of("sc", boundary=periodic))
        fits = case_of("sc", packing={"vacancies": near}, boundary=periodic, replace=ball)
        assert len(near) == 6 and all_gaps(build_packing(fits)).min() > -1e-15
        inside = around(61, case_of("sc"))
        assert assemble(case_of("sc", packing={"vacancies": inside}, replace=ball, boundary={"bottom": "free"}))
        with pytest.raises(InputError, match=r"sphere 61 of 0.018 m overlaps sphere \d+ by 0.004 m \(and 1 more"):
            case_of("sc", packing={"vacancies": inside}, boundary=periodic, replace=ball)

    @pytest.mark.parametrize("sides", ["free", "periodic"])
    def test_next_to_small_ones_there_is_room(self, sides: str) -> None:
        ring = {"index": around(INNER), "diameter": 0.009}
        case = case_of(replace=[ring, {"index": INNER, "diameter": 0.011}], boundary={"sides": sides})
        assert build_packing(case).coordination[INNER - 1] == 12

    def test_a_share_of_the_spheres_that_there_are(self) -> None:
        case = case_of(packing={"vacancies": 0.25}, replace=[{"share": 0.5, "material": "steel"}])
        steel = 1 + np.flatnonzero(assemble(case).sites.body)
        assert assemble(case).n_spheres == 252 and len(steel) == 126 and set(steel) < set(assemble(case).ids.tolist())
