"""Results of all suites as they are stored: ``docs/explanation/results.json``, and the pages and
README made of it.

    python docs/_ext/results_table.py      # pages, picture, README and first page again from the stored rows; no runs

A suite has its date, versions, and studies; suites without rows are named. A study has its rows,
each of one kind (a source, theory, a verification of the code, or granwave alone), and its own
tables. The first page has the most telling rows and a picture of all; each suite has a page of its
own. Nothing of them is typed: all is made from the stored results.
"""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import results_coverage
import results_picture

from granwave.analysis.document.model import (
    Cell,
    DocumentSection,
    DocumentTable,
    Note,
    Report,
    TableColumn,
    cleaned,
    percent,
    significant,
    tidied,
)
from granwave.analysis.reports.report import markdown
from granwave.analysis.reports.studies import row_tables
from granwave.analysis.studies.study import Row, Study, record_of
from granwave.lammps_inputs.files import replace_text

ROOT = Path(__file__).parents[2]
STORED = ROOT / "docs" / "explanation" / "results.json"
PAGE = STORED.with_suffix(".md")
PICTURE = STORED.with_name("agreement.webp")
PAGES = STORED.with_suffix("")  # folder of a page for each suite
README = ROOT / "README.md"
FIRST_PAGE = ROOT / "docs" / "index.md"
PAPER = ROOT / "docs" / "paper" / "paper.md"
_TITLE = "Results against the sources"
_LEAD = (
    "Made from finished runs by make results, and not typed. Thesis is R. K. Pal, University of Illinois at "
    "Urbana-Champaign, 2015; composite chain is the paper on chains of steel with brass or PTFE; square packing is "
    "Leonard, Fraternali, Daraio, Exp. Mech.; lateral constraints is J. Appl. Mech. 2020, doi 10.1115/1.4047004. "
    "Rows are of four kinds. A source is printed in the literature. Theory follows "
    "from equations. A verification tests the code and not a source: a second solver, a check value, a formula "
    "or what similarity forces on any correct code; our second solvers, which stand in tests/helpers, share no code with "
    "granwave. The rest is granwave alone. Where ours is missing, only source and theory speak. A bound is all that a "
    "source tells there: the end of an axis, or at most; no difference is given."
)
#: What the suites are called in the picture and in the list of pages.
LABELS = {
    "bands": "Bands and gaps",
    "benchmarks": "Measurements and tests of others",
    "composite-chains": "Composite chains",
    "losses": "Losses in contacts",
    "lateral": "Plane crystals between walls",
    "prestress": "Precompression",
    "square-packing-sensors": "Square packings: sensors",
    "square-packing": "Square packings",
    "thesis-2": "Thesis 2: elasto-plastic chains",
    "sphere-contacts": "Thesis 2, 3: contact of two spheres",
    "thesis-3": "Thesis 3: elastic bars",
    "thesis-4": "Thesis 4: elastic and bilinear chains",
    "fcc-impact": "Thesis 5: reference impact",
    "thesis-5": "Thesis 5: packings and blocks",
    "confined": "Thesis 6: rows in a tube",
    "thesis-7": "Thesis 7: filters",
    "thesis-8": "Thesis 8: a row that switches",
    "protection": "Protected targets",
    "tolerance": "Tolerance and friction",
}
_ROUNDING = 1e-12  # relative
_LOWER = ("at least", "more than", "Well over")  # words of a bound below
_LARGE = 10.0  # deviation from which on a ratio says more than per cent
_BLOCK = re.compile(r"(<!-- results -->\n)(.*?)(<!-- /results -->)", re.DOTALL)
_KINDS = {
    "source": "source",
    "theory": "theory",
    "verification": "verification",
    "alone": "granwave alone",
}
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
        (
            "V, N2 = 3, brass-composite, restitution 0.97",
            "V, N2 = 24, brass-composite, restitution 0.97",
        ),
    ),
    ("Square packing: ", "square-packing", "square-in-plane", ("Energy in central chains",)),
    (
        "Square packing, out-of-plane: energy in central chains, strikers, struck spheres",
        "square-packing",
        "square-out-of-plane",
        ("Energy in central chains", "Energy in strikers", "Energy in struck spheres"),
    ),
    (
        "Row with gaps: ",
        "thesis-8",
        "no_cylinders",
        ("Displacement of sphere 10 in a long row, at rest again",),
    ),
    (
        "Chain of two materials, 20 N: edges of its band gap, sqrt(2 k/M) and sqrt(2 k/m)",
        "bands",
        "bands",
        ("Top of the acoustic band, sqrt(2 k/M)", "Bottom of the optical band, sqrt(2 k/m)"),
    ),
    ("FCC packing: ", "prestress", "packing_speed", ("Speed of small waves, fcc, uniaxial",)),
)
#: Further rows of the first page of results, in the same form; a name that ends in nothing is the quantity alone.
MORE = (
    (
        "FCC packing: ",
        "bands",
        "bands",
        ("Ridge of the transform at 0.5 of the zone, FCC, 1e+06 Pa",),
    ),
    ("", "bands", "resonance", ("Bead on a plane, 0.02 N: frequency of the largest velocity",)),
    (
        "Chain under a static force: ",
        "benchmarks",
        "chains_precompressed",
        ("Speed over c0, force added 129 times 1 N",),
    ),
    (
        "Measured: ",
        "benchmarks",
        "chains_brass_teflon",
        ("Speed in brass over speed in PTFE, impact at 1 m/s",),
    ),
    (
        "Chain in gravity: ",
        "benchmarks",
        "chains_gravity",
        ("Power of the speed with the depth, beads 60 to 180",),
    ),
    (
        "Sphere on a plane: ",
        "benchmarks",
        "impacts_oblique",
        ("Spin measured at 10.87 degrees, oxide, partial slip",),
    ),
    (
        "",
        "benchmarks",
        "impacts_plane",
        ("Test 5, spin of finite elements at incidence 2.28, partial slip",),
    ),
    ("", "benchmarks", "impacts_plastic", ("Power of restitution, 1 to 10 m/s, thornton",)),
    (
        "Homogeneous chain: ",
        "composite-chains",
        "homogeneous_chain",
        ("Peak force; source: mesh 0.01 to 0.02 mm",),
    ),
    ("", "losses", "loss", ("Restitution at 10 m/s, time 0.3 µs",)),
    ("", "lateral", "crystals", ("Front speed of BCC over that of HCP, crystals of 40",)),
    ("Precompressed chain: ", "prestress", "waves", ("Speed of the wave, F_m/F0 = 28.57",)),
    (
        "",
        "square-packing-sensors",
        "defects",
        ("Power of the wave speed with the force, square struck in its plane, scatter",),
    ),
    (
        "Elasto-plastic chain: ",
        "thesis-2",
        "elastoplastic_decay",
        ("Power of the peak force with distance, contacts 15",),
    ),
    (
        "",
        "sphere-contacts",
        "sphere_contact",
        ("Finite elements over the law from 10 alpha_y to 0.2 R*: least, brass, like",),
    ),
    ("Elastic bar: ", "thesis-3", "split_hopkinson", ("Speed, split-hopkinson",)),
    ("Elastic chain, 40 N for 10 ms: ", "thesis-4", "long_load", ("Speed of the front",)),
    (
        "Bilinear chain, short pulse: ",
        "thesis-4",
        "bilinear_pulse",
        ("Factor of sqrt(1 - beta) in 4.22, beta 0.7",),
    ),
    (
        "FCC packing: ",
        "thesis-5",
        "packings",
        ("Dissipated share of 7 struck spheres over that of one",),
    ),
    (
        "Row in a tube: ",
        "confined",
        "confined_scaling",
        ("Power of the speed with the velocity, n = 8",),
    ),
    ("Filter: ", "thesis-7", "peaks", ("Beads that the leading wave spans at contact 121",)),
    (
        "Switch: ",
        "thesis-8",
        "switch",
        ("First peak at sphere 21, open gaps, 2 cylinders, friction 0",),
    ),
    ("Sphere on a target: ", "protection", "protected-checks", ("Peak force, rigid wall",)),
)
#: Measurements of others on the first page of the site.
MEASURED = (
    (
        "Tangential restitution of a sphere of aluminium oxide on glass, 20.22 degrees",
        "benchmarks",
        "impacts_oblique",
        ("Tangential restitution measured at 20.22 degrees, oxide, partial slip",),
    ),
    (
        "Composite chain, steel with 3 and with 24 beads of brass: speed of the wave through these",
        "composite-chains",
        "contact_losses",
        (
            "V, N2 = 3, brass-composite, restitution 0.97",
            "V, N2 = 24, brass-composite, restitution 0.97",
        ),
    ),
    (
        "Speed of the wave in a chain of brass beads over that in PTFE",
        "benchmarks",
        "chains_brass_teflon",
        ("Speed in brass over speed in PTFE, impact at 1 m/s",),
    ),
)
#: Rows of the paper, with what the quantity is called there; a few columns, as its page is narrow.
IN_PAPER = (
    ("Dissipated share, 155 520 brass spheres", *CHOSEN[0][1:]),
    ("Force of a bilinear chain once its fronts have met", *CHOSEN[3][1:]),
    ("Energy in the central chains of a square packing", *CHOSEN[5][1:]),
    ("Speed of small waves in a compressed FCC packing", *CHOSEN[9][1:]),
    (
        "Speed over that of sound, precompressed chain",
        "benchmarks",
        "chains_precompressed",
        ("Speed over c0, force added 129",),
    ),
    ("Tangential restitution at 20.22 degrees, measured", *MEASURED[0][1:]),
    (
        "Speed in a brass section of a steel chain, measured",
        "composite-chains",
        "contact_losses",
        MEASURED[1][3][:1],
    ),
)


