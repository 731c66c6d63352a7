"""Functions of a case, as `granwave.lammps_inputs` gives them to users: each assembles the case and
hands the assembly down.

The packages themselves read and assemble a case once, and call the functions of an assembly.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact import law
from granwave.lammps_inputs.deck import deck
from granwave.lammps_inputs.packing import packing
from granwave.lammps_inputs.packing import walls as of_packing
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.planning import plan as planning
from granwave.lammps_inputs.planning import schedule, timestep

Others = ParamSpec("Others")
Returned = TypeVar("Returned")


def _of_case(
    function: Callable[Concatenate[Assembly, Others], Returned],
) -> Callable[Concatenate[Case, Others], Returned]:
    """Make a function of a case from one whose first argument is its assembly."""

    @wraps(function)
    def of_case(case: Case, *args: Others.args, **kwargs: Others.kwargs) -> Returned:
        return function(assemble(case), *args, **kwargs)

    signature = inspect.signature(function)
    _, *others = signature.parameters.values()
    first = inspect.Parameter("case", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation="Case")
    cast(Any, of_case).__signature__ = signature.replace(parameters=[first, *others])
    return of_case


auto_timestep = _of_case(timestep.auto_timestep)
build_packing = _of_case(packing.build_packing)
expected_peak_overlap = _of_case(timestep.expected_peak_overlap)
flat_contact = _of_case(law.flat_contact)
make_schedule = _of_case(schedule.make_schedule)
pair_contact = _of_case(law.pair_contact)
plan = _of_case(planning.plan)
walls = _of_case(of_packing.walls)
write_deck = _of_case(deck.write_deck)
