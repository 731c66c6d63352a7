"""Command line from the point of view of a user: exit statuses, messages, directories, ranks; see
also test_resume.py.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys

import h5py
import pytest

import granwave as gw
from tests.conftest import PLAIN
from tests.helpers.made_up.run_files import summary

pytestmark = pytest.mark.xdist_group("cli")  # its fixtures are made once

TINY = ["--set", "packing.size=[4,4,3]", "--set", "run.end_time=4e-5", "--set", "run.frames=3"]
QUICK = [*TINY, "--no-figures"]
FIGURES = ["energies", "timestep", "peak_force_principal"]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Finished small run."""
    directory = tmp_path_factory.mktemp("runs") / "tiny"
    words = [
        "run",
        "fcc-small",
        "-o",
        str(directory),
        *TINY,
        "--set",
        f"figures.only={json.dumps(FIGURES)}",
    ]
    done = subprocess.run(
        [sys.executable, "-m", "granwave.workflows", *words],
        capture_output=True,
        text=True,
        env=PLAIN,
    )
    assert done.returncode == 0, done.stderr
    return directory


def test_a_run_leaves_everything(finished):
    for name in (
        "case.toml",
        "in.granwave",
        "data.granwave",
        "log.lammps",
        "dumps",
        "result.h5",
        "summary.json",
    ):
        assert (finished / name).exists(), name
    drawn = {path.name for path in (finished / "figures").iterdir()}
    assert drawn >= {f"{name}.{kind}" for name in FIGURES for kind in ("png", "pdf", "csv")}
    values = summary(finished)
    assert 0 < values["timestep_smallest_s"] <= values["timestep_s"] <= values["timestep_largest_s"]
    assert values["timestep_s"] * values["n_steps"] == pytest.approx(values["end_time_s"])
    with h5py.File(finished / "result.h5") as file:
        units = {
            name: file["energy"][name].attrs["unit"]
            for name in ("timestep", "smallest_timestep", "expected_error")
        }
    assert units == {"timestep": "s", "smallest_timestep": "s", "expected_error": "1"}
    assert (
        values["energy_balance_error"] < 1e-5
        and values["n_spheres"] == 48
        and values["end_reason"] == "end_time"
    )


def test_balance_that_does_not_close_is_refused(granwave, tmp_path):
    done = granwave("run", "fcc-small", "-o", tmp_path / "r", *QUICK, "--set", "run.timestep=1e-6")
    assert done.returncode == 1 and "energy balance error too large: its error is" in done.stderr
    assert "remove run.timestep" in done.stderr
    assert summary(tmp_path / "r")["end_reason"] == "energy balance refused"


def test_a_loose_tolerance_is_accepted(granwave, tmp_path):
    loose = [
        "--set",
        "packing.size=[8,8,6]",
        "--set",
        "run.end_time=2e-4",
        "--set",
        "run.energy_tolerance=1e-3",
    ]
    done = granwave("run", "fcc-small", "-o", tmp_path / "r", *loose, "--no-figures")
    assert done.returncode == 0 and "balance misses" not in done.stderr
    values = summary(tmp_path / "r")
    assert 1e-5 < values["energy_balance_error"] < 1e-3 == values["energy_balance_accepted"]
    record = json.loads((tmp_path / "r" / "run.json").read_text())
    assert record["energy_balance_accepted"] == 1e-3
    page = granwave("report", tmp_path / "r", "-o", tmp_path / "report.md")
    text = (tmp_path / "report.md").read_text()
    assert page.returncode == 0 and "do not use" not in text
    assert "accepted: at most 0.001" in text


def test_published_variant_is_never_refused(granwave, tmp_path):
    variant = ["--set", "contact.variant=published", "--set", "run.timestep=4e-7"]
    done = granwave("run", "fcc-small", "-o", tmp_path / "r", *QUICK, *variant)
    assert done.returncode == 0, done.stderr
    assert summary(tmp_path / "r")["energy_balance_error"] > 1e-5


def test_end_time_auto_settles(granwave, lmp, tmp_path):
    sets = ["--set", "packing.size=[5,5,4]", "--set", "run.end_time=auto", "--set", "run.frames=3"]
    done = granwave("run", "fcc-small", "-o", tmp_path / "r", *sets, "--no-figures")
    assert done.returncode == 0, done.stderr
    values = summary(tmp_path / "r")
    assert values["end_reason"] == "settled" and values["end_time_s"] < 5e-3
    # the same holds for a deck run by hand, whose lmp finds the plugin automatically
    assert granwave("write", "fcc-small", "-o", tmp_path / "deck", *sets).returncode == 0
    assert "plugin" not in (tmp_path / "deck" / "in.granwave").read_text().replace("pair style", "")
    assert lmp(tmp_path / "deck" / "in.granwave").returncode == 0
    last = (tmp_path / "deck" / "dumps" / "energy.txt").read_text().splitlines()[-1].split()
    assert float(last[1]) == values["end_time_s"]


