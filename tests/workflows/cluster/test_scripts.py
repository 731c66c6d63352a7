"""Scripts of all schedulers, and the parsed output of their commands."""

from __future__ import annotations

import dataclasses
import shlex
import subprocess
from pathlib import Path

import pytest

from granwave.lammps_inputs.errors import InputError, RunError
from granwave.workflows.cluster.profile import load_profile
from granwave.workflows.cluster.scheduler import JobRequest
from granwave.workflows.cluster.schedulers import SCHEDULERS, scheduler

REQUEST = JobRequest(
    name="granwave-my scan", ranks=7, nodes=2, minutes=90, memory=3000, logs="logs",
    words=["python", "-m", "a b"], directory=Path("/scratch/my work"), before="module load mpich",
    partition="long", account="granular", parallel_environment="mpich", options="--x='a b'",
    after=("17",),
)  # fmt: skip
#: Directives of a job of 7 ranks on 2 nodes, 90 minutes and 3 GB a node, after job 17.
DIRECTIVES = {
    "slurm": """#SBATCH --job-name=granwave-myscan
#SBATCH --output=logs/%j.log
#SBATCH --export=ALL
#SBATCH --ntasks=7
#SBATCH --nodes=2
#SBATCH --ntasks-per-node=4
#SBATCH --time=90
#SBATCH --mem=3000
#SBATCH --signal=TERM@90
#SBATCH --partition=long
#SBATCH --account=granular
#SBATCH --dependency=afterany:17
#SBATCH --x='a b'""",
    "pbs": """#PBS -S /bin/bash
#PBS -N granwave-myscan
#PBS -o logs/
#PBS -j oe
#PBS -V
#PBS -l select=2:ncpus=4:mpiprocs=4:mem=3000mb
#PBS -l walltime=01:30:00
#PBS -q long
#PBS -A granular
#PBS -W depend=afterany:17
#PBS --x='a b'""",
    "torque": """#PBS -S /bin/bash
#PBS -N granwave-myscan
#PBS -o logs/
#PBS -j oe
#PBS -V
#PBS -l nodes=2:ppn=4
#PBS -l mem=6000mb
#PBS -l walltime=01:30:00
#PBS -q long
#PBS -A granular
#PBS -W depend=afterany:17
#PBS --x='a b'""",
    "lsf": """#BSUB -J granwave-myscan
#BSUB -o logs/%J.log
#BSUB -n 7
#BSUB -R "span[ptile=4]"
#BSUB -R "rusage[mem=3000MB]"
#BSUB -W 90
#BSUB -q long
#BSUB -P granular
#BSUB -w "ended(17)"
#BSUB --x='a b'""",
    "sge": """#$ -S /bin/bash
#$ -N granwave-myscan
#$ -cwd
#$ -o logs/$JOB_ID.log
#$ -j y
#$ -V
#$ -pe mpich 7
#$ -l h_rt=5400
#$ -l mem_free=750M
#$ -q long
#$ -P granular
#$ -hold_jid 17
#$ --x='a b'""",
    "moab": """#MSUB -S /bin/bash
#MSUB -N granwave-myscan
#MSUB -o logs/
#MSUB -j oe
#MSUB -V
#MSUB -l nodes=2:ppn=4
#MSUB -l mem=6000mb
#MSUB -l walltime=01:30:00
#MSUB -q long
#MSUB -A granular
#MSUB -l depend=afterany:17
#MSUB --x='a b'""",
    "flux": """# flux: --job-name=granwave-myscan
# flux: --output=logs/{{id}}.log
# flux: --nslots=7
# flux: --nodes=2
# flux: --time-limit=5400s
# flux: --queue=long
# flux: --bank=granular
# flux: --dependency=afterany:17
# flux: --x='a b'""",
}


def test_there_is_a_script_for_every_scheduler():
    assert set(DIRECTIVES) == set(SCHEDULERS)


@pytest.mark.parametrize("name", DIRECTIVES)
def test_script(name):
    shell, _, rest = scheduler(name).script(REQUEST).partition("\n")
    directives, _, commands = rest.partition("\n\n")
    assert shell == "#!/bin/bash"
    assert directives == DIRECTIVES[name]
    lines = commands.splitlines()
    assert lines[:2] == ["set -euo pipefail", "cd '/scratch/my work'"]
    assert lines[2].startswith("export GRANWAVE_JOB=$")
    assert lines[3] == "module load mpich"
    warned = "" if name == "slurm" else "timeout --foreground --preserve-status --signal=TERM 5310 "
    assert lines[4:] == [f"exec {warned}python -m 'a b'"]


