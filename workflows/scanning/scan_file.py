"""A scan file: one case, varied keys, and the resulting points.

Every point is a complete case, checked before anything runs. Its id is a hash of the resolved case
and of the versions that its result depends on, so that equal points are run once, within a scan and
in repeated scans.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import itertools
import json
import logging
import random
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.values import unique_labels
from granwave.analysis.scans.result import SEED, Scalar
from granwave.analysis.versions import versions_of
from granwave.lammps_inputs.case.case import Case, case_keys
from granwave.lammps_inputs.case.packing.made_packing import (
    PackingNotMadeError,
    PackingToMake,
    is_made,
)
from granwave.lammps_inputs.case.parse import apply_overrides, parse_overrides
from granwave.lammps_inputs.case.schema import ErrorList, read_table, show
from granwave.lammps_inputs.errors import InputError, InputFault, fault_of
from granwave.lammps_inputs.files import read_toml, with_short_paths
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.lammps_inputs.result_directory import without_remarks
from granwave.workflows import library
from granwave.workflows.run.progress import Progress, each_warning_once
from granwave.workflows.run.record import versions
from granwave.workflows.scanning.header import ScanHeader, flat, studies_beside, variations_of
from granwave.workflows.solvers import AnyCase, CaseKind, Cost, case_commands, solver_of

_LOG = logging.getLogger("granwave")

_ID_LENGTH = 12
_MANY = 300  # points above which reading them, about 5 ms each, shows a progress bar


@dataclasses.dataclass(frozen=True)
class ScanPoint:
    """One point of a scan.

    Attributes
    ----------
    number
        Number of the point from 1, in the order of the scan.
    id
        Hash of the resolved case and the relevant versions.
    labels
        Varied values by dotted key; lists and tables as text.
    case
        Resolved case.
    kind
        Kind of the case.
    plan
        Expected cost.
    ranks
        Number of MPI ranks.
    size
        Number of spheres or elements.
    """

    number: int
    id: str
    labels: dict[str, Scalar]
    case: AnyCase
    kind: CaseKind
    plan: Cost
    ranks: int
    size: int


@dataclasses.dataclass(frozen=True)
class Scan:
    """A checked scan.

    Attributes
    ----------
    varied
        Varied dotted keys, in the order of the file.
    text
        Text of the file, after comments with the overrides.
    study
        Names of the studies in its report, and absolute paths of files of studies.
    n_points
        Number of points of the file; more than ``points`` if only some were made.
    n_values
        Number of different values of varied keys, if only some points were made.
    """

    name: str
    case_name: str
    varied: tuple[str, ...]
    points: tuple[ScanPoint, ...]
    figures: bool
    text: str
    study: tuple[str, ...] = ()
    n_points: int = 1
    n_values: Mapping[str, int] = dataclasses.field(default_factory=dict)

    @property
    def scale(self) -> float:
        """Number of points of the file divided by the number of points that were made."""
        return self.n_points / len(self.points)

    def n_values_of(self, key: str) -> int:
        """Return the number of different values of a varied key."""
        return self.n_values.get(key) or len({str(point.labels[key]) for point in self.points})

    @property
    def distinct(self) -> dict[str, ScanPoint]:
        """Distinct points by id."""
        return {point.id: point for point in reversed(self.points)}

    def index(self) -> dict[str, Any]:
        """Return the content of scan.json."""
        points = [
            {"number": point.number, "id": point.id, "labels": point.labels, "ranks": point.ranks}
            for point in self.points
        ]
        return {
            "name": self.name,
            "case": self.case_name,
            "varied": list(self.varied),
            "study": list(self.study),
            "points": points,
            "versions": versions_of(()),
        }


def find_scan(scan: str | Path, directory: Path = Path()) -> Path:
    """Find the file of a scan or a suite, given as a path or as the name of a built-in scan.

    Parameters
    ----------
    directory
        Folder that a relative path starts from.

    Raises
    ------
    InputError
        There is no such scan, or it cannot be read.
    """
    try:
        return library.find_for(str(scan), library.SCAN, directory=directory)
    except OSError as error:
        raise InputError(f"{scan}: cannot be read: {error.strerror}") from None


def load_scan(
    scan: str | Path,
    overrides: Iterable[str] | Mapping[str, Any] = (),
    *,
    here: bool = True,
    most: int | None = None,
) -> Scan:
    """Read a scan file and make its points.

    Parameters
    ----------
    scan
        Path of the file, or name of a built-in scan.
    overrides
        Keys of the case for all points, in addition to the keys of ``[set]`` and with precedence
        over them.
    here
        True if the points run on this machine and must fit into its memory.
    most
        Number of random points of a larger scan to make for its plan; None: all.

    Raises
    ------
    InputError
        The file, an override or any point is invalid; the message has a line for each invalid
        point.
    """
    changes = parse_overrides(overrides)
    path = find_scan(scan)
    text = path.read_text(encoding="utf-8")
    return scan_from_dict(read_toml(path), path, changes, here=here, text=text, most=most)


def scan_from_dict(
    data: Mapping[str, Any],
    path: Path,
    changes: Mapping[str, Any],
    *,
    here: bool = True,
    text: str = "",
    template: Mapping[str, Any] | None = None,
    most: int | None = None,
) -> Scan:
    """Make a scan of the tables of a scan file; raise as `load_scan`.

    Parameters
    ----------
    path
        Name of the file in messages; its stem is the default name of the scan, and its folder is
        the base of relative paths.
    changes
        Keys of the case for all points, by dotted key.
    here
        As in `load_scan`.
    text
        Text of the file.
    template
        Tables of the case; None if ``data`` names its file.
    most
        As in `load_scan`.
    """
    data = dict(data)
    if "scans" in data:
        raise InputError(
            f"{path}: is a suite of scans, expected one scan: one of {', '.join(map(str, data['scans']))}"
        )
    errors = ErrorList(str(path), vocabulary=[f"set.{key}" for key in case_keys()])
    tables: dict[str, Any] = {
        name: data.pop(name) for name in ("set", "grid", "zip", "points") if name in data
    }
    header = read_table(ScanHeader, {"name": path.stem, **data}, "", errors)
    fixed = {
        key: value
        for key, value in flat(tables.get("set", {}), "set", errors).items()
        if not any(
            key.startswith(f"{changed}.") for changed in changes
        )  # --set material=steel replaces the complete table
    } | dict(changes)
    variations = variations_of(tables, header, errors)
    if header is not None:
        header = dataclasses.replace(header, study=studies_beside(header.study, path, errors))
    if errors.items or header is None:
        raise InputError(errors.items)
    return _build(path, header, fixed, changes, variations, here, text, template, most)


def scan_of_case(case: str, beside: Path, *, here: bool = True) -> Scan:
    """Make a scan of a single point, with figures, from one case; raise as `load_scan`.

    Parameters
    ----------
    case
        Name of a built-in study, or path of a case file relative to the file ``next to``.
    """
    text = f'case = "{case}"\nfigures = true\n'
    header = ScanHeader(name=Path(case).stem, case=case, figures=True)
    return _build(beside, header, {}, {}, [{}], here, text)


def _build(
    path: Path,
    header: ScanHeader,
    fixed: Mapping[str, Any],
    changes: Mapping[str, Any],
    variations: Sequence[Mapping[str, Any]],
    here: bool,
    text: str,
    template: Mapping[str, Any] | None = None,
    most: int | None = None,
) -> Scan:
    n_all = len(variations)
    n_values = {}
    if most is not None and n_all > most:
        n_values = {
            key: len({repr(values.get(key)) for values in variations}) for key in variations[0]
        }
        variations = [variations[n] for n in sorted(random.Random(0).sample(range(n_all), most))]
    varied = tuple(dict.fromkeys(itertools.chain.from_iterable(variations)))
    if header.replicates > 1:
        if SEED in varied:
            raise InputError(
                f"{path}: {SEED}: varies twice; remove replicates, which are seeds from 1 on"
            )
        varied = (*varied, SEED)
    _check_fixed(path, fixed, varied, changes)
    if template is None:
        template = _template_of(path, header)
    reader = _PointReader(path, template, fixed, changes, solver_of(template))
    points = _points_of(header, reader, variations, varied, here=here)
    return Scan(
        name=header.name,
        case_name=str(template["name"]),
        varied=varied,
        points=tuple(_labelled(points, varied, path.parent)),
        figures=header.figures,
        study=header.study,
        n_points=round(len(points) * n_all / len(variations)),
        n_values=n_values,
        text="".join(f"# --set {key}={show(value)}\n" for key, value in changes.items()) + text,
    )


def _check_fixed(
    path: Path, fixed: Mapping[str, Any], varied: Sequence[str], changes: Mapping[str, Any]
) -> None:
    """Reject keys that are both fixed for all points and varied."""
    twice = [key for key in fixed if key in varied]
    if twice:
        fault = "is varied in the scan, expected a key with one value in all points"
        raise InputError(
            fault_of(
                fault,
                source="" if key in changes else f"{path}: set",
                key=key,
                changed=key in changes,
            )
            for key in twice
        )


def _template_of(path: Path, header: ScanHeader) -> Mapping[str, Any]:
    """Read the case that a scan varies."""
    try:
        base = library.find_for(header.case, *case_commands(), directory=path.parent)
    except InputError as error:
        raise InputError(item.inside(f"{path}: case") for item in error.items) from None
    except OSError as error:
        fault = f"found {show(header.case)}, which cannot be read: {error.strerror}"
        raise InputError(f"{path}: case: {fault}") from None
    return {"name": base.stem, **read_toml(base)}


@dataclasses.dataclass(frozen=True)
class _PointReader:
    """Reader of the cases of points.

    Attributes
    ----------
    path
        Scan file.
    template
        Tables of the case that the scan varies.
    fixed
        Keys that are the same for all points.
    changes
        Keys of ``fixed`` that were changed by the user of the scan file.
    kind
        Kind of the cases.
    """

    path: Path
    template: Mapping[str, Any]
    fixed: Mapping[str, Any]
    changes: Mapping[str, Any]
    kind: CaseKind

    def tables(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the tables of the case with these values."""
        return _with(self.template, {**self.fixed, **values}, self.path, self.changes)

    def read(self, values: Mapping[str, Any]) -> AnyCase:
        """Read the case with these values."""
        return self.kind.read(self.tables(values), self.path, overridden=self.changes)


