"""Parameters of contact laws: case files, decks, input scripts, binding, commands and manual follow
the table of laws.
"""

from __future__ import annotations

import dataclasses
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave._contact_laws import LAWS, PARAMETERS, ContactLaw, LawParameter
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.deck.commands import law_coefficients
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.cli.main import main

R = 0.005
MANUAL = Path(__file__).parents[3] / "plugins" / "doc" / "pair_gran_hysteretic.md"
BOUNDS = {"above": "> {:g}", "at_least": ">= {:g}", "below": "< {:g}", "at_most": "<= {:g}"}
NAMES: list[tuple[str, str]] = []
for LAW, ENTRY in LAWS.items():
    NAMES += [(LAW, name) for name in ENTRY.parameters]
NUMBERS = [(law, name) for law, name in NAMES if not PARAMETERS[name].words]


def example_of(parameter: LawParameter) -> Any:
    """Value other than the default, near which the laws are passive."""
    if parameter.words:
        return parameter.words[-1]
    if parameter.required or parameter.example != parameter.default:
        return parameter.example
    return parameter.default * 0.99


def case_of(law: str, values: dict[str, Any]) -> Case:
    """Two spheres of brass with a law and values of its parameters."""
    material = {"preset": "brass"}
    contact: dict[str, Any] = {"law": law}
    for name, value in values.items():
        holder = material if PARAMETERS[name].of_material else contact
        holder[name] = value
    packing = {"kind": "chain", "size": 2, "diameter": 2 * R}
    tables = {"packing": packing, "material": material, "contact": contact}
    return case_from_dict(tables, "case")


def needed(law: str) -> dict[str, Any]:
    """Required values of a law."""
    return {p.name: p.example for p in LAWS[law].parameters.values() if p.required}


@pytest.mark.parametrize("parameter", PARAMETERS.values(), ids=str)
def test_the_table_agrees_with_itself(parameter: LawParameter) -> None:
    """Case files accept part of the range of the law, with the default and the example."""
    if parameter.words:
        assert parameter.default in parameter.words and not parameter.case_range
        return
    low = parameter.range.get("at_least", parameter.range.get("above", -math.inf))
    high = parameter.range.get("at_most", parameter.range.get("below", math.inf))
    inner = parameter.case_range
    assert low <= inner.get("at_least", inner.get("above", low))
    assert inner.get("at_most", inner.get("below", high)) <= high
    values = [parameter.example] if parameter.required else [parameter.default, parameter.example]
    for value in values:
        assert inner.get("at_least", -math.inf) <= value <= inner.get("at_most", math.inf)
        assert inner.get("above", -math.inf) < value < inner.get("below", math.inf)
    assert parameter.optional or not parameter.of_material


@pytest.mark.parametrize(("law", "name"), NAMES)
def test_a_parameter_reaches_the_law_by_all_ways(law: str, name: str) -> None:
    """The forces of a case, computed by the binding, agree with the words of its deck."""
    keyword = PARAMETERS[name].keyword
    group = [p for p in LAWS[law].parameters.values() if p.keyword == keyword]
    case = case_of(law, needed(law) | {p.name: example_of(p) for p in group})
    words = law_coefficients(case.contact, case.material)
    assert keyword in words.split()
    contact = sphere_contact(case)
    read = ContactLaw.from_words(words, radius=(R, R))
    overlap = np.geomspace(1e-8, 2e-4, 50)
    peak = np.full(50, 2e-4)
    assert np.array_equal(contact.force(overlap, peak), read.force(overlap, peak))
    assert np.array_equal(contact.loading_force(overlap), read.loading_force(overlap))
    assert np.array_equal(contact.rate_factor(overlap, 5.0), read.rate_factor(overlap, 5.0))


@pytest.mark.parametrize(("law", "name"), NUMBERS)
def test_values_outside_the_range_are_refused_by_all(law: str, name: str) -> None:
    """Invalid values are rejected by the case, and by binding and words if the range is the range
    of the law.
    """
    parameter = PARAMETERS[name]
    for bounds, by_case in ((parameter.case_range, True), (parameter.range, False)):
        for bound, value in bounds.items():
            step = {"above": 0, "below": 0, "at_least": -1, "at_most": 1}[bound]
            wrong = float(value + step)
            if by_case:
                with pytest.raises(InputError, match=rf"\.{name}: found .*expected a number"):
                    case_of(law, needed(law) | {name: wrong})
                continue
            values = needed(law) | {name: (wrong, wrong) if parameter.of_material else wrong}
            bodies = {"youngs_modulus": (1e9, 1e9), "poisson_ratio": (0.3, 0.3)}
            with pytest.raises(ValueError, match=rf"{name} must"):
                ContactLaw(law, **bodies, yield_strength=(1e6, 1e6), radius=(R, R), **values)
            strength = "1e6" if LAWS[law].yields else ""
            words = f"{law} 1e9 0.3 {strength} {parameter.keyword}{f' {wrong}' * 2}"
            with pytest.raises(ValueError, match=f"must .*, found '{wrong}'"):
                ContactLaw.from_words(words, radius=(R, R))


