"""Plan of a scan, as values and as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.lammps_inputs.planning.plan import Plan
from granwave.workflows.cli.tables.rows import GIB, table
from granwave.workflows.cli.tables.static_stages import static_stage_note
from granwave.workflows.cli.tables.zone import expected_cut
from granwave.workflows.scanning.batches import Machine
from granwave.workflows.scanning.scan_file import Scan, ScanPoint


def plan_values(
    scan: Scan, directory: Path, left: Sequence[ScanPoint], machine: Machine
) -> dict[str, Any]:
    """Return the values of a planned scan with these points left to be run; units are part of the
    names.
    """
    points = scan.distinct.values()
    sizes = [point.size for point in points]
    parts = scan.points[0].kind.parts
    return {
        "name": scan.name,
        "directory": directory,
        "varied": list(scan.varied),
        "n_points": scan.n_points,
        "n_planned": len(scan.points),
        "n_distinct": len(points),
        "n_left": len(left),
        f"n_{parts}_least": min(sizes),
        f"n_{parts}_most": max(sizes),
        "jobs": machine.jobs,
        "wall_time_s": scan.scale * machine.time(left),
        "memory_bytes": sum(
            sorted((point.plan.memory for point in left), reverse=True)[: machine.jobs]
        ),
        "disk_bytes": scan.scale * sum(point.plan.disk for point in left),
    }


def plan_text(
    scan: Scan, left: Sequence[ScanPoint], values: Mapping[str, Any], slowness: float | None
) -> str:
    """Return the table of a planned scan of these `plan_values`."""
    points = scan.distinct.values()
    parts = scan.points[0].kind.parts
    jobs = values["jobs"]
    counts = f"{scan.n_points}"
    if scan.scale > 1:
        counts += f", planned from {len(scan.points)} random points; a run checks all"
    if len(points) < len(scan.points):
        counts += f", {len(points)} of them different"
    if len(left) < len(points):
        counts += f", {len(points) - len(left)} done already"
    least = values[f"n_{parts}_least"]
    most = values[f"n_{parts}_most"]
    measured = ", from the speed measured here" if slowness else ""
    times = [p.plan.times for p in left if isinstance(p.plan, Plan)]
    unknown = [time for time in times if time.most_static > time.static]
    zones = [p.plan.zone for p in points if isinstance(p.plan, Plan) and p.plan.zone]
    cut = sum(bool(zone.reaches and expected_cut(zone)) for zone in zones)
    static = static_stage_note(unknown, jobs / (slowness or 1.0)) if unknown else ""
    reaches = ""
    if cut:
        reaches = f"expected to reach a boundary of the packing in {cut} of {len(points)} points"
    return table(
        [
            ("scan", scan.name),
            ("points", counts),
            ("varies", ", ".join(f"{key} ({scan.n_values_of(key)})" for key in scan.varied)),
            (parts, f"{least} to {most}" if most > least else f"{least}"),
            ("jobs at once", f"{jobs}"),
            ("expected time", f"about {duration(values['wall_time_s'])}{measured}"),
            ("static stages", static),
            ("memory", f"about {values['memory_bytes'] / GIB:.2f} GiB"),
            ("disk", f"about {values['disk_bytes'] / 1e9:.3g} GB"),
            ("plastic zone", reaches),
            ("directory", str(values["directory"])),
        ]
    )
