"""Impacts on packings compared with our second solver.

The second solver is a network of contacts in numpy that shares no code with granwave. It computes
the reference impact with the initial contact normals and a fixed last layer, and a packing of 12 ×
12 × 8 with true and with initial normals, over 0.2 ms. The reference impact is run with the same
normals and bottom, and with the rigid wall and the current normals of the case.
"""

import csv
from pathlib import Path

import granwave as gw

BY = "our second solver"
TABLE = Path(__file__).with_name("second_solver.csv")
NORMALS = {"current": "true", "initial": "of the start"}  # names in a case and in the table
REFERENCE = ("reference", 5.0, "of the start")
#: Ends of the quantities of the reference impact, and remarks, by the normals of the run.
SYSTEMS = {
    "initial": (
        ", fixed last layer and initial normals",
        "The run has initial normals and a fixed last layer, as the second solver has.",
    ),
    "current": (
        ", rigid wall and current normals",
        "The second solver has initial normals and a fixed last layer. The rows with the same "
        "normals and bottom show how much of the difference they cause.",
    ),
}


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
    found = {run.case.contact.normals: run for run in runs if is_reference(run)}
    for normals in SYSTEMS:
        if normals in found:
            yield from rows_of_reference(found[normals])
    for run in sorted(runs, key=lambda run: (run.case.contact.normals, run.case.load.velocity)):
        if not is_reference(run):
            yield row_of_small_packing(run)


def rows_of_reference(run):
    values = second_solver()[REFERENCE]
    end, remark = SYSTEMS[run.case.contact.normals]
    sphere = {"shape": "sphere", "diameter": 0.01, "material": "brass"}
    _, yield_force = gw.contact_yield("elastoplastic", [sphere, sphere])
    of_force = f"{remark} F_y = {yield_force:.4g} N for spheres of 10 mm."
    # fmt: off
    peak_force = run["peak_force_N"] / yield_force
    for what, unit, ours, name, words in (
        ("Dissipated fraction", "", run["dissipated_fraction"], "dissipated_fraction", remark),
        ("Peak contact force", "F_y", peak_force, "peak_force_F_y", of_force),
        ("Yielded contacts", "", run["n_plastic_contacts"], "yielded_contacts", remark),
    ):
        yield gw.Row(f"{what}{end}", unit, ours=ours, theory=float(values[name]), where=BY,
                     remark=words, verification=True)
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
