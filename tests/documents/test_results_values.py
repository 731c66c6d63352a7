"""The figures of values on the pages of results: parts of names, panels, and their rows."""

from __future__ import annotations

import copy
import itertools

import matplotlib.pyplot as plt
import pytest

from granwave.analysis.figures.style import style
from tests.documents.pages import extension
from tests.helpers.selection import with_every_test

extension("results_chosen")
extension("results_stored")
extension("results_notes")
extension("results_sources")
extension("results_rows")
extension("results_symbols")
QUANTITIES = extension("results_quantities")
STORE = extension("results_stored")
PANELS = extension("results_panels")
extension("results_picture")
extension("results_axes")
PICTURE = extension("results_values_picture")
STORED = STORE.read_stored()
FOLDER = STORE.STORED.with_suffix("")
RESOLUTION = 200  # dots per inch, as in the files
AGAIN = "run .venv/bin/python docs/_ext/results_table.py"
#: Pages with the longest names and most panels: tested each time, the others as validations.
DENSE = ("lateral", "benchmarks", "confined", "protection")
WITH_PANELS = [name for name, suite in STORED["suites"].items() if PANELS.values_of(suite).panels]


def row(quantity, ours, source=None, *, theory=None, unit="m/s", bound=False, remark=""):
    """Return a stored row."""
    kind = "alone"
    if source is not None or theory is not None:
        kind = "theory" if source is None else "source"
    return {
        "quantity": quantity,
        "unit": unit,
        "source": source,
        "granwave": ours,
        "where": "",
        "remark": remark,
        "theory": theory,
        "kind": kind,
        "digits": 4,
        "bound": bound,
    }


def suite(*rows, title="Study"):
    """Return a suite with one study."""
    return {"studies": {"study": {"title": title, "rows": list(rows)}}}


@pytest.mark.parametrize(
    ("name", "base", "conditions"),
    [
        ("V, N2 = 3, elastic", "Speed V", {"N2 = {}": (3,), "elastic": ()}),
        (
            "Peak force; source: mesh 0.2 to 0.4 mm",
            "Peak force",
            {"source's mesh {} to {} mm": (0.2, 0.4)},
        ),
        ("Front speed at 150 MPa, BCC", "Front speed", {"{} MPa": (150,), "BCC": ()}),
        (
            "Peak at a section (contact 1, 2), a = -1.8e-05, at most",
            "Peak at a section (contact 1, 2)",
            {"a = {}": (-1.8e-5,)},
        ),
        (
            "Test 5, rebound at incidence 2.01, steel",
            "Test 5 rebound",
            {"incidence {}": (2.01,), "steel": (), "one spring": ()},
        ),
        (
            "Test 5, rebound of finite elements at incidence 1.19, partial slip",
            "Test 5 rebound",
            {"incidence {}": (1.19,), "finite elements": (), "partial slip": ()},
        ),
        (
            "Spin measured at 5.9 degrees, oxide, partial slip",
            "Spin",
            {"{} degrees": (5.9,), "measured": (), "oxide": (), "partial slip": ()},
        ),
    ],
)
def test_a_name_has_parts(name, base, conditions):
    quantity = QUANTITIES.quantity_of(name)
    assert quantity.base == base
    assert {one.template: one.numbers for one in quantity.conditions} == conditions


@pytest.mark.parametrize(
    ("template", "label"),
    [("N2 = {}", "N2"), ("scatter of {} %", "scatter (%)"), ("{} MPa", "modulus (MPa)")],
)
def test_an_abscissa_has_its_unit(template, label):
    assert QUANTITIES.abscissa(template) == label


def test_symbols_take_their_width_in_lines():
    """A symbol is much shorter than its name and its code."""
    assert QUANTITIES.lines_of("at alpha_y, R*", 12) == [r"at $\alpha_y$, R*"]
    lines = QUANTITIES.lines_of("in-plane, radii 2 to 1, 550 MPa", 20)
    assert [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines] == [
        "in-plane, radii 2",
        "to 1, 550 MPa",
    ]
    assert QUANTITIES.typeset("Spin at beta") == r"Spin at $\beta$"


def test_rows_that_differ_by_one_number_are_curves():
    """Rows of ours alone belong to a curve; two values are a list."""
    rows = [
        row(f"Front speed at {modulus} MPa, {lattice}", modulus, 125.0)
        for modulus, lattice in itertools.product((480, 150, 1573), ("BCC", "HCP"))
    ]
    rows[0] |= {"source": None, "kind": "alone"}
    (panel,) = PANELS.values_of(suite(*rows)).panels
    assert (panel.title, panel.abscissa, panel.unit) == ("Front speed", "modulus (MPa)", "m/s")
    assert [name for name, _ in panel.curves] == ["BCC", "HCP"]
    assert [value.x for value in panel.curves[0][1]] == [150, 480, 1573]
    assert panel.number() == 5
    (panel,) = PANELS.values_of(suite(*rows[2:])).panels
    assert not panel.abscissa and [value.label for value in panel.values()] == [
        "150 MPa, BCC",
        "150 MPa, HCP",
        "1573 MPa, BCC",
        "1573 MPa, HCP",
    ]


