"""Command ``granwave check``: the plan of a run, its inputs, and values of extensions, as a
table.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.lammps_inputs.case.packing.made_packing import PackingNotMadeError, nothing_made
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import added, load
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.planning.impact_input import inputs_of_packing
from granwave.lammps_inputs.planning.plan import Plan
from granwave.workflows import library
from granwave.workflows.check_part import CheckPart, input_values
from granwave.workflows.cli.packing_picture import draw_packing
from granwave.workflows.cli.submission import ranks_of
from granwave.workflows.cli.tables.cluster_plan import ClusterPlan
from granwave.workflows.cli.tables.plan_table import energy_is_bound, plan_table
from granwave.workflows.cli.tables.plan_values import packing_values
from granwave.workflows.cli.tables.rows import GIB, table
from granwave.workflows.cli.tables.zone import expected_cut
from granwave.workflows.cli.terminal import print_json, warn, warn_of_lacks
from granwave.workflows.cluster.profile import load_profile
from granwave.workflows.file_kinds import file_kinds
from granwave.workflows.solvers import GRANULAR, CaseKind, case_commands, solver_of


def check(options: argparse.Namespace) -> int:
    """Plan a case and check that this machine can run it; return the exit status."""
    checks = {kind.command: kind.check for kind in file_kinds() if kind.check}
    path = library.find_for(options.case, *case_commands(), *checks)
    if (command := library.verb_of(path)) in checks:
        if options.profile:
            raise InputError(f"--profile: {path} is not a case of a run; remove this option")
        draw_packing(options.picture, None)
        return int(load(checks[command])(path, options))
    kind = solver_of(read_toml(path))
    try:
        with nothing_made():
            case = kind.load(path, options.overrides)
    except PackingNotMadeError as error:
        return _not_made(error, as_json=options.json)
    assembled = kind.assemble(case)
    cluster = _cluster_plan(kind, assembled, options)
    expected = cluster.expected if cluster else kind.cost(assembled, options.ranks, True)
    parts = _parts(kind, assembled)
    if cluster is not None:
        parts.append(cluster.part())
    kind.check(case)
    draw_packing(options.picture, assembled)

    def afford() -> None:
        if cluster is None:
            kind.afford(case, expected, Path(case.name).absolute())

    warnings = _warnings(expected)
    if cluster is not None:
        warnings += cluster.warnings()
    if options.json:
        warnings += warn_of_lacks(case.name, afford)
        values = _values(kind, assembled, expected, parts)
        print_json({"name": case.name, "command": kind.verb, **values, "warnings": warnings})
        return 0
    print(_plan_text(kind, assembled, case.name, expected, parts))
    sys.stdout.flush()
    warn_of_lacks(case.name, afford)
    for warning in warnings:
        warn(f"{case.name}: {warning}")
    return 0


def _plan_text(
    kind: CaseKind, assembled: Any, name: str, expected: Any, parts: Sequence[CheckPart]
) -> str:
    """Return the table of a plan, and the lines that extensions add."""
    if isinstance(expected, Plan):
        rows = [*chain.from_iterable(part.rows for part in parts)]
        text = plan_table(assembled, expected, inputs_of_packing(assembled), rows)
    else:
        text = _table_of_other(kind, assembled, name, expected, parts)
    texts = [text]
    for part in parts:
        texts += part.lines
    return "\n".join(texts)


def _cluster_plan(
    kind: CaseKind, assembled: Any, options: argparse.Namespace
) -> ClusterPlan | None:
    """Return the plan for the cluster of ``--profile``; None without one."""
    if not options.profile:
        return None
    profile = load_profile(options.profile)
    ranks = ranks_of(options, profile) if kind.parallel else 1
    return ClusterPlan(profile, kind.cost(assembled, ranks, True), ranks)


def _not_made(error: PackingNotMadeError, *, as_json: bool) -> int:
    """Show the recipe of the bed of a case; the plan follows after the bed is made."""
    (packing,) = error.packings
    if as_json:
        print_json({"not_made": dict(packing.rows)})
    else:
        print(table(packing.rows))
    return 0


def _parts(kind: CaseKind, assembled: Any) -> list[CheckPart]:
    """Return the values that extensions add for a case."""
    if kind is GRANULAR:
        return [part(assembled) for part in added("check")]
    return [] if kind.check_part is None else [kind.check_part(assembled)]


def _warnings(expected: Any) -> list[str]:
    """Return warnings of the plan of a packing."""
    if not isinstance(expected, Plan):
        return []
    warnings = []
    if expected.slowness:
        warnings.append(f"the run takes about {duration(expected.wall_time)}: {expected.slowness}")
    if cut := expected_cut(expected.zone):
        warnings.append(cut)
    return warnings


def _values(
    kind: CaseKind, assembled: Any, expected: Any, parts: Sequence[CheckPart]
) -> dict[str, Any]:
    """Return the values of a planned case; units are part of the names."""
    values: dict[str, Any] = {f"n_{kind.parts}": kind.size(assembled)}
    if isinstance(expected, Plan):
        values |= packing_values(assembled, expected)
    for part in parts:
        values |= part.values
    values |= {
        "memory_bytes": expected.memory,
        "disk_bytes": expected.disk,
        "wall_time_s": expected.wall_time,
    }
    if isinstance(expected, Plan):
        at_most = energy_is_bound(assembled.case)
        values |= input_values(inputs_of_packing(assembled), at_most=at_most)
    for part in parts:
        values |= part.further_values
    return values


def _table_of_other(
    kind: CaseKind, assembled: Any, name: str, expected: Any, parts: Sequence[CheckPart]
) -> str:
    """Return the table of a case without spheres."""
    rows = [("case", name), (kind.parts, f"about {kind.size(assembled)}")]
    for part in parts:
        rows += part.rows
    rows.append(("memory", f"about {expected.memory / GIB:.2f} GiB"))
    rows.append(("disk", f"about {expected.disk / 1e9:.3g} GB"))
    rows.append(("expected time", f"about {duration(expected.wall_time)}"))
    return table(rows)
