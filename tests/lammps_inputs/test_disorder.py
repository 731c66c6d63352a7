"""Disorder: diameters within a tolerance, random numbers, timestep and time; see also test_unlike_spheres.py."""

from __future__ import annotations

import logging
import math
import time
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.lammps_inputs.packing.packing import build_packing
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.planning.plan import plan
from granwave.lammps_inputs.planning.timestep import auto_timestep
from tests.helpers.disordered import LATTICES, D, all_gaps, case_of, diameters


class TestDiameters:
    @pytest.mark.parametrize("distribution", ["uniform", "normal"])
    def test_moments_and_distribution(self, distribution: str) -> None:
        band = 4e-5
        case = case_of(size=(40, 40, 25), packing={"diameter_scatter": band, "scatter_distribution": distribution})
        found = diameters(case)
        assert found.min() >= D - band and found.max() <= D
        deviation = band / math.sqrt(12) if distribution == "uniform" else band / 6
        law = (
            stats.uniform(D - band, band)
            if distribution == "uniform"
            else stats.truncnorm(-3, 3, loc=D - band / 2, scale=deviation)
        )
        n = len(found)
        assert found.mean() == pytest.approx(D - band / 2, abs=4 * deviation / math.sqrt(n))
        assert found.std() == pytest.approx(law.std(), rel=4 / math.sqrt(n))
        assert stats.skew(found) == pytest.approx(0, abs=4 * math.sqrt(6 / n))
        assert stats.kstest(found, law.cdf).pvalue > 1e-3

    def test_neighbours_have_nothing_to_do_with_each_other(self) -> None:
        found = diameters(case_of(size=(40, 40, 25), packing={"diameter_scatter": 1e-5})).reshape(25, 40, 40)
        for axis in range(3):
            one, other = np.delete(found, 0, axis).ravel(), np.delete(found, -1, axis).ravel()
            assert abs(np.corrcoef(one, other)[0, 1]) < 4 / math.sqrt(one.size)

    @pytest.mark.parametrize(("kind", "sides"), [*product(KINDS, ["free"]), *product(LATTICES, ["periodic"])])
    def test_gaps_follow_and_are_never_negative(self, kind: str, sides: str) -> None:
        band = 3e-4
        case = case_of(kind, packing={"diameter_scatter": band}, boundary={"sides": sides})
        packing = build_packing(case)
        np.testing.assert_array_equal(
            packing.positions, build_packing(case_of(kind, boundary={"sides": sides})).positions
        )
        gaps = all_gaps(packing)
        assert gaps.min() >= 0
        pairs = assemble(case_of(kind, boundary={"sides": sides})).contacts() - 1
        found = diameters(case)
        expected = D - (found[pairs[:, 0]] + found[pairs[:, 1]]) / 2
        assert gaps[pairs[:, 0], pairs[:, 1]] == pytest.approx(expected, abs=1e-12 * D)
        assert np.median(expected) == pytest.approx(band / 2, rel=0.2)
        assert len(packing.contacts) == assemble(case).n_contacts == np.count_nonzero(gaps <= 1e-6 * D) / 2
        assert assemble(case).n_neighbours == len(pairs)

    def test_a_narrow_tolerance_leaves_some_contacts(self) -> None:
        case = case_of(size=(20, 20, 10), packing={"diameter_scatter": 1e-7})
        packing = build_packing(case)
        assert 0 < assemble(case).n_contacts == len(packing.contacts) < assemble(case).n_neighbours
        assert packing.coordination.sum() == 2 * assemble(case).n_contacts
        assert np.abs(packing.gaps(packing.contacts)).max() <= 1e-6 * D

    def test_the_tolerance_counts_from_each_nominal_diameter(self) -> None:
        band = 1e-5
        plain = case_of(packing={"diameter_scatter": band})
        case = case_of(packing={"diameter_scatter": band}, replace=[{"index": [3, 100], "diameter": 0.008}])
        odd = np.array([3, 100]) - 1
        np.testing.assert_allclose(diameters(case)[odd], diameters(plain)[odd] - 0.002, rtol=0, atol=1e-17)
        np.testing.assert_array_equal(np.delete(diameters(case), odd), np.delete(diameters(plain), odd))

    def test_beads_of_a_chain_are_stacked_by_nominal_diameters(self) -> None:
        replaced = [{"index": {"first": 2, "last": 12}, "diameter": 0.006}, {"index": 5, "diameter": 0.02}]
        stacked = case_of("chain", replace=replaced)
        case = case_of("chain", replace=replaced, packing={"diameter_scatter": 1e-4})
        np.testing.assert_array_equal(assemble(case).positions(), assemble(stacked).positions())
        assert assemble(case).bottom() == assemble(stacked).bottom() == pytest.approx(0.005 + 0.02 + 10 * 0.006)
        assert assemble(stacked).n_contacts == 11 and assemble(case).n_contacts == 0
        assert all_gaps(build_packing(case)).min() >= 0 and abs(all_gaps(build_packing(stacked)).min()) < 1e-16

    def test_walls_stand_where_nominal_spheres_touch_them(self) -> None:
        plain = case_of(boundary={"sides": "wall"})
        case = case_of(boundary={"sides": "wall"}, packing={"diameter_scatter": 1e-4})
        assert {w.name: w.coordinate for w in walls(case)} == {w.name: w.coordinate for w in walls(plain)}


