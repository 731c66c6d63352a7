"""Commands of the command line; each function returns the exit status."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import logging
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.measures.zone.marks import zone_warning
from granwave.analysis.summary_table import continuum_table, summary_table
from granwave.lammps_inputs.case.contact import LAWS
from granwave.lammps_inputs.case.material import Material, material, sphere_mass
from granwave.lammps_inputs.contact.initial_dents import earlier_result
from granwave.lammps_inputs.contact.law import contact_of, rigid_wall_contact_of
from granwave.lammps_inputs.deck.deck import deck_files, write_deck
from granwave.lammps_inputs.directories import refuse_other_file, refuse_source, results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import replace_text
from granwave.lammps_inputs.ownership import claim, clear, refuse_foreign, refuse_other_kind, refuse_results, results_in
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.plan import check_run, plan
from granwave.lammps_inputs.run_directory import CASE_FILE, EXPORT_DIRECTORY, RESULT_FILE, RUN, SUMMARY_FILE
from granwave.lammps_inputs.run_state import restore_case
from granwave.lammps_inputs.toml_files import read_toml
from granwave.workflows import library
from granwave.workflows.cli.as_json import print_json
from granwave.workflows.cli.colour import BOLD, GREEN, RED, coloured
from granwave.workflows.run import mpi, record
from granwave.workflows.solvers import CONTINUUM, SPHERE_CONTACT, solver_of

Arguments = Sequence[str]
_USUAL_WIDTH = 120  # characters of a line where there is no terminal


def run(options: argparse.Namespace, arguments: Arguments) -> int:
    """Execute ``granwave run``."""
    starts_ranks = options.np > 1 and not mpi.launched()
    if starts_ranks:
        mpi.check_cores(options.np)
        logging.getLogger("granwave").setLevel(logging.ERROR)  # the ranks will give the warnings of the case
    case = library.load_case(options.case, options.overrides)
    directory = results_directory(options.directory or case.name)
    if starts_ranks:
        from granwave.workflows.run.directory import decide

        how = {"resume": options.resume, "force": options.force, "figures": options.figures}
        decide(case, directory, n_ranks=options.np, **how)
        return mpi.launch(options.np, _without_ranks(arguments))

    from granwave.workflows.run.driver import run_case

    comm = mpi.world()
    outcome = run_case(
        case,
        directory,
        resume=options.resume,
        force=options.force,
        progress=True,
        checkpoint_interval=options.checkpoint,
        figures=options.figures,
        comm=comm,
    )
    if comm.rank == 0:
        if options.json:
            print_json(outcome.summary)
        else:
            print(f"{summary_table(outcome.summary)}\n\nresults in {outcome.directory}")
        _warn_of_zone(outcome.summary)
        beyond = outcome.summary.get("contacts_beyond_law")
        if beyond:
            print(
                f"granwave: warning: {beyond} contacts were pressed beyond 0.2 R*, where the contact law ends; "
                "figures draw a ring around them",
                file=sys.stderr,
            )
        if outcome.state == record.INTERRUPTED:
            print(
                "granwave: stopped before its end; the same command with --resume goes on",
                file=sys.stderr,
            )
        if outcome.state == record.REFUSED:
            error = outcome.summary.get("energy_balance_error")
            misses = "it is not a number" if error is None else f"it misses by {error:.1e} of the input"
            automatic = case.run.timestep == "auto"
            mend = "give run.energy_tolerance a smaller value" if automatic else "leave out run.timestep"
            print(
                f"granwave: the energy balance was refused: {misses}; what was computed is kept. Expected at most 1e-5 "
                f"or run.energy_tolerance, whichever is larger: {mend}, and run it again with --force",
                file=sys.stderr,
            )
    return {record.FINISHED: 0, record.INTERRUPTED: 130}.get(outcome.state, 1)


def _without_ranks(arguments: Arguments) -> list[str]:
    kept, skip = [], False
    for argument in arguments:
        if skip or argument == "--np" or argument.startswith("--np="):
            skip = not skip and argument == "--np"
        else:
            kept.append(argument)
    return kept


def write(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave write``."""
    from granwave.workflows.run.directory import held, run_files

    case = library.load_case(options.case, options.overrides)
    expected = plan(case)
    check_run(case, expected)
    directory = results_directory(options.directory, force=options.force)
    with held(directory, mpi.world()):
        refuse_other_kind(directory, RUN)
        if not options.force:
            refuse_results(directory, "--force removes them all")
        refuse_foreign(directory, run_files(case, expected.schedule))
        refuse_source(directory, case.name, earlier_result(case))
        earlier = results_in(directory)
        deck = write_deck(case, options.directory)  # whole or not at all; only then is removed what was there
        clear(directory, set(earlier) - set(deck.written))
        deck.dumps.mkdir(exist_ok=True)
        claim(directory, deck_files(assemble(case), deck.schedule))
    schedule = deck.schedule
    steps = f"{schedule.n_steps} steps of {schedule.timestep:.3g} s"
    if schedule.adaptive:
        steps = f"steps of {schedule.first_timestep:.3g} s and more, to {schedule.end_time:.4g} s"
    assembly = assemble(deck.case)
    print(f"{deck.directory}: {assembly.n_spheres} {assembly.grains_called}, {steps}")
    print(f"run it by hand:  cd {deck.directory} && lmp -in {deck.script.name}")
    return 0


