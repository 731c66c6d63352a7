"""The tables of results are generated from the stored rows, some of which are computed again."""

from __future__ import annotations

import copy
import itertools
from pathlib import Path
from types import SimpleNamespace

import pytest

import granwave as gw
from granwave.analysis.studies.registry import COMPARISON, STUDIES
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Study, make_studies
from granwave.workflows import load_scan
from tests.documents.pages import ROOT, extension

# relative: runs of these cases give the same bits; libraries of other versions round otherwise
SAME = 1e-6
HOMOGENEOUS = str(ROOT / "reproductions" / "composite_chains" / "homogeneous_chain.py")
SENSOR_CHAIN = str(ROOT / "reproductions" / "square_packing" / "sensor_chain.py")
#: Quick cases and their study.
QUICK = (("homogeneous-chain", HOMOGENEOUS), ("sensor-chain", SENSOR_CHAIN))


STORE = extension("results_stored")
CHOSEN = extension("results_chosen")
NOTES = extension("results_notes")
SOURCES = extension("results_sources")
ROWS_OF_TABLES = extension("results_rows")
CONCLUSIONS = extension("results_conclusions")
SYMBOLS = extension("results_symbols")
STUDY = extension("results_study")
PICTURE = extension("results_picture")
for part in ("quantities", "panels", "axes", "values_picture"):
    extension(f"results_{part}")
MEASURED = extension("results_measured_picture")
extension("results_coverage")
WIDE = extension("results_wide")
TABLE = extension("results_table")
RESULTS = extension("results")
STORED = STORE.read_stored()
#: Every stored row with its suite and study.
ROWS = [
    (name, key, record, STORE.row_of(record))
    for name, suite in STORED["suites"].items()
    for key, study in suite["studies"].items()
    for record in study["rows"]
]


@pytest.mark.parametrize(("name", "study"), QUICK)
def test_a_fresh_run_gives_the_stored_rows(tmp_path, name, study):
    run = gw.run(name, directory=tmp_path, progress=False)
    runs = (
        [run]
        if study.endswith(".py")
        else [FinishedRun(name, run.directory, run.case, run.summary)]
    )
    (made,) = make_studies({study: runs})
    word = Path(study).stem.replace("_", "-")
    stored = {row.quantity: row for _, key, _, row in ROWS if key.replace("_", "-") == word}
    assert made.rows and {row.quantity for row in made.rows} <= set(stored)
    for row in made.rows:
        before = stored[row.quantity]
        assert row.kind == before.kind, row.quantity
        for ours, theirs in (
            (row.ours, before.ours),
            (row.source, before.source),
            (row.theory, before.theory),
        ):
            assert ours == (None if theirs is None else pytest.approx(theirs, rel=SAME)), (
                row.quantity
            )


AGAIN = "run .venv/bin/python docs/_ext/results_table.py"


def test_pages_are_made_of_the_stored_rows():
    pages = TABLE.pages_of(STORED)
    assert set(TABLE.PAGES.glob("*.md")) == set(pages) - {TABLE.PAGE}, AGAIN
    for page, text in pages.items():
        assert page.read_text(encoding="utf-8") == text, f"{page.name}: {AGAIN}"
    for page, table in TABLE.tables_elsewhere(STORED).items():
        text = page.read_text(encoding="utf-8")
        assert TABLE.with_block(text, table) == text, f"{page.name}: {AGAIN}"
        counts = TABLE.printed_in_words(STORED)
        assert TABLE.with_counts(text, counts) == text, f"{page.name}: {AGAIN}"
        assert (counts in text) == (page != TABLE.PAPER)


def test_the_picture_is_of_the_stored_rows():
    for picture in (TABLE.PICTURE, TABLE.PAPER.with_name("agreement.png")):
        assert PICTURE.digest_of(picture) == PICTURE.digest(STORED, CHOSEN.LABELS), AGAIN
        assert picture.stat().st_size < 300_000
    changed = copy.deepcopy(STORED)
    row = next(
        row
        for row in changed["suites"]["thesis-4"]["studies"]["long_load"]["rows"]
        if row["source"]
    )
    row["granwave"] *= 1.01
    assert PICTURE.digest(changed, CHOSEN.LABELS) != PICTURE.digest(STORED, CHOSEN.LABELS)