def read_stored(path: Path = STORED) -> dict[str, Any]:
    """Read the stored results; those of no suite if there is no file."""
    if not path.is_file():
        return {"suites": {}}
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def write_all(stored: Mapping[str, Any]) -> None:
    """Write the JSON file, the pages, the picture, and the blocks of the README and of the site's
    first page.
    """
    replace_text(STORED, json.dumps(stored, indent=1, ensure_ascii=False) + "\n")
    write_pages(stored)


def write_pages(stored: Mapping[str, Any]) -> None:
    """Write what is made of the stored results."""
    pages = pages_of(stored)
    PAGES.mkdir(exist_ok=True)
    for old in set(PAGES.glob("*.md")) - set(pages):
        old.unlink()
    for page, text in pages.items():
        replace_text(page, text)
    for picture in (PICTURE, PAPER.with_name("agreement.png")):
        if not picture.is_file() or results_picture.digest_of(picture) != results_picture.digest(
            stored, LABELS
        ):
            results_picture.draw(stored, LABELS, picture)
    results_coverage.write_page(stored)
    for page, table in tables_elsewhere(stored).items():
        replace_text(page, with_block(page.read_text(encoding="utf-8"), table))


def tables_elsewhere(stored: Mapping[str, Any]) -> dict[Path, str]:
    """Return the tables of pages that are written by hand."""
    return {
        README: table_of(chosen_rows(stored)),
        FIRST_PAGE: table_of(chosen_rows(stored, MEASURED)),
        PAPER: _of_paper(stored),
    }