def test_parameters_of_another_law_are_refused() -> None:
    """Parameters without a default in the case; the message names the laws that have them."""
    for name, parameter in PARAMETERS.items():
        if parameter.of_material or not (parameter.required or parameter.optional):
            continue
        with pytest.raises(InputError, match=rf"contact\.{name}: found .*applies only to law = "):
            case_of("hertz", {name: example_of(parameter)})
        with pytest.raises(ValueError, match=f"'{name}' is not an option of law 'hertz'"):
            ContactLaw.from_words(f"hertz 1e9 0.3 {name} 1.0", radius=(R, R))


def curve_in(file: Path) -> np.ndarray:
    """Return overlaps and forces of a table of `granwave law`: (n, 2)."""
    return np.loadtxt(file, delimiter=",", skiprows=1, usecols=(1, 2))


@pytest.mark.parametrize("law", [name for name, entry in LAWS.items() if entry.yields])
def test_the_command_has_an_option_for_each(tmp_path: Path, law: str) -> None:
    """The parameter changes the curve of `granwave law`; quasi-static loading does not depend on
    the rate.
    """
    command = ["law", "--law", law, "--max-overlap", "20", "-o"]
    usual = tmp_path / "usual.csv"
    assert main([*command, str(usual)]) == 0
    for parameter in LAWS[law].parameters.values():
        option = "--" + parameter.name.replace("_", "-")
        file = tmp_path / f"{parameter.name}.csv"
        assert main([*command, str(file), option, str(example_of(parameter))]) == 0
        same = np.array_equal(curve_in(file), curve_in(usual))
        assert same == (parameter.keyword == "rate"), option


@pytest.mark.parametrize("parameter", PARAMETERS.values(), ids=str)
def test_the_manual_has_keyword_values_range_and_laws(parameter: LawParameter) -> None:
    """In the block of keywords, or for required values in the block of the laws."""
    text = MANUAL.read_text(encoding="utf-8").partition("## Examples")[0]
    if parameter.required:
        assert re.search(rf"args = .* {parameter.keyword} {parameter.symbol}\b", text)
        return
    lines = [line.strip() for line in text.splitlines()]
    (start,) = [n for n, line in enumerate(lines) if names_of(line, parameter.keyword)]
    entry = " ".join(lines[start : start + 4])
    for word in parameter.words or (parameter.symbol,):
        assert word in entry
    for law in LAWS:
        assert (parameter.name in LAWS[law].parameters) == (law in laws_of(lines[start])), law
    bounds = [BOUNDS[bound].format(value) for bound, value in parameter.range.items()]
    for bound in bounds:
        assert bound in entry or flipped(bound) in entry, bound


def names_of(line: str, keyword: str) -> bool:
    """Return True for the line of the manual that describes a keyword."""
    keywords = re.match(r"([\w, ]+?) values? = ", line)
    return keywords is not None and keyword in keywords[1].split(", ")


def laws_of(line: str) -> list[str]:
    """Laws in the brackets at the end of a line of the manual."""
    brackets = re.search(r"\(([^()]*)\)$", line)
    assert brackets is not None, line
    return re.findall(r"[\w-]+", brackets[1])


def flipped(bound: str) -> str:
    """Write ``>= 0`` as ``0 <=``."""
    sign, number = bound.split()
    return f"{number} {sign.replace('>', '<')}"


def test_keys_are_fields_of_the_sections() -> None:
    """Each parameter is a key of ``[contact]`` or ``[material]``, and there are no others."""
    case = case_of("hertz", {})
    for section, of_material in ((case.contact, False), (case.material, True)):
        names = {field.name for field in dataclasses.fields(section)}
        for name, parameter in PARAMETERS.items():
            assert (name in names) == (parameter.of_material == of_material)
