"""Studies by the name that a scan or suite file gives: ``study = "solitary-wave"``.

A study is a module with

    TITLE                              title, unless there is a function `title`
    select(runs) -> list of groups     the runs that it is about, put together; a study is made of each group
    text(group) -> str                 what was run, in a few sentences
    rows(group) -> Row ...             the table "source against ours"
    pictures(group) -> Picture ...     figures with captions

and, where they are wanted, `title(group)`, `name(group)` (short, for links and files), `tables(group)` and
`verdict(group)`. A group is whatever `select` makes of the runs. `make_studies` in `study` puts it together.
"""

from __future__ import annotations

#: Module of each study, below this package, in the order of a report.
STUDIES: dict[str, str] = {
    "square-impact": "square.impact",
    "square-wave-speed": "square.wave_speed",
    "square-yielding": "square.yielding",
    "sensors-in-square": "square.sensors",
    "directional": "square.directional",
    "sensor-chain": "square.sensor_chain",
}
