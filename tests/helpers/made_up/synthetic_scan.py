"""Synthetic directories of scans: every number in them follows from the labels."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis import velocity_normalised
from granwave.lammps_inputs import Case, sphere_contact
from granwave.lammps_inputs.case.parse import apply_overrides, parse_overrides
from granwave.lammps_inputs.lattices import lattice_kinds
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble

BASE = {
    "name": "synthetic",
    "material": "brass",
    "packing": {"kind": "fcc", "size": [24, 24, 12], "diameter": 0.010},
    "load": {"velocity": 5.0},
}
VERSIONS = {"granwave": "0.1.0", "lammps": "1"}

Labels = dict[str, Any]
Change = Mapping[int, str]


def grid(**values: Sequence[Any]) -> list[Labels]:
    """Every combination; `load__velocity` stands for load.velocity."""
    names = [name.replace("__", ".") for name in values]
    return [dict(zip(names, point, strict=True)) for point in itertools.product(*values.values())]


def write_scan(
    directory: Path,
    points: Sequence[Labels],
    *,
    failed: Change | None = None,
    missing: Iterable[int] = (),
    study: Sequence[str] = (),
) -> Path:
    """Write a scan of these points.

    Parameters
    ----------
    failed
        Reasons of failed points, by number from 1.
    missing
        Numbers of points that were never started.
    study
        Studies that the scan names.
    """
    varied = list(dict.fromkeys(key for point in points for key in point))
    index = []
    for number, labels in enumerate(points, start=1):
        name = point_id(labels)
        index.append({"number": number, "id": name, "labels": labels, "ranks": 1})
        if number in (failed or {}):
            folder = directory / "unfinished" / name
            folder.mkdir(parents=True)
            write_json(
                folder / "point.json",
                {"state": "failed", "attempts": 2, "reason": (failed or {})[number]},
            )
        elif number not in missing:
            folder = directory / "points" / name
            folder.mkdir(parents=True, exist_ok=True)
            finish_point(folder, labels)
    directory.mkdir(parents=True, exist_ok=True)
    about = {"name": "synthetic", "case": "fcc-small", "varied": varied, "study": list(study)}
    write_json(directory / "scan.json", about | {"points": index})
    return directory


def point_id(labels: Labels) -> str:
    """Equal points share one."""
    return hashlib.sha256(json.dumps(labels, sort_keys=True).encode()).hexdigest()[:10]


def finish_point(folder: Path, labels: Labels) -> None:
    """Write the files of a finished run that a scan reads."""
    case = case_of(labels)
    (folder / "case.toml").write_text(case.to_toml(), encoding="utf-8")
    write_json(folder / "point.json", {"state": "finished", "attempts": 1, "reason": None})
    write_json(folder / "summary.json", summary_of(case))


def case_of(labels: Labels) -> Case:
    """The case of one point."""
    words = [
        f"{key}={json.dumps(value) if isinstance(value, bool) else value}"
        for key, value in labels.items()
    ]
    return case_from_dict(apply_overrides(BASE, parse_overrides(words)), "case")


def summary_of(case: Case) -> dict[str, Any]:
    """A summary whose values depend on the case smoothly, and on the seed by up to 2 %."""
    law = sphere_contact(case)
    velocity = case.load.velocity
    diameter = case.packing.diameter
    seed = getattr(case.packing, "seed", None) or 0
    noise = 1 + 0.02 * ((seed * 7) % 11 - 5) / 5
    noise *= 1 + 0.01 * list(lattice_kinds()).index(case.packing.kind)  # kinds differ
    given = 0.5 * case.sphere_mass * velocity**2 * case.load.spheres
    strength = law.yield_strength
    yields = case.contact.yields
    unit = law.yield_force * law.yield_overlap if yields else 1.0
    reduced = (
        velocity_normalised(velocity, law.effective_modulus, case.material.density, strength)
        if yields
        else None
    )
    neighbours = lattice_kinds()[case.packing.kind].coordination
    fraction = noise * 0.9 * reduced / (reduced + 8) * (neighbours / 12) ** 0.1 if reduced else 0.0
    n_plastic = round(noise * 3 * (given / unit) ** 0.6) if yields else 0
    return {
        "name": case.name,
        "n_spheres": assemble(case).lattice.n_spheres,
        "end_time_s": 1e-3,
        "energy_input_J": given,
        "dissipated_fraction": min(fraction, 1.0),
        "peak_force_N": noise * 30.0 * velocity**1.1 * (diameter / 0.01) ** 2,
        "n_plastic_spheres": n_plastic,
        "plastic_zone_volume_m3": n_plastic * 0.5236 * diameter**3 if yields else None,
        "plastic_zone_depth_m": noise * 2 * diameter * max(velocity, 0.1) ** 0.3
        if yields
        else None,
        "plastic_zone_radius_m": noise * diameter * max(velocity, 0.1) ** 0.3 if yields else None,
        "velocity_normalised": reduced,
        "energy_input_normalised": given / unit if yields else None,
        "wall_impulse_Ns": 1e-3,
        "wave_speed_m_s": noise * 350 * velocity**0.2
        if assemble(case).lattice.shape[2] >= 9
        else None,
        "sphere_steps_per_s": 1e7,
        "n_ranks": 1,
        "end_reason": "end_time",
        "versions": VERSIONS,
    }


def write_json(path: Path, content: Any) -> None:
    """Write a file in the format of the scan engine."""
    path.write_text(json.dumps(content), encoding="utf-8")
