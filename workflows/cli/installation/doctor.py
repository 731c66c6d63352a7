"""Check of the installation: a line for each part and extension, with a remedy for each
failure.
"""

from __future__ import annotations

import argparse
import dataclasses
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from granwave import plugins
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import (
    Extension,
    distribution_of,
    extensions,
    install_command,
)
from granwave.workflows.cli.terminal import (
    GREEN,
    RED,
    SWITCH_ON,
    YELLOW,
    coloured,
    line_of,
    print_json,
)
from granwave.workflows.cluster.profile import load_profile
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import check_release
from granwave.workflows.run.launchers import (
    environment_settings,
    kill_session,
    known_fault,
    of_this_machine,
)
from granwave.workflows.run.mpi_library import installation_of_mpich
from granwave.workflows.run.record import versions

_DECK = """\
units si
atom_style sphere
newton off
boundary f f f
region box block 0 1 0 1 0 1
create_box 1 box
create_atoms 1 single 0.5 0.5 0.5
create_atoms 1 single 0.5 0.5 0.9
set group all diameter 0.5 density 1000
pair_style gran/hysteretic 0.01
pair_coeff * * hertz 1e5 0.3
fix 1 all nve
run 0
"""

_IN_PYTHON = """\
from lammps import lammps
instance = lammps(cmdargs=["-log", "none", "-screen", "none"])
known = instance.has_style("pair", "gran/hysteretic")
instance.close()
if not known:
    raise SystemExit("LAMMPS has not loaded the plugin")
"""


_LIBRARY_CHECK = """\
import sys
from granwave.workflows.run.mpi_library import library_fault
sys.exit(library_fault() or 0)
"""

_NOT_STARTED = "MPI_Init"  # in the messages of MPI libraries that cannot start
_LONGEST = 60.0  # time limit of a check, s


@dataclasses.dataclass(frozen=True)
class Finding:
    """Result of the check of one part: its name, whether it works, details, and remedy."""

    part: str
    works: bool
    found: str
    remedy: str = ""


@dataclasses.dataclass(frozen=True)
class FoundExtension:
    """An extension that is installed.

    Attributes
    ----------
    distribution
        Name and version of the distribution that brings it.
    missing
        Packages that it needs and that are not installed, by their names in pip.
    remedy
        Command that installs them; empty if none is missing.
    """

    name: str
    title: str
    distribution: str
    missing: tuple[str, ...] = ()
    remedy: str = ""


def doctor(options: argparse.Namespace) -> int:
    """Execute ``granwave doctor``; return the exit status."""
    findings = examine(options.profile)
    works = all(finding.works for finding in findings)
    found = found_extensions()
    if options.json:
        parts = [dataclasses.asdict(finding) for finding in findings]
        listed = [dataclasses.asdict(extension) for extension in found]
        print_json({"works": works, "parts": parts, "extensions": listed})
        return 0 if works else 1
    ok = coloured("ok  ", GREEN, sys.stdout)
    for finding in findings:
        state = ok if finding.works else coloured("FAIL", RED, sys.stdout)
        print(f"{state}  {finding.part}: {finding.found}")
        if not finding.works:
            print(f"      fix: {finding.remedy}")
    for extension in found:
        state = coloured("lack", YELLOW, sys.stdout) if extension.missing else ok
        title = f"{extension.title} ({extension.distribution})"
        print(f"{state}  extension {extension.name}: {title}")
        if extension.missing:
            packages = ", ".join(extension.missing)
            print(f"      some features require {packages}: {extension.remedy}")
    return 0 if works else 1


def found_extensions() -> list[FoundExtension]:
    """Return the extensions that are installed and enabled, by name."""
    return [_found(extension) for extension in extensions()]


def _found(extension: Extension) -> FoundExtension:
    packages = extension.packages.items()
    missing = dict.fromkeys(pip for name, pip in packages if find_spec(name) is None)
    remedy = ""
    if missing:
        remedy = install_command(extension)
    return FoundExtension(
        extension.name, extension.title, distribution_of(extension), tuple(missing), remedy
    )


def examine(profile: Path | None = None) -> list[Finding]:
    """Check all parts that are required for a run, and for the profile of a cluster if one is
    given.
    """
    found = versions()
    path = plugins.library()
    wrong = check_release()
    listed = ", ".join(
        f"{name} {version}" for name, version in found.items() if not name.startswith("plugin")
    )
    missing = {name for name, version in found.items() if version == "not installed"} - {
        "mpich"
    }  # or another MPI
    to_switch_on = "; ".join(
        f"{line} in {file}" for line, file in SWITCH_ON.values()
    )  # only the shell knows if it is
    library = _mpi_library()
    of_mpi = [library]
    if library.works:
        of_mpi += [_lammps_module(), _python_module(), _command(), _ranks()]
    return [
        Finding("versions", not missing, listed,
                "reinstall granwave with pip in a virtual environment"),
        Finding("plugin", path.is_file(), f"{path}, built for LAMMPS {plugins.lammps_release()}",
                "reinstall granwave: a wheel requires no compiler, the sources (pip install .) "
                "require g++"),
        Finding("LAMMPS release", wrong is None, wrong or "the release for which the plugin was "
            "built", wrong or ""),
        *of_mpi,
        Finding("tab completion", True, f"to enable it: {to_switch_on}"),
        *([] if profile is None else _cluster(profile)),
    ]  # fmt: skip


