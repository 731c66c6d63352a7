"""Invalid scan files: messages, and detection of all errors at once."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from granwave.analysis.scans.result import ScanResult
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import load_profile
from granwave.workflows.cli.tables.scan_outcome import outcome_text
from granwave.workflows.scanning.batches import Machine
from granwave.workflows.scanning.driver import ScanOutcome
from granwave.workflows.scanning.engine import request_of
from tests.helpers.made_up.scan_texts import SMALL, VELOCITIES, Load, reader
from tests.helpers.made_up.synthetic_scan import grid, write_scan


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


@pytest.mark.parametrize(
    ("options", "said"),
    [("--account=a", "no --account: it is the key slurm.account"), ("--mem 3", "it is the key slurm.memory"),
     ("-J x", "no -J: granwave sets it for each job")],
)  # fmt: skip
def test_options_of_a_profile_that_have_their_own_place(
    tmp_path: Path, options: str, said: str
) -> None:
    (tmp_path / "p.toml").write_text(f'[slurm]\noptions = "{options}"\n')
    with pytest.raises(InputError, match=said):
        load_profile(tmp_path / "p.toml")


def test_a_profile_tells_how_jobs_are_submitted(tmp_path: Path, load: Load) -> None:
    (tmp_path / "p.toml").write_text(
        '[slurm]\nmemory = 70\noptions = "-q long --comment2=\'a b\'"\nbefore = "module load x"\n'
    )
    points = list(load(SMALL + VELOCITIES).distinct.values())
    (batch, *_) = Machine(1).batches(points, "a")
    profile = load_profile(tmp_path / "p.toml")
    script = profile.script(request_of(profile, batch, "my", tmp_path))
    for option in ("-q long --comment2='a b'", "--mem=70", "--ntasks=1", "--job-name=granwave-my"):
        assert f"#SBATCH {option}\n" in script
    assert "\nmodule load x\nexec srun --ntasks=1 " in script
    assert script.endswith(f"batches/{batch.id}.json\n")


def end_of(tmp_path, points, share) -> str:
    scan = write_scan(tmp_path / "scan", points)
    for point in ScanResult(scan).points:
        path = scan / "points" / point.id / "summary.json"
        path.write_text(
            json.dumps(json.loads(path.read_text()) | {"dissipated_fraction": share(point.labels)})
        )
    return outcome_text(ScanOutcome(scan, done=len(points), failed=0, missing=0, stopped=None))


def test_means_and_a_sentence(tmp_path):
    points = grid(load__velocity=[1, 2], packing__seed=[1, 2, 3])
    text = end_of(tmp_path, points, lambda p: 0.3 * p["load.velocity"] + 0.05 * p["packing.seed"])
    assert "means of 3 replicates, with 95 % confidence intervals:" in text
    (head,) = [line for line in text.splitlines() if "Impact velocity (m/s)" in line]
    assert "Dissipated fraction" in head and "0.40 ± 0.12" in text
    ends = "from 0.40 ± 0.12 (impact velocity 1 m/s) to 0.70 ± 0.12 (impact velocity 2 m/s)"
    assert f"{ends}. It rises with" in text


def test_means_within_their_intervals_have_no_trend(tmp_path):
    """A difference of 0.3 is less than the combined interval, 0.35; the sentence is on the force,
    which differs by more.
    """
    points = grid(load__velocity=[1, 2], packing__seed=[1, 2, 3])
    text = end_of(tmp_path, points, lambda p: 0.3 * p["load.velocity"] + 0.1 * p["packing.seed"])
    assert "Dissipated fraction: from" not in text
    assert "Peak contact force, excluding walls: from" in text


def test_the_force_on_the_bottom_is_in_the_table_of_means(tmp_path):
    """Values of zones that reach a boundary give their place to the force on the bottom."""
    points = grid(packing__diameter_scatter=[1e-6, 5e-6], packing__seed=[1, 2, 3])
    scan = write_scan(tmp_path / "scan", points)
    for point in ScanResult(scan).points:
        path = point.directory / "summary.json"
        force = 2000.0 - 2e8 * point.labels["packing.diameter_scatter"]
        more = {"wall_peak_force_N": force + point.labels["packing.seed"], "zone_cut": ["sides"]}
        path.write_text(json.dumps(json.loads(path.read_text()) | more))
    text = outcome_text(ScanOutcome(scan, done=6, failed=0, missing=0, stopped=None))
    (head,) = [line for line in text.splitlines() if "Diameter scatter (µm)" in line]
    assert "Peak force on the bottom (N)" in head and "Yielded spheres" not in head
    assert "\nPeak force on the bottom: from " in text


def test_values_that_the_end_limits_are_listed(tmp_path):
    """All of them, and both marks of a zone that reaches a boundary after a returned wave."""
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[1, 2, 4]))
    point = ScanResult(scan).points[2]
    path = point.directory / "summary.json"
    more = {
        "incomplete_values": ["n_plastic_spheres", "wall_impulse_Ns"],
        "zone_cut": ["sides"], "wave_return_share": 0.1,
    }  # fmt: skip
    path.write_text(json.dumps(json.loads(path.read_text()) | more))
    text = outcome_text(ScanOutcome(scan, done=3, failed=0, missing=0, stopped=None))
    assert (
        "\nvalues that still change at the end of the run, in 1 of 3 points, as marked in figures: "
        "yielded spheres, impulse on the bottom; increase run.end_time\n" in text
    )
    assert "zone reaches a boundary in 1 of 3 points" in text
    assert "reflected wave came back in 1 of 3 points" in text


def test_without_replicates_there_is_the_sentence_alone(tmp_path):
    text = end_of(tmp_path, grid(load__velocity=[1, 2, 4]), lambda p: 0.1 * p["load.velocity"])
    assert "means of" not in text
    assert (
        "Dissipated fraction: from 0.1 (impact velocity 1 m/s) to 0.4 (impact velocity 4 m/s)."
        in text
    )
