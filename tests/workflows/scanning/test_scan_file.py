"""Scan files: varied keys, resulting points, their IDs and labels."""

from __future__ import annotations

import itertools
import json
import logging
from pathlib import Path

import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows import library, load_case, load_scan
from granwave.workflows.cli.tables.scan_plan import plan_text, plan_values
from granwave.workflows.scanning.batches import Machine
from granwave.workflows.scanning.directory import check_points
from granwave.workflows.scanning.scan_file import Scan
from granwave.workflows.scanning.suite import is_suite
from tests.helpers.made_up.scan_texts import SMALL, VELOCITIES, Load, reader


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Read a scan of this text."""
    return reader(tmp_path)


def values(scan: Scan, key: str) -> list:
    return [point.labels[key] for point in scan.points]


def ids(scan: Scan) -> list[str]:
    return [point.id for point in scan.points]


# ---------------------------------------------------------------------- what varies


KINDS = '[grid]\n"load.velocity" = [1, 2]\n"packing.kind" = ["fcc", "hcp"]\n'
SCATTERED = SMALL + "packing.diameter_scatter = 1e-6\n"


@pytest.mark.parametrize(
    ("text", "varied", "expected"),
    [
        pytest.param(
            SMALL + '[grid]\nload.velocity = [1, 2]\nmaterial = ["brass", "steel", "aluminium"]\n',
            ("load.velocity", "material"),
            [*itertools.product((1, 2), ("brass", "steel", "aluminium"))],
            id="grid, the last key fastest",
        ),
        pytest.param(
            SMALL.replace("run.end_time = 5e-5\n", "") + VELOCITIES
            + "[[zip]]\npacking.diameter = [0.005, 0.010]\nrun.end_time = [1e-5, 2e-5]\n"
            + "[[zip]]\nload.spheres = [1, 3, 7]\n",
            ("load.velocity", "packing.diameter", "run.end_time", "load.spheres"),
            [(v, *pair, n) for v in (1, 2) for pair in ((0.005, 1e-5), (0.010, 2e-5)) for n in (1, 3, 7)],
            id="zipped keys vary together",
        ),
        pytest.param(
            SMALL + VELOCITIES + "[[points]]\nload.velocity = 40\n[[points]]\nload.spheres = 3\n",
            ("load.velocity", "load.spheres"),
            [(1, 1), (2, 1), (40, 1), (5.0, 3)],
            id="single points come last and take the rest from the case",
        ),
        ('case = "two-spheres"\n[[points]]\nload.velocity = 3\n', ("load.velocity",), [(3,)]),
        pytest.param(
            "replicates = 3\n" + SCATTERED + VELOCITIES + "[[points]]\nload.velocity = 7\n",
            ("load.velocity", "packing.seed"),
            [*itertools.product((1, 2, 7), (1, 2, 3))],
            id="replicates carry seeds from one",
        ),
        pytest.param(
            "replicates = 3\n" + SMALL + "[grid]\npacking.diameter_scatter = [0.0, 1e-6]\n",
            ("packing.diameter_scatter", "packing.seed"),
            [(0.0, 1), (1e-6, 1), (1e-6, 2), (1e-6, 3)],
            id="only what is random is replicated",
        ),
    ],
)  # fmt: skip
def test_points(
    load: Load, caplog, text: str, varied: tuple[str, ...], expected: list[tuple]
) -> None:
    scan = load(text)
    assert scan.varied == varied and not caplog.records
    assert [tuple(point.labels.values()) for point in scan.points] == expected
    assert [point.number for point in scan.points] == [*range(1, len(expected) + 1)]
    assert len(scan.distinct) == len(set(ids(scan))) == len(expected)
    for point in scan.points:  # the labels are what the cases have
        found = {"load.velocity": point.case.load.velocity, "packing.seed": point.case.packing.seed,
                 "material": point.case.material.name, "load.spheres": point.case.load.spheres}  # fmt: skip
        assert all(found.get(key, value) == value for key, value in point.labels.items())


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("{linear = [0.5, 1.0, 6]}", [0.5, 0.6, 0.7, 0.8, 0.9, 1.0]),
        ("{linear = [0.1, 1, 10]}", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]),
        ("{linear = [3, 1, 3]}", [3.0, 2.0, 1.0]),
        ("{log = [0.001, 1000, 7]}", [0.001, 0.01, 0.1, 1.0, 10.0, 100.0, 1000.0]),
        ("{log = [2, 8, 2]}", [2.0, 8.0]),
    ],
)
def test_ranges_hold_their_ends_and_round_numbers(
    load: Load, written: str, expected: list[float]
) -> None:
    scan = load(SMALL + f"[grid]\nload.velocity = {written}\n")
    assert values(scan, "load.velocity") == expected
    assert ids(scan) == ids(load(SMALL + f"[grid]\nload.velocity = {expected}\n"))


def test_a_log_range_has_one_ratio(load: Load) -> None:
    found = values(load(SMALL + "[grid]\nload.velocity = {log = [0.5, 40, 9]}\n"), "load.velocity")
    ratios = [later / earlier for earlier, later in itertools.pairwise(found)]
    assert ratios == pytest.approx([80 ** (1 / 8)] * 8, rel=1e-12)


SIZES = "[grid]\npacking.size = [[6, 6, 4], [6, 6, 8], [12, 12, 8]]\n"


@pytest.mark.parametrize(
    ("usual", "written"),
    [
        (SMALL + KINDS, SMALL + '[grid]\nload.velocity = [1, 2]\npacking.kind = ["fcc", "hcp"]\n'),
        (SMALL + KINDS, SMALL + '[grid]\nload = {velocity = [1, 2]}\npacking.kind = ["fcc", "hcp"]\n'),
        (SMALL + KINDS, SMALL + '[grid.load]\nvelocity = [1, 2]\n[grid.packing]\nkind = ["fcc", "hcp"]\n'),
        (SMALL + KINDS, SMALL + '[grid]\nload.velocity = {linear = [1, 2, 2]}\n"packing.kind" = ["fcc", "hcp"]\n'),
        *((SMALL + VELOCITIES, text + VELOCITIES) for text in (
            'case = "fcc-small"\n[set]\n"packing.size" = [6, 6, 4]\n"run.end_time" = 5e-5\n',
            'case = "fcc-small"\n[set.packing]\nsize = [6, 6, 4]\n[set.run]\nend_time = 5e-5\n',
            'case = "fcc-small"\nset = {packing = {size = [6, 6, 4]}, run.end_time = 5e-5}\n',
            "replicates = 1\n" + SMALL, 'name = "Stöße 衝撃"\n' + SMALL, 'name = "called-otherwise"\n' + SMALL,
            SMALL + "load.spheres = 1\n", SMALL + 'material = {preset = "brass"}\n', SMALL + 'material.preset = "brass"\n',
        )),
        (f'case = "fcc-small"\n{SIZES}', f'ranks = 2\ncase = "fcc-small"\n{SIZES}'),
    ],
)  # fmt: skip
def test_ids_follow_the_resolved_case_however_it_is_written(
    load: Load, usual: str, written: str
) -> None:
    assert ids(load(usual)) == ids(load(written))


@pytest.mark.parametrize(
    "change",
    [
        "load.spheres = 3",
        "material.yield_strength = 551e6",
        "run.frames = 3",
        'contact.variant = "published"',
    ],
)
def test_ids_of_other_cases_are_others(load: Load, change: str) -> None:
    assert not set(ids(load(SMALL + VELOCITIES))) & set(
        ids(load(SMALL + change + "\n" + VELOCITIES))
    )


def test_whole_tables_are_replaced_and_then_changed(load: Load) -> None:
    scan = load(
        SMALL
        + "material.yield_strength = 4e8\n"
        + '[grid]\nmaterial = ["brass", {preset = "steel"}, {preset = "steel", density = 7000}]\n'
    )
    brass, steel, light = (point.case.material for point in scan.points)
    assert (brass.youngs_modulus, steel.youngs_modulus, light.density) == (115e9, 210e9, 7000)
    assert {brass.yield_strength, steel.yield_strength, light.yield_strength} == {4e8}
    assert values(scan, "material") == ["brass", "steel", "steel density=7000"]


def test_a_table_under_set_with_a_preset_replaces_the_material(load: Load) -> None:
    scan = load(SMALL + 'material = {preset = "steel", yield_strength = 1e9}\n' + VELOCITIES)
    assert scan.points[0].case.material.youngs_modulus == 210e9
    assert scan.points[0].case.material.yield_strength == 1e9


def test_whole_packings_can_vary(load: Load) -> None:
    kinds = ", ".join(
        f'{{kind = "{kind}", size = [6, 6, 4], diameter = 0.01}}' for kind in ("fcc", "hcp")
    )
    scan = load(f'case = "fcc-small"\n[grid]\npacking = [{kinds}]\n')
    assert [point.case.packing.kind for point in scan.points] == ["fcc", "hcp"]
    fcc, hcp = (str(point.labels["packing"]) for point in scan.points)
    assert "fcc" in fcc and "hcp" in hcp


def test_unlike_materials_of_one_name_are_told_apart(load: Load) -> None:
    made = '{name = "mine", youngs_modulus = 1e11, poisson_ratio = 0.3, density = 8000, yield_strength = %s}'
    scan = load(f'case = "fcc-small"\n[grid]\nmaterial = [{made % "3e8"}, {made % "6e8"}]\n')
    labels = [str(point.labels["material"]) for point in scan.points]
    assert len(set(labels)) == 2 and all("mine" in label for label in labels)


# ---------------------------------------------------------------------- ids and labels


def test_the_source_of_a_packing_is_no_part_of_an_id(load: Load, tmp_path: Path) -> None:
    """The key is only a remark: points of earlier scans without it are recognised."""
    (tmp_path / "beads.csv").write_text("x,y,z,radius\n0,0,0.005,0.005\n0,0,0.015,0.005\n")
    case = 'name = "two"\nmaterial = "brass"\n[packing]\nkind = "file"\nfile = "beads.csv"\n'
    (tmp_path / "plain.toml").write_text(case)
    (tmp_path / "named.toml").write_text(case + 'source = "two beads"\n')
    plain, named = (f'case = "{name}.toml"\n' for name in ("plain", "named"))
    assert ids(load(plain + VELOCITIES)) == ids(load(named + VELOCITIES))


def test_equal_points_have_one_id_and_are_one_run(load: Load) -> None:
    scan = load(SMALL + "[grid]\nload.velocity = [1, 2, 1.0]\n[[points]]\nload.velocity = 2\n")
    assert len(scan.points) == 4 and len(scan.distinct) == 2
    first, second, third, fourth = ids(scan)
    assert first == third and second == fourth and first != second
    assert {point.number for point in scan.distinct.values()} == {1, 2}


def test_a_case_file_beside_the_scan_serves_as_a_built_in_one(
    load: Load, tmp_path: Path, monkeypatch
) -> None:
    (tmp_path / "mine.toml").write_text(
        library.text("fcc-small").replace("fcc-small", "mine"), encoding="utf-8"
    )
    built_in = ids(load(SMALL + VELOCITIES))
    monkeypatch.chdir("/")
    scan = load(SMALL.replace("fcc-small", "mine.toml") + VELOCITIES)
    assert ids(scan) == built_in and scan.case_name == "mine"


def test_ids_follow_the_versions_that_matter(load: Load, monkeypatch) -> None:
    from granwave.workflows.scanning import scan_file

    before = ids(load(SMALL + VELOCITIES))
    now = scan_file.versions()
    monkeypatch.setattr(scan_file, "versions", lambda: {**now, "matplotlib": "0", "python": "0"})
    assert ids(load(SMALL + VELOCITIES)) == before
    monkeypatch.setattr(scan_file, "versions", lambda: {**now, "lammps": "0"})
    assert not set(ids(load(SMALL + VELOCITIES))) & set(before)


def test_labels_are_scalars(load: Load) -> None:
    scan = load(
        'case = "fcc-small"\n[grid]\npacking.size = [[6, 6, 4], [8, 8, 4]]\n'
        'material = ["brass", {name = "glass", youngs_modulus = 7e10, poisson_ratio = 0.3, density = 2500, '
        "yield_strength = 1e9}]\n"
        "[[zip]]\nrun.frames = [2, [0.0, 1e-5]]\nrun.end_time = [5e-5, 1e-3]\n"
    )
    assert all(
        isinstance(label, bool | int | float | str)
        for p in scan.points
        for label in p.labels.values()
    )
    assert scan.points[0].labels == {
        "packing.size": "[6, 6, 4]",
        "material": "brass",
        "run.frames": 2,
        "run.end_time": 5e-5,
    }
    assert (
        scan.points[-1].labels["material"] == "glass"
        and scan.points[-1].labels["run.frames"] == "[0.0, 1e-05]"
    )


def test_index_holds_every_point(load: Load) -> None:
    scan = load('name = "mine"\nranks = 2\n' + SMALL + "[grid]\nload.velocity = [1, 1]\n")
    index = json.loads(json.dumps(scan.index()))
    assert (index["name"], index["case"], index["varied"]) == (
        "mine",
        "fcc-small",
        ["load.velocity"],
    )
    assert index["points"] == [
        {"number": n, "id": scan.points[0].id, "labels": {"load.velocity": 1}, "ranks": 2}
        for n in (1, 2)
    ]
    assert load(SMALL + VELOCITIES).name == "my"  # that of the file


# ---------------------------------------------------------------------- ranks, replicates, overrides


@pytest.mark.parametrize(
    ("ranks", "expected"),
    [
        ("2", [2, 2, 2]),
        ("{spheres_per_rank = 144, most = 3}", [1, 2, 3]),
        ("{spheres_per_rank = 100}", [1, 1, 1]),
    ],
)
def test_ranks_by_size(load: Load, ranks: str, expected: list[int]) -> None:
    scan = load(f'ranks = {ranks}\ncase = "fcc-small"\n{SIZES}')
    assert [point.ranks for point in scan.points] == expected


def test_replicates_where_nothing_is_random_are_told(load: Load, caplog) -> None:
    with caplog.at_level(logging.WARNING, logger="granwave"):
        scan = load("replicates = 3\n" + SMALL + VELOCITIES)
    assert len(scan.points) == 2 and [
        record.message.count("have no random quantities") for record in caplog.records
    ] == [1]


def test_replicates_and_seeds_of_its_own(load: Load) -> None:
    with pytest.raises(InputError, match=r"packing\.seed: varies twice"):
        load("replicates = 2\n" + SMALL + "[grid]\npacking.seed = [1, 2]\n")


def test_overrides_go_before_what_is_set(load: Load) -> None:
    scan = load(SMALL + VELOCITIES, ["packing.size=[8,8,4]", "load.spheres=7"])
    assert scan.points[0].case.packing.size == (8, 8, 4) and scan.points[0].case.load.spheres == 7
    assert ids(scan) == ids(
        load(SMALL + VELOCITIES, {"packing.size": [8, 8, 4], "load.spheres": 7})
    )


def test_an_override_of_a_table_drops_what_was_set_inside_it(load: Load) -> None:
    (first, _) = load(
        SMALL + "material.yield_strength = 1e9\n" + VELOCITIES, ["material=steel"]
    ).points
    assert first.case.material == load_case("fcc-small", ["material=steel"]).material


def test_a_warning_is_given_once_and_not_for_every_point(load: Load, caplog) -> None:
    with caplog.at_level(logging.WARNING, logger="granwave"):
        load(SMALL + "material.poisson_ratio = 0.28\n[grid]\nload.velocity = [1, 2, 3, 4]\n")
    assert [record.message.count("Poisson") for record in caplog.records] == [1]


@pytest.mark.parametrize(
    "name", [name for name in library.names(library.SCANS) if not is_suite(name)]
)
def test_built_in_scans_can_be_read(name: str) -> None:
    scan = load_scan(name)
    assert scan.name == name and len(scan.distinct) == len(scan.points) > 0
    assert library.text(name).startswith("# ")


def test_a_plan_of_100_000_points_is_made_of_some(tmp_path: Path, load: Load) -> None:
    """A grid whose faster axis has ten values: points at equal intervals would all have the same
    value.
    """
    grid = "[grid]\nload.velocity = {linear = [1, 10, 10000]}\npacking.diameter = {linear = [0.005, 0.01, 10]}\n"
    scan = load(SMALL + grid, most=50)
    assert (scan.n_points, len(scan.points), scan.scale) == (100_000, 50, 2000)
    assert (scan.n_values_of("load.velocity"), scan.n_values_of("packing.diameter")) == (10_000, 10)
    assert len({point.labels["packing.diameter"] for point in scan.points}) > 5
    values = plan_values(scan, tmp_path / "out", scan.points, Machine(2))
    shown = plan_text(scan, scan.points, values, None)
    assert "100000, planned from 50 random points" in shown and "load.velocity (10000)" in shown
    assert (values["n_points"], values["n_planned"]) == (100_000, 50)
    assert values["disk_bytes"] == pytest.approx(
        2000 * sum(point.plan.disk for point in scan.points)
    )
    with pytest.raises(InputError, match="the points require about"):
        check_points(scan, ResultDirectory(tmp_path), force=False)
    whole = load(SMALL + VELOCITIES, most=50)
    assert (whole.n_points, whole.scale) == (2, 1)
    assert "planned from" not in plan_text(
        whole, whole.points, plan_values(whole, tmp_path, whole.points, Machine(2)), None
    )


def test_points_for_a_cluster_may_need_more_memory_than_is_here(load) -> None:
    text = 'case = "fcc-small"\n[grid]\npacking.size = [[6, 6, 4], [1000, 1000, 400]]\n'
    assert load(text, here=False).points[1].plan.memory > 1e11
