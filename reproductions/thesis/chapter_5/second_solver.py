"""Impacts on packings compared with our second solver.

The second solver is a network of contacts in numpy that shares no code with granwave. It computes
the reference impact with the initial contact normals and a fixed last layer, and a packing of 12 ×
12 × 8 with true and with initial normals, over 0.2 ms.
"""

import csv
from pathlib import Path

import granwave as gw

BY = "our second solver"
TABLE = Path(__file__).with_name("second_solver.csv")
NORMALS = {"current": "true", "initial": "of the start"}  # names in a case and in the table
REFERENCE = ("reference", 5.0, "of the start")


def second_solver():
    """Values of the second solver by packing, velocity and normals; written by ``python -m
    tests.helpers.second_solver``.
    """
    with TABLE.open(encoding="utf-8", newline="") as stream:
        return {
            (row["packing"], float(row["velocity_m_s"]), row["normals"]): row
            for row in csv.DictReader(stream)
        }


def is_reference(run):
    """True for the impact on 72 × 72 × 30 spheres."""
    return run["n_spheres"] == 72 * 72 * 30


def rows(runs):
    for run in runs:
        if is_reference(run):
            yield from rows_of_reference(run)
    for run in sorted(runs, key=lambda run: (run.case.contact.normals, run.case.load.velocity)):
        if not is_reference(run):
            yield row_of_small_packing(run)


def rows_of_reference(run):
    solved = second_solver()
    values = solved[REFERENCE]
    true, fixed = (
        float(solved["small", 5.0, normals]["dissipated_fraction"]) for normals in NORMALS.values()
    )
    start = "Initial normals and a fixed last layer; true normals change the dissipated "
    start += f"fraction of a small packing by {abs(true - fixed):.0e} at 5 m/s"
    sphere = {"shape": "sphere", "diameter": 0.01, "material": "brass"}
    _, yield_force = gw.contact_yield("elastoplastic", [sphere, sphere])
    # fmt: off
    for what, unit, ours, name, remark in (
        ("Dissipated fraction", "", run["dissipated_fraction"], "dissipated_fraction", start),
        ("Peak contact force", "F_y", run["peak_force_N"] / yield_force, "peak_force_F_y",
         f"F_y = {yield_force:.4g} N for spheres of 10 mm"),
        ("Yielded contacts", "", run["n_plastic_contacts"], "yielded_contacts", start),
    ):
        yield gw.Row(what, unit, ours=ours, theory=float(values[name]), where=BY, remark=remark, verification=True)
    # fmt: on


def row_of_small_packing(run):
    """Dissipated fraction compared with the network with the same normals."""
    velocity = run.case.load.velocity
    normals = NORMALS[run.case.contact.normals]
    values = second_solver()["small", velocity, normals]
    return gw.Row(
        f"Dissipated fraction of 12 × 12 × 8 spheres, {velocity:g} m/s, {run.case.contact.normals} normals", digits=5,
        theory=float(values["dissipated_fraction"]), ours=run["dissipated_fraction"], where=BY,
        remark="The bottom is free.", verification=True,
    )  # fmt: skip
