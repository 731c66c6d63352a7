"""Stored results of all suites, ``docs/explanation/results.json``, and the pages and tables
generated from them.

    python docs/_ext/results_table.py      # pages, picture, README and first page again from the stored rows; no runs

A suite has its date, versions, and studies; suites without rows are listed by name. A study has its
rows, each of one kind (a source, theory, a verification of the code, or granwave only), and its own
tables. The first page has the headline comparisons and a picture of all; each suite has a separate
page. All of them are generated from the stored results.
"""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import results_coverage
import results_measured_picture
import results_picture
import results_values_picture
from results_chosen import CHOSEN, IN_PAPER, LABELS, MEASURED, MORE
from results_conclusions import CLOSE, agreement_of, bounds_of, conclusion_of
from results_rows import (
    KINDS,
    LARGE,
    beyond,
    chosen_rows,
    difference,
    escaped,
    excess,
    factor,
    holds,
    ours_text,
    reference_text,
    table_of,
)
from results_sources import BIBLIOGRAPHY
from results_stored import ROOT, STORED, read_stored, read_table, row_of
from results_study import tables_of
from results_symbols import readable_numbers, with_formulas
from results_wide import parts_of

from granwave.analysis.document.model import (
    DocumentSection,
    DocumentTable,
    Note,
    Report,
    changed,
    cleaned,
    percent,
    significant,
    tidied,
)
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.formatting.values import ratio_in_words, with_unit
from granwave.analysis.reports.report import markdown
from granwave.analysis.studies.study import Row, Study
from granwave.lammps_inputs.files import replace_text

PAGE = STORED.with_suffix(".md")
PICTURE = STORED.with_name("agreement.webp")
PAGES = STORED.with_suffix("")  # folder of a page for each suite
README = ROOT / "README.md"
FIRST_PAGE = ROOT / "docs" / "index.md"
PAPER = ROOT / "docs" / "paper" / "paper.md"
# page of results, as linked from other pages
_OF_README = "docs/explanation/results.md"
_OF_FIRST_PAGE = "explanation/results.md"
_TITLE = "Comparison with the literature"
_MESSAGE = """\
More than half of the values that sources print are reproduced within 10 %, many within 1 %: for
example the energy in a square packing, the fronts in a bilinear chain, and waves in precompressed
chains. Larger differences have four causes. The source has a misprint or contradicts itself
([errata](errata.md)); it does not print a property that matters, such as a modulus or the velocity
of a striker; a formula is used outside its range; or one of the two models lacks an effect, such as
partial slip ([limits](limits.md)). Some differences are not explained. The pages by subject begin
with their conclusions."""
_KINDS = """\
There are four kinds of rows:

* A *source* is a value printed in the literature.
* *Theory* is a value that follows from equations.
* A *verification* tests the code only: a second solver, a check value, a formula, or a scaling of
  any correct code. The second solvers are in `tests/helpers` and share no code with granwave.
* Rows of *granwave only* have no reference. (Their kind is `alone` in `study_rows.csv`.)

If a source or theory gives only a bound (the end of an axis, or *at most*), the tables state
whether our value is within the bound, or by how much it is beyond it. Rebound angles and similar
quantities have values on both sides of zero; the tables give their absolute difference. Everywhere
else, and in all counts and in the figures, the difference is relative to the reference.

`make results` generates these pages from finished runs; no number is typed by hand. The text of the
conclusions is in `reproductions/conclusions.md`."""
_COUNTING = """\
A number with its unit and place in a source is one printed value, which several rows may compare:
with other positions, with variants that test a reason for a difference, or with settings of the
source, such as its meshes. A number printed once is counted once, even if several rows use it. A
value agrees in every comparison if all its rows do. Values from theory and verifications are
counted by rows. Remarks
give the reason of a difference where it is known: a misprint ([errata](errata.md)), missing data of
the source, or an effect that one of the two models does not have."""
_BLOCK = re.compile(r"(<!-- results -->\n)(.*?)(<!-- /results -->)", re.DOTALL)
_COUNTS = re.compile(r"(<!-- counts -->)(.*?)(<!-- /counts -->)", re.DOTALL)
_PICTURE_TEXT = "Relative difference of each value from its reference, by study and kind"
_PICTURE_CAPTION = (
    "*Each point is a row. Filled symbols: granwave is larger than the reference; open "
    "symbols: granwave is smaller. The dotted line is at 1 %, and the grey area begins at 10 %.*"
)
#: Tables of rows that test the code alone.
_VERIFICATION = re.compile(
    r"^\*\*(?P<caption>.*verification of the code.*)\*\*\n\n"
    r"(?P<rows>(?:\|.*\n)+(?:\n[⁰¹²³⁴⁵⁶⁷⁸⁹]+ .*\n)*)",
    re.MULTILINE,
)


