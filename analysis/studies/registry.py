"""Studies by the name that a scan or suite file gives: ``study = "tolerance"``.

A study is a module with

    TITLE, TEXT                        title, and what was run in a few sentences; or `title(group)`, `text(group)`
    select(runs) -> list of groups     the runs that it is about, put together; a study is made of each group
    rows(group) -> Row ...             tables of ours against a source, against theory, as a verification, and alone
    pictures(group) -> Picture ...     figures with captions

and, where they are wanted, `title(group)`, `name(group)` (short, for links and files), `tables(group)` (with notes on
them) and `verdict(group)`. `missing(group, undone)` are sentences for the end of the verdict about points of its scans
that failed or were not run, as values of the keys that vary. A group is whatever `select` makes of the runs. Without
`name` a study has the name of its entry here; several groups are then numbered, and so are their pictures.
`make_studies` in `study` puts it together.
"""

from __future__ import annotations

#: Module of each study, below this package, in the order of a report.
STUDIES: dict[str, str] = {
    "bands": "bands.simulated",
    "tunable-gap": "bands.tunnel",
    "resonance": "bands.resonance",
    "rectification": "bands.rectification",
    "protected-height": "protection.heights",
    "protected-bottoms": "protection.bottoms",
    "protected-spectrum": "protection.spectrum",
    "protected-checks": "protection.checks",
    "tolerance": "tolerance.study",
    "sphere-contact": "sphere_contact",
}

#: Studies of runs of two finite-element spheres; all others are of packings and chains.
OF_SPHERE_CONTACTS = ("sphere-contact",)

#: Study that every report makes of all its runs, packings and blocks alike, in a section of its own.
COMPARISON: dict[str, str] = {"comparison": "packing_and_block.study"}
