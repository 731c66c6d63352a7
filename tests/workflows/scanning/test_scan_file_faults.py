"""Invalid scan files: messages, and detection of all errors at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.workflows import load_profile, load_scan
from granwave.workflows.scanning.batches import Machine
from granwave.workflows.scanning.engine import submission
from tests.helpers.scan_texts import SMALL, VELOCITIES, Load, reader


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Read a scan of this text."""
    return reader(tmp_path)


@pytest.fixture
def faults_of(load: Load, tmp_path: Path) -> Callable[..., list[str]]:
    """Errors of a scan of this text, without its path."""

    def errors(text: str, overrides=()) -> list[str]:
        with pytest.raises(InputError) as caught:
            load(text, overrides)
        assert all(fault.count("\n") == 0 for fault in caught.value.errors)
        return [fault.removeprefix(f"{tmp_path / 'my.toml'}: ") for fault in caught.value.errors]

    return errors


def test_only_the_invalid_points_are_named_a_line_each(faults_of) -> None:
    errors = faults_of(SMALL + "[grid]\nload.velocity = [1, -1, 2, 0]\nload.spheres = [1, 3]\n")
    assert [fault.split(")")[0] + ")" for fault in errors] == [
        "point 3 (load.velocity = -1, load.spheres = 1)",
        "point 4 (load.velocity = -1, load.spheres = 3)",
        "point 7 (load.velocity = 0, load.spheres = 1)",
        "point 8 (load.velocity = 0, load.spheres = 3)",
    ]
    assert all("expected a number above 0 (m/s)" in fault for fault in errors)


def test_a_point_that_is_wrong_twice_has_one_line(faults_of) -> None:
    (fault,) = faults_of(SMALL + VELOCITIES + "[[points]]\nload.velocity = nan\nload.spheres = 2\n")
    assert fault.startswith("point 3 (load.velocity = nan, load.spheres = 2): ")
    assert "load.velocity: found nan" in fault and "; load.spheres: found 2" in fault


def test_what_is_wrong_with_every_point_is_said_once(faults_of) -> None:
    assert faults_of(SMALL + "packing.diametre = 1\n" + VELOCITIES) == [
        "packing.diametre: unknown key; did you mean diameter?"
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[grid]\nload.velocty = [1, 2]", [["load.velocty", "did you mean velocity"]]),
        ("[grid]\nlaod.velocity = [1, 2]", [["laod", "did you mean load"]]),
        ("[grid]\nload.velocity = []", [["grid: load.velocity", "found []", "at least one value"]]),
        ("[grid]\nload.velocity = 3", [["grid: load.velocity", "found 3", "list", "belongs under [set]"]]),
        ('[grid]\nmaterial = "brass"', [["grid: material", '"brass"', "list"]]),
        (
            "[[zip]]\nload.velocity = [1, 2]\nload.spheres = [1, 3, 7]",
            [["zip 1", "different lengths", "load.velocity has 2", "load.spheres has 3"]],
        ),
        (
            "[[zip]]\nload.velocity = [1, 2]\n[[zip]]\nload.spheres = [1]\nrun.frames = [2, 3]",
            [["zip 2", "load.spheres has 1"]],
        ),
        ("[[zip]]\nload.velocity = []\nload.spheres = []", [["zip 1: load.velocity"], ["zip 1: load.spheres"]]),
        ("[[zip]]", [["zip 1", "empty table"]]),
        ("[[points]]", [["points 1", "empty table"]]),
        ("", [["nothing varies", "[grid], [[zip]] or [[points]]"]]),
        ("[grid]", [["nothing varies"]]),
        ("load.velocity = 3\n" + VELOCITIES, [["set: load.velocity", "varies in the scan"]]),
        (VELOCITIES + "[[zip]]\nload.velocity = [3, 4]", [["load.velocity", "varies twice"]]),
        ("name.x = 1\n" + VELOCITIES, [["name.x", "expected a table [name]"]]),
        ('"a..b" = 1\n"" = 2\n' + VELOCITIES, [["set", '"a..b"', "load.velocity"], ["set", '""']]),
        ("[grid]\nload.velocity = {log = [0, 10, 3]}", [["{log = [first, last, how many]}", "positive"]]),
        ("[grid]\nload.velocity = {log = [1, nan, 3]}", [["load.velocity", "nan", "[first, last, how many]"]]),
        ("[grid]\nload.velocity = {log = [1e-308, 1e308, 3]}", [["closer to each other"]]),
        (f"[grid]\nload.velocity = {{linear = [1, 1{'0' * 400}, 3]}}", [["[first, last, how many]"]]),
        ("[grid]\nload.velocity = {linear = [1, 10, 1]}", [["2 to 100000 values"]]),
        ("[grid]\nload.velocity = {linear = [1, 10, 2.5]}", [["2 to 100000 values"]]),
        ("[grid]\nload.velocity = {linear = [1, 10]}", [["[first, last, how many]"]]),
        ("[grid]\nload.velocity = {linear = [1, 2, 3], log = [1, 2, 3]}", [["expected a list of values"]]),
        ("[grid]\nload.velocity = {lin = [1, 2, 3]}", [["expected a list of values"]]),
        (
            "[grid]\nload.velocity = {linear = [1, 20, 1000]}\nload.spheres = {linear = [1, 7, 101]}",
            [["found 101000 points", "at most 100000"]],
        ),
        ("packing.kind = 'hpc'\n" + VELOCITIES, [["packing.kind", "did you mean hcp"]]),
        (f"run.frames = 1{'0' * 400}\n" + VELOCITIES, [["run.frames", "expected at most"]]),
        ("[[points]]\nrun.frames = 3\n[[points]]\nload.spheres = 2", [["point 2", "load.spheres"]]),
    ],
)
def test_faults_of_the_tables(faults_of, text: str, expected: list[list[str]]) -> None:
    errors = faults_of(SMALL + text)
    assert len(errors) == len(expected), errors
    for fault, words in zip(errors, expected, strict=True):
        assert all(word in fault for word in words), fault


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('case = "fcc-smal"\n', [["case", "fcc-smal", "did you mean fcc-small"]]),
        ('case = "velocity-fcc"\n', [["case", "is a scan, expected a case"]]),
        ('case = "."\n', [["case", "found a directory"]]),
        (f'case = "{"a" * 5000}"\n', [["case", "neither a file nor a built-in"]]),
        ("case = 3\n", [["case", "found 3"]]),
        ("", [["case", "missing"]]),
        ('case = "fcc-small"\nrepliactes = 3\n', [["repliactes", "did you mean replicates"]]),
        ('case = "fcc-small"\nreplicates = 0\n', [["replicates", "found 0", "from 1 up"]]),
        ('case = "fcc-small"\nreplicates = 2\nset = {packing.seed = 3}\n', [["packing.seed", "varies in the scan"]]),
        ('case = "fcc-small"\nranks = 0\n', [["ranks", "found 0", "from 1 up"]]),
        ('case = "fcc-small"\nranks = {mots = 2}\n', [["ranks", "mots", "did you mean most"]]),
        ('case = "fcc-small"\nfigures = "yes"\n', [["figures", "true"]]),
        ('case = "fcc-small"\nset = 4\n', [["set", "found 4", "a table"]]),
        ('case = "fcc-small"\nzip = 3\npoints = [1]\n', [["zip", "[[zip]]"], ["points", "[[points]]"]]),
        *(
            (f'case = "fcc-small"\nname = {name}\n', [["name", "a plain name"]])
            for name in ('"../x"', '"/tmp/x"', '".."', '"."', '" "', '"a\\u001b[31m"', f'"{"a" * 300}"', "3")
        ),
    ],
)
def test_faults_of_the_head(faults_of, text: str, expected: list[list[str]]) -> None:
    errors = faults_of(text + VELOCITIES)
    assert len(errors) == len(expected), errors
    for fault, words in zip(errors, expected, strict=True):
        assert all(word in fault for word in words), fault


