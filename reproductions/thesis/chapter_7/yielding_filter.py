"""Filter with yielding contacts.

Beyond the source, whose contacts are elastic: sphere 20 of a pressed row is struck at 1 and 5 m/s,
with contacts that yield and elastic ones. Grains that yield rattle behind the front: there the
peaks of contacts have little meaning.
"""

from filter_row import FilterRow

import granwave as gw

# m/s: largest impact velocity of yielding rows; peaks over the force of the walls
RATTLES = 1.0
LITTLE = 0.25
RATTLING = "Grains that rattle behind the front decide: it changes much with the timestep."


def rows(runs):
    found = {(row.speed, row.yields): row for row in map(FilterRow, runs)}
    for velocity in sorted({velocity for velocity, _ in found}):
        elastic = found[velocity, False]
        row = found[velocity, True]
        name = f"{row.name}, {row.case.contact.law}, {velocity:g} m/s"
        for contact in (21, 31, 61, 101):
            peak = row.peaks[contact - 1]
            remark = f"Elastic: {elastic.peaks[contact - 1]:.4g} N."
            share = peak / row.wall_force
            rattles = velocity <= RATTLES and share < LITTLE
            yield gw.Row(
                f"Peak force at contact {contact}, {name}", "N", ours=peak, where="not in the source",
                remark=f"{remark} {RATTLING}" if rattles else remark,
                digits=1 if rattles else 2 if velocity <= RATTLES and share < 1 else 4,
            )  # fmt: skip
        yield gw.Row(
            f"Force of a wall after the wave over that before, {name}", ours=row.kept, where="not in the source",
            remark="What the wave has left of the precompression of the whole row, and with it of the filter; elastic: "
            f"{elastic.kept:.3g}.", digits=3,
        )  # fmt: skip