def write_all(stored: Mapping[str, Any]) -> None:
    """Write the JSON file, the pages, the picture, and the blocks of the README and of the site's
    first page.
    """
    replace_text(STORED, json.dumps(stored, indent=1, ensure_ascii=False) + "\n")
    write_pages(stored)


def write_pages(stored: Mapping[str, Any]) -> None:
    """Write all pages that are generated from the stored results."""
    pages = pages_of(stored)
    PAGES.mkdir(exist_ok=True)
    for old in set(PAGES.glob("*.md")) - set(pages):
        old.unlink()
    for page, text in pages.items():
        replace_text(page, text)
    for picture in (PICTURE, PAPER.with_name("agreement.png")):
        if is_stale(picture, stored, LABELS):
            results_picture.draw(stored, LABELS, picture)
    for name, suite in stored["suites"].items():
        part, labels = results_picture.by_study(suite)
        picture = PAGES / f"{name}.webp"
        if labels and is_stale(picture, part, labels):
            results_picture.draw(part, labels, picture, letters=False)
    results_values_picture.write_stale(stored, PAGES)
    results_measured_picture.write_stale(stored)
    results_coverage.write_page(stored)
    for page, table in tables_elsewhere(stored).items():
        text = with_block(page.read_text(encoding="utf-8"), table)
        replace_text(page, with_counts(text, printed_in_words(stored)))


def is_stale(picture: Path, stored: Mapping[str, Any], labels: Mapping[str, str]) -> bool:
    """Return True for a picture that is missing or shows other results."""
    if not picture.is_file():
        return True
    return results_picture.digest_of(picture) != results_picture.digest(stored, labels)


def tables_elsewhere(stored: Mapping[str, Any]) -> dict[Path, str]:
    """Return the tables in pages that are otherwise written by hand."""
    return {
        README: readable_numbers(table_of(chosen_rows(stored), sources=_OF_README)),
        FIRST_PAGE: results_measured_picture.text()
        + readable_numbers(table_of(chosen_rows(stored, MEASURED), sources=_OF_FIRST_PAGE)),
        PAPER: _of_paper(stored),
    }


def printed_in_words(stored: Mapping[str, Any]) -> str:
    """Return a sentence on the values that sources print, and on their agreement."""
    printed = results_picture.printed_values(stored)
    always = [max(offs) for offs in printed]
    once = [min(offs) for offs in printed]
    return (
        f"Of {len(printed)} values that the sources print, {_close(once)} agree within 10 % in at "
        f"least one comparison, and {_close(always)} in every comparison."
    )


def counts_in_words(stored: Mapping[str, Any]) -> str:
    """Return sentences on the number of compared values of each kind, and on their agreement."""
    bounds = list(itertools.chain.from_iterable(map(bounds_of, stored["suites"].values())))
    _, theory, verifications = (_deviations(stored, kind) for kind in results_picture.KINDS)
    return (
        f"{printed_in_words(stored)} Theory gives {len(theory)} values, of which {_close(theory)} "
        f"agree within 10 %. For {len(bounds)} values the reference is only a limit (at most, at "
        f"least); {sum(map(holds, bounds))} are within their limit. {len(verifications)} values "
        "test the code only, against a second solver or a formula."
    )


def _deviations(stored: Mapping[str, Any], kind: str) -> list[float]:
    """Return the magnitude of the deviation of each compared value of a kind."""
    return [abs(off) for _, _, of, off in results_picture.points(stored) if of == kind]


def _close(deviations: Sequence[float]) -> str:
    """Return the number of deviations within 10 %, with its percentage."""
    number = sum(off <= CLOSE for off in deviations)
    return f"{number} ({100 * number / len(deviations):.0f} %)"


def with_counts(text: str, sentences: str) -> str:
    """Return a text whose sentence on the numbers of values is replaced, if it has one."""
    return _COUNTS.sub(lambda found: f"{found[1]}{sentences}{found[3]}", text)


