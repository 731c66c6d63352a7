"""Disorder, dissimilar spheres and initial indentations of a packing."""

from __future__ import annotations

import math
import time
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from granwave.lammps_inputs import auto_timestep, build_packing, plan, walls
from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.lammps_inputs.packing.places import struck_spheres
from granwave.workflows import load_case, run_case
from tests.helpers.made_up.small_cases import (
    BALL,
    INNER,
    LATTICES,
    D,
    all_gaps,
    around,
    diameters,
    packing_of,
)


class TestDiameters:
    @pytest.mark.parametrize("distribution", ["uniform", "normal"])
    def test_moments_and_distribution(self, distribution: str) -> None:
        band = 4e-5
        case = packing_of(
            size=(40, 40, 25),
            packing={"diameter_scatter": band, "scatter_distribution": distribution},
        )
        found = diameters(case)
        assert found.min() >= D - band and found.max() <= D
        deviation = band / math.sqrt(12) if distribution == "uniform" else band / 6
        law = stats.truncnorm(-3, 3, loc=D - band / 2, scale=deviation)
        law = stats.uniform(D - band, band) if distribution == "uniform" else law
        n = len(found)
        assert found.mean() == pytest.approx(D - band / 2, abs=4 * deviation / math.sqrt(n))
        assert found.std() == pytest.approx(law.std(), rel=4 / math.sqrt(n))
        assert stats.skew(found) == pytest.approx(0, abs=4 * math.sqrt(6 / n))
        assert stats.kstest(found, law.cdf).pvalue > 1e-3

    def test_neighbours_have_nothing_to_do_with_each_other(self) -> None:
        found = diameters(
            packing_of(size=(40, 40, 25), packing={"diameter_scatter": 1e-5})
        ).reshape(25, 40, 40)
        for axis in range(3):
            one = np.delete(found, 0, axis).ravel()
            other = np.delete(found, -1, axis).ravel()
            assert abs(np.corrcoef(one, other)[0, 1]) < 4 / math.sqrt(one.size)

    @pytest.mark.parametrize(
        ("kind", "sides"), [*product(KINDS, ["free"]), *product(LATTICES, ["periodic"])]
    )
    def test_gaps_follow_and_are_never_negative(self, kind: str, sides: str) -> None:
        band = 3e-4
        case = packing_of(kind, packing={"diameter_scatter": band}, boundary={"sides": sides})
        packing = build_packing(case)
        np.testing.assert_array_equal(
            packing.positions, build_packing(packing_of(kind, boundary={"sides": sides})).positions
        )
        gaps = all_gaps(packing)
        assert gaps.min() >= 0
        pairs = assemble(packing_of(kind, boundary={"sides": sides})).contacts() - 1
        found = diameters(case)
        expected = D - (found[pairs[:, 0]] + found[pairs[:, 1]]) / 2
        assert gaps[pairs[:, 0], pairs[:, 1]] == pytest.approx(expected, abs=1e-12 * D)
        assert np.median(expected) == pytest.approx(band / 2, rel=0.2)
        assert (
            len(packing.contacts)
            == assemble(case).n_contacts
            == np.count_nonzero(gaps <= 1e-6 * D) / 2
        )
        assert assemble(case).n_neighbours == len(pairs)
        if kind == "fcc" and sides == "free":  # a narrow tolerance leaves some contacts
            narrow = build_packing(
                packing_of(size=(20, 20, 10), packing={"diameter_scatter": 1e-7})
            )
            assert (
                0
                < narrow.assembly.n_contacts
                == len(narrow.contacts)
                < narrow.assembly.n_neighbours
            )
            assert narrow.coordination.sum() == 2 * narrow.assembly.n_contacts

    def test_the_tolerance_counts_from_each_nominal_diameter(self) -> None:
        band = 1e-5
        plain = packing_of(packing={"diameter_scatter": band})
        case = packing_of(
            packing={"diameter_scatter": band}, replace=[{"index": [3, 100], "diameter": 0.008}]
        )
        odd = np.array([3, 100]) - 1
        np.testing.assert_allclose(
            diameters(case)[odd], diameters(plain)[odd] - 0.002, rtol=0, atol=1e-17
        )
        np.testing.assert_array_equal(
            np.delete(diameters(case), odd), np.delete(diameters(plain), odd)
        )

    def test_beads_of_a_chain_are_stacked_by_nominal_diameters(self) -> None:
        replaced = [
            {"index": {"first": 2, "last": 12}, "diameter": 0.006},
            {"index": 5, "diameter": 0.02},
        ]
        stacked = packing_of("chain", replace=replaced)
        case = packing_of("chain", replace=replaced, packing={"diameter_scatter": 1e-4})
        np.testing.assert_array_equal(assemble(case).positions(), assemble(stacked).positions())
        assert (
            assemble(case).bottom()
            == assemble(stacked).bottom()
            == pytest.approx(0.005 + 0.02 + 10 * 0.006)
        )
        assert assemble(stacked).n_contacts == 11 and assemble(case).n_contacts == 0
        assert (
            all_gaps(build_packing(case)).min() >= 0
            and abs(all_gaps(build_packing(stacked)).min()) < 1e-16
        )

    def test_walls_stand_where_nominal_spheres_touch_them(self) -> None:
        plain = packing_of(boundary={"sides": "wall"})
        case = packing_of(boundary={"sides": "wall"}, packing={"diameter_scatter": 1e-4})
        assert {w.name: w.coordinate for w in walls(case)} == {
            w.name: w.coordinate for w in walls(plain)
        }