def _of_paper(stored: Mapping[str, Any]) -> str:
    """Return the sentence on all rows, and the table, of the paper."""
    shown = results_picture.points(stored)
    parts = []
    for kind, (name, _) in results_picture.KINDS.items():
        offs = [abs(off) for _, _, of, off in shown if of == kind]
        close = [sum(off <= limit for off in offs) for limit in (0.01, 0.1)]
        parts.append(
            f"of {len(offs)} values of kind *{name}*, {close[0]} agree within 1 % and {close[1]} within 10 %"
        )
    text = "; ".join(parts)
    lines = ["| quantity | kind | other | granwave | difference |", "|---|---|---|---|---|"]
    for name, (row, *_) in chosen_rows(stored, IN_PAPER):
        against = row.theory if row.source is None else row.source
        unit = f" {row.unit}" if row.unit else ""
        values = significant(against, 5), significant(row.ours, min(row.digits, 5))
        lines.append(
            f"| {name} | {_KINDS[row.kind]} | {values[0]}{unit} | {values[1]}{unit} | {_difference(row)} |"
        )
    return "\n".join([f"{text[:1].upper()}{text[1:]}.", "", *lines]) + "\n"


def as_stored(study: Study) -> dict[str, Any]:
    """Return a study for the JSON file: numbers of its rows in full, its own tables as text."""
    return {
        "title": study.title,
        "text": study.text,
        "verdict": list(study.verdict),
        "rows": [record_of(row) | {"digits": row.digits, "bound": row.bound} for row in study.rows],
        "tables": [
            _table(one) if isinstance(one, DocumentTable) else one.text for one in study.tables
        ],
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


def pages_of(stored: Mapping[str, Any]) -> dict[Path, str]:
    """Return the first page of results, and that of each suite."""
    pages = {PAGES / f"{name}.md": _suite_page(suite) for name, suite in stored["suites"].items()}
    return {PAGE: _first_page(stored), **pages}


def _first_page(stored: Mapping[str, Any]) -> str:
    """Return the page with the most telling rows, the picture of all, what is far off, and the list
    of the others.
    """
    names = [name for name in stored["suites"]]
    lines = sorted(zip((*CHOSEN, *MORE), chosen_rows(stored, (*CHOSEN, *MORE)), strict=True),
                   key=lambda pair: names.index(pair[0][1]) if pair[0][1] in names else len(names))  # fmt: skip
    table = table_of((line for _, line in lines), [f"results/{entry[1]}.md" for entry, _ in lines])
    counts = {name: _counts(suite) for name, suite in stored["suites"].items()}
    pages = "\n".join(
        f"| {_link(name)} | {stored['suites'][name]['title']} | {counts[name]} |" for name in names
    )
    absent = stored.get("absent", ())
    note = (
        f"\nNo rows are stored of: {', '.join(absent)}. Nothing is said of them here.\n"
        if absent
        else ""
    )
    shown = results_picture.points(stored)
    number = sum(
        len(study["rows"])
        for suite in stored["suites"].values()
        for study in suite["studies"].values()
    )
    bounds: list[tuple[str, Row]] = []
    for name, suite in stored["suites"].items():
        for study in suite["studies"].values():
            bounds += [(name, row_of(row)) for row in study["rows"] if row.get("bound")]
    outside = [(name, row) for name, row in bounds if beyond(row)]
    tree = "\n".join(f"{LABELS.get(name, name)} <results/{name}>" for name in names)
    return f"""# {_TITLE}

```{{index}} ! validation, ! comparison with experiments
```

{_LEAD}

## All agreements

![Difference of each value of ours from what it is compared with, by suite and kind](agreement.webp)

*Each point is one of the {len(shown)} values that are compared: ours over that of the source, of theory, or what the
code must give, less 1, on a logarithmic axis. Full: ours is larger; open: smaller. The grey area begins at 10 %. Points
at the left edge are smaller still, those at the right edge larger. Rows that have only a bound, or nothing to be
compared with, are left out. Letters: the list below.*

## Rows that tell most

Of {number} rows, these {len(lines)} tell most; all of them, agreeing or not, are on [pages of their own](#all-rows).

{table}
## What lies further off than {_percent(results_picture.FAR)}

A value may differ because a source has a misprint ([errata](errata.md)), because a formula does not hold there, or
because granwave lacks something ([limits](limits.md)). Each letter is a study with such values; the remark is that of
the furthest.

| | study | compared with | how many | difference | remark on the furthest |
|---|---|---|---|---|---|
{_far_rows(stored)}
## Beyond a bound

Of {len(bounds)} values that a source only bounds, {len(outside)} lie outside.

| quantity | bound | granwave | beyond by |
|---|---|---|---|
{_outside_rows(outside)}
## All rows

| page | what | rows |
|---|---|---|
{pages}
{note}
```{{toctree}}
:hidden:

{tree}
```
"""


def _far_rows(stored: Mapping[str, Any]) -> str:
    lines = []
    for one in results_picture.far_off(stored):
        ends = dict.fromkeys(
            percent(100 * off) if abs(off) < _LARGE else _factor(off)
            for off in (one.least, one.most)
        )
        link = f"[{_escaped(one.title)}](results/{one.suite}.md)"
        number = f"{one.number} of {one.total}"
        cells = [
            f"**{one.mark}**",
            link,
            _KINDS[one.kind],
            number,
            " to ".join(ends),
            _escaped(one.why),
        ]
        lines.append(f"| {' | '.join(cells)} |\n")
    return "".join(lines)


def _outside_rows(outside: Iterable[tuple[str, Row]]) -> str:
    lines = []
    for name, row in outside:
        unit = f" {row.unit}" if row.unit else ""
        cells = [
            f"[{_escaped(row.quantity)}](results/{name}.md)",
            f"{significant(row.source, 5)}{unit}",
            f"{significant(row.ours, row.digits)}{unit}",
            _excess(beyond(row)),
        ]
        lines.append(f"| {' | '.join(cells)} |\n")
    return "".join(lines)


def beyond(row: Row) -> float:
    """Return by how much of a bound a value of ours lies outside it; 0 if it does not.

    A bound is an upper one of the size, unless the quantity or the remark says that it is the
    least.
    """
    if not row.bound or row.ours is None or not row.source:
        return 0.0
    over = abs(row.ours / row.source) - 1
    lower = any(words in f"{row.quantity} {row.remark}" for words in _LOWER)
    return max(-over if lower else over, 0.0)


def flagged(row: Row) -> Row:
    """Return a row that says if it lies beyond its bound."""
    over = beyond(row)
    if not over:
        return row
    return dataclasses.replace(row, remark=f"{row.remark} Beyond the bound by {_excess(over)}.")


def _excess(over: float) -> str:
    return f"{significant(100 * over, 2)} %" if over < _LARGE else _factor(over)


def _difference(row: Row) -> str:
    """Return how far ours lies off, rounding left out."""
    off = row.deviation
    return "-" if off is None else percent(100 * off if abs(off) > _ROUNDING else 0)


def _factor(off: float) -> str:
    """Return a very large ratio of ours to the other."""
    return f"times {significant(off + 1, 2)}"


def _percent(share: float) -> str:
    return f"{100 * share:g} %"


def _escaped(text: str) -> str:
    """Escape what Markdown would take for its own within a table."""
    return re.sub(r"([\\`*_\[\]|~#$<>])", r"\\\1", text)


def _link(name: str) -> str:
    return f"[{LABELS.get(name, name)}](results/{name}.md)"


def _counts(suite: Mapping[str, Any]) -> str:
    """Return how many rows of each kind a suite has."""
    kinds = [row["kind"] for study in suite["studies"].values() for row in study["rows"]]
    return (
        ", ".join(f"{kinds.count(kind)} {word}" for kind, word in _KINDS.items() if kind in kinds)
        or "tables alone"
    )


def chosen_rows(
    stored: Mapping[str, Any], chosen: Sequence[tuple[str, str, str, tuple[str, ...]]] = CHOSEN
) -> Iterator[tuple[str, list[Row]]]:
    """Name and rows of each line of a table; no rows if the stored results lack one of them."""
    for before, suite, study, starts in chosen:
        records = stored["suites"].get(suite, {}).get("studies", {}).get(study, {}).get("rows", ())
        found = [
            next((row_of(one) for one in records if one["quantity"].startswith(start)), None)
            for start in starts
        ]
        rows = [row for row in found if row is not None and row.ours is not None]
        whole = before.endswith(": ") or not before  # then what the quantity is called follows
        name = before + rows[0].quantity if whole and len(starts) == 1 and rows else before
        yield name, rows if len(rows) == len(starts) else []


def table_of(lines: Iterable[tuple[str, list[Row]]], links: Sequence[str] = ()) -> str:
    """Return chosen rows as a table.

    Parameters
    ----------
    links
        Page of each line, to which its quantity leads.
    """
    heads = ("quantity", "what it is compared with", "value", "granwave", "difference", "remark")
    text = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for number, (name, rows) in enumerate(lines):
        if rows:
            against = [row.theory if row.source is None else row.source for row in rows]
            values = ", ".join("-" if one is None else significant(one, 5) for one in against)
            ours = ", ".join(significant(row.ours, row.digits) for row in rows)
            off = ", ".join(map(_difference, rows))
            unit = f" {rows[0].unit}" if rows[0].unit else ""
            what = f"{_KINDS[rows[0].kind]}: {rows[0].where}".removesuffix(": ")
            sentences = [
                one
                for row in rows
                if row.remark
                for one in row.remark.removesuffix(".").split(". ")
            ]
            remark = "".join(f"{one}. " for one in dict.fromkeys(sentences)).rstrip()
            shown = f"[{_escaped(name)}]({links[number]})" if links else _escaped(name)
            cells = [shown, what, values + unit, ours + unit, off, _escaped(remark)]
            text.append(f"| {' | '.join(cells)} |")
    return "\n".join(text) + "\n"


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


def _suite_page(suite: Mapping[str, Any]) -> str:
    """Return the page of a suite: a section for each study that has rows or tables."""
    versions = ", ".join(
        f"{program} {'/'.join(found)}" for program, found in suite["versions"].items()
    )
    state = "" if suite["complete"] else " Not all of its runs are done."
    lead = f"Command: {suite['command']}. Last run on {suite['date']}, with {versions}.{state} Rows: {_counts(suite)}."
    sections = []
    for name, study in suite["studies"].items():
        found = Study("", study["title"], "", tuple(flagged(row_of(row)) for row in study["rows"]))
        notes = [Note(text) for text in (study["text"], *study["verdict"]) if text]
        tables = [
            Note(one) if isinstance(one, str) else _read_table(one) for one in study["tables"]
        ]
        parts = (*notes, *row_tables(found), *tables)
        if len(parts) > len(notes):
            sections.append(DocumentSection(study["title"], name, parts))
    text, _ = markdown(cleaned(tidied(Report(suite["title"], lead, tuple(sections)))), "")
    title, _, rest = text.partition("\n")
    return f"{title}\n\nA page of [{_TITLE.lower()}](../results.md), which tells what the words mean.\n{rest}"


def _table(table: DocumentTable) -> dict[str, Any]:
    columns = [[column.heading, column.unit, column.numeric] for column in table.columns]
    return {
        "caption": table.caption,
        "columns": columns,
        "rows": [[cell.text for cell in row] for row in table.rows],
    }


def _read_table(stored: Mapping[str, Any]) -> DocumentTable:
    columns = tuple(
        TableColumn(heading, unit, numeric=numeric) for heading, unit, numeric in stored["columns"]
    )
    rows: Sequence[Sequence[str]] = stored["rows"]
    return DocumentTable(stored["caption"], columns, tuple(tuple(map(Cell, row)) for row in rows))


if __name__ == "__main__":
    write_pages(read_stored())