def _of_paper(stored: Mapping[str, Any]) -> str:
    """Return the sentence on all rows and the table of the paper."""
    parts = []
    for kind, (name, _) in results_picture.KINDS.items():
        offs = _deviations(stored, kind)
        every = ""
        if kind == "source":
            offs = [max(of_value) for of_value in results_picture.printed_values(stored)]
            every = " in every comparison"
        close = [sum(off <= limit for off in offs) for limit in (0.01, CLOSE)]
        parts.append(
            f"of {len(offs)} values of kind *{name}*, {close[0]} agree within 1 % and {close[1]} "
            f"within 10 %{every}"
        )
    text = "; ".join(parts)
    lines = ["| quantity | kind | other | granwave | difference |", "|---|---|---|---|---|"]
    for name, (row, *_) in chosen_rows(stored, IN_PAPER):
        against = row.theory if row.source is None else row.source
        value = with_unit(significant(against, 5), row.unit)
        ours = with_unit(significant(row.ours, min(row.digits, 5)), row.unit)
        lines.append(f"| {name} | {KINDS[row.kind]} | {value} | {ours} | {difference(row)} |")
    return "\n".join([f"{text[:1].upper()}{text[1:]}.", "", *lines]) + "\n"


def pages_of(stored: Mapping[str, Any]) -> dict[Path, str]:
    """Return the first page of results, and the page of each suite."""
    pages = {
        PAGES / f"{name}.md": _suite_page(name, suite) for name, suite in stored["suites"].items()
    }
    return {PAGE: with_formulas(readable_numbers(_first_page(stored))), **pages}


