"""Results of all suites as they are stored: ``docs/explanation/results.json``, and the page and README made of it.

A suite has its date, versions, and studies; suites without rows are named. A study has its rows, each of one kind (a
source, theory, a verification of the code, or granwave alone), and its own tables. Nothing of the page is typed: it is
made from the stored results alone.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.document.cells import significant, tidied
from granwave.analysis.document.model import Block, Cell, Column, Group, Note, Report, Section, Table, cleaned
from granwave.analysis.reports.studies import row_tables
from granwave.analysis.reports.writers import markdown
from granwave.analysis.studies.study import Row, Study, record_of
from granwave.lammps_inputs.files import replace_text

ROOT = Path(__file__).parents[2]
STORED = ROOT / "docs" / "explanation" / "results.json"
PAGE = STORED.with_suffix(".md")
README = ROOT / "README.md"
_TITLE = "Results against the sources"
_LEAD = (
    "Made from finished runs by make results, and not typed. Thesis is R. K. Pal, University of Illinois at "
    "Urbana-Champaign, 2015; composite chain is the paper on chains of steel with brass or PTFE; square packing is "
    "Leonard, Fraternali, Daraio, Exp. Mech.; lateral constraints is J. Appl. Mech. 2020, doi 10.1115/1.4047004. "
    "Rows are of four kinds. A source is printed in the literature. Theory follows "
    "from equations. A verification tests the code and not a source: a second solver, a check value, a formula "
    "or what similarity forces on any correct code; our second solver and our second program share no code with "
    "granwave. The rest is granwave alone. Where ours is missing, only source and theory speak. A bound is all that a "
    "source tells there: the end of an axis, or at most; no difference is given."
)
_BLOCK = re.compile(r"(<!-- results -->\n)(.*?)(<!-- /results -->)", re.DOTALL)
_KINDS = {"source": "source", "theory": "theory", "verification": "verification", "alone": "granwave alone"}
_REFERENCE = "second_solver"
#: The ten results of the README: what is before the quantity, suite, study, starts of the quantities (the first such
#: rows). Several rows share a line, and the words before are then all that names it.
CHOSEN = (
    ("Reference impact: ", "fcc-impact", _REFERENCE, ("Dissipated fraction",)),
    ("Reference impact: ", "fcc-impact", _REFERENCE, ("Peak contact force",)),
    ("Elastic chain, 40 N for 10 ms: ", "thesis-4", "long_load", ("Peak force",)),
    ("Bilinear chain, long load: ", "thesis-4", "bilinear_long_load", ("F2, force",)),
    (
        "Composite chain, steel with 3 and with 24 beads of brass: speed of the wave through these",
        "composite-chains",
        "contact_losses",
        ("V, N2 = 3, brass-composite, restitution 0.97", "V, N2 = 24, brass-composite, restitution 0.97"),
    ),
    ("Square packing: ", "square-packing", "square-in-plane", ("Energy in central chains",)),
    (
        "Square packing, out-of-plane: energy in central chains, strikers, struck spheres",
        "square-packing",
        "square-out-of-plane",
        ("Energy in central chains", "Energy in strikers", "Energy in struck spheres"),
    ),
    ("Row with gaps: ", "thesis-8", "no_cylinders", ("Displacement of sphere 10 in a long row, at rest again",)),
    (
        "Chain of two materials, 20 N: edges of its band gap, sqrt(2 k/M) and sqrt(2 k/m)",
        "bands",
        "bands",
        ("Top of the acoustic band, sqrt(2 k/M)", "Bottom of the optical band, sqrt(2 k/m)"),
    ),
    ("FCC packing: ", "prestress", "packing_speed", ("Speed of small waves, fcc, uniaxial",)),
)


def read_stored(path: Path = STORED) -> dict[str, Any]:
    """Read the stored results; those of no suite if there is no file."""
    if not path.is_file():
        return {"suites": {}}
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def write_all(stored: Mapping[str, Any]) -> None:
    """Write the JSON file, the page and the README's block."""
    replace_text(STORED, json.dumps(stored, indent=1, ensure_ascii=False) + "\n")
    replace_text(PAGE, page_of(stored))
    text = README.read_text(encoding="utf-8")
    replace_text(README, with_block(text, readme_table(stored)))


def as_stored(study: Study) -> dict[str, Any]:
    """Return a study for the JSON file: numbers of its rows in full, its own tables as text."""
    return {
        "title": study.title,
        "text": study.text,
        "verdict": list(study.verdict),
        "rows": [record_of(row) | {"digits": row.digits, "bound": row.bound} for row in study.rows],
        "tables": [_table(one) if isinstance(one, Table) else one.text for one in study.tables],
    }