def test_the_picture_of_each_suite_is_of_its_stored_rows():
    for name, suite in STORED["suites"].items():
        part, labels = PICTURE.by_study(suite)
        if labels:
            assert not TABLE.is_stale(TABLE.PAGES / f"{name}.webp", part, labels), AGAIN
        assert len(PICTURE.points(part)) == sum(one == name for one, *_ in PICTURE.points(STORED))


def test_the_figure_of_measurements_is_of_the_stored_rows():
    """It has the rows of the table, with the errors that the sources state."""
    assert not MEASURED.is_stale(STORED), AGAIN
    found = list(MEASURED.ratios(STORED))
    assert len(found) == len(CHOSEN.MEASURED)
    assert sum(error > 0 for *_, error in found) == 3


def test_remarks_are_notes_below_a_table():
    """Rows that test the code are folded on the site."""
    table = ROWS_OF_TABLES.table_of(ROWS_OF_TABLES.chosen_rows(STORED))
    assert "| remark |" not in table and "\n¹ " in table and " ¹ |" in table
    page = TABLE.pages_of(STORED)[TABLE.PAGES / "fcc-impact.md"]
    assert page.count(":::{dropdown}") == 1 and "](fcc-impact.webp)" in page


def test_wide_tables_are_printed_in_parts():
    """Each part begins with the columns that tell the rows apart, and no column is lost."""
    columns = [[heading, "", True] for heading in "abcdefghijklmn"]
    rows = [[*pair, *"cdefghijklmn"] for pair in itertools.product("12", "345")]
    table = STORE.read_table({"caption": "wide", "columns": columns, "rows": rows})
    assert WIDE.number_of_keys(table) == 2
    parts = list(WIDE.parts_of(table))
    for part, headings in zip(parts, ("abcdefgh", "abijklmn"), strict=True):
        assert "".join(column.heading for column in part.columns) == headings
    assert [part.caption for part in parts] == ["wide (1 of 2)", "wide (2 of 2)"]
    assert all(len(part.rows) == len(rows) for part in parts)
    narrow = table.keeping(range(WIDE.MOST))
    assert list(WIDE.parts_of(narrow)) == [narrow]


def test_what_is_far_off_is_named():
    """Deviations in the list and the picture agree with the rows; each has a distinct mark, and a
    reason.
    """
    compared = [
        (name, key, row.kind, row.deviation)
        for name, key, _, row in ROWS
        if row.deviation is not None
    ]
    assert sorted(PICTURE.points(STORED)) == sorted(compared)
    far = PICTURE.far_off(STORED)
    assert sum(one.number for one in far) == sum(abs(off) > PICTURE.FAR for *_, off in compared)
    assert len({one.mark for one in far}) == len(far) and all(one.why for one in far)
    assert PICTURE._mark(25) == "z" and PICTURE._mark(26) == "aa" and PICTURE._mark(52) == "ba"


def test_the_first_pages_have_few_rows():
    everything = (*CHOSEN.CHOSEN, *CHOSEN.MORE)
    for chosen, numbers in (
        (CHOSEN.CHOSEN, {10}),
        (CHOSEN.MEASURED, {9}),
        (CHOSEN.IN_PAPER, {7}),
        (everything, range(28, 36)),
    ):
        lines = list(ROWS_OF_TABLES.chosen_rows(STORED, chosen))
        assert len(lines) in numbers
        assert [name for name, rows in lines if not rows or any(row.bound for row in rows)] == []
    named = {entry[1] for entry in everything}
    with_rows = {name for name, *_ in ROWS}
    assert named == with_rows, "every suite has a row on the first page of results"
    assert set(CHOSEN.LABELS) == set(STORED["suites"])