@pytest.mark.parametrize("name", SCHEDULERS)
def test_a_script_runs_its_command(name, tmp_path):
    """The shell commands, by a real shell: directory, id of the job, command."""
    request = JobRequest(
        name="x", ranks=2, nodes=1, minutes=10, memory=100, logs=".", directory=tmp_path,
        words=["sh", "-c", "echo $GRANWAVE_JOB > id; pwd > place"], parallel_environment="mpi",
    )  # fmt: skip
    variables = {
        "SLURM_JOB_ID": "5", "PBS_JOBID": "5.server", "LSB_JOBID": "5", "JOB_ID": "5",
        "FLUX_JOB_ID": "5", "PATH": "/usr/bin:/bin",
    }  # fmt: skip
    script = scheduler(name).script(request)
    subprocess.run(["bash"], input=script, text=True, check=True, env=variables, cwd="/")
    assert (tmp_path / "id").read_text() == "5\n"
    assert (tmp_path / "place").read_text() == f"{tmp_path}\n"


def test_sigterm_comes_before_the_time_limit(tmp_path):
    """A job of one minute receives the signal at 40 s; here a job of a tenth of a second."""
    words = shlex.join(scheduler("pbs").starter(REQUEST)).replace("5310", "0.1").split()
    trap = "trap 'echo stopped; exit 130' TERM; while true; do sleep 0.02; done"
    done = subprocess.run([*words, "bash", "-c", trap], capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stdout) == (130, "stopped\n")


def test_a_template_of_the_site(tmp_path):
    (tmp_path / "job.sh").write_text(
        "#!/bin/bash\n#SBATCH -n {{cores}} --mem={{memory_max}}G -t {{run_time_max // 60}}\n"
        "source /site/setup\n{{command}}\n"
    )
    (tmp_path / "p.toml").write_text('[cluster]\ntemplate = "job.sh"\npartition = "x"\n')
    script = load_profile(tmp_path / "p.toml").script(REQUEST)
    head = "#!/bin/bash\n#SBATCH -n 7 --mem=3G -t 90\nsource /site/setup\nset -euo pipefail\n"
    assert script.startswith(head)
    (tmp_path / "job.sh").write_text("{{ cores }")
    with pytest.raises(InputError, match="template of jobs: "):
        load_profile(tmp_path / "p.toml").script(REQUEST)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[cluster]\nscheduler = 'slrum'", 'cluster.scheduler: found "slrum"'),
        ("[slurm]\nscheduler = 'pbs'", "slurm.scheduler"),
        ("[cluster]\nscheduler = 'pbs'\nstatus = 'sacct'", "sacct is a command of Slurm"),
        ("[cluster]\nscheduler = 'lsf'\noptions = '-q x'", "it is the key cluster.partition"),
        ("[cluster]\ntemplate = 'none.sh'", "cluster.template: found no file"),
        ("[cluster]\npartition = 'a b'", "cluster.partition: .*a name without blanks"),
        ('[cluster]\naccount = "a\\nrm b"', "a name without blanks"),
        ('[cluster]\noptions = "--x\\nrm b"', "options of jobs in one line"),
        ("[cluster]\n[slurm]", r"expected one table \[cluster\], or \[slurm\]"),
    ],
)
def test_faults_of_profiles(tmp_path, text, said):
    (tmp_path / "p.toml").write_text(text)
    with pytest.raises(InputError, match=said):
        load_profile(tmp_path / "p.toml")


def test_a_limit_of_memory_of_lsf(tmp_path):
    """The key ``memory`` reserves memory; the limit -M of a site is a separate option."""
    (tmp_path / "p.toml").write_text("[cluster]\nscheduler = 'lsf'\noptions = '-M 8GB'\n")
    profile = load_profile(tmp_path / "p.toml")
    request = dataclasses.replace(REQUEST, options=profile.options)
    assert "#BSUB -M 8GB\n" in profile.script(request)


def test_grid_engine_needs_its_parallel_environment():
    request = JobRequest(
        name="x", ranks=2, nodes=1, minutes=1, memory=1, logs=".", words=[], directory=Path("/")
    )
    with pytest.raises(InputError, match=r"cluster\.parallel_environment: missing"):
        scheduler("sge").script(request)


QSTAT = """Job Id: 12.server
    Job_Name = granwave-a
    Job_Owner = me@login
    job_state = {}
    queue = work
    Variable_List = PBS_O_HOME=/home/me,PBS_O_WORKDIR=/home/me/run,PBS_O_HOST=login

Job Id: 13.server
    Job_Name = granwave-b
    Job_Owner = me@login
    job_state = Q
    queue = work
    Variable_List = PBS_O_HOME=/home/me,PBS_O_WORKDIR=/home/me/run,PBS_O_HOST=login
"""
QSTAT_XML = """<?xml version='1.0'?>
<job_info><queue_info>{}</queue_info><job_info>{}</job_info></job_info>"""
JOB_XML = (
    '<job_list state="x"><JB_job_number>{}</JB_job_number><JAT_prio>0.5</JAT_prio>'
    "<JB_name>a</JB_name><JB_owner>me</JB_owner><state>{}</state><slots>1</slots></job_list>"
)
BJOBS = """JOBID   USER    STAT  QUEUE      FROM_HOST   EXEC_HOST   JOB_NAME   SUBMIT_TIME
12      me      RUN   normal     login       node1       granwave-a Nov 29 01:00
                                             node2
13      me      PEND  normal     login                   granwave-b Nov 29 01:00
"""
SHOWQ = (
    '<Data><queue count="1" option="active"><job AWDuration="3" JobID="12" State="Running" '
    'User="me"></job></queue><queue count="1" option="eligible"><job JobID="13" State="Idle" '
    'User="me"></job></queue></Data>'
)
BOTH = {"12": "running", "13": "pending"}


