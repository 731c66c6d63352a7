"""Switch: the chain without cylinders (thesis 8.3 and 8.4).

A chain of 27 steel spheres ends on an aluminium block. The impact on the first sphere is at 0.8
m/s, or the first sphere falls from 33 and 42 mm. A chain of 60 spheres is long enough for the full
displacement of a sphere by the wave. A sensor in a sphere measures the mean of its two contact
forces.
"""

from switch_row import SENSORS, SOLVER, STATES, SwitchRow, second_solver

import granwave as gw

FALLS = {0.907766: "42 mm", 0.804649: "33 mm"}  # m/s: height
AXIS = 120.0  # N: end of Figs 8.4 and 8.6
CONTACT = 13  # far from both ends


def rows(runs):
    found = {(len(row.ids), row.speed): row for row in map(SwitchRow, runs) if not row.n}
    row = found[27, 0.8]
    long = found[60, 0.8]
    time, force = row.first
    at_end = {"remark": "The bound is the end of the axis.", "bound": True}
    solver = {"where": "thesis 8", "verification": True}
    solved = second_solver()
    theory = solved[STATES[0], 0.0, 0, 27, 0.8]
    theory_of_long = solved[STATES[0], 0.0, 0, 60, 0.8]
    near, far = (1e6 * theory_of_long[f"sphere_{number}_moved_m"] for number in (10, 25))
    # fmt: off
    yield gw.Row("First peak at sphere 21, no cylinders, at most", "N", AXIS, force, "thesis Fig. 8.6", **at_end)
    for what, unit, ours, value, remark in (
        ("First peak at sphere 21", "N", force, theory["sphere_21_first_N"], ""),
        ("Its time", "us", 1e6 * time, 1e6 * theory["sphere_21_first_s"], ""),
        ("First peak at sphere 6", "N", row.first_peak_at(SENSORS[0])[1], theory["sphere_6_first_N"], ""),
        (f"Force of contact {CONTACT} in the wave", "N", row.of_contacts("peak_force")[CONTACT - 1],
         theory["contact_13_N"], " The mean of two contacts at a sensor is smaller."),
    ):
        yield gw.Row(f"{what}, no cylinders", unit, ours=ours, theory=value, remark=f"{SOLVER}{remark}", **solver)
    for velocity, height in FALLS.items():
        name = f"Peak at sphere 6 of a sphere that fell {height} ({velocity:.3f} m/s)"
        peak = found[27, velocity].first_peak_at(SENSORS[0])[1]
        yield gw.Row(name, "N", ours=peak, remark=SOLVER,
                     theory=solved[STATES[0], 0.0, 0, 27, velocity]["sphere_6_first_N"], **solver)
        yield gw.Row(f"{name}, at most", "N", AXIS, peak, "thesis Fig. 8.4",
                     "The bound is the end of the axis. Our sphere falls freely, the sphere of "
                     "the source along rails, and its sensor is somewhere in the middle of a chain "
                     "of unknown length.", bound=True)
    yield gw.Row("Displacement of sphere 10 in a long chain, after the wave", "um", 13.0,
                 1e6 * long.array("probes/sphere_10_uz")[-1], "thesis 8",
                 "The source states a displacement of about 13. In the second solver the wave "
                 f"itself displaces spheres by {far:.2f} um, and less near the impacted sphere.",
                 near)
    yield gw.Row("Mass of a sphere", "g", 3.0, 1e3 * row.mass, "thesis 8.4",
        "The source states a mass of around 3 g.")
    # fmt: on
