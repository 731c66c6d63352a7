"""Switch with yielding contacts.

This study goes beyond the source, whose contacts are elastic: open gaps with 2 and 10 cylinders,
plates without friction, and impacts on the first sphere at 0.8 and 4 m/s.
"""

from switch_row import SwitchRow

import granwave as gw


def rows(runs):
    found = {(row.case.contact.law, row.speed, row.n): row for row in map(SwitchRow, runs)}
    for (law, velocity, n), row in sorted(found.items()):
        if law != "hertz":
            name = f"{n} cylinders, open gaps, {law}, {velocity:g} m/s"
            elastic = found["hertz", velocity, n]
            yield gw.Row(
                f"First peak at sphere 21, {name}",
                "N",
                ours=row.first[1],
                where="not in the source",
            )
            yield gw.Row(
                f"First peak relative to elastic contacts, {name}",
                    ours=row.first[1] / elastic.first[1],
                where="not in the source",
            )  # fmt: skip