@pytest.mark.parametrize(
    ("name", "answer", "states"),
    [
        ("slurm", "12|me|R|a|/x\n13|me|PD|b|/y z\n14|me|OOM|c|/z\n", BOTH),
        ("slurm", "12|me|R|a|b|/x|y\n13|me|PD|b|/y\n", BOTH),
        ("slurm", "", {}),
        ("pbs", QSTAT.format("R"), BOTH),
        ("torque", QSTAT.format("C"), {"13": "pending"}),
        ("pbs", QSTAT.format("F"), {"13": "pending"}),
        ("pbs", QSTAT.replace("12.s", "12[].s"), {"13": "pending"}),
        ("pbs", "", {}),
        ("sge", QSTAT_XML.format(JOB_XML.format(12, "r"), JOB_XML.format(13, "qw")), BOTH),
        ("sge", QSTAT_XML.format("", JOB_XML.format(13, "qw")), {"13": "pending"}),
        ("sge", QSTAT_XML.format("", ""), {}),
        ("lsf", BJOBS, BOTH),
        ("lsf", "", {}),
        ("moab", SHOWQ, BOTH),
    ],
)
def test_states_of_jobs(name, answer, states):
    assert scheduler(name).states_in(answer) == states


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("slurm", "12;cluster\n"), ("slurm", "12\n"), ("pbs", "12.server\n"),
        ("torque", "12.s.x\n"), ("sge", "12\n"),
        ("lsf", "Job <12> is submitted to default queue <normal>.\n"),
        ("moab", "\n12\n"),
    ],
)  # fmt: skip
def test_id_of_a_new_job(name, answer):
    assert scheduler(name).id_in(answer) == "12"


@pytest.mark.parametrize(
    ("name", "line", "said"),
    [
        ("pbs", "=>> PBS: job killed: walltime 65 exceeded limit 60",
         "PBS ended job 12: walltime 65 exceeded limit 60; give a longer time in the profile"),
        ("lsf", "TERM_MEMLIMIT: job killed after reaching LSF memory usage limit.",
         "LSF ended job 12: TERM_MEMLIMIT: job killed after reaching LSF memory usage limit.; "
         "give more memory in the profile"),
        ("torque", "an error of the run", ""),
    ],
)  # fmt: skip
def test_why_a_job_has_ended(name, line, said):
    assert scheduler(name).end_of("12", ["first", line]) == said


@pytest.mark.parametrize(
    ("name", "log"),
    [("pbs", "12.server.example.OU"), ("torque", "granwave-x.o12"), ("slurm", "12.log")],
)
def test_logs_of_a_job_in_a_folder(name, log, tmp_path):
    """The scheduler names the log if only the folder is set: PBS by the id of the job."""
    for file in (log, log.replace("12", "123"), log.replace("12", "312")):
        (tmp_path / file).write_text("")
    patterns = [pattern.format(job="12") for pattern in scheduler(name).log_patterns]
    found = [path for path in tmp_path.iterdir() if any(map(path.match, patterns))]
    assert [path.name for path in found] == [log]


def fake(folder: Path, name: str, text: str) -> None:
    """Make a command of a scheduler."""
    path = folder / name
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


@pytest.fixture
def tools(tmp_path, monkeypatch):
    """Folder of commands of a scheduler, which are in PATH."""
    folder = tmp_path / "tools"
    folder.mkdir()
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    return folder


def test_jobs_are_submitted_from_standard_input(tools, tmp_path, monkeypatch):
    """The command gets the script in the folder of submission, without variables of an enclosing
    job.
    """
    monkeypatch.setenv("PBS_JOBID", "3")
    fake(tools, "qsub", f"cat > {tmp_path}/script; pwd > {tmp_path}/place; env > {tmp_path}/env\n"
         "echo 12.server")  # fmt: skip
    place = tmp_path / "with space"
    place.mkdir()
    assert scheduler("pbs").submit("#!/bin/bash\n", place) == "12"
    assert (tmp_path / "script").read_text() == "#!/bin/bash\n"
    assert (tmp_path / "place").read_text() == f"{place}\n"
    assert "PBS_JOBID" not in (tmp_path / "env").read_text()


def test_answers_that_cannot_be_read(tools):
    fake(tools, "qsub", "echo what")
    fake(tools, "squeue", "echo what")
    fake(tools, "qdel", "exit 1")
    with pytest.raises(RunError, match="qsub: found 'what', expected the id of a job"):
        scheduler("pbs").submit("", Path("/"))
    with pytest.raises(RunError, match=r"answer of squeue .* cannot be read"):
        scheduler("slurm").queue()
    fake(tools, "bjobs", "echo No unfinished job found >&2; exit 255")
    assert scheduler("lsf").queue() == {}
