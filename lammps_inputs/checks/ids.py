"""Checks of ids of spheres in the tables of a case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.output import Probe
from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.errors import Mismatch

_TABLES_OF_GRAINS = ("replace", "hold", "guide", "absorb")


def check_ids(case: Case, errors: ErrorList) -> None:
    """Check that each table names ids of grains of the packing, or also of strikers, and that names
    of sensors are unique.
    """
    n_grains = case.packing.n_spheres
    # they are checked first, because a table may be invalid
    for key, ids, last in list(_named_ids(case)):
        largest = max(ids or (), default=0)
        if largest > last:
            end = "the end of the packing" if last == n_grains else "strikers included"
            errors.add(key, Mismatch(f"{largest}", f"ids from 1 to {last}, {end}"))
    for probe in _probes(case):
        if len(set(probe.spheres)) < len(probe.spheres):
            fault = Mismatch(f"contact {show(probe.contact)}", "two different spheres")
            errors.add("output.probes", fault)
    errors.check_names(numbered("sensor", case.sensor))


def _named_ids(case: Case) -> Iterator[tuple[str, Sequence[int] | None, int]]:
    """Iterate over keys with ids: key, ids if there are any, and the largest allowed id."""
    n_grains = case.packing.n_spheres
    last = n_grains + len(case.striker)
    if "load" in vars(case):  # otherwise the table is invalid
        yield "load.index", case.load.index, n_grains
    for name in _TABLES_OF_GRAINS:
        for key, entry in numbered(name, getattr(case, name)).items():
            yield f"{key}.index", entry.index, n_grains
    for n_earlier, striker in enumerate(case.striker):
        yield f"striker.{n_earlier + 1}.touches", striker.touches, n_grains + n_earlier
    for key, sensor in numbered("sensor", case.sensor).items():
        yield f"{key}.id", (sensor.id,), last
    for probe in _probes(case):
        yield "output.probes", probe.spheres, last
    lines = numbered("line", case.line)
    for key, line in lines.items():
        if isinstance(line.index, tuple):
            yield f"{key}.index", line.index, last
    for key, line in lines.items():
        yield f"{key}.start", (line.start or 1,), last


def _probes(case: Case) -> tuple[Probe, ...]:
    """Return the probes of a case; none if the table of outputs is invalid."""
    return case.output.probes if "output" in vars(case) else ()