def test_velocity_beyond_the_law_runs_and_counts(granwave, tmp_path):
    done = granwave("run", "fcc-small", "-o", tmp_path / "r", *QUICK, "--set", "load.velocity=120")
    assert done.returncode == 0, done.stderr
    assert summary(tmp_path / "r")["contacts_beyond_law"] > 0
    assert "0.2 R*" in done.stderr


def test_show_gives_a_case_that_runs(granwave, tmp_path):
    done = granwave("show", "fcc-small")
    (tmp_path / "mine.toml").write_text(done.stdout)
    assert granwave("check", "mine.toml", cwd=tmp_path).returncode == 0


def test_check_tells_what_it_would_be(granwave):
    done = granwave("check", "fcc-impact")
    for word in ("155520", "902165", "GiB", "GB", "timestep", "steps", "time", "overlap"):
        assert word in done.stdout


def test_law_table_and_plot(granwave, tmp_path):
    done = granwave(
        "law",
        "--material",
        "brass",
        "steel",
        "--radius",
        "0.004",
        "0.008",
        "-o",
        "law.csv",
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "law.csv").open()))
    assert set(rows[0]) == {
        "branch",
        "overlap_m",
        "force_N",
        "overlap_normalised",
        "force_normalised",
    }
    assert {"loading"} < {row["branch"].split("_")[0].split(" ")[0] for row in rows}
    assert granwave("law", "-o", "law.png", cwd=tmp_path).returncode == 0
    assert (tmp_path / "law.png").read_bytes()[:4] == b"\x89PNG"


def test_law_of_a_material_of_a_file_on_a_plane(granwave, tmp_path):
    """The curve agrees with `granwave.contact_force`, and a case file can be used as a file of
    materials.
    """
    values = "youngs_modulus = 1e9\npoisson_ratio = 0.30\ndensity = 1200\nyield_strength = 30e6\n"
    (tmp_path / "mine.toml").write_text(f"[soft]\n{values}")
    (tmp_path / "case.toml").write_text(f'material = "brass"\n[materials.soft]\n{values}')
    for name in ("mine", "case"):
        options = ("--material", f"{name}.toml:soft", "steel", "--radius", "0.005", "inf")
        done = granwave("law", *options, "-o", f"{name}.csv", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "mine.csv").read_text() == (tmp_path / "case.csv").read_text()
    rows = list(csv.DictReader((tmp_path / "mine.csv").open()))
    soft = {"youngs_modulus": 1e9, "poisson_ratio": 0.3, "yield_strength": 30e6}
    bodies = [
        {"shape": "sphere", "radius": 0.005, "material": soft},
        {"shape": "plane", "material": "steel"},
    ]
    row = [row for row in rows if row["branch"] == "loading"][20]
    force = gw.contact_force("elastoplastic", bodies, float(row["overlap_m"]))
    assert float(row["force_N"]) == pytest.approx(force, rel=1e-6)
    done = granwave("law", "--radius", "inf", cwd=tmp_path)
    assert done.returncode == 2
    assert "the second may be inf, a plane" in done.stderr
    restitution = ("--restitution", "-o", "restitution.csv", "--radius", "0.005", "inf")
    assert granwave("law", *restitution, cwd=tmp_path).returncode == 0
    assert "sphere and plane" in (tmp_path / "restitution.csv").read_text()


def test_error_on_one_rank_ends_all(process, tmp_path):
    """The error occurs on one rank only; the others must not wait indefinitely."""
    sets = [
        "contact.law=thornton",
        "load.velocity=500",
        "packing.size=[8,8,4]",
        "run.end_time=2e-4",
        "run.frames=2",
    ]
    words = [word for one in sets for word in ("--set", one)]
    done = process("run", "fcc-small", "-o", tmp_path / "r", "--np", 2, *words, timeout=120)
    assert done.returncode == 1 and "more than the radius" in done.stderr
    assert json.loads((tmp_path / "r" / "run.json").read_text())["state"] == "failed"


def test_forces_on_the_bottom_do_not_depend_on_the_probes(finished, granwave, tmp_path):
    done = granwave(
        "run", "fcc-small", "-o", tmp_path / "r", *QUICK, "--set", "output.probe_interval=1e-5"
    )
    assert done.returncode == 0, done.stderr
    for key in ("wall_peak_force_N", "wall_impulse_Ns"):
        assert summary(tmp_path / "r")[key] == summary(finished)[key]