class TestSeed:
    TABLES: dict[str, Any] = {  # noqa: RUF012
        "packing": {"diameter_scatter": 1e-5, "vacancies": 0.05, "seed": 3},
        "replace": [{"share": 0.2, "material": "steel"}, {"share": 0.1, "diameter": 0.009}],
    }

    @pytest.mark.parametrize(
        ("distribution", "expected"),
        [
            ("uniform", ["0x1.476b26959d1acp-7", "0x1.47a9a04c2b83cp-7", "0x1.477c794fbb3f8p-7"]),
            ("normal", ["0x1.47788444284e0p-7", "0x1.479a91d6e04c0p-7", "0x1.4780ea7967cafp-7"]),
        ],
    )
    def test_bits_are_those_of_every_version_and_machine(
        self, distribution: str, expected: list[str]
    ) -> None:
        """Random numbers are those of x86-64 with numpy 2 at the time of writing."""
        tables = {"diameter_scatter": 1e-5, "scatter_distribution": distribution, "seed": 7}
        assert [float(one).hex() for one in diameters(packing_of(packing=tables))[:3]] == expected

    def test_choices_are_those_of_every_version_and_machine(self) -> None:
        case = packing_of(
            packing={"vacancies": 0.02, "seed": 7}, replace=[{"share": 0.02, "material": "steel"}]
        )
        gone = np.setdiff1d(np.arange(1, 337), assemble(case).ids)
        assert gone.tolist() == [83, 156, 177, 245, 310, 328, 334]
        assert (1 + np.flatnonzero(assemble(case).sites.body)).tolist() == [
            40,
            106,
            113,
            129,
            258,
            275,
            281,
        ]

    def test_no_change_of_one_changes_another(self) -> None:
        full = assemble(packing_of(**self.TABLES)).sites
        packing = self.TABLES["packing"]
        steel, small = self.TABLES["replace"]
        unscattered, whole = (
            assemble(packing_of(packing={**packing, key: 0.0}, replace=[steel, small])).sites
            for key in ("diameter_scatter", "vacancies")
        )
        for name in ("present", "body", "nominal"):
            np.testing.assert_array_equal(getattr(unscattered, name), getattr(full, name))
        losses = [(one.nominal - one.diameter)[full.present] for one in (whole, full)]
        np.testing.assert_allclose(*losses, rtol=0, atol=2e-17)
        one = assemble(packing_of(packing=packing, replace=[steel])).sites
        np.testing.assert_array_equal(
            one.body == 1, (full.body == 1) | (one.body == 1) & (full.nominal < D)
        )

    def test_the_three_streams_are_not_one(self) -> None:
        packing = {"diameter_scatter": D / 4, "vacancies": 0.3}
        replaced = [{"share": 0.3, "material": "steel"}, {"share": 0.3, "diameter": 0.009}]
        sites = assemble(packing_of(size=(30, 30, 10), packing=packing, replace=replaced)).sites
        loss = sites.nominal - sites.diameter
        steel = sites.body == 1
        small = sites.nominal < D
        for mask in (sites.present, steel, small):
            assert stats.ks_2samp(loss[mask], loss[~mask]).pvalue > 1e-3
        n = np.count_nonzero(sites.present)
        assert np.count_nonzero(small) == round(0.3 * n)  # the last entry takes precedence
        assert np.count_nonzero(steel) == pytest.approx(
            0.3 * 0.7 * n, abs=4 * math.sqrt(0.3 * 0.7 * n)
        )

    def test_a_wider_band_stretches_and_a_larger_share_contains_a_smaller_one(self) -> None:
        narrow, wide = (
            D - diameters(packing_of(packing={"diameter_scatter": s})) for s in (1e-6, 1e-4)
        )
        np.testing.assert_allclose(wide, 100 * narrow, rtol=0, atol=1e-15)
        few, many = (
            set(assemble(packing_of(packing={"vacancies": share})).ids.tolist())
            for share in (0.05, 0.2)
        )
        assert many < few

    @pytest.mark.parametrize(
        ("tables", "random"),
        [
            (
                {
                    "packing": {"vacancies": [1], "seed": 5},
                    "replace": [{"index": 2, "material": "steel"}],
                },
                False,
            ),
            ({"packing": {"diameter_scatter": 1e-6}}, True),
            ({"packing": {"vacancies": 0.1}}, True),
            ({"replace": [{"share": 0.1, "material": "steel"}]}, True),
        ],
    )
    def test_what_is_random(
        self, tables: dict[str, Any], random: bool, caplog: pytest.LogCaptureFixture
    ) -> None:
        assert is_random(packing_of(**tables)) == random
        assert not caplog.records  # a seed without chance is no fault


