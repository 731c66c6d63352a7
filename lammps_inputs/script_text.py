"""Words of the LAMMPS input script: numbers, lists, long commands, and the coefficients of the contact
law."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from granwave.lammps_inputs.case import Case

_WIDTH = 110


def num(value: float) -> str:
    """The shortest text that reads back as exactly this number."""
    short = f"{value:.6g}"
    return short if float(short) == value else repr(float(value))


def joined(values: Iterable[object]) -> str:
    """Values with spaces between them."""
    return " ".join(str(value) for value in values)


def command(*words: str) -> list[str]:
    """One command of many words, broken into lines that LAMMPS puts together again."""
    lines = [words[0]]
    for word in words[1:]:
        if len(lines[-1]) + len(word) + 3 > _WIDTH:
            lines[-1] += " &"
            lines.append("                " + word)
        else:
            lines[-1] += " " + word
    return lines


def law_coefficients(case: Case) -> str:
    """The contact law with its material, as pair_coeff and the wall take it."""
    material, contact = case.material, case.contact
    words = [contact.law, num(material.youngs_modulus), num(material.poisson_ratio)]
    if contact.yields and material.yield_strength is not None:
        words.append(num(material.yield_strength))
    if contact.law == "elastoplastic":
        words += ["variant", contact.variant, "yield_factor", num(contact.yield_factor)]
        words += [word for name, value in contact.constants.items() for word in (name, num(value))]
    if contact.law == "bilinear":
        words += ["beta", num(contact.beta)]
    return joined(words)