def _points_of(
    header: ScanHeader,
    reader: _PointReader,
    variations: Sequence[Mapping[str, Any]],
    varied: Sequence[str],
    *,
    here: bool,
) -> list[ScanPoint]:
    """Make the points of a scan, and log each of their warnings once.

    Raises
    ------
    InputError
        Points are invalid; the message has a line for each of them.
    PackingNotMadeError
        Packings of points are not made, and this is within `nothing_made`.
    """
    path = reader.path
    kind = reader.kind
    points: list[ScanPoint] = []
    to_make: dict[Path, PackingToMake] = {}
    errors: list[tuple[int, Mapping[str, Any], list[InputFault]]] = []
    progress = Progress(len(variations), f"{header.name}: points", enabled=len(variations) > _MANY)
    fresh = each_warning_once()  # many points would repeat them
    with contextlib.closing(progress), contextlib.ExitStack() as at_end:
        _LOG.addFilter(fresh)
        at_end.callback(_LOG.removeFilter, fresh)
        for n, values in enumerate(variations, start=1):
            try:
                for replicate in _replicates(header, values, reader):
                    case = _read_or_note(reader, replicate, to_make)
                    if case is None:
                        continue
                    points.append(_point(len(points) + 1, replicate, case, kind, header, varied))
                    if here:
                        kind.afford(case, points[-1].plan, None)
            except InputError as error:
                errors.append((n, values, error.items))
            progress.update(n, "checked")
    if header.replicates > 1 and not to_make and len(points) == len(variations):
        _LOG.warning(
            "%s: replicates: these packings have no random quantities, so each is run once", path
        )
    if errors:
        raise InputError(_faults_of(path, errors, len(variations)))
    if to_make:
        raise PackingNotMadeError(
            f"{path}: packings of its points that are not generated yet: {len(to_make)}",
            list(to_make.values()),
        )
    return points


