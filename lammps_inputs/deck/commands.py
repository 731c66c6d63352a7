"""Elements of the input script: numbers, lists, long commands, dumps, time series, coefficients of contact laws."""

from __future__ import annotations

from collections.abc import Iterable

from granwave.lammps_inputs.case.contact import Contact
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import Viscous
from granwave.lammps_inputs.run_directory import DUMPS

_WIDTH = 110


def num(value: float) -> str:
    """Format a number with as few digits as reproduce it exactly."""
    short = f"{value:.6g}"
    return short if float(short) == value else repr(float(value))


def joined(values: Iterable[object]) -> str:
    """Join values with spaces."""
    return " ".join(str(value) for value in values)


def id_ranges(ids: Iterable[int]) -> str:
    """Join rising ids as LAMMPS takes them, runs of them as ``first:last``."""
    ranges: list[list[int]] = []
    for number in ids:
        if ranges and number == ranges[-1][1] + 1:
            ranges[-1][1] = int(number)
        else:
            ranges.append([int(number), int(number)])
    return joined(f"{first}:{last}" if last > first else first for first, last in ranges)


def command(*words: str) -> list[str]:
    """Join the words of a command, with LAMMPS continuation lines where it gets long."""
    lines = [words[0]]
    for word in words[1:]:
        if len(lines[-1]) + len(word) + 3 > _WIDTH:
            lines[-1] += " &"
            lines.append("                " + word)
        else:
            lines[-1] += " " + word
    return lines


def time_series(name: str, every: int, file: str, title: str, columns: dict[str, str], resumed: bool) -> list[str]:
    """Return the command of a time series: one row every so many steps, the step first."""
    return command(
        f"fix             {name} all ave/time {every} 1 {every}",
        *columns.values(),
        f'{"append" if resumed else "file"} {DUMPS}/{file} format " %.17g" title1 "# {title}"',
        f'title2 "# {joined(["step", *columns])}"',
    )


def first_or_append(resumed: bool) -> str:
    """Return the arguments of dump_modify: a snapshot at the first step, or appended to earlier ones."""
    return "append yes first no" if resumed else "first yes"


def column_names(columns: dict[str, str]) -> list[str]:
    """Return the arguments of dump_modify that name the columns, given their sources by name."""
    return [f"colname {source} {name}" for name, source in columns.items() if name != source]


def law_coefficients(
    contact: Contact,
    first: Material,
    second: Material | None = None,
    friction: float = 0.0,
    loss: Viscous | None = None,
) -> str:
    """Return the coefficients of a contact law, as pair_coeff and the wall fix take them.

    Parameters
    ----------
    first
        Material of a sphere.
    second
        Material of its partner; None if it is the same. A partner without a yield strength is elastic.
    friction
        Coefficient of friction.
    loss
        Kind and size of a viscous loss.
    """
    words: list[str] = [contact.law]
    for material in (first,) if second is None else (first, second):
        words += [num(material.youngs_modulus), num(material.poisson_ratio)]
        if contact.yields:
            words.append("INF" if material.yield_strength is None else num(material.yield_strength))
    if contact.takes("variant"):
        words += ["variant", contact.variant]
    for option in ("yield_factor", "beta", "constant", "exponent"):
        if contact.takes(option):
            words += [option, num(getattr(contact, option))]
    words += [word for name, value in contact.constants.items() for word in (name, num(value))]
    if friction:
        words += ["friction", num(friction)]
        words += [] if contact.tangential == "mindlin_rescale" else ["tangential", contact.tangential]
    if loss is not None:
        words += ["loss", loss[0], num(loss[1])]
    return joined(words)