def test_the_stored_rows_are_those_of_the_code():
    """For a stale table the suite, the reason and the command are reported."""
    found = RESULTS.stale(STORED)
    assert not found, "\n" + "\n".join(f"{name}: {why}" for name, why in found.items())


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda one: one.update(versions={"granwave": ["0.0.1"]}), "run by granwave 0.0.1"),
        (lambda one: one.update(versions={"granwave": ["99.0"]}), "run by granwave 99.0"),
        (lambda one: one.update(complete=False), "not all of its runs are done; run make results"),
        (
            lambda one: one["digests"].update(runs="0"),
            "its scans or cases have changed since; run make results",
        ),
        (lambda one: one["digests"].update(studies="0"), "results.py --no-run sphere-contacts"),
    ],
)
def test_what_makes_a_table_stale(change, says):
    fresh = {
        "versions": {"granwave": [RESULTS.SAME_NUMBERS_SINCE, RESULTS.granwave.__version__]},
        "complete": True,
        "digests": RESULTS.digests(RESULTS.SUITES["sphere-contacts"]),
    }
    assert RESULTS.stale({"suites": {"sphere-contacts": fresh}}, ["sphere-contacts"]) == {}
    change(fresh)
    assert (
        says
        in RESULTS.stale({"suites": {"sphere-contacts": fresh}}, ["sphere-contacts"])[
            "sphere-contacts"
        ]
    )
    assert RESULTS.stale({"suites": {}}, ["sphere-contacts"]) == {
        "sphere-contacts": "no rows are stored; run make results"
    }


def test_a_suite_is_complete_only_if_every_present_point_is_done():
    """A scan with points of an earlier file, or with a missing point, is not complete."""
    suite = RESULTS.SUITES["sphere-contacts"]
    ids = [point.id for point in load_scan("sphere-contacts", here=False).points]

    def inputs(done: list[str]) -> SimpleNamespace:
        points = [SimpleNamespace(run=True, result=SimpleNamespace(id=one)) for one in done]
        return SimpleNamespace(scans=[SimpleNamespace(points=points)], runs=[])

    assert RESULTS._complete(suite, inputs(ids))
    assert not RESULTS._complete(suite, inputs(ids[1:]))
    assert not RESULTS._complete(suite, inputs(["of an earlier file" for _ in ids]))


def test_a_digest_sees_code_and_no_words(tmp_path):
    texts = (
        '"""Doc."""\nx = 1  \n',
        '"""Other\nwords."""\n# a remark\nx = 1\n',
        '"""Doc."""\nx = 2\n',
    )
    files = [tmp_path / f"{n}.py" for n in range(3)]
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    first, same, other = map(RESULTS._code, files)
    assert first == same != other


def test_a_digest_of_scripts_sees_what_makes_rows(tmp_path):
    """Definitions that are unused, or used only by figures and tables, are left out."""
    beside = tmp_path / "beside.py"
    beside.write_text("LIMIT = 2\n\n\ndef measured(runs):\n    return LIMIT\n")
    study = tmp_path / "study.py"

    def digest(words, factor):
        study.write_text(
            f"from beside import measured\nWORDS = {words}\nFACTOR = {factor}\n\n\n"
            "def rows(runs):\n    yield FACTOR * measured(runs)\n\n\n"
            "def tables(runs):\n    yield WORDS\n"
        )
        return RESULTS._code_of_scripts([beside, study])

    first = digest("'one'", 1)
    assert first == digest("'two'", 1)
    assert first != digest("'one'", 3)
    beside.write_text(beside.read_text().replace("2", "4"))
    assert first != digest("'one'", 1)