def _read_or_note(
    reader: _PointReader, values: Mapping[str, Any], to_make: dict[Path, PackingToMake]
) -> AnyCase | None:
    """Return a case; None if its packing is not made, which is added to ``to_make``."""
    try:
        return reader.read(values)
    except PackingNotMadeError as error:
        to_make.update({packing.file: packing for packing in error.packings})
        return None


def _replicates(
    header: ScanHeader, values: Mapping[str, Any], reader: _PointReader
) -> list[Mapping[str, Any]]:
    """Return the values of a point with each of its seeds; the values if nothing is random."""
    if header.replicates <= 1:
        return [values]
    n_seeds = header.replicates
    if not is_made(reader.tables(values)):
        case = reader.read(values)
        if not isinstance(case, Case):
            return [values]
        if not is_random(case):
            n_seeds = 1
    return [{**values, SEED: seed} for seed in range(1, n_seeds + 1)]


def _with(
    template: Mapping[str, Any], settings: Mapping[str, Any], path: Path, changes: Mapping[str, Any]
) -> dict[str, Any]:
    """Apply settings to the tables of a case."""
    # complete tables first, then keys inside them
    ordered = {key: settings[key] for key in sorted(settings, key=lambda key: key.count("."))}
    try:
        return apply_overrides(template, ordered)
    except InputError as error:
        raise InputError(
            item if item.key in changes else item.inside(str(path)) for item in error.items
        ) from None