def row_of(record: Mapping[str, Any]) -> Row:
    """Return a stored row."""
    return Row(
        record["quantity"],
        record["unit"],
        record["source"],
        record["granwave"],
        record["where"],
        record["remark"],
        record["theory"],
        record["kind"] == "verification",
        record["digits"],
        record.get("bound", False),
    )


def page_of(stored: Mapping[str, Any]) -> str:
    """Return the page of all stored results."""
    sections = tuple(_section(name, suite) for name, suite in stored["suites"].items())
    if absent := stored.get("absent"):
        note = Note(f"No rows are stored of: {', '.join(absent)}. Nothing is said of them here.")
        sections += (Section("Not run", "not-run", (note,)),)
    text, _ = markdown(cleaned(tidied(Report(_TITLE, _LEAD, sections))), "")
    return text


def chosen_rows(stored: Mapping[str, Any]) -> Iterator[tuple[str, list[Row]]]:
    """Name and rows of each line of the README; no rows if the stored results lack one of them."""
    for before, suite, study, starts in CHOSEN:
        records = stored["suites"].get(suite, {}).get("studies", {}).get(study, {}).get("rows", ())
        found = [next((row_of(one) for one in records if one["quantity"].startswith(start)), None) for start in starts]
        rows = [row for row in found if row is not None and row.ours is not None]
        name = before + rows[0].quantity if len(starts) == 1 and rows else before
        yield name, rows if len(rows) == len(starts) else []


def readme_table(stored: Mapping[str, Any]) -> str:
    """Return the README's table."""
    lines = ["| quantity | what it is compared with | value | granwave | remark |", "|---|---|---|---|---|"]
    for name, rows in chosen_rows(stored):
        if rows:
            against = [row.theory if row.source is None else row.source for row in rows]
            values = ", ".join("-" if one is None else significant(one, 5) for one in against)
            ours = ", ".join(significant(row.ours, row.digits) for row in rows)
            unit = f" {rows[0].unit}" if rows[0].unit else ""
            what = f"{_KINDS[rows[0].kind]}: {rows[0].where}".removesuffix(": ")
            sentences = [one for row in rows if row.remark for one in row.remark.removesuffix(".").split(". ")]
            remark = "".join(f"{one}. " for one in dict.fromkeys(sentences)).rstrip()
            lines.append(f"| {name} | {what} | {values}{unit} | {ours}{unit} | {remark} |")
    return "\n".join(lines) + "\n"


def with_block(text: str, table: str) -> str:
    """Return a text whose block of results is replaced.

    Raises
    ------
    ValueError
        It has no such block.
    """
    if not _BLOCK.search(text):
        raise ValueError("found no block between <!-- results --> and <!-- /results -->")
    return _BLOCK.sub(lambda found: f"{found[1]}{table}{found[3]}", text)


def _section(name: str, suite: Mapping[str, Any]) -> Section:
    kinds = [row["kind"] for study in suite["studies"].values() for row in study["rows"]]
    counts = ", ".join(f"{kinds.count(kind)} {word}" for kind, word in _KINDS.items() if kind in kinds)
    versions = ", ".join(f"{program} {'/'.join(found)}" for program, found in suite["versions"].items())
    state = "" if suite["complete"] else " Not all of its runs are done."
    blocks: list[Block] = [Note(f"Command: {suite['command']}. Last run on {suite['date']}, with {versions}.{state}")]
    if counts:
        blocks.append(Note(f"Rows: {counts}."))
    for study in suite["studies"].values():
        found = Study("", study["title"], "", tuple(map(row_of, study["rows"])))
        notes = [Note(text) for text in (study["text"], *study["verdict"]) if text]
        tables = [Note(one) if isinstance(one, str) else _read_table(one) for one in study["tables"]]
        parts = (*notes, *row_tables(found), *tables)
        if len(parts) > len(notes):
            blocks.append(Group(study["title"], parts))
    return Section(suite["title"], name, tuple(blocks))


def _table(table: Table) -> dict[str, Any]:
    columns = [[column.heading, column.unit, column.numeric] for column in table.columns]
    return {"caption": table.caption, "columns": columns, "rows": [[cell.text for cell in row] for row in table.rows]}


def _read_table(stored: Mapping[str, Any]) -> Table:
    columns = tuple(Column(heading, unit, numeric=numeric) for heading, unit, numeric in stored["columns"])
    rows: Sequence[Sequence[str]] = stored["rows"]
    return Table(stored["caption"], columns, tuple(tuple(map(Cell, row)) for row in rows))