@pytest.mark.parametrize(
    ("quantity", "source", "ours", "over"),
    [
        ("Force, at most", 100.0, 120.0, 0.2),
        ("Force, at most", 100.0, 99.0, 0.0),
        ("Edge, at least", 100.0, 80.0, 0.2),
        ("Edge, at least", 100.0, 120.0, 0.0),
        ("Ratio, within", -10.0, -900.0, 89.0),
    ],
)
def test_what_lies_beyond_a_bound_is_flagged(quantity, source, ours, over):
    """The column of the difference states it on the page of the suite."""
    row = gw.Row(quantity, source=source, ours=ours, bound=True)
    assert ROWS_OF_TABLES.beyond(row) == pytest.approx(over)
    (table,) = STUDY.tables_of(Study("study", "Study", "", (row,)))
    heads = [column.heading for column in table.columns]
    shown = table.rows[0][heads.index("Difference")].text
    assert shown == (f"beyond by {ROWS_OF_TABLES.excess(over)}" if over else "within")
    assert not ROWS_OF_TABLES.beyond(gw.Row(quantity, source=source, ours=ours))


def test_bounds_that_do_not_hold_are_counted():
    """The sentence of counts, the pages of suites and the list of the first page agree."""
    bounds = [row for *_, row in ROWS if row.bound]
    holding = sum(map(ROWS_OF_TABLES.holds, bounds))
    counts = TABLE.counts_in_words(STORED)
    assert f"For {len(bounds)} values" in counts and f"{holding} are within their limit" in counts
    pages = TABLE.pages_of(STORED)
    first = pages.pop(TABLE.PAGE)
    _, _, listed = first.partition("## Values outside a bound")
    listed = listed.partition("\n## ")[0].count("\n| [")
    marked = sum(text.count("| beyond by ") for text in pages.values())
    assert listed == marked == len(bounds) - holding


def test_every_page_begins_with_its_conclusion():
    """Its numbers are from the stored rows, and its fields name rows that exist."""
    texts = CONCLUSIONS.read_conclusions()
    assert set(texts) == set(STORED["suites"])
    for name, page in STORED["suites"].items():
        text = CONCLUSIONS.conclusion_of(name, page)
        assert not CONCLUSIONS._FIELD.search(text) and text.count(".") > 1, name
    fields = {"study": {"title": "Study", "rows": [ROWS[0][2] | {"quantity": "Speed, a = 1"}]}}
    with pytest.raises(ValueError, match="no row 'Force'"):
        CONCLUSIONS._first({"studies": fields}, "study", "Force")


def test_shared_sentences_of_remarks_are_one_note():
    remarks = ["The fit has few points. It is uncertain. At 2 N.", "At 3 N.", "At 2 N.", ""]
    above, notes = NOTES.notes_of(remarks)
    assert not above
    assert notes == [
        ["The fit has few points. It is uncertain.", "At 2 N."],
        ["At 3 N."],
        ["At 2 N."],
        [],
    ]
    forces = ["The force is 3 N.", "The force is 1.5 N.", "", "The force is 2 N."]
    text = "The force is 3, 1.5, 2 N (in the order of the rows with this note)."
    assert NOTES.notes_of(forces)[1] == [[text], [text], [], [text]]
    assert NOTES.notes_of([*forces[:2], "From 1 to 2 N."])[1] == [
        ["The force is 3 N."],
        ["The force is 1.5 N."],
        ["From 1 to 2 N."],
    ]
    above, notes = NOTES.notes_of(["See Fig. 2. One.", "See Fig. 2. Two."])
    assert above == "See Fig. 2." and notes == [["One."], ["Two."]]


@pytest.mark.parametrize(
    ("ours", "digits", "shown"),
    [(-1.0069, 2, "-1.007"), (-1.0558, 2, "-1.056"), (2.0379, 2, "2.04"), (1.0000001, 3, "1")],
)
def test_digits_show_the_difference(ours, digits, shown):
    row = gw.Row(
        "Exponent", source=round(ours) * (0.8 if ours > 2 else 1), ours=ours, digits=digits
    )
    assert ROWS_OF_TABLES.ours_text(row) == shown


def test_rounded_values_of_all_rows_have_the_displayed_difference():
    """From a deviation of 1 % on, the displayed values give it within a twentieth of it."""
    for _, _, _, row in ROWS:
        against = row.theory if row.source is None else row.source
        if row.deviation is not None and abs(row.deviation) > 0.01:
            shown = float(f"{row.ours:.{ROWS_OF_TABLES.shown_digits(row)}g}") / against - 1
            assert shown == pytest.approx(row.deviation, rel=0.05), row.quantity


