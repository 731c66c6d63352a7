"""Options ``--submit``, ``--print``, ``--chain`` of commands, and ``check --profile``."""

from __future__ import annotations

import json

import pytest

PROFILE = """[cluster]
scheduler = "pbs"
partition = "workq"
nodes = 2
cores = 16
"""
SMALL = ["--set", "run.end_time=5e-5"]


@pytest.fixture
def profile(tmp_path):
    (tmp_path / "cluster.toml").write_text(PROFILE)
    return tmp_path


def test_the_script_of_a_run(granwave, profile):
    done = granwave("run", "fcc-small", *SMALL, "--submit", "cluster.toml", "--print", cwd=profile)
    assert done.returncode == 0, done.stderr
    assert "#PBS -l select=2:ncpus=16:mpiprocs=16:mem=" in done.stdout
    assert "#PBS -q workq\n" in done.stdout
    assert f"cd {profile}/fcc-small.job\n" in done.stdout
    assert [path.name for path in profile.iterdir()] == ["cluster.toml"]


def test_the_script_of_a_scan(granwave, profile):
    done = granwave("scan", "restitution", "--submit", "cluster.toml", "--print", cwd=profile)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("#!/bin/bash\n#PBS -S /bin/bash\n#PBS -N granwave-restit\n")
    assert "granwave.workflows.cli.worker .scan/batches/" in done.stdout
    assert [path.name for path in profile.iterdir()] == ["cluster.toml"]


def test_a_usual_slurm_without_a_profile(granwave, tmp_path):
    done = granwave("run", "fcc-small", *SMALL, "--print", "--submit", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "#SBATCH --ntasks=1\n" in done.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("run fcc-small --print", "--print: requires --submit"),
        ("run fcc-small --chain 2", "--chain: requires --submit"),
        ("scan restitution --print", "--print: requires --submit"),
        ("scan restitution --submit cluster.toml --executor slurm", "cannot be combined"),
        ("scan restitution --executor slurm --profile cluster.toml", "expected pbs, the scheduler"),
        ("run fcc-small --submit none.toml", "none.toml"),
    ],
)
def test_options_that_do_not_fit(granwave, profile, words, said):
    done = granwave(*words.split(), cwd=profile)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert [path.name for path in profile.iterdir()] == ["cluster.toml"]


def test_without_the_scheduler(granwave, profile, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    done = granwave("run", "fcc-small", *SMALL, "--submit", "cluster.toml", cwd=profile)
    assert done.returncode == 2
    assert "--submit: there is no qsub here; run it on a login node" in done.stderr
    assert [path.name for path in profile.iterdir()] == ["cluster.toml"]


def test_a_folder_of_somebody_else(granwave, profile, monkeypatch):
    """The existing directory is kept, and nothing is submitted."""
    tools = profile / "tools"
    tools.mkdir()
    for name in ("qsub", "qstat", "qdel"):
        (tools / name).write_text("#!/bin/sh\n")
        (tools / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tools}:/usr/bin:/bin")
    folder = profile / "out.job"
    folder.mkdir()
    (folder / "mine").write_text("x")
    words = ["run", "fcc-small", "-o", "out", *SMALL, "--submit", "cluster.toml"]
    done = granwave(*words, cwd=profile)
    assert done.returncode == 2
    assert "out.job: found something else" in done.stderr
    assert [path.name for path in folder.iterdir()] == ["mine"]


def test_the_plan_for_a_cluster(granwave, profile):
    done = granwave("check", "fcc-small", "--profile", "cluster.toml", "--json", cwd=profile)
    assert done.returncode == 0, done.stderr
    values = json.loads(done.stdout)
    assert (values["scheduler"], values["n_ranks"], values["n_nodes"]) == ("pbs", 32, 2)
    here = granwave("check", "fcc-small", "--np", "32", "--json", cwd=profile)
    assert values["memory_bytes"] == json.loads(here.stdout)["memory_bytes"]
    assert values["memory_bytes"] / 2 < values["memory_of_node_bytes"] < values["memory_bytes"]
    assert values["memory_other_rank_bytes"] < values["memory_first_rank_bytes"]


def test_a_plan_beyond_the_limits_of_a_profile(granwave, profile):
    """Time for a chain, and a warning of memory."""
    (profile / "cluster.toml").write_text(PROFILE + "time = 1\nmemory = 100\n")
    words = ["check", "fcc-small", "--profile", "cluster.toml", "--set", "run.end_time=1.0"]
    done = granwave(*words, "--set", "run.timestep=1e-8", "--np", "1", cwd=profile)
    assert done.returncode == 0, done.stderr
    assert "PBS: 1 rank on 1 node, partition workq" in done.stdout
    assert " jobs, --chain " in done.stdout
    assert "memory of the profile: found 100 MB on each node, expected at least" in done.stderr