class TestSeed:
    TABLES: dict[str, Any] = {  # noqa: RUF012
        "packing": {"diameter_scatter": 1e-5, "vacancies": 0.05, "seed": 3},
        "replace": [{"share": 0.2, "material": "steel"}, {"share": 0.1, "diameter": 0.009}],
    }

    def test_same_seed_same_bits(self, tmp_path: Path) -> None:
        for n in (1, 2):
            write_data(assemble(case_of(**self.TABLES)), tmp_path / str(n))
        assert (tmp_path / "1").read_bytes() == (tmp_path / "2").read_bytes()
        other = self.TABLES | {"packing": self.TABLES["packing"] | {"seed": 4}}
        write_data(assemble(case_of(**other)), tmp_path / "3")
        assert (tmp_path / "3").read_bytes() != (tmp_path / "1").read_bytes()

    def test_one_is_the_default(self) -> None:
        given, implied = (case_of(packing={"diameter_scatter": 1e-5, **seed}) for seed in ({"seed": 1}, {}))
        np.testing.assert_array_equal(diameters(given), diameters(implied))

    @pytest.mark.parametrize(
        ("distribution", "expected"),
        [
            ("uniform", ["0x1.476b26959d1acp-7", "0x1.47a9a04c2b83cp-7", "0x1.477c794fbb3f8p-7"]),
            ("normal", ["0x1.47788444284e0p-7", "0x1.479a91d6e04c0p-7", "0x1.4780ea7967cafp-7"]),
        ],
    )
    def test_bits_are_those_of_every_version_and_machine(self, distribution: str, expected: list[str]) -> None:
        """Random numbers are those of x86-64 with numpy 2 at the time of writing."""
        tables = {"diameter_scatter": 1e-5, "scatter_distribution": distribution, "seed": 7}
        assert [float(one).hex() for one in diameters(case_of(packing=tables))[:3]] == expected

    def test_choices_are_those_of_every_version_and_machine(self) -> None:
        case = case_of(packing={"vacancies": 0.02, "seed": 7}, replace=[{"share": 0.02, "material": "steel"}])
        gone = np.setdiff1d(np.arange(1, 337), assemble(case).ids)
        assert gone.tolist() == [83, 156, 177, 245, 310, 328, 334]
        assert (1 + np.flatnonzero(assemble(case).sites.body)).tolist() == [40, 106, 113, 129, 258, 275, 281]

    def test_no_change_of_one_changes_another(self) -> None:
        full = assemble(case_of(**self.TABLES)).sites
        packing, (steel, small) = self.TABLES["packing"], self.TABLES["replace"]
        for left_out in ("diameter_scatter", "vacancies"):
            fewer = case_of(packing={k: v for k, v in packing.items() if k != left_out}, replace=[steel, small])
            sites = assemble(fewer).sites
            if left_out == "diameter_scatter":
                np.testing.assert_array_equal(sites.present, full.present)
                np.testing.assert_array_equal(sites.body, full.body)
                np.testing.assert_array_equal(sites.nominal, full.nominal)
            else:
                losses = [(one.nominal - one.diameter)[full.present] for one in (sites, full)]
                np.testing.assert_allclose(*losses, rtol=0, atol=2e-17)
        one = assemble(case_of(packing=packing, replace=[steel])).sites
        np.testing.assert_array_equal(one.body == 1, (full.body == 1) | (one.body == 1) & (full.nominal < D))

    def test_the_three_streams_are_not_one(self) -> None:
        packing = {"diameter_scatter": D / 4, "vacancies": 0.3}
        replaced = [{"share": 0.3, "material": "steel"}, {"share": 0.3, "diameter": 0.009}]
        sites = assemble(case_of(size=(30, 30, 10), packing=packing, replace=replaced)).sites
        loss = sites.nominal - sites.diameter
        steel, small = sites.body == 1, sites.nominal < D
        for mask in (sites.present, steel, small):
            assert stats.ks_2samp(loss[mask], loss[~mask]).pvalue > 1e-3
        n = np.count_nonzero(sites.present)
        assert np.count_nonzero(small) == round(0.3 * n)  # the last entry takes precedence
        assert np.count_nonzero(steel) == pytest.approx(0.3 * 0.7 * n, abs=4 * math.sqrt(0.3 * 0.7 * n))

    def test_a_wider_band_stretches_and_a_larger_share_contains_a_smaller_one(self) -> None:
        narrow, wide = (D - diameters(case_of(packing={"diameter_scatter": s})) for s in (1e-6, 1e-4))
        np.testing.assert_allclose(wide, 100 * narrow, rtol=0, atol=1e-15)
        few, many = (set(assemble(case_of(packing={"vacancies": share})).ids.tolist()) for share in (0.05, 0.2))
        assert many < few

    def test_what_is_random(self) -> None:
        assert not is_random(
            case_of(packing={"vacancies": [1], "seed": 5}, replace=[{"index": 2, "material": "steel"}])
        )
        assert is_random(case_of(packing={"diameter_scatter": 1e-6}))
        assert is_random(case_of(packing={"vacancies": 0.1}))
        assert is_random(case_of(replace=[{"share": 0.1, "material": "steel"}]))


