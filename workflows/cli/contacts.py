"""Commands about single contacts: laws, fits, and forces inferred from measurements; each returns
the exit status.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave._contact_laws import ContactLaw
from granwave.extensions.inference import run as inference
from granwave.lammps_inputs.case.contact import LAWS
from granwave.lammps_inputs.case.contact_tables import COHESION, Cohesion
from granwave.lammps_inputs.case.law_parameters import PARAMETERS, laws_with
from granwave.lammps_inputs.case.material import Material, load_materials, material, sphere_mass
from granwave.lammps_inputs.case.schema import ValidationError
from granwave.lammps_inputs.contact.law import contact_of
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows.cli.parser import chosen
from granwave.workflows.cli.results import as_wrong_input
from granwave.workflows.cli.terminal import columns, print_json
from granwave.workflows.run.directory import held

if TYPE_CHECKING:
    from granwave.extensions.continuum.law_fit.fit import Fit


def law(options: argparse.Namespace) -> int:
    """Execute ``granwave law``."""
    from granwave.analysis.contact_law import curves

    output = options.output or Path("restitution.png" if options.restitution else "law.png")
    speed = options.velocity
    _at_most_two(options)
    _check_law(options, output)
    parameters = _parameters(options)
    materials = [
        dataclasses.replace(_material(name), **parameters["material"]) for name in options.material
    ]
    cohesion = _cohesion(options)
    constants = parameters["contact"]
    spheres = _contact(materials, options.radius, options.law, constants, cohesion)
    names = " on ".join(text.rpartition(":")[2] for text in options.material)
    if not options.restitution:
        title = f"{names}, {speed:g} m/s" if speed else names
        curves.write_law(spheres, output, options.max_overlap, title, speed)
    else:
        first = sphere_mass(materials[0], options.radius[0])
        flat = (options.radius[0], math.inf)
        wall = _contact((materials[0], None), flat, options.law, constants)
        if math.isinf(options.radius[-1]):
            contacts = {"sphere and plane": (spheres, first)}
        else:
            second = sphere_mass(materials[-1], options.radius[-1])
            contacts = {"two spheres": (spheres, first * second / (first + second))}
        contacts["sphere and rigid wall"] = (wall, first)
        title = f"{names}, {options.law}"
        curves.write_restitution(contacts, output, max_overlap=options.max_overlap, title=title)
    print(output)
    return 0


def _check_law(options: argparse.Namespace, output: Path) -> None:
    """Raise InputError for options of ``granwave law`` that do not fit together."""
    rate = options.rate_sensitivity
    speed = options.velocity
    contact_law = LAWS[options.law]
    published = options.variant not in (None, "continuous")
    takes_rate = contact_law.yields and "rate_sensitivity" in contact_law.parameters
    other = (
        "takes all velocities: leave out --restitution"
        if rate
        else "matters to none: give --rate-sensitivity"
    )
    for wrong, fault in (
        (
            output.suffix not in (".png", ".pdf", ".csv"),
            f"-o {output}: expected a name that ends in .png, .pdf or .csv",
        ),
        (
            not output.absolute().parent.is_dir(),
            f"-o {output}: there is no directory {output.absolute().parent}",
        ),
        (not _are_radii(options.radius), _RADII),
        (
            options.restitution and not contact_law.yields,
            f"--restitution: a contact of law {options.law} gives all back; choose another --law",
        ),
        (
            rate and not takes_rate,
            f"--rate-sensitivity: found with law {options.law}, which knows no strain rate",
        ),
        (
            rate and published,
            f"--rate-sensitivity: found with variant {options.variant}, expected continuous",
        ),
        (
            speed and (not rate or options.restitution),
            f"--velocity: found {speed:g}, which {other}",
        ),
    ):
        if wrong:
            raise InputError(fault)


def _parameters(options: argparse.Namespace) -> dict[str, dict[str, Any]]:
    """Return the parameters of the law that are given, of ``contact`` and of each ``material``.

    As in a case, those that have a default there may stand with another law, which has no use for
    them.
    """
    law = LAWS[options.law]
    slow = {"rate_sensitivity": None}  # unless a rate is asked for
    parameters: dict[str, dict[str, Any]] = {"contact": {}, "material": slow}
    for name, parameter in PARAMETERS.items():
        value = getattr(options, name, None)
        if value is None or value == parameter.default:
            continue
        if name in law.parameters:
            parameters["material" if parameter.of_material else "contact"][name] = value
        elif parameter.optional:
            flag = name.replace("_", "-")
            laws = " or ".join(laws_with(parameter))
            raise InputError(f"--{flag}: found with law {options.law}; it belongs to {laws}")
    return parameters


def _contact(
    materials: Sequence[Material | None],
    radii: Sequence[float],
    law: str,
    constants: dict[str, Any],
    cohesion: Cohesion | None = None,
) -> ContactLaw:
    """Return the law between two bodies; raise InputError where its parameters do not fit."""
    try:
        return contact_of(materials, radii, law, constants, cohesion=cohesion)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"law {law}: {error}") from None


def _cohesion(options: argparse.Namespace) -> Cohesion | None:
    """Read ``--cohesion``; None without it."""
    if not options.cohesion:
        return None
    kind, energy = options.cohesion
    try:
        found: Cohesion = COHESION.read({"kind": kind, "energy": float(energy)})
    except (ValueError, ValidationError):
        raise InputError(
            f"--cohesion: found {kind} {energy}, expected jkr or dmt, and the work of adhesion in J/m^2"
        ) from None
    if kind == "jkr" and LAWS[options.law].yields:
        raise InputError(
            f"--cohesion: found jkr with law {options.law}; it is of elastic spheres: take --law hertz, or dmt"
        )
    if options.restitution:
        raise InputError("--cohesion: expected without --restitution")
    return found


_RADII = "--radius: expected positive lengths in m (the second may be inf, a plane)"


def _are_radii(radii: Sequence[float]) -> bool:
    """Return True for one finite radius, and a second one that may be infinite."""
    return math.isfinite(radii[0]) and all(radius > 0 for radius in radii)


def _at_most_two(options: argparse.Namespace) -> None:
    for name, values in (("--material", options.material), ("--radius", options.radius)):
        if len(values) > 2:
            raise InputError(f"{name}: found {len(values)} values, expected one or two")


def fit(options: argparse.Namespace) -> int:
    """Execute ``granwave fit``."""
    from granwave.analysis.contact_law.curves import read_curve
    from granwave.extensions.continuum.law_fit.fit import fit_law
    from granwave.extensions.continuum.law_fit.fit_output import WRITTEN, pair_toml, write_fit

    _at_most_two(options)
    if not _are_radii(options.radius):
        raise InputError(_RADII)
    pair: list[str] | None = options.pair
    directory: Path = options.directory or Path("fit")
    results = ResultDirectory(results_directory(directory))
    if not results.path.parent.is_dir():
        raise InputError(f"-o {directory}: there is no directory {directory.absolute().parent}")
    if set(WRITTEN) & set(results.result_names()):
        if not options.force:
            raise InputError(f"{directory}: already holds a fit; {results.by_force}")
        results.refuse_immovable()
    results.refuse_foreign(WRITTEN)
    materials = [_material(text) for text in options.material]
    found = fit_law(
        read_curve(options.curve),
        materials,
        options.radius,
        options.free,
        fit_yield=options.fit_yield,
    )
    with held(results):
        results.make_room(force=options.force, names=WRITTEN)
        written = write_fit(found, results, pair)
    print(fit_summary(found))
    if pair:
        print(f"\n{pair_toml(found, pair)}")
    print(
        f"\n{written[0]} holds [contact] for a case file, and runs by itself: granwave run {written[0]}"
    )
    return 0


def fit_summary(found: Fit) -> str:
    """Format the constants with their uncertainties, and the misfits, for the terminal."""
    from granwave.extensions.continuum.law_fit.fit_output import constants_table

    rows = [["constant", "value", "+-", "published", ""]]
    for name, value, spread, published, how in zip(*constants_table(found).values(), strict=True):
        rows.append(
            [
                name,
                f"{value:.5g}",
                f"{spread:.2g}" if spread == spread else "",
                f"{published:.5g}",
                how,
            ]
        )
    fits = [["off by, per cent", "rows", "rms", "largest", "published rms", "largest"]]
    for part, n_rows, *numbers in found.misfit.itertuples(index=False):
        fits.append([part, str(n_rows), *(f"{number:.3g}" for number in numbers)])
    text = f"{columns(rows, left=(0, 4))}\n\n{columns(fits, left=(0,))}\n"
    text += f"(overlaps in units of that at first yield, {found.law.yield_overlap:.4g} m)"
    if found.correlation:
        text += f"\nneighbouring rows err alike (correlation {found.correlation:.2f}): the uncertainties are widened for it"
    return text


def _material(text: str) -> Material:
    """Return a preset, or the material FILE.toml:NAME from a file of the user."""
    path, colon, name = text.rpartition(":")
    if not colon:
        return material(text)
    known = load_materials(path)
    if name not in known:
        raise InputError(
            f"--material {text}: found no {name} in {path}, expected one of {', '.join(known)}"
        )
    return known[name]


@as_wrong_input()
def infer(options: argparse.Namespace) -> int:
    """Execute ``granwave infer``."""
    from granwave.extensions.inference.forces.tables import in_words

    directory = inference.results_place(options.directory or "infer", force=options.force)
    how = chosen(options, inference.infer)
    found = inference.infer(options.measurement, options.case, progress=True, **how)
    inference.save(found, directory, force=options.force, figures=options.figures)
    print_json(found.summary) if options.json else print(
        f"{in_words(found.summary)}\n\nresults in {directory}"
    )
    return 0