def test_every_fault_is_found_at_once(faults_of) -> None:
    errors = faults_of('ranks = 0\ncase = "fcc-small"\n[grid]\nload.velocity = []\nmaterial = "brass"\n[[zip]]\n')
    assert [fault.split(" ")[0] for fault in errors] == ["ranks:", "grid:", "grid:", "zip"]


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("load.velocity=3", ["--set: load.velocity", "varies in the scan"]),
        ("load.veloctiy=3", ["--set: load.veloctiy", "did you mean velocity"]),
        ("load.spheres=2", ["--set: load.spheres", "found 2"]),
        ("load", ["--set", "KEY=VALUE"]),
    ],
)
def test_faults_of_overrides(load: Load, override: str, words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        load(SMALL + VELOCITIES, [override])
    (fault,) = caught.value.errors
    assert all(word in fault for word in words), fault


def test_points_must_fit_into_the_memory_unless_they_are_for_a_cluster(load: Load, faults_of) -> None:
    text = 'case = "fcc-small"\n[grid]\npacking.size = [[6, 6, 4], [1000, 1000, 400]]\n'
    (fault,) = faults_of(text)
    assert fault.startswith("point 2 (packing.size = [1000, 1000, 400])") and "GiB" in fault
    assert load(text, here=False).points[1].plan.memory > 1e11


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("velocity-fc", ["velocity-fc", "did you mean velocity-fcc"]),
        ("fcc-small", ["is a case, expected a scan", "granwave run fcc-small"]),
        ("/", ["found a directory"]),
        ("nowhere/my.toml", ["nowhere/my.toml"]),
    ],
)
def test_scans_that_do_not_exist(name: str, words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        load_scan(name)
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize(
    ("options", "said"),
    [("--account=a", "no --account: it is the key slurm.account"), ("--mem 3", "it is the key slurm.memory"),
     ("-J x", "no -J: granwave gives it to each job")],
)  # fmt: skip
def test_options_of_a_profile_that_have_their_own_place(tmp_path: Path, options: str, said: str) -> None:
    (tmp_path / "p.toml").write_text(f'[slurm]\noptions = "{options}"\n')
    with pytest.raises(InputError, match=said):
        load_profile(tmp_path / "p.toml")


def test_a_profile_tells_how_jobs_are_submitted(tmp_path: Path, load: Load) -> None:
    (tmp_path / "p.toml").write_text(
        '[slurm]\nmemory = 70\noptions = "-q long --comment2=\'a b\'"\nbefore = "module load x"\n'
    )
    points = list(load(SMALL + VELOCITIES).distinct.values())
    (batch, *_) = Machine(1).batches(points, "a")
    command, script = submission(load_profile(tmp_path / "p.toml"), batch, "my")
    assert command[-3:] == ["-q", "long", "--comment2=a b"] and "--mem=70" in command and "--ntasks=1" in command
    assert "\nmodule load x\nexec srun --ntasks=1 " in script and script.endswith(f"batches/{batch.id}.json\n")