def analyse(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave analyse``."""
    from granwave.analysis.pipeline import analyse as analyse_directory
    from granwave.workflows.run.directory import held

    if not options.directory.is_dir():
        raise InputError(f"{options.directory}: no such directory; run a case into it first")
    with held(options.directory.absolute(), way=""):
        refuse_foreign(options.directory, [RESULT_FILE, SUMMARY_FILE])
        if restore_case(options.directory):
            print(f"granwave: {options.directory / CASE_FILE}: written again as it was run", file=sys.stderr)
        with as_wrong_input():
            summary = analyse_directory(options.directory, progress=True, figures=options.figures)
    print_json(summary) if options.json else print(summary_table(summary))
    _warn_of_zone(summary)
    return 0


def _warn_of_zone(summary: Mapping[str, Any]) -> None:
    """Print a warning if the size of the packing or block limits the plastic zone."""
    if warning := zone_warning(summary):
        print(f"granwave: warning: {summary['name']}: {warning}", file=sys.stderr)


def scan(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave scan``."""
    from granwave.workflows.cli.scan import scan as run

    return run(options)


def continuum(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave continuum``."""
    from granwave.workflows.run.directory import held

    path = library.find_for(options.case, CONTINUUM.verb)
    kind = solver_of(read_toml(path))
    if kind is SPHERE_CONTACT:
        from granwave.workflows.finite_elements.sphere_contact import SphereContactCase as OwnCase
        from granwave.workflows.finite_elements.sphere_contact.run import run_sphere_contact as run_it
    else:
        from granwave.workflows.finite_elements.punch import ContinuumCase as OwnCase  # type: ignore[assignment]
        from granwave.workflows.finite_elements.punch.run import run_continuum as run_it  # type: ignore[assignment]

    case = OwnCase.load(path, options.overrides)
    directory = results_directory(options.directory or case.name)
    expected = kind.cost(case, 1, options.figures)
    if not options.resume:  # a finished run needs no resources
        kind.check(case, expected, directory)
    with held(directory):
        summary = run_it(
            case, directory, progress=True, force=options.force, resume=options.resume, figures=options.figures
        )
    print_json(summary) if options.json else print(f"{continuum_table(summary)}\n\nresults in {directory}")
    _warn_of_zone(summary)
    return 0


def report(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave report``."""
    from granwave.analysis.reports.report import write_report

    print(write_report(options.directories, options.output, options.study))
    return 0


@contextlib.contextmanager
def as_wrong_input() -> Iterator[None]:
    """Raise InputError for results that are missing or damaged."""
    from granwave.analysis.errors import MissingOutputError, OutputFormatError

    try:
        yield
    except (MissingOutputError, OutputFormatError) as error:
        raise InputError(str(error)) from None


def export(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave export``."""
    from granwave.analysis.exports.export import export as export_directory
    from granwave.workflows.run.directory import held

    output = options.output or options.directory / EXPORT_DIRECTORY
    if not options.directory.is_dir():
        raise InputError(f"{options.directory}: no such directory; expected that of a run or a scan")
    with held(results_directory(output)):
        placed = export_directory(options.directory, options.to, options.output)
    for path in placed:
        print(path)
    return 0


def check(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave check``."""
    from granwave.workflows.cli.check import check as check_case

    return check_case(options)


def show(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave show``."""
    sys.stdout.write(library.text(options.name))
    return 0


def keys(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave keys``."""
    from granwave.workflows.cli.keys import as_text, find, overview, tables

    found = find(*options.table) if options.table else None
    if options.json:
        print_json([dataclasses.asdict(one) for one in found or tables()])
    else:
        print(overview() if found is None else "\n\n\n".join(map(as_text, found)))
    return 0


def law(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave law``."""
    output = options.output or Path("restitution.png" if options.restitution else "law.png")
    for name, values in (("--material", options.material), ("--radius", options.radius)):
        if len(values) > 2:
            raise InputError(f"{name}: found {len(values)} values, expected one or two")
    if output.suffix not in (".png", ".pdf", ".csv"):
        raise InputError(f"-o {output}: expected a name that ends in .png, .pdf or .csv")
    if not output.absolute().parent.is_dir():
        raise InputError(f"-o {output}: there is no directory {output.absolute().parent}")
    if not all(0 < radius < float("inf") for radius in options.radius):
        raise InputError("--radius: expected positive lengths in m")
    if not 0 < options.max_overlap < float("inf"):
        raise InputError(f"--max-overlap: found {options.max_overlap:g}, expected a positive number")
    if options.restitution and not LAWS[options.law].yields:
        raise InputError(f"--restitution: a contact of law {options.law} gives all back; choose another --law")
    materials = [material(name) for name in options.material]
    (_write_restitution if options.restitution else _write_law)(options, materials, output)
    print(output)
    return 0


def _write_law(options: argparse.Namespace, materials: Sequence[Material], output: Path) -> None:
    from granwave.analysis.contact_law.curves import write_law

    contact = contact_of(materials, options.radius, options.law, options.variant)
    write_law(contact, output, max_overlap=options.max_overlap, title=" on ".join(options.material))


def _write_restitution(options: argparse.Namespace, materials: Sequence[Material], output: Path) -> None:
    from granwave.analysis.contact_law.curves import write_restitution

    masses = [
        sphere_mass(m, r)
        for m, r in zip((materials[0], materials[-1]), (options.radius[0], options.radius[-1]), strict=True)
    ]
    spheres = contact_of(materials, options.radius, options.law, options.variant)
    wall = rigid_wall_contact_of(materials[0], options.radius[0], options.law, options.variant)
    contacts = {
        "two spheres": (spheres, masses[0] * masses[1] / (masses[0] + masses[1])),
        "sphere and rigid wall": (wall, masses[0]),
    }
    write_restitution(
        contacts, output, max_overlap=options.max_overlap, title=f"{' on '.join(options.material)}, {options.law}"
    )


def fit(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave fit``."""
    from granwave.workflows.cli.fitting import fit as run_fit

    return run_fit(options)


def infer(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave infer``."""
    from granwave.workflows.cli.inferring import infer as run_infer

    with as_wrong_input():
        return run_infer(options)


def bench(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave bench``."""
    import json

    from granwave.workflows.bench.bench import bench as run_bench

    if options.json and not options.json.absolute().parent.is_dir():
        raise InputError(f"--json {options.json}: there is no directory {options.json.absolute().parent}")
    if options.json:
        refuse_other_file(options.json, rb'"triad_GB_per_s"')
    results = run_bench(options.parts, options.repeats)
    if options.json:
        replace_text(options.json, json.dumps(results, indent=2) + "\n")
    return 0


def cases(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave cases``."""
    import shutil
    import textwrap

    wanted = [word.lower() for word in options.words]
    found = [
        entry for entry in library.entries() if all(word in f"{entry.name} {entry.title}".lower() for word in wanted)
    ]
    if not found:
        raise InputError(
            f"{' '.join(options.words)}: no built-in case or scan has these words; granwave cases lists all"
        )
    if options.json:
        print_json([entry._asdict() for entry in found])
        return 0
    name_width = max(len(entry.name) for entry in found)
    on_terminal = sys.stdout.isatty()
    most = shutil.get_terminal_size().columns if on_terminal else sys.maxsize
    briefly = not (options.all or wanted)
    for group in dict.fromkeys(entry.group for entry in found):
        print(coloured(f"{group}:", BOLD, sys.stdout))
        here = [entry for entry in found if entry.group == group]
        lines = [f"{entry.kind}  {entry.name:{name_width}}  {entry.title}" for entry in here]
        if briefly:
            width = most if on_terminal else _USUAL_WIDTH
            lines = textwrap.wrap(
                "  ".join(entry.name for entry in here), width - 2, break_on_hyphens=False, break_long_words=False
            )
            lines = [f"  {line}" for line in lines]
        for line in lines:
            print(line if len(line) <= most else f"{line[: most - 1]}…")
    if briefly:
        print(
            "granwave cases WORD tells what those with this word are, --all what each is; granwave show NAME prints one"
        )
    return 0


def show_help(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave help``."""
    print(options.parsers[options.name].format_help(), end="")
    return 0


def doctor(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave doctor``."""
    from granwave.workflows.cli.doctor import examine

    findings = examine(options.profile)
    works = all(finding.works for finding in findings)
    if options.json:
        print_json({"works": works, "parts": [dataclasses.asdict(finding) for finding in findings]})
        return 0 if works else 1
    for finding in findings:
        state = coloured("ok  ", GREEN, sys.stdout) if finding.works else coloured("FAIL", RED, sys.stdout)
        print(f"{state}  {finding.part}: {finding.found}")
        if not finding.works:
            print(f"      mend: {finding.remedy}")
    return 0 if works else 1


def completion(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave completion``."""
    from granwave.workflows.cli.completion import shell_code

    print(shell_code(options.shell))
    return 0
