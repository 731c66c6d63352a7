"""Requirements of the remaining points of a scan: files and disk space."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.initial_dents import earlier_result
from granwave.lammps_inputs.directories import check_disk, refuse_source
from granwave.lammps_inputs.errors import InputError, raise_all
from granwave.workflows.scanning import layout
from granwave.workflows.scanning.scan_file import Point, Scan


def left(scan: Scan, directory: Path, *, fresh: bool = False) -> list[Point]:
    """Return the points still to be run or analysed again; all if the scan starts ``fresh``.

    Raises
    ------
    InputError
        The case.toml of finished points was changed.
    """
    if fresh:
        return list(scan.distinct.values())
    found, errors = [], []
    for name, point in scan.distinct.items():
        try:
            found += [] if layout.is_whole(directory, name) else [point]
        except InputError as error:
            errors += error.errors
    if errors:
        raise InputError(errors)
    return found


def check_points(scan: Scan, directory: Path, *, force: bool) -> None:
    """Check that the remaining points can be run: files that they name, and disk space.

    Parameters
    ----------
    force
        True to replace the points in ``directory``.

    Raises
    ------
    InputError
        The points cannot be run; the message lists all faults.
    """
    points = sorted(left(scan, directory, fresh=force), key=lambda point: point.number)
    needed = scan.scale * sum(point.plan.disk for point in points)
    spare = layout.LEAST_FREE + max((point.plan.disk_reserve for point in points), default=0.0)
    cases = [point.case for point in points if force and isinstance(point.case, Case)]
    sources = {source: case.name for case in cases if (source := earlier_result(case)) is not None}
    raise_all(
        [
            lambda: _check_files(scan.name, points),
            lambda: check_disk(directory, needed, what="the points", spare=spare),
            *(partial(refuse_source, directory, name, source) for source, name in sources.items()),
        ]
    )


def _check_files(name: str, points: Sequence[Point]) -> None:
    """Check the files that points name; a fault of all points is reported once."""
    found: dict[str, list[str]] = {}
    for point in points:
        try:
            point.kind.check(point.case, point.plan, memory=False)
        except InputError as error:
            labels = ", ".join(f"{key} = {value}" for key, value in point.labels.items())
            for fault in error.errors:
                found.setdefault(fault, []).append(f"point {point.number} ({labels})")
    errors: list[str] = []
    for fault, concerned in found.items():
        shared = len(concerned) == len(points)
        errors += [f"{name}: {fault}"] if shared else [f"{name}: {point}: {fault}" for point in concerned]
    if errors:
        raise InputError(errors)
