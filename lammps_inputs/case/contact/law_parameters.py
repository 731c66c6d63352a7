"""Keys of a case that are parameters of contact laws.

The table of laws in C++ (``plugins/laws``) has the name, range, unit, default and description of
each parameter. A section of a case takes the keys of its table from there with `with_parameters`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

from granwave import _contact_laws
from granwave.lammps_inputs.case import schema

Section = TypeVar("Section")

#: Parameters of all contact laws, by name.
PARAMETERS: dict[str, _contact_laws.LawParameter] = _contact_laws.PARAMETERS
OF_CONTACT = tuple(p for p in PARAMETERS.values() if not p.of_material)
OF_MATERIAL = tuple(p for p in PARAMETERS.values() if p.of_material)
#: Parameters of the contact loss, which any law can have.
OF_LOSS: tuple[_contact_laws.LawParameter, ...] = tuple(_contact_laws.LOSS_PARAMETERS.values())
RATE = "rate"  # keyword of the parameters of a rate-dependent yield strength


def with_parameters(
    parameters: Iterable[_contact_laws.LawParameter], *, first: Sequence[str]
) -> Callable[[type[Section]], type[Section]]:
    """Make a decorator that adds the fields of parameters to a section, before the section becomes
    a dataclass.

    Parameters
    ----------
    first
        Fields in the order of files of earlier versions; the other fields of the section follow,
        then the other parameters.
    """
    fields = {parameter.name: _field(parameter) for parameter in parameters}
    annotations = {parameter.name: _annotation(parameter) for parameter in parameters}

    def add(section: type[Section]) -> type[Section]:
        every = section.__annotations__ | annotations
        names = [*first, *(name for name in every if name not in first)]
        section.__annotations__ = {name: every[name] for name in names}
        for name, field in fields.items():
            setattr(section, name, field)
        return section

    return add


def _annotation(parameter: _contact_laws.LawParameter) -> str:
    """Return the annotation of the field of a parameter, with None if the key may be omitted."""
    kind = "str" if parameter.words else "float"
    return kind if _in_case(parameter) is not None else f"{kind} | None"


def _in_case(parameter: _contact_laws.LawParameter) -> float | str | None:
    """Return the default of the key; None if only the law has a default, or there is none."""
    return None if parameter.optional else parameter.default


def _field(parameter: _contact_laws.LawParameter) -> Any:
    """Return the field of a key."""
    description = parameter.description
    if parameter.optional and not parameter.of_material:
        description += f"; {parameter.default:g} by default"
    if parameter.words:
        made = schema.choice(description, parameter.words)
    else:
        unit = parameter.unit or None
        made = schema.number(description, unit, **parameter.case_range)
    info = dataclasses.replace(schema.info_of(made), example=parameter.example)
    return schema.key_field(info, _in_case(parameter))


def type_of(parameter: _contact_laws.LawParameter) -> schema.ValueType:
    """Return the type of the values of the key of a parameter."""
    return schema.info_of(_field(parameter)).type


def keywords(
    parameters: Mapping[str, _contact_laws.LawParameter],
) -> dict[str, list[_contact_laws.LawParameter]]:
    """Return the parameters of a law by their keyword in input scripts, in its order."""
    groups: dict[str, list[_contact_laws.LawParameter]] = {}
    for parameter in parameters.values():
        groups.setdefault(parameter.keyword, []).append(parameter)
    return groups


def value_of(holder: Any, parameter: _contact_laws.LawParameter) -> Any:
    """Return the value of a parameter for a contact or material; default: the value of the law.

    Parameters
    ----------
    holder
        Section with the key; None for a rigid body, which has the default.
    """
    value = getattr(holder, parameter.name, None)
    return parameter.default if value is None else value


def is_set(holder: Any, parameter: _contact_laws.LawParameter) -> bool:
    """Return True if a contact or material has another value than the default of the law."""
    return bool(value_of(holder, parameter) != parameter.default)


def laws_with(parameter: _contact_laws.LawParameter) -> list[str]:
    """Return the names of the laws that take a parameter."""
    laws = _contact_laws.LAWS.items()
    return [name for name, entry in laws if parameter.name in entry.parameters]