def _point(
    number: int,
    values: Mapping[str, Any],
    case: AnyCase,
    kind: CaseKind,
    header: ScanHeader,
    varied: Sequence[str],
) -> ScanPoint:
    assembled = kind.assemble(case)
    size = kind.size(assembled)
    ranks = header.ranks.of(size) if kind.parallel else 1
    expected = kind.cost(assembled, ranks, header.figures)
    resolved = case.to_dict()
    stamp = {name: versions()[name] for name in kind.versions}
    key = json.dumps([without_remarks({**resolved, "name": ""}), stamp], sort_keys=True).encode()
    labels = {}
    for one in varied:
        found: Any = resolved
        for name in one.split("."):
            found = found.get(name, "") if isinstance(found, Mapping) else ""
        labels[one] = values.get(one, found)
    return ScanPoint(
        number,
        hashlib.sha256(key).hexdigest()[:_ID_LENGTH],
        labels,
        case,
        kind,
        expected,
        ranks,
        size,
    )


def _labelled(points: Sequence[ScanPoint], varied: Sequence[str], folder: Path) -> list[ScanPoint]:
    """Replace the varied values of points by labels, with paths relative to the folder of the scan
    file.
    """
    columns: dict[str, list[Scalar]] = {}
    for key in varied:
        values = [with_short_paths(point.labels[key], folder, key) for point in points]
        # tables get unique text labels, since points of equal labels count as one
        columns[key] = [
            value if isinstance(value, bool | int | float | str) else words
            for value, words in zip(values, unique_labels(values), strict=True)
        ]
    return [
        dataclasses.replace(point, labels={key: columns[key][n] for key in varied})
        for n, point in enumerate(points)
    ]


def _faults_of(
    path: Path, errors: Sequence[tuple[int, Mapping[str, Any], list[InputFault]]], count: int
) -> list[InputFault]:
    """Return faults common to all points once; otherwise a fault for each invalid point."""
    shared = [
        item
        for item in errors[0][2]
        if len(errors) == count and all(item in items for _, _, items in errors)
    ]
    faults = [
        item if item.changed or item.source == str(path) else item.inside(str(path))
        for item in shared
    ]
    for n, values, items in errors:
        own = [item for item in items if item not in shared]
        if own:
            labels = ", ".join(
                f"{key} = {show(with_short_paths(value, path.parent, key))}"
                for key, value in values.items()
            )
            message = "; ".join(str(item.outside(str(path))) for item in own)
            faults.append(fault_of(f"point {n} ({labels}): {message}", source=str(path)))
    return faults
