"""Elements of the LAMMPS input script: numbers, lists, long commands, and coefficients of contact laws."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.material import Material
    from granwave.lammps_inputs.case.sections import Contact

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


def law_coefficients(contact: Contact, first: Material, second: Material | None = None, friction: float = 0.0) -> str:
    """Return the coefficients of a contact law, as pair_coeff and the wall fix take them.

    Parameters
    ----------
    first
        Material of a sphere.
    second
        Material of its partner; None if it is the same. A partner without a yield strength is elastic.
    friction
        Coefficient of friction.
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
    return joined(words)