def _mpi_library() -> Finding:
    """Check the MPI library of LAMMPS, without which no part that starts MPI can work."""
    finding = _attempt(
        "MPI library",
        [*mpi.PYTHON, "-c", _LIBRARY_CHECK],
        "LAMMPS can be loaded with it",
        f"install MPICH: {installation_of_mpich()}",
    )
    if finding.works:
        return finding
    return dataclasses.replace(finding, found=f"{finding.found}. Parts that use MPI: not checked")


def _lammps_module() -> Finding:
    script = (
        "from granwave.workflows.run.lammps_engine import open_engine\n"
        "from granwave.workflows.run.mpi import world\n"
        f"with open_engine(world(), log='none') as e: e.commands('''{_DECK}''')\nprint('ok')"
    )
    return _attempt(
        "lammps module",
        [*mpi.PYTHON, "-c", script],
        "loads the plugin and runs",
        "use a virtual environment: only there mpi4py finds the libmpi of the environment",
    )


def _python_module() -> Finding:
    return _attempt(
        "from lammps import lammps",
        [*mpi.PYTHON, "-c", _IN_PYTHON],
        "loads its MPI library and the plugin automatically",
        "in your own scripts, write `from mpi4py import MPI` above `from lammps import lammps`",
    )


def _command() -> Finding:
    lmp = Path(sys.prefix) / "bin" / "lmp"
    found = str(lmp) if lmp.exists() else shutil.which("lmp")
    if not found:
        return Finding(
            "lmp command", False, "not found", "pip install 'lammps[mpi]', or put lmp on the PATH"
        )
    with tempfile.TemporaryDirectory() as scratch:
        deck = Path(scratch) / "in.doctor"
        deck.write_text(_DECK, encoding="ascii")
        command = [found, "-in", str(deck), "-log", "none", "-screen", "none"]
        remedy = f"export LAMMPS_PLUGIN_PATH={plugins.directory()}"
        return _attempt("lmp command", command, f"{found} finds the plugin automatically", remedy)


def _ranks() -> Finding:
    launcher = mpi.find_mpiexec()
    if launcher is None:
        missing = f"no mpiexec in {Path(sys.prefix) / 'bin'} or in PATH"
        return Finding(
            "MPI ranks",
            False,
            missing,
            f"install MPICH: {installation_of_mpich()}; or load the site's MPI",
        )
    script = (
        "import sys; from granwave.workflows.run.mpi import world; n = world().size; "
        "sys.exit(n != 2 and f'found {n} rank(s)')"
    )
    command = [launcher, "-n", "2", *mpi.PYTHON, "-m", "mpi4py", "-c", script]
    remedy = "use mpiexec and mpi4py of the same MPI library, and unset the variables listed above"
    return _attempt("MPI ranks", command, f"two ranks with {launcher}", remedy)


def _cluster(path: Path) -> list[Finding]:
    """Check the commands in the profile of a cluster: scheduler and launcher."""
    try:
        profile = load_profile(path)
    except InputError as error:
        return [
            Finding(
                "profile",
                False,
                "; ".join(map(line_of, error.items)),
                "granwave keys cluster lists the keys",
            )
        ]
    found = [Finding("profile", True, f"{path}")]
    before = profile.before
    if before:
        command = ["bash", "-c", f"set -e\n{before}"]
        found.append(
            _attempt("commands of before", command, "run", "correct the key before in the profile")
        )
    for name in profile.queue.programs:
        command = ["bash", "-c", f"command -v {shlex.quote(name)}"]
        found.append(
            _attempt(
                f"{name} command",
                command,
                "found (login node)",
                "run on a login node of the cluster",
            )
        )
    for name in profile.launcher_command[:1]:
        command = ["bash", "-c", f"{before}\ncommand -v {shlex.quote(name)}"]
        where = "found (launcher of the profile, after the commands of `before`)"
        found.append(
            _attempt(
                f"{name} command",
                command,
                where,
                "correct the keys launcher or before in the profile",
            )
        )
    return found


def _attempt(part: str, command: list[str], success: str, remedy: str) -> Finding:
    with tempfile.TemporaryFile() as output:
        try:
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                env=of_this_machine(mpi.alone()),
                cwd=tempfile.gettempdir(),
                start_new_session=True,
            )
        except OSError as error:
            return Finding(part, False, str(error), remedy)
        try:
            status = process.wait(_LONGEST)
        except subprocess.TimeoutExpired:
            kill_session(process)
            found = f"{command[0]} did not answer within {_LONGEST:.0f} s"
            return Finding(part, False, f"{found}{environment_settings()}", remedy)
        if status == 0:
            return Finding(part, True, success)
        output.seek(0)
        lines = output.read().decode("utf-8", "replace").splitlines()
    fault = _fault_in(lines) or f"exit status {status}"
    if any(_NOT_STARTED in line for line in lines):
        if known := known_fault(mpi.alone()):
            return Finding(part, False, known, "fix the start of MPI, as the line above explains")
        fault = f"MPI cannot be started: {fault}"
    return Finding(part, False, fault, remedy)


def _fault_in(lines: Sequence[str]) -> str:
    """Return the last error of granwave among the lines of a program, otherwise its last line."""
    errors = mpi.errors_in(lines) or [line.strip() for line in lines if line.strip()]
    return errors[-1] if errors else ""
