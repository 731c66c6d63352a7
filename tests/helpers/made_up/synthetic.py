"""Synthetic run directories, written without LAMMPS: all numbers in them are known, so that readers
can be tested.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from granwave.lammps_inputs import Case, build_packing, sphere_contact, write_deck
from granwave.lammps_inputs.load_case import case_from_dict

BRASS = {"youngs_modulus": 115e9, "poisson_ratio": 0.3, "density": 8500.0, "yield_strength": 550e6}
DIAMETER = 0.010
TIMESTEP = 1e-7
STEPS = 1000
DENT = 40.0  # peak of the deepest dent, alpha_y
REACH = 1.2  # decay length of the dents, diameters
BOTTOM_FORCE = 100.0  # N, amplitude of the half-sine force on the bottom
BALANCE = 3e-7  # error of the energy balance of the ledger
RUBBED = 0.25  # frictional loss as a fraction of the plastic loss of a contact
FRAME_COLUMNS = (
    "id type radius x y z ux uy uz vx vy vz force peak_force peak_overlap dissipated elastic"
)
CONTACT_COLUMNS = "i j overlap force peak_overlap peak_force elastic dissipated time_first time_peak time_yield live"
# of contacts, where there is friction
FRICTION_COLUMNS = "tangential_force elastic_tangential friction"
WALL_COLUMNS = "id overlap force peak_overlap peak_force dissipated time_first time_peak time_yield"


def make_case(
    kind: str = "fcc",
    size: Sequence[int] | int = (6, 6, 4),
    law: str = "elastoplastic",
    packing=(),
    **tables,
) -> Case:
    """Case of brass, with further keys of the packing, and further tables by name."""
    return case_from_dict(
        {
            "name": f"synthetic-{kind}",
            "packing": {
                "kind": kind,
                "size": size if isinstance(size, int) else list(size),
                "diameter": DIAMETER,
                **dict(packing),
            },
            "material": BRASS,
            "contact": {"law": law},
            "run": {"end_time": STEPS * TIMESTEP, "timestep": TIMESTEP, "frames": 5},
            "output": {"history": 0, "dump_format": "text"},
            **tables,
        }
    )


def write_run(directory: Path, case: Case, dent: float = DENT) -> Path:
    """Write a run in which every touching pair has an indentation that decreases with the distance
    from the impacted sphere.

    With friction every contact also has a frictional dissipation of `RUBBED` times its plastic
    dissipation; with ``contact.initial_overlap`` each has this initial indentation. Displacements
    of sphere n at frame m are (m n, 0, m) 1e-9 m; a contact at the distance d from the impacted
    sphere was first loaded at d / (1000 m/s).
    """
    deck = write_deck(case, directory)
    packing = build_packing(case)
    law = sphere_contact(case)
    dumps = directory / "dumps"
    contacts = dents_of(case, packing, deck.struck[0], law, dent)
    write_local(
        dumps / "contacts.dump", np.stack(list(contacts.values()), axis=1), " ".join(contacts)
    )
    write_frames(dumps / "spheres.dump", packing.positions, contacts, ids=packing.ids)
    write_ledger(
        dumps / "energy.txt",
        contacts["dissipated"].sum(),
        law,
        np.sum(contacts.get("friction", 0.0)),
    )
    if case.boundary.bottom != "free":
        time = np.arange(0, STEPS + 1, 5) * TIMESTEP
        force = BOTTOM_FORCE * np.sin(np.pi * time / time[-1])
        rows = np.stack([np.arange(len(time)) * 5, time, force], axis=1)
        write_table(dumps / "walls.txt", "step time bottom", rows)
    if case.boundary.bottom == "wall":
        write_custom(dumps / "wall_bottom.dump", WALL_COLUMNS, np.empty((0, 9)), STEPS)
    record = {
        "n_steps": STEPS,
        "wall_time_s": 2.0,
        "n_ranks": 3,
        "end_reason": "end_time",
        "versions": {"lammps": "1"},
    }
    (directory / "run.json").write_text(json.dumps(record))
    return directory


def dents_of(case, packing, struck, law, dent) -> dict[str, np.ndarray]:
    """Columns of contacts.dump."""
    pairs = packing.contacts
    ends = (
        packing.positions[np.searchsorted(packing.ids, pairs)]
        if len(pairs)
        else np.empty((0, 2, 3))
    )
    distance = np.linalg.norm(
        ends.mean(axis=1) - packing.positions[np.searchsorted(packing.ids, struck)], axis=1
    )
    unit = law.yield_overlap if math.isfinite(law.yield_overlap) else 1e-6
    before = np.full(len(pairs), case.contact.initial_overlap)
    peak = np.maximum(dent * unit * np.exp(-(distance / DIAMETER - 0.5) / REACH), before)
    first = distance / 1000.0
    yielded = {"hertz": peak < 0, "bilinear": peak > 0}.get(
        law.name, peak > np.maximum(before, law.yield_overlap)
    )

    def of(function, overlaps):
        return np.atleast_1d(function(overlaps)) if len(pairs) else np.empty(0)

    lost = of(law.dissipated_energy, peak) - of(law.dissipated_energy, before)
    zeros = np.zeros(len(pairs))
    columns = [
        pairs[:, 0],
        pairs[:, 1],
        zeros - 1e-7,
        zeros,
        peak,
        of(law.loading_force, peak),
        zeros,
        lost,
    ]
    columns += [first, first + 2e-6, np.where(yielded, first + 1e-6, -1.0), zeros + 1]
    found = dict(zip(CONTACT_COLUMNS.split(), columns, strict=True))
    if case.has_friction:
        found |= dict(zip(FRICTION_COLUMNS.split(), (zeros, zeros, RUBBED * lost), strict=True))
    return found | ({"initial": before} if case.has_initial_dents else {})


def write_frames(path: Path, positions, contacts, ids, steps: Sequence[int] = (0, 250, 500, 1000)):
    """Snapshots, with rows from the last ID to the first."""
    n = len(positions)
    ends = np.searchsorted(ids, np.stack([contacts["i"], contacts["j"]], axis=1))
    peak_force, peak_overlap, lost, rubbed = np.zeros((4, n))
    for column in range(2):
        np.maximum.at(peak_force, ends[:, column], contacts["peak_force"])
        np.maximum.at(peak_overlap, ends[:, column], contacts["peak_overlap"])
        np.add.at(lost, ends[:, column], 0.5 * contacts["dissipated"])
        np.add.at(rubbed, ends[:, column], 0.5 * contacts.get("friction", np.zeros(len(ends))))
    path.unlink(missing_ok=True)
    columns = FRAME_COLUMNS + (" elastic_tangential friction" if "friction" in contacts else "")
    for m, step in enumerate(steps):
        shift = np.stack([m * ids * 1e-9, 0 * ids, np.full(n, m * 1e-9)], axis=1)
        grown = min(step / STEPS * 2, 1.0)
        rows = np.column_stack(
            [ids, np.ones(n), np.full(n, DIAMETER / 2), positions + shift, shift, shift * 1e6,
             0.1 * peak_force * (m > 0), grown * peak_force, grown * peak_overlap, grown * lost, 0.1 * lost * (m > 0),
             0.01 * lost, grown * rubbed]
        )  # fmt: skip
        write_custom(path, columns, rows[::-1, : len(columns.split())], step, append=True)


def write_ledger(path: Path, lost: float, law, rubbed: float = 0.0) -> None:
    """Energy record of 251 rows with an energy balance error of `BALANCE`; three quarters of the
    input are dissipated.
    """
    unit = law.yield_force * law.yield_overlap if math.isfinite(law.yield_overlap) else 1e-3
    given = (lost + rubbed) / 0.75 if lost else 8000 * unit
    share = np.linspace(0, 1, 251)
    dissipated = (lost + rubbed) * share
    elastic = 0.1 * given * share * (1 - share)
    kinetic = given - dissipated - elastic
    kinetic[100] += BALANCE * given
    zeros = np.zeros_like(share)
    step = np.rint(share * STEPS)
    rows = [step, step * TIMESTEP, kinetic, elastic, dissipated, zeros, zeros, zeros + given]
    rows += [zeros, zeros, zeros, zeros, 5.0 - 5.5 * share]
    names = (
        "step time kinetic elastic dissipated elastic_wall dissipated_wall input contacts_yielded beyond_law "
        "beyond_half largest_force struck_velocity"
    )
    if rubbed:
        names += " rotational elastic_tangential friction"
        rows += [0.1 * kinetic, 0.1 * elastic, rubbed * share]
    write_table(path, names, np.stack(rows, axis=1))


def write_table(path: Path, names: str, rows: np.ndarray) -> None:
    """Table in the format of fix ave/time."""
    lines = [" ".join([f"{row[0]:.0f}", *(f"{value:.17g}" for value in row[1:])]) for row in rows]
    path.write_text("\n".join(["# title", f"# {names}", *lines]) + "\n")


def write_local(path: Path, rows: np.ndarray, columns: str = CONTACT_COLUMNS) -> None:
    """Snapshot in the format of dump local."""
    _write(path, "ENTRIES", columns, rows, STEPS, append=False)


def write_custom(
    path: Path, columns: str, rows: np.ndarray, step: int, append: bool = False
) -> None:
    """Snapshot in the format of dump custom."""
    _write(path, "ATOMS", columns, rows, step, append)


def _write(path: Path, what: str, columns: str, rows: np.ndarray, step: int, append: bool) -> None:
    with open(path, "a" if append else "w") as file:
        file.write(f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF {what}\n{len(rows)}\n")
        file.write(
            "ITEM: BOX BOUNDS mm mm mm\n" + "-1.0e-02 1.0e-01\n" * 3 + f"ITEM: {what} {columns} \n"
        )
        for row in rows:
            file.write(" ".join(f"{value:.17g}" for value in row) + " \n")