def test_numbers_that_vary_together_are_one_abscissa():
    rows = [
        row(f"Speed of the wave, F_m/F0 = {force}, impact at {speed} m/s", speed, theory=speed)
        for force, speed in ((1.1, 0.1), (1.7, 0.2), (2.9, 0.4))
    ]
    (panel,) = PANELS.values_of(suite(*rows)).panels
    assert panel.abscissa == "F_m/F0" and panel.title == "Speed of the wave"
    assert [value.x for value in panel.values()] == [1.1, 1.7, 2.9]


def test_quantities_of_similar_size_and_one_unit_are_a_list():
    rows = [
        row("Speed of the front", 470.0, 687.0),
        row("Upper bound", 480.0, 704.0),
        row("Velocity of the plateau", 0.21, theory=0.22),
        row("Mean velocity", 0.2, theory=0.21),
    ]
    fast, slow = sorted(PANELS.values_of(suite(*rows)).panels, key=PANELS.Panel.weight)[::-1]
    assert fast.title == slow.title == "Study" and fast.is_mixed
    assert [value.label for value in fast.values()] == ["Speed of the front", "Upper bound"]
    assert [value.label for value in slow.values()] == ["Velocity of the plateau", "Mean velocity"]


def test_bounds_and_intervals_are_read():
    rows = [
        row("Force, A, at most", 7.0, 10.0, bound=True),
        row("Force, B, at least", 12.0, 10.0, bound=True),
        row("Force, C", 9.0, 10.0, remark="The measured value is ± 0.5. No more."),
    ]
    (panel,) = PANELS.values_of(suite(*rows)).panels
    assert [(value.bound, value.interval) for value in panel.values()] == [
        ("most", 0.0),
        ("least", 0.0),
        ("", 0.5),
    ]


@pytest.mark.parametrize("name", WITH_PANELS)
def test_panels_contain_stored_rows(name):
    """Each value is the value of a row of the page, and each row is in one panel at most."""
    page = PANELS.values_of(STORED["suites"][name])
    assert len(page.panels) <= PANELS.MOST and page.number() <= page.total
    rounded = []
    for study in STORED["suites"][name]["studies"].values():
        for record in study["rows"]:
            numbers = (record[kind] for kind in ("granwave", "source", "theory"))
            rounded.append(tuple(None if one is None else f"{one:.4g}" for one in numbers))
    shown = []
    for value in page.values():
        numbers = (value.ours, value.source, value.theory)
        shown.append(tuple(None if one is None else f"{one:.4g}" for one in numbers))
    assert all(shown.count(numbers) <= rounded.count(numbers) for numbers in shown)


@pytest.mark.parametrize("name", WITH_PANELS)
def test_the_figure_of_values_is_of_the_stored_rows(name):
    suite = STORED["suites"][name]
    page = PANELS.values_of(suite)
    picture = FOLDER / PICTURE.picture_of(name)
    assert not PICTURE.is_stale(picture, page), AGAIN
    assert picture.stat().st_size < 300_000
    text = (FOLDER / f"{name}.md").read_text(encoding="utf-8")
    assert PICTURE.text_of(name, suite) in text, AGAIN
    assert f"The figure shows {page.number()} of the {page.total} values" in text


@pytest.mark.parametrize("name", with_every_test(WITH_PANELS, DENSE))
def test_all_texts_are_inside_the_figure(name):
    """No title or label is cut off at an edge, and no title of a curve covers another."""
    with style():
        figure = PICTURE.figure_of(PANELS.values_of(STORED["suites"][name]))
        figure.set_dpi(RESOLUTION)
        figure.canvas.draw()
        names = [axes.title for axes in figure.axes if axes.get_title()]
        headings = [text.get_window_extent() for text in (*figure.texts, *names)]
        boxes = [*headings, *(axes.get_tightbbox() for axes in figure.axes)]
        width, height = figure.canvas.get_width_height()
        plt.close(figure)
    for box in boxes:
        assert box.x0 >= 0 and box.x1 <= width and box.y0 >= 0 and box.y1 <= height
    pairs = itertools.combinations(headings, 2)
    assert not any(one.overlaps(other) for one, other in pairs)


def test_a_changed_row_makes_its_figure_stale():
    changed = copy.deepcopy(STORED["suites"]["thesis-4"])
    record = next(
        record
        for record in changed["studies"]["long_load"]["rows"]
        if record["quantity"] == "Peak force"
    )
    record["granwave"] *= 1.01
    assert PICTURE.is_stale(FOLDER / PICTURE.picture_of("thesis-4"), PANELS.values_of(changed))


def test_pages_without_figures_have_none():
    """Pages without references have no figure, and no figure is left over."""
    without = set(STORED["suites"]) - set(WITH_PANELS)
    assert all(not PICTURE.text_of(name, STORED["suites"][name]) for name in without)
    pictures = {path.name for path in FOLDER.glob("*-values.webp")}
    assert pictures == {PICTURE.picture_of(name) for name in WITH_PANELS}, AGAIN