class TestTimestep:
    def test_a_small_tolerance_hardly_changes_it(self) -> None:
        plain = auto_timestep(packing_of())
        assert auto_timestep(packing_of(packing={"diameter_scatter": 5e-6})) == pytest.approx(
            plain, rel=0.05
        )
        assert auto_timestep(packing_of(packing={"vacancies": 0.1})) == plain
        few, many = (  # kinds that are told apart, and those near each other as one
            packing_of(
                "chain",
                (n,),
                replace=[{"index": k, "diameter": 0.008 + 0.002 * k / n} for k in range(1, n)],
            )
            for n in (40, 60)
        )
        assert auto_timestep(many) == pytest.approx(auto_timestep(few), rel=0.1)

    def test_a_large_packing_with_thousands_of_diameters_takes_no_time(self) -> None:
        packing = {"diameter_scatter": 4e-3, "vacancies": 0.01}
        replaced = [{"share": 0.5, "material": "steel"}]
        start = time.process_time()
        found = plan(packing_of(size=(72, 72, 30), packing=packing, replace=replaced))
        assert time.process_time() - start < 4
        assert found.n_spheres == 153_965 and found.n_contacts == 0


class TestVacancies:
    def test_ids_are_those_of_the_lattice(self, tmp_path: Path) -> None:
        case = packing_of(packing={"vacancies": [1, 17, 300]})
        packing = build_packing(case)
        full = build_packing(packing_of())
        kept = np.setdiff1d(full.ids, [1, 17, 300])
        np.testing.assert_array_equal(packing.ids, kept)
        np.testing.assert_array_equal(packing.positions, full.positions[kept - 1])
        np.testing.assert_array_equal(packing.rows(packing.ids), np.arange(len(kept)))
        expected = full.contacts[~np.isin(full.contacts, [1, 17, 300]).any(axis=1)]
        np.testing.assert_array_equal(packing.contacts, expected)
        assert (assemble(case).n_spheres, assemble(case).n_contacts) == (333, len(expected))
        assert assemble(case).last_sphere == 336 and not assemble(case).plain
        np.testing.assert_array_equal(
            packing.coordination, np.bincount(expected.ravel(), minlength=337)[kept]
        )
        write_data(assemble(case), tmp_path / "data")
        text = (
            (tmp_path / "data").read_text().split("Atoms # sphere: id type diameter density x y z")
        )
        assert "\n333 atoms\n" in text[0]
        rows = np.array([row.split() for row in text[1].split("\n") if row], dtype=float)
        np.testing.assert_array_equal(rows[:, 0], kept)
        np.testing.assert_array_equal(rows[:, 4:], packing.positions)

    @pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "chain"])
    def test_a_share_never_takes_what_the_case_names(self, kind: str) -> None:
        case = packing_of(
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
        assert (
            assemble(case).ids[-1] == n + 1
            and len(assemble(case).positions()) == assemble(case).n_spheres
        )

    def test_a_striker_can_sit_in_one(self) -> None:
        """Striker between the two spheres next to a vacancy at the edge of a square packing, as
        close as the diameters permit.
        """
        tables = {"vacancies": [5], "diameter_scatter": 1e-6}
        case = packing_of(
            "square", packing=tables, striker=[{"touches": [4, 6], "diameter": 0.012}]
        )
        packing = build_packing(case)
        assert packing.ids[-1] == 73 and packing.n_spheres == 72
        assert packing.positions[-1] == pytest.approx(
            [4 * D, -math.sqrt(0.011**2 - D**2), 0], abs=1e-6
        )
        assert packing.contacts.tolist() == [[4, 73], [6, 73]]


class TestReplaced:
    def test_later_entries_overrule_earlier_ones(self) -> None:
        box = {"low": [0, 0, 0], "high": [1, 1, 0.001]}
        case = packing_of(replace=[box | {"material": "steel", "diameter": 0.009}, {"index": 3, "material": "ptfe"}],
                       contact={"law": "hertz"})  # fmt: skip
        top = assemble(case).lattice.n_spheres // 6
        names = [assemble(case).material_of(sphere).name for sphere in (1, 2, 3, top, top + 1)]
        assert names == ["steel", "steel", "ptfe", "steel", "brass"]
        assert [assemble(case).diameter_of(sphere) for sphere in (1, 3, top, top + 1)] == [
            0.009,
            D,
            0.009,
            D,
        ]
        sites = assemble(case).sites
        assert [np.count_nonzero(one) for one in (sites.nominal != D, sites.body)] == [top - 1, top]

    def test_smaller_ones_leave_gaps(self) -> None:
        case = packing_of(replace=[{"index": INNER, "diameter": 0.009}])
        packing = build_packing(case)
        assert packing.coordination[INNER - 1] == 0
        assert assemble(case).n_contacts == assemble(packing_of()).lattice.n_contacts - 12
        assert np.sort(all_gaps(packing)[INNER - 1])[:12] == pytest.approx(0.0005, rel=1e-9)

    def test_larger_ones_next_to_vacancies_can_touch_beyond_neighbours(self) -> None:
        case = packing_of(packing={"vacancies": around(INNER)}, replace=[BALL])
        packing = build_packing(case)
        gaps = all_gaps(packing)
        assert gaps.min() > -1e-15
        pairs = np.argwhere(gaps <= 1e-6 * D)
        expected = packing.ids[pairs[pairs[:, 0] < pairs[:, 1]]]
        np.testing.assert_array_equal(packing.contacts, expected)
        assert np.count_nonzero(expected == INNER) == 6 and assemble(case).n_contacts == len(
            expected
        )

    def test_images_of_larger_ones_count(self) -> None:
        """Sphere 61 is at two faces of the box: its neighbors across them must be removed, too."""
        periodic = {"sides": "periodic"}
        ball = [{"index": 61, "diameter": 0.018}]
        near = around(61, packing_of("sc", boundary=periodic))
        fits = packing_of("sc", packing={"vacancies": near}, boundary=periodic, replace=ball)
        assert len(near) == 6 and all_gaps(build_packing(fits)).min() > -1e-15
        inside = around(61, packing_of("sc"))
        assert assemble(
            packing_of(
                "sc", packing={"vacancies": inside}, replace=ball, boundary={"bottom": "free"}
            )
        )
        with pytest.raises(
            InputError, match=r"sphere 61 of 0.018 m overlaps sphere \d+ by 0.004 m \(and 1 more"
        ):
            packing_of("sc", packing={"vacancies": inside}, boundary=periodic, replace=ball)


def test_timestep_counts_the_slope_of_dents(tmp_path: Path) -> None:
    """Unloading is steeper: with indentations far beyond the peak overlap the energy balance closes
    as well as without.
    """
    changes = {"packing.size": 30, "run.end_time": 2e-4, "run.frames": 2}
    one = load_case("preconditioned-chain", changes | {"contact.initial_overlap": {"force": 1e4}})
    summary = run_case(one, tmp_path / "run", figures=False).summary
    fresh = load_case("preconditioned-chain", changes | {"contact.initial_overlap": 0.0})
    small = load_case("preconditioned-chain", changes | {"contact.initial_overlap": {"force": 1.0}})
    from_file = load_case(
        "preconditioned-chain", changes | {"contact.initial_overlap": str(tmp_path / "run")}
    )
    assert auto_timestep(one) < 0.6 * auto_timestep(fresh)
    assert auto_timestep(small) == auto_timestep(fresh)
    assert auto_timestep(from_file) == pytest.approx(auto_timestep(one), rel=0.11)  # two digits
    assert summary["energy_balance_error"] < one.run.energy_tolerance