class TestTimestep:
    def test_a_small_tolerance_hardly_changes_it(self) -> None:
        plain = auto_timestep(case_of())
        assert auto_timestep(case_of(packing={"diameter_scatter": 5e-6})) == pytest.approx(plain, rel=0.05)
        assert auto_timestep(case_of(packing={"vacancies": 0.1})) == plain

    def test_it_goes_with_the_smallest_sphere(self) -> None:
        tenth = auto_timestep(case_of(size=(3, 3, 3), packing={"diameter_scatter": 0.0049}))
        assert 0.4 < tenth / auto_timestep(case_of(size=(3, 3, 3))) < 0.7

    def test_thousands_of_diameters_cost_nothing(self) -> None:
        tables = {"packing": {"diameter_scatter": 4e-3}, "replace": [{"share": 0.5, "material": "steel"}]}
        case = case_of(size=(40, 40, 30), **tables)
        _ = assemble(case)
        start = time.process_time()
        found = plan(case)
        assert time.process_time() - start < 2
        assert found.n_spheres == 48_000 and found.n_contacts == 0

    def test_kinds_told_apart_or_near_each_other_give_the_same_within_a_tenth(self) -> None:
        def of(n: int) -> float:
            entries = [{"index": k, "diameter": 0.008 + 0.002 * k / n} for k in range(1, n)]
            return auto_timestep(case_of("chain", (n,), replace=entries))

        assert of(60) == pytest.approx(of(40), rel=0.1)


def test_155520_spheres_take_no_time() -> None:
    tables = {
        "packing": {"diameter_scatter": 5e-6, "vacancies": 0.01},
        "replace": [{"share": 0.1, "material": "steel"}],
    }
    start = time.process_time()
    case = case_of(size=(72, 72, 30), **tables)
    assert assemble(case).n_contacts >= 0 and len(assemble(case).positions()) == 153_965
    assert time.process_time() - start < 2


def test_listed_seeds_without_chance_are_no_fault(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, logger="granwave"):
        assert assemble(case_of(packing={"seed": 7})).plain
    assert not caplog.records
