"""Studies by the name that a scan or suite file gives: ``study = "solitary-wave"``.

A study is a module with

    TITLE, TEXT                        title, and what was run in a few sentences; or `title(group)`, `text(group)`
    select(runs) -> list of groups     the runs that it is about, put together; a study is made of each group
    rows(group) -> Row ...             the table "source against ours"
    pictures(group) -> Picture ...     figures with captions

and, where they are wanted, `name(group)` (short, for links and files), `tables(group)` and
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
    "precompressed-small-pulses": "precompression.small_pulses",
    "precompressed-waves": "precompression.solitary_waves",
    "precompressed-transition": "precompression.transition",
    "precompressed-packing-speed": "precompression.packing_speed",
    "precompressed-impact": "precompression.packing_impact",
    "settled-packing": "precompression.settled",
    "preconditioned": "precompression.preconditioned",
    "repeated-hits": "precompression.hits",
    "protected-height": "protection.heights",
    "protected-bottoms": "protection.bottoms",
    "protected-spectrum": "protection.spectrum",
    "protected-checks": "protection.checks",
}