def _first_page(stored: Mapping[str, Any]) -> str:
    """Return the page with the headline comparisons, the picture of all, the large deviations, and
    the list of the other pages.
    """
    names = [name for name in stored["suites"]]
    lines = sorted(zip((*CHOSEN, *MORE), chosen_rows(stored, (*CHOSEN, *MORE)), strict=True),
                   key=lambda pair: names.index(pair[0][1]) if pair[0][1] in names else len(names))  # fmt: skip
    table = table_of((line for _, line in lines), [f"results/{entry[1]}.md" for entry, _ in lines])
    pages = "\n".join(
        f"| {_link(name)} | {suite['title']} | {_counts(suite)} | {agreement_of(suite)} |"
        for name, suite in stored["suites"].items()
    )
    absent = stored.get("absent", ())
    note = (
        f"\nNo rows are stored for: {', '.join(absent)}. They are not included here.\n"
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
    others = number - len(shown) - len(bounds)
    tree = "\n".join(f"{LABELS.get(name, name)} <results/{name}>" for name in names)
    return f"""# {_TITLE}

```{{index}} ! validation, ! comparison with experiments, ! compare with experiments
```

```{{index}} ! papers, ! published experiments
```

{counts_in_words(stored)}

{_MESSAGE}

## Sources

{BIBLIOGRAPHY}

## All comparisons

![Difference between each granwave value and its reference, by suite and kind](agreement.webp)

*Each point is one of {len(shown)} rows with a difference: the relative difference between granwave and its reference, on a
logarithmic axis. Full symbols: granwave is larger; open symbols: granwave is smaller. The grey area begins at 10 %. Points at an
edge lie beyond the axis. Of all {number} rows, {len(bounds)} have only a bound. For {others},
there is no reference, the reference is zero, or we computed no value. These rows are left out. The
letters are explained below.*

{_COUNTING}

## Headline comparisons

These are {len(lines)} of {number} rows. [Pages by subject](#all-rows) list all rows, whether they agree or not.

{table}
## Differences larger than {_percent(results_picture.FAR)}

A value may differ because a source has a misprint ([errata](errata.md)), because a formula does not hold in that range, or
because granwave does not model an effect ([limits](limits.md)). Each letter is a study with such values. The remark explains the
largest difference.

| | study | compared with | number | difference | remark |
|---|---|---|---|---|---|
{_far_rows(stored)}
## Values outside a bound

For {len(bounds)} values, the source or theory gives only a bound.
Of these, {len(outside)} lie outside.

| quantity | bound | granwave | outside by |
|---|---|---|---|
{_outside_rows(outside)}
## All rows

| page | subject | rows | agreement |
|---|---|---|---|
{pages}
{note}
## Kinds of rows

{_KINDS}

```{{toctree}}
:hidden:

{tree}
```
"""


def _far_rows(stored: Mapping[str, Any]) -> str:
    lines = []
    for one in results_picture.far_off(stored):
        link = f"[{escaped(one.title)}](results/{one.suite}.md)"
        number = f"{one.number} of {one.total}"
        cells = [
            f"**{one.mark}**",
            link,
            KINDS[one.kind],
            number,
            "; ".join(_ranges(one)),
            escaped(one.why),
        ]
        lines.append(f"| {' | '.join(cells)} |\n")
    return "".join(lines)


def _ranges(far: results_picture.Far) -> list[str]:
    """Return the range of the relative deviations, and of the absolute differences of quantities
    that have values on both sides of zero.
    """
    ranges = []
    if far.deviations:
        offs = (min(far.deviations), max(far.deviations))
        ends = [percent(100 * off) if abs(off) < LARGE else factor(off) for off in offs]
        ranges.append(" to ".join(dict.fromkeys(ends)))
    if far.differences:
        ends = [plain(f"{off:+.2g}") for off in (min(far.differences), max(far.differences))]
        ranges.append(f"{' to '.join(dict.fromkeys(ends))} {far.unit or '(absolute)'}")
    return ranges


def _outside_rows(outside: Iterable[tuple[str, Row]]) -> str:
    lines = []
    for name, row in outside:
        quantity = readable_numbers(ratio_in_words(row.quantity))
        cells = [
            f"[{escaped(quantity)}](results/{name}.md)",
            with_unit(reference_text(row), row.unit),
            with_unit(ours_text(row), row.unit),
            excess(beyond(row)),
        ]
        lines.append(f"| {' | '.join(cells)} |\n")
    return "".join(lines)


def _percent(share: float) -> str:
    return f"{100 * share:g} %"


def _link(name: str) -> str:
    return f"[{LABELS.get(name, name)}](results/{name}.md)"


def _counts(suite: Mapping[str, Any]) -> str:
    """Return the number of rows of each kind in a suite."""
    kinds = []
    for study in suite["studies"].values():
        for row in study["rows"]:
            kinds.append(row["kind"])
    return (
        ", ".join(f"{kinds.count(kind)} {word}" for kind, word in KINDS.items() if kind in kinds)
        or "tables only"
    )


def with_block(text: str, table: str) -> str:
    """Return a text whose block of results is replaced.

    Raises
    ------
    ValueError
        The text has no such block.
    """
    if not _BLOCK.search(text):
        raise ValueError("found no block between <!-- results --> and <!-- /results -->")
    return _BLOCK.sub(lambda found: f"{found[1]}{table}{found[3]}", text)


def _suite_page(name: str, suite: Mapping[str, Any]) -> str:
    """Return the page of a suite: its picture, and a section for each study that has rows or tables."""
    state = "" if suite["complete"] else " Not all of its runs are done."
    sections = []
    for study_name, study in suite["studies"].items():
        found = Study("", study["title"], "", tuple(row_of(row) for row in study["rows"]))
        notes = [Note(text) for text in (study["text"], *study["verdict"]) if text]
        tables: list[Note | DocumentTable] = []
        for one in study["tables"]:
            tables += [Note(one)] if isinstance(one, str) else parts_of(read_table(one))
        parts = (*notes, *tables_of(found), *tables)
        if len(parts) > len(notes):
            sections.append(DocumentSection(study["title"], study_name, parts))
    report = changed(tidied(Report(suite["title"], "", tuple(sections))), str, readable_numbers)
    text, _ = markdown(cleaned(report), "")
    title, _, rest = text.partition("\n")
    picture = results_values_picture.text_of(name, suite)
    if results_picture.by_study(suite)[1]:
        picture += f"\n![{_PICTURE_TEXT}]({name}.webp)\n\n{_PICTURE_CAPTION}\n"
    runs = (
        f"Command: `{suite['command']}`. Last run on {suite['date']}.{state} "
        f"Rows: {_counts(suite)}. [{_TITLE}](../results.md) explains the kinds of rows."
    )
    head = f"{title}\n\n{conclusion_of(name, suite)}\n"
    return with_formulas(f"{head}{picture}\n{runs}\n{_VERIFICATION.sub(_folded, rest)}")


def _folded(table: re.Match[str]) -> str:
    """Return a table that the site shows folded, below its caption."""
    return f":::{{dropdown}} {table['caption']}\n\n{table['rows']}:::\n"


if __name__ == "__main__":
    write_pages(read_stored())
