"""Coverage of the four sources: the page ``docs/explanation/coverage.md``, generated from
``reproductions/coverage.csv`` and the stored rows.

    python docs/_ext/results_coverage.py      # the page again; no runs

A line of the table is a system, law, figure or table of a source, which is reproduced, partly
reproduced, or missing with a reason. It names the studies whose rows compare it.
"""

from __future__ import annotations

import csv
import dataclasses
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from results_rows import holds
from results_stored import row_of

from granwave.lammps_inputs.files import replace_text

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "reproductions" / "coverage.csv"
PAGE = ROOT / "docs" / "explanation" / "coverage.md"
STATES = ("works", "partly", "missing")
#: What the page calls the sources, by their names in the table.
SOURCES = {
    "thesis": "Thesis of R. K. Pal, 2015",
    "composite chains": "Paper on chains of steel with brass or PTFE",
    "lateral constraints": "Paper on crystals of soft cylinders between walls",
    "square packing": "Paper on impacts on square packings",
}
_CLOSE = 0.05
_FAR = 0.3


@dataclasses.dataclass(frozen=True)
class Item:
    """A system, law, figure or table of a source.

    Attributes
    ----------
    place
        Figure, table, equation or section of the source.
    state
        One of `STATES`.
    studies
        Pairs of a suite and a study whose rows compare it.
    why
        Missing part, with the reason; empty if everything is reproduced.
    differs
        Remaining differences of more than 10 % of an item that works, with the reason.
    """

    source: str
    place: str
    what: str
    state: str
    studies: tuple[tuple[str, str], ...]
    why: str
    differs: str = ""


def read_items(path: Path = TABLE) -> list[Item]:
    """Read the table."""
    with path.open(encoding="utf-8", newline="") as stream:
        return [_item(row) for row in csv.DictReader(stream)]


def _item(row: Mapping[str, str]) -> Item:
    studies: list[tuple[str, str]] = []
    for name in row["studies"].split():
        suite, _, study = name.partition("/")
        studies.append((suite, study))
    return Item(
        row["source"], row["place"], row["what"], row["state"], tuple(studies), row["why"],
        row["differs"],
    )  # fmt: skip


def write_page(stored: Mapping[str, Any]) -> None:
    """Write the page."""
    replace_text(PAGE, page_of(read_items(), stored))


def page_of(items: Sequence[Item], stored: Mapping[str, Any]) -> str:
    """Return the page: for each source the number of reproduced items, and a table."""
    counts = "\n".join(_count_line(name, _of_source(items, name)) for name in SOURCES)
    parts = [_section(name, _of_source(items, name), stored) for name in SOURCES]
    return f"""# Coverage of the sources

This page lists which parts of the four sources granwave reproduces: their {len(items)} systems,
laws, figures and tables, without sketches and photographs. An item *works* if its content is
computed and compared. It works *partly* if only some of it is, or if the values of the source
are not available, or if a difference from its main statement is not explained. Otherwise it is
*missing*. Items that work can differ from the source; the table then names differences of more
than 10 %. The [pages of results](results.md) in the last column show how well the values agree; the
[errata](errata.md) list misprints.

The sources were read as scanned text, which has the captions of figures but no pictures. No
measured curve could be read off a figure. The comparisons use numbers of the text, ends of axes
and legends.

| source | {" | ".join(STATES)} |
|---|---|---|---|
{counts}
{_count_line("all", items)}

{"".join(parts)}"""


def _of_source(items: Iterable[Item], name: str) -> list[Item]:
    return [item for item in items if item.source == name]


def _count_line(name: str, items: Sequence[Item]) -> str:
    states = [item.state for item in items]
    numbers = [str(states.count(state)) for state in STATES]
    return f"| {SOURCES.get(name, name)} | {' | '.join(numbers)} |"


def _section(name: str, items: Sequence[Item], stored: Mapping[str, Any]) -> str:
    lines = "\n".join(_item_line(item) for item in items)
    return f"""## {SOURCES[name]}

{_agreement(items, stored)}

| place | subject | state | missing part or difference, with the reason | results |
|---|---|---|---|---|
{lines}

"""


def _item_line(item: Item) -> str:
    suites = dict.fromkeys(suite for suite, _ in item.studies)
    links = ", ".join(f"[{suite}](results/{suite}.md)" for suite in suites)
    cells = map(_escaped, (item.place, item.what, item.state, item.why or item.differs))
    return f"| {' | '.join(cells)} | {links} |"


def _escaped(text: str) -> str:
    return re.sub(r"([\\`*_|~#$<>])", r"\\\1", text)


def _agreement(items: Sequence[Item], stored: Mapping[str, Any]) -> str:
    """Return the deviations of our values from the values that the source prints."""
    named: dict[tuple[str, str], None] = {}
    for item in items:
        named |= dict.fromkeys(item.studies)
    rows: list[Mapping[str, Any]] = []
    for suite, study in named:
        stored_rows = stored["suites"][suite]["studies"][study]["rows"]
        rows += [row for row in stored_rows if row["kind"] == "source"]
    off = [abs(row["difference"]) for row in rows if row["difference"] is not None]
    close = sum(one <= _CLOSE for one in off)
    far = sum(one > _FAR for one in off)
    return (
        f"There are {len(rows)} rows with a value of a source. Of these, {close} differ from it by "
        f"at most {100 * _CLOSE:g} %, {len(off) - close - far} by {100 * _CLOSE:g} to "
        f"{100 * _FAR:g} %, and {far} by more. "
        f"The other {len(rows) - len(off)} rows have no difference: they are bounds, the printed "
        f"value is zero, or we computed no value. {_bounds(rows)}".rstrip()
    )


def _bounds(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the sentence on the bounds that hold; empty without bounds."""
    bounds = [row for row in map(row_of, rows) if row.bound]
    if not bounds:
        return ""
    return f"Bounds that hold: {sum(map(holds, bounds))} of {len(bounds)}."


def main() -> None:
    """Write the page from the table and the stored rows."""
    import results_stored

    write_page(results_stored.read_stored())


if __name__ == "__main__":
    main()