@pytest.mark.parametrize(
    ("quantity", "unit", "shown"),
    [
        ("Rebound angle at 9.72 degrees", "degrees", "-1.48 degrees"),
        ("Test 6, rebound at incidence 1", "", "-1.48 (absolute)"),
        ("Spin at 5 degrees", "rad/s", "+140 %"),
    ],
)
def test_quantities_of_both_signs_have_an_absolute_difference(quantity, unit, shown):
    row = gw.Row(quantity, unit, source=-1.06, ours=-2.542)
    assert ROWS_OF_TABLES.difference(row) == shown
    far = {one.suite + one.study: one for one in PICTURE.far_off(STORED)}
    spheres = far["benchmarksimpacts_spheres"]
    assert not spheres.deviations and max(spheres.differences) < 0
    assert TABLE._ranges(spheres) == ["-0.7 to -0.2 (absolute)"]
    assert TABLE._ranges(far["benchmarksimpacts_oblique"])[1] == "-1.5 to +1.4 degrees"


@pytest.mark.parametrize(
    ("place", "name"),
    [
        ("thesis 2.25, Fig. 2.13", "Pal 2015, 2.25, Fig. 2.13"),
        ("thesis Figs 5.5 to 5.7", "Pal 2015, Figs. 5.5 to 5.7"),
        ("thesis (4.5)", "Pal 2015 (4.5)"),
        ("composite chain, section 4, measured", "Wu et al. 2019, section 4, measured"),
        ("square packing, Fig. 11(a)", "Leonard et al. 2013, Fig. 11(a)"),
        ("Hertz (1882)", "Hertz (1882)"),
    ],
)
def test_sources_have_author_and_year(place, name):
    """Names of tables are linked to the bibliography on the page of results."""
    assert SOURCES.named(place) == name
    link = SOURCES.linked(name, "results.md")
    assert ("](results.md#sources)" in link) == (name != place)
    assert "\n## Sources\n" in TABLE.pages_of(STORED)[TABLE.PAGE]


def test_an_error_of_the_source_is_next_to_its_value():
    row = gw.Row("Ratio", source=3.3922, ours=2.769, remark="The measured ratio is 3.39 ± 0.40.")
    assert ROWS_OF_TABLES.reference_text(row) == "3.39 ± 0.40"
    assert ROWS_OF_TABLES.difference(row) == "-18.4 % (1.6 times the error)"


def test_symbols_and_numbers_are_readable():
    assert SYMBOLS.readable_numbers("at 3e+03 to 1e+06 Pa, 1.7e+04 kg/m³, 3.79e+03") == (
        "at 3 kPa to 1 MPa, 17\N{NO-BREAK SPACE}000 kg/m³, 3790"
    )
    text = SYMBOLS.with_formulas(
        "| F\\_y alpha\\_y and E\\*R\\*^2 tau, `F_y`, F\\_yield |\n## F\\_y"
    )
    assert text == "| $F_y \\alpha_y$ and $E^* R^{*2} \\tau$, `F_y`, F\\_yield |\n## F\\_y"


def test_every_study_of_a_source_has_its_rows_stored():
    """Every built-in study belongs to a suite."""
    named = {name for suite in RESULTS.SUITES.values() for name in RESULTS.studies_named(suite)}
    assert set(STUDIES) <= named
    assert set(COMPARISON) <= named


def test_every_row_compares_something():
    """A row has our value, or a theoretical value together with the source value; a bound has no
    difference.
    """
    for _, _, record, row in ROWS:
        assert row.kind == record["kind"], row.quantity
        assert row.ours is not None or row.theory is not None, row.quantity
        assert not row.bound or row.deviation is None, row.quantity


def test_every_suite_says_when_and_with_what_it_was_run():
    for name, suite in STORED["suites"].items():
        assert (
            suite["date"]
            and suite["versions"].get("granwave")
            and suite["command"].startswith("granwave")
        ), name
