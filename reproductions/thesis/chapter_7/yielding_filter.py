"""Filter with yielding contacts.

This study goes beyond the source, whose contacts are elastic. The impact on sphere 20 of a pressed
chain is at 1 and 5 m/s, with yielding and with elastic contacts. In the yielding chain grains
rattle behind the front, where the peaks of contacts have little meaning.
"""

from filter_row import FilterRow

import granwave as gw

# m/s: largest impact velocity of yielding rows; peaks / force of the walls
RATTLES = 1.0
LITTLE = 0.25
RATTLING = (
    "The value is due to rattling grains behind the front, and depends strongly on the timestep."
)


def rows(runs):
    found = {(row.speed, row.yields): row for row in map(FilterRow, runs)}
    for velocity in sorted({velocity for velocity, _ in found}):
        elastic = found[velocity, False]
        row = found[velocity, True]
        name = f"{row.name}, {row.case.contact.law}, {velocity:g} m/s"
        for contact in (21, 31, 61, 101):
            peak = row.peaks[contact - 1]
            remark = f"The elastic chain has {elastic.peaks[contact - 1]:.4g} N."
            share = peak / row.wall_force
            rattles = velocity <= RATTLES and share < LITTLE
            yield gw.Row(
                f"Peak force at contact {contact}, {name}", "N", ours=peak, where="not in the source",
                remark=f"{remark} {RATTLING}" if rattles else remark,
                digits=1 if rattles else 2 if velocity <= RATTLES and share < 1 else 4,
            )  # fmt: skip
        yield gw.Row(
            f"Force of a wall after / before the wave, {name}", ours=row.kept, where="not in the "
                                                                                     "source",
            remark="The value shows how much of the precompression of the chain, and thus of the "
                   f"filter, remains after the wave. The elastic chain has {elastic.kept:.3g}.", digits=3,
        )  # fmt: skip
