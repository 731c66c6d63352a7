"""What each word of the command line does; every function returns the exit status."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material, material, sphere_mass
from granwave.lammps_inputs.case.overrides import apply_overrides, parse_overrides
from granwave.lammps_inputs.case.sections import LAWS
from granwave.lammps_inputs.contact.law import contact_of, rigid_wall_contact_of
from granwave.lammps_inputs.deck.deck import write_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.plan import check_memory, plan
from granwave.lammps_inputs.toml_files import read_toml
from granwave.workflows import library
from granwave.workflows.cli.tables import continuum_plan_table, plan_table, summary_table
from granwave.workflows.run import mpi, record
from granwave.workflows.solvers import GRANULAR, SPHERE_CONTACT, kind_of

Words = Sequence[str]


def _case(options: argparse.Namespace) -> Case:
    case = library.load_case(options.case, options.overrides)
    try:
        plan(case)
    except (ArithmeticError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{options.case}: no timestep can be found for these values ({error}); are they all in SI units?"
        ) from None
    return case


def run(options: argparse.Namespace, words: Words) -> int:
    """granwave run"""
    case = _case(options)
    directory = (options.directory or Path(case.name)).absolute()
    if options.np > 1 and not mpi.launched():
        from granwave.workflows.run.directory import decide

        decide(case, directory, resume=options.resume, force=options.force, n_ranks=options.np)
        return mpi.launch(options.np, _without_ranks(words))

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
        print(summary_table(outcome.summary))
        print(f"\nresults in {outcome.directory}")
        beyond = outcome.summary.get("contacts_beyond_law")
        if beyond:
            print(
                f"granwave: warning: {beyond} contacts were pressed beyond 0.2 R*, where the contact law ends; "
                "figures draw them hollow",
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
            print(f"granwave: the energy balance was refused: {misses}; what was computed is kept", file=sys.stderr)
    return {record.FINISHED: 0, record.INTERRUPTED: 130}.get(outcome.state, 1)


def _without_ranks(words: Words) -> list[str]:
    kept, skip = [], False
    for word in words:
        if skip or word == "--np" or word.startswith("--np="):
            skip = not skip and word == "--np"
        else:
            kept.append(word)
    return kept


def write(options: argparse.Namespace, _: Words) -> int:
    """granwave write"""
    from granwave.workflows.run.directory import clear, held, refuse_results

    case = _case(options)
    check_memory(plan(case))
    if not options.force:
        refuse_results(options.directory, "--force removes them all")
    with held(options.directory.absolute(), mpi.world()):
        clear(options.directory)
        deck = write_deck(case, options.directory)
    print(
        f"{deck.directory}: {assemble(deck.case).n_spheres} spheres, "
        f"{deck.schedule.n_steps} steps of {deck.schedule.timestep:.3g} s"
    )
    print(f"run it by hand:  cd {deck.directory} && lmp -in {deck.script.name}")
    return 0


def analyse(options: argparse.Namespace, _: Words) -> int:
    """granwave analyse"""
    from granwave.analysis import MissingOutputError
    from granwave.analysis import analyse as analyse_directory

    if not options.directory.is_dir():
        raise InputError(f"{options.directory}: no such directory; run a case into it first")
    try:
        print(summary_table(analyse_directory(options.directory, progress=True, figures=options.figures)))
    except MissingOutputError as error:
        raise InputError(str(error)) from None
    return 0


def scan(options: argparse.Namespace, _: Words) -> int:
    """granwave scan"""
    from granwave.workflows.cli.scan import scan as run

    return run(options)


def continuum(options: argparse.Namespace, _: Words) -> int:
    """granwave continuum"""
    from granwave.workflows.cli.tables import continuum_table
    from granwave.workflows.run.directory import clear, held

    path = library.find(options.case)
    kind = kind_of(read_toml(path))
    if kind is SPHERE_CONTACT:
        from granwave.workflows.finite_elements.sphere_contact import SphereContactCase as OwnCase
        from granwave.workflows.finite_elements.sphere_contact import run_sphere_contact as run_it
    else:
        from granwave.workflows.finite_elements.punch import ContinuumCase as OwnCase  # type: ignore[assignment]
        from granwave.workflows.finite_elements.punch import run_continuum as run_it  # type: ignore[assignment]

    case = OwnCase.load(path, options.overrides)
    directory = (options.directory or Path(case.name)).absolute()
    kind.check_memory(case, None)
    with held(directory):
        if options.force:
            clear(directory)  # of another kind, perhaps
        summary = run_it(
            case, directory, progress=True, force=options.force, resume=options.resume, figures=options.figures
        )
    print(continuum_table(summary))
    print(f"\nresults in {directory}")
    return 0


def report(options: argparse.Namespace, _: Words) -> int:
    """granwave report"""
    from granwave.analysis.reports.report import write_report

    print(write_report(options.directories, options.output))
    return 0


def export(options: argparse.Namespace, _: Words) -> int:
    """granwave export"""
    from granwave.analysis.exports.export import export as export_directory

    for path in export_directory(options.directory, options.to, options.output):
        print(path)
    return 0


def check(options: argparse.Namespace, _: Words) -> int:
    """granwave check"""
    path = library.find(options.case)
    kind = kind_of(read_toml(path))
    if kind is not GRANULAR:
        data = apply_overrides(read_toml(path), parse_overrides(options.overrides))
        other = kind.read(data, path, overridden=parse_overrides(options.overrides), directory=path.parent)
        print(continuum_plan_table(other.name, kind.size(other), kind.cost(other, 1, True)))
        kind.check_memory(other, None)
        return 0
    case = _case(options)
    expected = plan(case, n_ranks=options.np)
    print(plan_table(case, expected))
    check_memory(expected)
    return 0


def show(options: argparse.Namespace, _: Words) -> int:
    """granwave show"""
    sys.stdout.write(library.text(options.name))
    return 0


def law(options: argparse.Namespace, _: Words) -> int:
    """granwave law"""
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
    from granwave.analysis.contact_law.restitution import write_restitution

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


def fit(options: argparse.Namespace, _: Words) -> int:
    """granwave fit"""
    from granwave.workflows.cli.fitting import fit as run_fit

    return run_fit(options)


def bench(options: argparse.Namespace, _: Words) -> int:
    """granwave bench"""
    import json

    from granwave.workflows.cli.bench import bench as run_bench

    if options.json and not options.json.absolute().parent.is_dir():
        raise InputError(f"--json {options.json}: there is no directory {options.json.absolute().parent}")
    results = run_bench(options.repeats, sizes=not options.styles_only)
    print(
        f"\nmemory bandwidth of one core (triad): {results['triad_GB_per_s']:.1f} GB/s; "
        f"load now {results['load_after'][0]:.2f}"
    )
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    return 0


def cases(_: argparse.Namespace, __: Words) -> int:
    """granwave cases"""
    found = [(kind, name) for kind in (library.CASES, library.SCANS) for name in library.names(kind)]
    width = max(len(name) for _, name in found)
    for kind, name in found:
        print(f"{'scan  ' if kind == library.SCANS else 'case  '}{name:{width}}  {library.title(name)}")
    return 0


def doctor(_: argparse.Namespace, __: Words) -> int:
    """granwave doctor"""
    from granwave.workflows.cli.doctor import examine

    findings = examine()
    for finding in findings:
        print(f"{'ok  ' if finding.works else 'FAIL'}  {finding.part}: {finding.found}")
        if not finding.works:
            print(f"      mend: {finding.remedy}")
    return 0 if all(finding.works for finding in findings) else 1
