"""Report of a search for the best design: best design, results of its checks, ten best designs, and
course of the search.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.ticker import MaxNLocator

from granwave.analysis.document.model import (
    Block,
    Cell,
    DocumentSection,
    DocumentTable,
    Figure,
    Gallery,
    Note,
    Report,
    TableColumn,
    case_column,
    label_of,
    percent,
    show,
    text_table,
    unit_of_value,
    value_cell,
    value_cells,
    value_column,
)
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import (
    BLUE,
    GREY,
    ORANGE,
    Drawing,
    FigureFolder,
    attempt,
    legend_above,
    style,
)
from granwave.analysis.formatting.numbers import duration, in_any_unit, quantity_in
from granwave.analysis.formatting.values import unit_in_cases
from granwave.analysis.reports.figures import picture_of
from granwave.analysis.reports.kinds import ReportKind, ReportRun, by_key
from granwave.analysis.reports.setting import setting_of
from granwave.analysis.result.reader import Result
from granwave.extensions.design.files import DESIGN, DESIGN_OUTCOME, DESIGN_TABLE, has_outcome
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json, read_toml
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import CASE_FILE

_MOST_ROWS = 10
_MOST_WORDS = 4  # most words of a variable in a figure
_TOLD = (
    "packing.kind",
    "packing.size",
    "packing.diameter",
    "material",
)  # keys that are listed with the setting of a case
_OF_OTHER_DESIGNS = ("neighbour", "moved")  # checks that compare with another design
_GRAMS = 1e3  # in a kilogram
_SHADES_OF_DESIGNS = "Blues"  # colours of designs in the figure of their values
_PALEST = 0.35  # part of these colours: the worst design
_SHADES = 256  # number of shades of their scale
_CAPTIONS = {
    "packing": "The best design: its packing, with a quarter cut away at the impact, and the peak "
    "contact force of each sphere",
    "convergence": "Objective of each design in the order of the search (excluding pruned and "
    "failed designs); best value so far; expected best value of random designs, from the "
    "model of the search",
    "front": "All designs of the search: each design of the front is better than every other "
    "design in at least one objective",
    "importance": "Fraction of the variance of the objective due to each variable alone "
    "(first-order Sobol index), from the model of the search; a remainder to 1 is due to several "
    "variables together",
    "coordinates": "Values of all designs of the search, scaled to their ranges; darker is "
    "better, the best is orange",
}


def design_report(directory: Path) -> Report:
    """Return the report of a search from design.json and designs.csv; its figures are redrawn."""
    found = read_json(directory / DESIGN_OUTCOME) or {}
    table = pd.read_csv(directory / DESIGN_TABLE)
    return Report(
        f"Design: {found['name']}", _lead(found), tuple(_sections(found, table, directory))
    )


def _lead(found: Mapping[str, Any]) -> str:
    goals = " and ".join(
        f"the {which} {label_of(name).lower()}" for name, which in found["objectives"].items()
    )
    of = f" of {found['designs']} designs" if found["designs"] else ""
    further = f", and {found['next_to_best']} next to the best" if found.get("next_to_best") else ""
    return f"Search for {goals}: {found['evaluations']}{of} were run{further}"


def _sections(
    found: Mapping[str, Any], table: pd.DataFrame, directory: Path
) -> list[DocumentSection]:
    best = found["best"]
    drawn = _drawn(found, table, directory)
    sections = [DocumentSection("Answer", "answer", tuple(_answer(found, directory, drawn)))]
    if best:
        sections.append(DocumentSection("The best designs", "best", (_best_table(found, table),)))
        sections.append(DocumentSection("Checks of the best", "checks", (_checks(best),)))
    figures = tuple(
        drawn[name]
        for name in ("convergence", "front", "importance", "coordinates")
        if name in drawn
    )
    sections.append(
        DocumentSection(
            "The search", "search", (*([Gallery(figures)] if figures else []), _cost(found))
        )
    )
    return sections


def _answer(found: Mapping[str, Any], directory: Path, drawn: Mapping[str, Figure]) -> list[Block]:
    best = found["best"]
    if best is None:
        return [
            Note(
                "No design of the search meets the limits; designs.csv lists the distance of each "
                "design from the limits.",
                "bad",
            )
        ]
    blocks: list[Block] = [Note(answer_of(found, directory), "lead")]
    if ranking_of(found):
        blocks.append(Note(ranking_of(found)))
    if found["front"] and len(found["front"]) > 1:
        (first, which), (second, _) = found["objectives"].items()
        last = found["front"][-1]
        count = len(found["front"])
        text = f"This is the design with the {which} {label_of(first).lower()} of the {count} of the front. At its other "
        value = " and ".join(
            _quantity_of(name, last["objective"][name]) for name in (first, second)
        )
        blocks.append(Note(f"{text}end is design {last['number']}: {value}."))
    blocks += [
        Note(f"{_sentence_case(one['text'])}.", "note") for one in best["guards"] if one["warning"]
    ]
    if "packing" in drawn:
        blocks.append(Gallery((drawn["packing"],)))
    return blocks


def _sentence_case(text: str) -> str:
    """Return a text that begins with a capital, unless it begins with a key."""
    is_key = "." in text.partition(" ")[0]
    return text if is_key else f"{text[:1].upper()}{text[1:]}"


def answer_of(found: Mapping[str, Any], directory: Path) -> str:
    """Return the best design and its objective in a sentence."""
    best = found["best"]
    place = directory / best["directory"]
    case = by_key(read_toml(place / CASE_FILE))
    summary = ResultDirectory(place).summary()
    runs = best.get("runs", 1)
    values = [_value_with_range(found, name) for name in best["objective"]]
    reduction = summary.get("peak_reduction")
    less = f", {reduction:.3g} times lower than without the packing" if reduction else ""
    if less and runs > 1:
        less += " in the first run"
    more = ", ".join(
        f"{key} {show(value)}"
        for key, value in best["variables"].items()
        if not key.startswith(_TOLD)
    )
    made = setting_of(case) + (f", with {more}" if more else "")
    if runs > 1:
        made += f" (first of {runs} runs)"
    where = f"{quantity_in(1000 * best['mass_kg'], 'g')}, {quantity_in(best['height_m'], 'm')} high"
    return f"{made}: {' and '.join(values)}{less}, {where}."


def _value_with_range(found: Mapping[str, Any], name: str) -> str:
    """Return an objective of the best design with its range in the runs and in the checks."""
    best = found["best"]
    ranges: list[str] = []
    ends = best.get("spread", {}).get(name)
    if ends:
        low, high = (_value_of(name, end) for end in ends)
        statistic = _statistic(found)
        of_runs = f"{statistic} of " if statistic else ""
        ranges.append(f"{of_runs}{low} to {high} in {best['runs']} runs")
    if checked := range_under_checks(best, name):
        ranges.append(checked)
    listed = f" ({'; '.join(ranges)})" if ranges else ""
    return f"{_quantity_of(name, best['objective'][name])}{listed}"


def _statistic(found: Mapping[str, Any]) -> str:
    """Return the statistic of several runs in words; empty for searches of 1.0."""
    statistic = found.get("statistic", "")
    return statistic if isinstance(statistic, str) else f"{statistic:g} quantile"


def ranking_of(found: Mapping[str, Any]) -> str:
    """Return a sentence on the ranking of the designs; empty for searches of 1.0, whose files
    contain no ranking.
    """
    if "statistic" not in found:
        return ""
    runs = found["best"].get("runs", 1)
    if runs == 1:
        return (
            "Designs are ranked by one run each; only the best was checked by further runs. With "
            "[uncertainty] they are ranked by several runs each."
        )
    return f"Designs are ranked by the {_statistic(found)} of {runs} runs each."


def range_under_checks(best: Mapping[str, Any], name: str) -> str:
    """Return the range of an objective in the further runs of the best design, in words.

    If a design has several runs, its checks are further runs of the first one, and the range is
    that of the relative change. Empty without further runs.
    """
    changes = [
        check["changes"][name]
        for check in best["guards"]
        if name in check["changes"] and not check["name"].startswith(_OF_OTHER_DESIGNS)
    ]
    if not changes:
        return ""
    ends = (min(0.0, *changes), max(0.0, *changes))
    if best.get("runs", 1) > 1:
        return f"changed by {percent(100 * ends[0])} to {percent(100 * ends[1])} in its checks"
    low, high = sorted(best["objective"][name] * (1 + change) for change in ends)
    return f"{_value_of(name, low)} to {_value_of(name, high)} in its checks"


def _best_table(found: Mapping[str, Any], table: pd.DataFrame) -> DocumentTable:
    """Return the ten best designs, or the front, with variables, mass, height and objectives."""
    objectives = list(found["objectives"])
    keys = list(found["best"]["variables"])
    complete = table[table["state"] == "complete"]
    if found["front"]:
        rows = complete[
            complete["number"].isin([one["number"] for one in found["front"]])
        ].sort_values(objectives[0])
    else:
        ascending = found["objectives"][objectives[0]] == "smallest"
        rows = complete.sort_values(objectives[0], ascending=ascending, kind="stable").head(
            _MOST_ROWS
        )
    limits = found.get("limits", {})
    known = [
        name
        for name in dict.fromkeys(("mass_kg", "height_m", *limits))
        if name not in objectives and name in table
    ]
    spread = []
    for name in objectives:
        for end in ("low", "high"):
            if f"{name}_{end}" in table:
                spread.append(f"{name}_{end}")
    heads = [TableColumn("Design", key=True)]
    columns = [list(map(value_cell, rows["number"].astype(object)))]
    for name in [*objectives, *spread]:
        of_value = name if name in objectives else name.rpartition("_")[0]
        unit, cells = value_cells(of_value, rows[name].astype(object).tolist())
        is_end = name not in objectives
        if is_end:
            heads.append(TableColumn(name.rpartition("_")[2], unit, numeric=True))
        else:
            heads.append(value_column(name, unit=unit))
        columns.append(cells)
    for name in known:
        unit, cells = value_cells(name, rows[name].astype(object).tolist())
        title = label_of(name) + limit_in_heading(name, limits.get(name, {}))
        heads.append(TableColumn(title, unit, numeric=True))
        columns.append(cells)
    for key in keys:
        unit = unit_in_cases(key, [{key: None}])
        heads.append(case_column(key, unit, numeric=False))
        columns.append(list(map(value_cell, rows[key].astype(object))))
    return DocumentTable(
        "Best designs; best-1.toml ... are their cases",
        tuple(heads),
        tuple(zip(*columns, strict=True)),
        sortable=True,
    )


def _quantity_of(name: str, value: float) -> str:
    """Return a value of a summary with its name and unit."""
    return f"{label_of(name).lower()} {_value_of(name, value)}"


def _value_of(name: str, value: float) -> str:
    """Return a value of a summary with its unit."""
    unit = unit_of_value(name)
    if unit == "kg":
        return quantity_in(_GRAMS * value, "g")
    return in_any_unit(value, unit)


def limit_in_heading(name: str, limit: Mapping[str, float]) -> str:
    """Return the bounds of a limit of a value, with their unit, in the form of a heading."""
    unit = unit_of_value(name)
    ends = {"low": "at least", "high": "at most"}
    texts = [
        f", {words} {in_any_unit(limit[end], unit)}"
        for end, words in ends.items()
        if limit.get(end) is not None
    ]
    return "".join(texts)


def _checks(best: Mapping[str, Any]) -> DocumentTable:
    rows = [
        (
            Cell(one["what"]),
            Cell(
                one["text"].removeprefix(f"{one['what']}: "), tone="note" if one["warning"] else ""
            ),
        )
        for one in best["guards"]
    ]
    first = ", compared with the first of its runs" if best.get("runs", 1) > 1 else ""
    return text_table(
        f"Checks of the best design and their results{first}", ("Check", "Found"), rows
    )


def _cost(found: Mapping[str, Any]) -> DocumentTable:
    states = ", ".join(f"{count} {state}" for state, count in found["states"].items())
    rows = [("Designs", states), ("Time of all runs", duration(found["seconds"]))]
    rows += [
        (name, version)
        for name, version in found["versions"].items()
        if name in ("granwave", "lammps", "python")
    ]
    return text_table("Cost and versions", ("Item", "Value"), rows)


# ---------------------------------------------------------------------- figures


def _drawn(found: Mapping[str, Any], table: pd.DataFrame, directory: Path) -> dict[str, Figure]:
    """Draw the figures of a search and save them; return them by name."""
    ran = table[table["state"].isin(["complete", "refused"])].dropna(
        subset=list(found["objectives"])
    )
    folder = FigureFolder(directory)
    makers: dict[str, Callable[[], Drawing | None]] = {
        "packing": lambda: _packing(found, directory),
        "convergence": lambda: _convergence(found, table[table["directory"].notna()]),
        "front": lambda: _front(found, ran),
        "importance": lambda: _importance(found["importance"]),
        "coordinates": lambda: _coordinates(found, ran),
    }
    with style():
        drawn = {name: attempt(f"figure {name}", make) for name, make in makers.items()}
        for name, drawing in drawn.items():
            folder.save(drawing, name, formats=())
        shown = {name: drawing for name, drawing in drawn.items() if isinstance(drawing, Drawing)}
        return {name: picture_of(drawing, name, _CAPTIONS[name]) for name, drawing in shown.items()}


def _packing(found: Mapping[str, Any], directory: Path) -> Drawing | None:
    figure = run_figures().get("packing_3d")
    if figure is None or not found["best"]:
        return None
    try:
        with Result(directory / found["best"]["directory"]) as result:
            return figure.draw(result)
    except (MissingOutputError, OutputFormatError):
        return None


def _convergence(found: Mapping[str, Any], ran: pd.DataFrame) -> Drawing | None:
    ((name, which), *others) = found["objectives"].items()
    if others or not ran[name].notna().any():
        return None
    values = ran[name].where(ran["state"] == "complete").to_numpy(float)
    so_far = np.fmin.accumulate(values) if which == "smallest" else np.fmax.accumulate(values)
    number = np.arange(1, len(ran) + 1)
    figure, axes = panels(2.6)
    axes.plot(number, ran[name], ".", color=GREY, label="designs")
    axes.step(number, so_far, where="post", color=BLUE, label="best so far")
    columns = {"number": number, name: ran[name], "best_so_far": so_far}
    if found.get("random"):
        random = np.array(found["random"])
        axes.plot(
            np.arange(1, len(random) + 1), random, "--", color=ORANGE, label="random, expected"
        )
        columns["random_expected"] = random
    if 0 < 3 * ran[name].min() < ran[name].max():
        axes.set_yscale("log")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    label(axes, "Designs run", value_column(name).title)
    legend_above(axes, 3)
    return Drawing(figure, columns)


def _front(found: Mapping[str, Any], ran: pd.DataFrame) -> Drawing | None:
    if not found["front"]:
        return None
    x, y = found["objectives"]
    objectives = [design["objective"] for design in found["front"]]
    front_x = [objective[x] for objective in objectives]
    front_y = [objective[y] for objective in objectives]
    figure, axes = panels(2.8)
    axes.plot(ran[x], ran[y], ".", color=GREY, label="designs")
    axes.plot(front_x, front_y, "o-", color=BLUE, label="front")
    label(axes, value_column(x).title, value_column(y).title)
    legend_above(axes, 2)
    return Drawing(figure, {x: ran[x], y: ran[y], f"front_{x}": front_x, f"front_{y}": front_y})


def _importance(shares: Mapping[str, float] | None) -> Drawing | None:
    if not shares:
        return None
    figure, axes = panels(0.8 + 0.22 * len(shares))
    axes.barh(list(shares)[::-1], list(shares.values())[::-1], color=BLUE)
    label(axes, "Fraction of the variance", xlim=(0, 1))
    return Drawing(figure, {"variable": list(shares), "share": list(shares.values())})


def _coordinates(found: Mapping[str, Any], ran: pd.DataFrame) -> Drawing | None:
    if not found["best"] or len(ran) < 3:
        return None
    keys = list(found["best"]["variables"])
    (name, which), *_ = found["objectives"].items()
    scaled = pd.DataFrame({key: _scaled(ran[key]) for key in (*keys, name)})
    goodness = 1 - scaled[name] if which == "smallest" else scaled[name]
    colours = colormaps[_SHADES_OF_DESIGNS]
    best = found["best"]["number"]
    figure, axes = panels(3.2, width=max(3.4, 0.7 * len(keys) + 1.5))
    places = range(len(keys) + 1)
    for row, good, number in zip(scaled.to_numpy(), goodness, ran["number"], strict=True):
        chosen: dict[str, Any] = {"color": ORANGE, "lw": 2, "zorder": 3, "label": "best design"}
        others: dict[str, Any] = {
            "color": colours(_PALEST + (1 - _PALEST) * good),
            "lw": 0.9,
            "zorder": 2 + 0.9 * good,
        }
        axes.plot(places, row, **(chosen if number == best else others))
    scale = ScalarMappable(Normalize(), ListedColormap(colours(np.linspace(_PALEST, 1, _SHADES))))
    bar = figure.colorbar(scale, ax=axes, label="Other designs", ticks=[0, 1], pad=0.03)
    bar.ax.set_yticklabels(["worst", "best"])
    names = zip((*keys, name), (*keys, value_column(name).title), strict=True)
    axes.set_xticks(
        places, [f"{words}\n{_ends(ran[key])}" for key, words in names], rotation=30, ha="right"
    )
    label(axes, y="Value, from first to last", yticks=[0, 1])
    legend_above(axes, 1)
    return Drawing(figure, {key: ran[key].astype(str).to_list() for key in (*keys, name)})


def _ends(column: pd.Series[Any]) -> str:
    """Return the smallest and the largest of numbers, or all words in their order."""
    if pd.api.types.is_numeric_dtype(column):
        return f"{column.min():.4g} to {column.max():.4g}"
    words = _named(sorted(column.astype(str).unique()))
    return ", ".join(words) if len(words) <= _MOST_WORDS else f"{words[0]} to {words[-1]}"


def _named(words: list[str]) -> list[str]:
    """Return the names of materials that are given as tables, if the names differ; other words
    unchanged.
    """
    found = [re.search(r'\b(?:name|preset) = "([^"]+)"', word) for word in words]
    names = [one[1] if one else word for one, word in zip(found, words, strict=True)]
    return names if len(set(names)) == len(words) else words


def _scaled(column: pd.Series[Any]) -> np.ndarray:
    """Scale numbers to the range from 0 to 1; words count by their order."""
    if pd.api.types.is_numeric_dtype(column):
        numbers = column.to_numpy(float)
    else:
        numbers = pd.factorize(column, sort=True)[0]
    span = np.ptp(numbers)
    return (numbers - numbers.min()) / span if span else np.full(len(numbers), 0.5)


class DesignKind(ReportKind):
    """A search for a design, which has a separate report."""

    result_kind = DESIGN
    noun = "search for a design"

    def whole_report(self, directory: Path) -> Report | None:
        """Return the report of a finished search."""
        return design_report(directory) if has_outcome(directory) else None

    def read(self, results: ResultDirectory, label: str) -> list[ReportRun]:
        """Reject the directory: it is not a run."""
        if has_outcome(results.path):
            reason = "is a design search, which has a separate report; remove the other directories"
        else:
            reason = (
                f"is an unfinished design search; resume with  granwave design FILE -o {results} "
                "--resume"
            )
        raise InputError(f"{results}: {reason}")


REPORT_KINDS = (DesignKind(),)
