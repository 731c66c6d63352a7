"""Files that a case names, and rows of CSV files."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from granwave.analysis.figures.style import write_csv
from granwave.extensions.continuum.punch import ContinuumCase
from granwave.extensions.continuum.sphere_contact import SphereContactCase
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import with_absolute_paths, with_short_paths, write_csv_rows
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows import load_case, load_scan
from granwave.workflows.cli.main import main
from granwave.workflows.library import SCANS, find
from granwave.workflows.scanning import layout
from granwave.workflows.scanning.directory import check_points
from granwave.workflows.scanning.suite import load_suite

MINE = "[mine]\nyoungs_modulus = {modulus}\npoisson_ratio = 0.3\ndensity = 7000\nyield_strength = 4e8\n"
MATERIAL = {"preset": "mine", "file": "mine.toml"}
SMALL = (
    'name = "small"\nmaterial = "brass"\n[packing]\nkind = "fcc"\nsize = [3, 3, 2]\ndiameter = 0.01\n'
    "[run]\nend_time = 1e-5\nframes = 2\n"
)
CHAIN = 'name = "c"\nmaterial = "brass"\n[packing]\nkind = "chain"\nsize = 4\ndiameter = 0.01\n'
BLOCK = (
    'name = "block"\nmaterial = {preset = "mine", file = "mine.toml"}\n[block]\ndiameter = 0.1\n'
)
SPHERE = 'name = "s"\nmaterial = "brass"\n[sphere]\nradius = 0.005\n'


@pytest.fixture
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    """Folder of a case file and working directory; each has a mine.toml, with different moduli."""
    folder = tmp_path / "folder"
    here = tmp_path / "here"
    for place, modulus in ((folder, "2e11"), (here, "1e11")):
        place.mkdir()
        (place / "mine.toml").write_text(MINE.format(modulus=modulus), encoding="utf-8")
        (place / "pulse.txt").write_text(f"0 0\n1e-5 {modulus}\n2e-5 0\n", encoding="utf-8")
    monkeypatch.chdir(here)
    return folder, here


# All places of a material: lines of a case file, the same for --set, and access to its value.
PLACES: list[tuple[str, str, Callable[[Any], Any]]] = [
    ("", "material", lambda case: case.material),
    ("[[replace]]\nindex = 2\nmaterial = {}\n", "replace.1.material", lambda case: case.replace[0].material),
    ("[[striker]]\ntouches = 1\nmaterial = {}\n", "striker.1.material", lambda case: case.striker[0].material),
    ("[boundary]\nbottom = {{material = {}}}\n", "boundary.bottom.material",
     lambda case: case.boundary.bottom_material),
    ("[boundary]\nsides = {{material = {}}}\n", "boundary.sides.material", lambda case: case.boundary.sides_material),
    ("[boundary]\nbottom = {{half_space = {{}}, material = {}}}\n", "boundary.bottom.material",
     lambda case: case.boundary.bottom_material),
    ("[bar]\nlength = 1\narea = 1e-4\nmaterial = {}\n", "bar.material", lambda case: case.bar.material),
    ('[load]\nkind = "force"\nshape = "half-sine"\namplitude = 1\nduration = 1e-5\n[incident_bar]\nlength = 1\n'
     "area = 1e-4\nmaterial = {}\n", "incident_bar.material", lambda case: case.incident_bar.material),
]  # fmt: skip


@pytest.mark.parametrize(("lines", "key", "found"), PLACES)
def test_a_material_of_a_file_wherever_one_may_stand(
    places: tuple[Path, Path], lines: str, key: str, found: Callable[[Any], Any]
) -> None:
    folder, _ = places
    text = CHAIN + lines.format('{preset = "mine", file = "mine.toml"}')
    if not lines:
        text = text.replace(
            'material = "brass"', 'material = {preset = "mine", file = "mine.toml"}'
        )
    (folder / "my.toml").write_text(text, encoding="utf-8")
    assert found(load_case(folder / "my.toml")).youngs_modulus == 2e11
    (folder / "my.toml").write_text(CHAIN + lines.format('"brass"'), encoding="utf-8")
    for overrides in (
        [f'{key}={{preset="mine",file="mine.toml"}}'],
        [f"{key}.preset=mine", f"{key}.file=mine.toml"],
        {key: MATERIAL},
        {key: {"preset": "mine", "file": "../here/mine.toml"}},
    ):
        assert found(load_case(folder / "my.toml", overrides)).youngs_modulus == 1e11, overrides


def test_a_material_of_a_file_in_continuum_cases(places: tuple[Path, Path]) -> None:
    folder, _ = places
    (folder / "block.toml").write_text(BLOCK, encoding="utf-8")
    (folder / "sphere.toml").write_text(
        SPHERE + '[partner]\nmaterial = {preset = "mine", file = "mine.toml"}\n', encoding="utf-8"
    )
    assert ContinuumCase.load(folder / "block.toml").material.youngs_modulus == 2e11
    assert (
        ContinuumCase.load(
            folder / "block.toml", ["material.file=mine.toml"]
        ).material.youngs_modulus
        == 1e11
    )
    assert SphereContactCase.load(folder / "sphere.toml").materials[1].youngs_modulus == 2e11
    changed = SphereContactCase.load(
        folder / "sphere.toml", {"partner.material": MATERIAL, "material": MATERIAL}
    )
    assert [material.youngs_modulus for material in changed.materials] == [1e11, 1e11]
    with pytest.raises(InputError, match=r"^partner.material.file: .*here/none.toml: no such file"):
        SphereContactCase.load(folder / "sphere.toml", {"partner.material.file": "none.toml"})


def test_points_of_a_load(places: tuple[Path, Path]) -> None:
    folder, _ = places
    (folder / "my.toml").write_text(
        CHAIN + '[load]\nkind = "force"\nfile = "pulse.txt"\n', encoding="utf-8"
    )
    case = load_case(folder / "my.toml")
    assert case.load.shape == "table" and case.load.table == ((0, 0), (1e-5, 2e11), (2e-5, 0))
    for overrides in (
        ["load.file=pulse.txt"],
        ['load={kind="force",shape="table",file="pulse.txt"}'],
    ):
        assert load_case(folder / "my.toml", overrides).load.largest == 1e11


def test_dents_of_an_earlier_run(places: tuple[Path, Path]) -> None:
    folder, here = places
    (folder / "my.toml").write_text(
        SMALL + '[contact]\ninitial_overlap = "first"\n', encoding="utf-8"
    )
    assert load_case(folder / "my.toml").contact.initial_overlap == str(folder / "first")
    for overrides in (["contact.initial_overlap=first"], {"contact.initial_overlap": "first"}):
        assert load_case(folder / "my.toml", overrides).contact.initial_overlap == str(
            here / "first"
        )
    tables = load_case(folder / "my.toml").to_dict() | {
        "contact": {"initial_overlap": "sub/../first"}
    }
    assert case_from_dict(tables).contact.initial_overlap == str(here / "first")
    assert case_from_dict(load_case(folder / "my.toml").to_dict()) == load_case(folder / "my.toml")


def test_only_text_under_keys_of_files_is_a_path(tmp_path: Path) -> None:
    tables = {"name": "file", "initial_overlap": [{"overlap": 1e-6}], "file": 3, "material": {"file": ""}, "x": ["a"],
              "load.file": ["a", 2], "odd": {"file": "a\0b"}}  # fmt: skip
    assert with_absolute_paths(tables, tmp_path) == tables | {"load.file": [str(tmp_path / "a"), 2]}
    assert with_short_paths({"file": str(tmp_path / "a")}, tmp_path) == {"file": "a"}
    assert with_short_paths({"file": "/usr"}, tmp_path) == {"file": "/usr"}
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    for directory in ("real", "link"):  # links lead to one path
        found = with_absolute_paths({"contact": {"initial_overlap": "x"}}, tmp_path / directory)
        assert found == {"contact": {"initial_overlap": str(tmp_path / "real" / "x")}}


# ---------------------------------------------------------------------- scans


def _scan(folder: Path, tables: str, case: str = "my.toml") -> Path:
    (folder / "my.toml").write_text(SMALL, encoding="utf-8")
    path = folder / "scan.toml"
    path.write_text(f'case = "{case}"\n{tables}', encoding="utf-8")
    return path


MINE_THERE = '{preset = "mine", file = "mine.toml"}'


@pytest.mark.parametrize(
    "tables",
    [
        f"[set]\nmaterial = {MINE_THERE}\n[grid]\nload.velocity = [1]\n",
        f"[grid]\nmaterial = [{MINE_THERE}]\n",
        '[set]\nmaterial.preset = "mine"\n[grid]\nmaterial.file = ["mine.toml"]\n',
        '[grid]\n"material.file" = ["mine.toml"]\n"material.preset" = ["mine"]\n',
        f"[[zip]]\nmaterial = [{MINE_THERE}]\nload.velocity = [1]\n",
        f"[[points]]\nmaterial = {MINE_THERE}\n",
        '[[points]]\n"material.file" = "mine.toml"\n"material.preset" = "mine"\n',
    ],
)
def test_files_of_a_scan_are_beside_it(
    places: tuple[Path, Path], tables: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, _ = places
    path = _scan(folder, tables)
    (point,) = load_scan(path).points
    assert point.case.material.youngs_modulus == 2e11
    monkeypatch.chdir(folder)
    (again,) = load_scan("scan.toml").points
    assert again.id == point.id and again.labels == point.labels


def test_files_set_from_outside_a_scan_are_here(places: tuple[Path, Path]) -> None:
    path = _scan(places[0], "[grid]\nload.velocity = [1]\n")
    for overrides in ([f"material={MINE_THERE}"], {"material": MATERIAL}):
        assert load_scan(path, overrides).points[0].case.material.youngs_modulus == 1e11


def test_labels_of_paths_are_as_seen_from_the_scan(places: tuple[Path, Path]) -> None:
    folder, _ = places
    (folder / "other.toml").write_text(MINE.format(modulus="3e11"), encoding="utf-8")
    path = _scan(
        folder,
        '[set]\nmaterial.preset = "mine"\n[grid]\nmaterial.file = ["mine.toml", "other.toml"]\n',
    )
    assert [point.labels["material.file"] for point in load_scan(path).points] == [
        "mine.toml",
        "other.toml",
    ]
    path = _scan(folder, f"[grid]\nmaterial = [{MINE_THERE}]\n")
    assert load_scan(path).points[0].labels["material"] == "mine file=mine.toml"


def test_the_case_of_a_scan_is_not_looked_for_here(places: tuple[Path, Path]) -> None:
    folder, here = places
    (here / "only-here.toml").write_text(SMALL, encoding="utf-8")
    with pytest.raises(
        InputError, match=r"scan.toml: case: only-here.toml: neither a file nor a built-in case"
    ):
        load_scan(_scan(folder, "[grid]\nload.velocity = [1]\n", case="only-here.toml"))


def test_scans_and_cases_of_a_suite(places: tuple[Path, Path]) -> None:
    folder, here = places
    _scan(folder, "[grid]\nload.velocity = [1]\n")
    (folder / "suite.toml").write_text(
        'scans = ["scan.toml"]\ncases = ["my.toml"]\n', encoding="utf-8"
    )
    assert [scan.name for scan in load_suite(folder / "suite.toml").scans] == ["scan", "my"]
    for name in ("scan.toml", "my.toml"):
        (folder / name).rename(here / name)
    with pytest.raises(InputError) as caught:
        load_suite(folder / "suite.toml")
    assert [
        fault.removeprefix(f"{folder / 'suite.toml'}: ").partition("; ")[0]
        for fault in caught.value.errors
    ] == [
        "scans: scan.toml: neither a file nor a built-in scan",
        "cases: my.toml: neither a file nor a built-in case",
    ]


def test_a_scan_of_the_repository_is_missing_without_it(places: tuple[Path, Path]) -> None:
    _, here = places
    name = "reproductions/bands/suite.toml"
    with pytest.raises(InputError, match=f"{name}: not found.*only in a checkout"):
        find(name, SCANS, here)


# ---------------------------------------------------------------------- opened before anything is run


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Directory of a small run."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "small.toml").write_text(SMALL, encoding="utf-8")
    assert (
        main(["run", str(folder / "small.toml"), "-o", str(folder / "first"), "--no-figures"]) == 0
    )
    return folder / "first"


#: Damages of a result.h5: a data set, and what is written in its place; and the message.
DAMAGES: dict[str, tuple[str, Any, str]] = {
    "rows": ("contacts/i", [1, 2], "contacts: found columns of 2 and"),
    "nan": (
        "contacts/peak_overlap",
        float("nan"),
        "contacts/peak_overlap: found values that are not finite, or negative",
    ),
    "words": ("spheres/id", ["a"] * 18, "is not the result.h5 of a run"),
    "group": ("wall_contacts/wall", None, "is not the result.h5 of a run"),
    "shape": ("spheres/position", [0.0] * 18, "spheres/position: found the shape (18,)"),
    "cut": ("", None, "is not the result.h5 of a run"),
    "missing": ("", None, "no such file; expected the result.h5 of a run"),
    "other packing": ("", None, "belongs to another packing: found 18 spheres, expected 27"),
}


@pytest.mark.parametrize("kind", DAMAGES)
def test_all_words_refuse_dents_that_cannot_be_had(
    first: Path, tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    result = tmp_path / "result.h5"
    content = (first / "result.h5").read_bytes()
    name, value, expected = DAMAGES[kind]
    if kind != "missing":
        result.write_bytes(content[: len(content) // 2] if kind == "cut" else content)
    if name:
        with h5py.File(result, "r+") as file:
            value = np.append(value, file[name][1:]) if kind == "nan" else value
            del file[name]
            if value is None:
                file.create_group(name)
            else:
                file[name] = value
    text = SMALL.replace("[3, 3, 2]", "[3, 3, 3]") if kind == "other packing" else SMALL
    (tmp_path / "my.toml").write_text(
        text + '[contact]\ninitial_overlap = "result.h5"\n', encoding="utf-8"
    )
    scan = tmp_path / "scan.toml"
    scan.write_text('case = "my.toml"\n[grid]\nload.velocity = [1, 2]\n', encoding="utf-8")
    for words in (
        ["check", "my.toml"],
        ["write", "my.toml", "-o", "out"],
        ["scan", "scan.toml", "-o", "out"],
    ):
        assert (
            main([word if word in ("-o", words[0]) else str(tmp_path / word) for word in words])
            == 2
        ), words
        error = capsys.readouterr().err
        assert (
            error.count("\n") == 1
            and f"contact.initial_overlap: {result}: " in error
            and expected in error
        ), words
        assert not (tmp_path / "out").exists()


def test_points_that_are_done_need_no_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my.toml").write_text(SMALL, encoding="utf-8")
    (tmp_path / "scan.toml").write_text(
        'case = "my.toml"\n[grid]\ncontact.initial_overlap = [0, "gone", "gone-too"]\n',
        encoding="utf-8",
    )
    scan = load_scan(tmp_path / "scan.toml")
    out = tmp_path / "out"
    with pytest.raises(InputError) as caught:
        check_points(scan, ResultDirectory(out), force=False)
    assert [fault.partition(" (")[0] for fault in caught.value.errors] == [
        "scan: point 2",
        "scan: point 3",
    ]
    assert (
        "contact.initial_overlap = gone-too): small: contact.initial_overlap: "
        in caught.value.errors[1]
    )
    done = {point.id for point in scan.points[1:]}
    monkeypatch.setattr(layout, "is_whole", lambda _, point: point in done)
    check_points(scan, ResultDirectory(out), force=False)
    with pytest.raises(InputError):
        check_points(scan, ResultDirectory(out), force=True)


def test_results_are_not_replaced_that_the_run_itself_needs(
    first: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "my.toml").write_text(SMALL, encoding="utf-8")
    assert (
        main(["run", str(tmp_path / "my.toml"), "-o", str(tmp_path / "out"), "--no-figures"]) == 0
    )
    before = (tmp_path / "out" / "result.h5").stat().st_mtime_ns
    for word in ("run", "write"):
        for named in ("out", "out/result.h5"):
            words = [word, str(tmp_path / "my.toml"), "--force", "-o", str(tmp_path / "out")]
            capsys.readouterr()
            assert main([*words, "--set", f"contact.initial_overlap={tmp_path / named}"]) == 2
            assert "is one of the results that would be replaced" in capsys.readouterr().err
    assert (tmp_path / "out" / "result.h5").stat().st_mtime_ns == before
    # a second run in the folder of another does not replace its results
    words = ["run", str(tmp_path / "my.toml"), "-o", str(tmp_path), "--no-figures"]
    assert main([*words, "--set", f"contact.initial_overlap={tmp_path / 'out'}"]) == 0


def test_case_of_a_results_directory_runs_from_anywhere(
    first: Path, places: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, here = places
    (folder / "first").symlink_to(first)
    text = SMALL.replace('"brass"', '{preset = "mine", file = "mine.toml"}')
    (folder / "my.toml").write_text(
        text + '[contact]\ninitial_overlap = "first"\n', encoding="utf-8"
    )
    assert main(["write", "../folder/my.toml", "-o", "deck"]) == 0
    monkeypatch.chdir("/")
    case = load_case(here / "deck" / "case.toml")
    assert case.contact.initial_overlap == str(first) and case.material.youngs_modulus == 2e11
    assert main(["check", str(here / "deck" / "case.toml")]) == 0


@pytest.mark.parametrize("cell", ["-1.5e-3", "+7", "-inf", "-", "", "a=1", "brass"])
def test_numbers_and_other_text_stay(cell):
    file = io.StringIO()
    write_csv_rows(file, [[cell, -2.5, None]])
    assert file.getvalue() == f"{cell},-2.5,\n"
    for formula in ("=1+1", "+cmd|calc", "-2+3", "@SUM(A1)", "\t=1", '=HYPERLINK("a")'):
        write_csv_rows(file := io.StringIO(), [[formula]])
        assert next(csv.reader([file.getvalue()])) == [f"'{formula}"]


def test_columns_named_by_the_user(tmp_path):
    write_csv({"=group": ["=a", "b"], "force": [-1.0, 2.0]}, tmp_path / "table.csv")
    assert (tmp_path / "table.csv").read_text() == "'=group,force\n'=a,-1\nb,2\n"
