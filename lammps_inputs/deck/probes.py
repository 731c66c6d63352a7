"""Probes of spheres and contacts, and the displacements of spheres."""

from __future__ import annotations

from typing import TYPE_CHECKING

from granwave.lammps_inputs.deck.commands import joined, time_series
from granwave.lammps_inputs.run_directory import PROBES_FILE

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.planning.schedule import Schedule


def probes(case: Case, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands of probes of spheres and contacts."""
    if not case.probes:
        return []
    lines = ["# Probes: displacement, velocity and force of spheres; overlap and force of contacts."]
    if not case.precompression:
        lines += displacements(case)[1:]
    columns = {"time": "v_time"}
    for n, probe in enumerate(case.probes, start=1):
        if probe.contact is not None:
            lines.append(f"compute         probe{n} all gran/hysteretic/contact {joined(probe.contact)}")
            label = "contact_{}_{}".format(*probe.contact)
            columns |= {f"{label}_overlap": f"c_probe{n}[1]", f"{label}_force": f"c_probe{n}[2]"}
            continue
        for quantity, source in _sphere_probe(probe.sphere or 0).items():
            lines.append(f"variable        probe{n}{quantity} equal {source}")
            columns[f"sphere_{probe.sphere}_{quantity}"] = f"v_probe{n}{quantity}"
    return lines + time_series("probes", schedule.probe_every, PROBES_FILE, "probes, SI units", columns, resumed)


def displacements(case: Case) -> list[str]:
    """Return the commands for displacements from the data file, of all spheres and of those probed."""
    lines = ["compute         displacement all displace/atom"]
    spheres = [probe.sphere for probe in case.probes if probe.sphere is not None]
    if spheres:
        lines.append(f"group           probes id {joined(dict.fromkeys(spheres))}")
        lines.append("compute         probed probes displace/atom")
    return lines


def _sphere_probe(sphere: int) -> dict[str, str]:
    axes = list(enumerate("xyz", start=1))
    return (
        {f"u{letter}": f"C_probed[{sphere}][{n}]" for n, letter in axes}
        | {f"v{letter}": f"v{letter}[{sphere}]" for _, letter in axes}
        | {f"f{letter}": f"f{letter}[{sphere}]" for _, letter in axes}
    )
