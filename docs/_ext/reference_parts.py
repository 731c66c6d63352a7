"""Parts of the reference that are generated from the tables of the code, as MyST Markdown.

A page contains a mark such as ``<!-- keys: case -->``; `code_tables.py` puts the part there when
the site is built, and `reference_pages.py` keeps it below the mark for readers of the repository.
"""

from __future__ import annotations

import argparse
import importlib
import re
import sys
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from bibtex import bibtex

from granwave._contact_laws import LAWS, LawParameter
from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.formatting.values import printed_unit
from granwave.analysis.quantities import ENTRIES, GROUPS, Quantity, entries
from granwave.analysis.reports.kinds import report_kinds
from granwave.analysis.result.data_sets import GROUPS as GROUPS_OF_DATA_SETS
from granwave.analysis.result.data_sets import DataSet
from granwave.analysis.studies.registry import STUDIES
from granwave.lammps_inputs import presets
from granwave.lammps_inputs.lattices import lattice_kinds
from granwave.workflows import library
from granwave.workflows.cli.keys.reference import Key, KeyTable, state, tables
from granwave.workflows.cli.parser import make_parser as command_line
from granwave.workflows.file_kinds import CASE_FILE

ROOT = Path(__file__).parents[2]
MANUAL = ROOT / "plugins" / "doc"
FIGURES = ROOT / "docs" / "figures"
LAW_HEADERS = ROOT / "plugins" / "laws"
sys.path.append(str(ROOT / "plugins" / "package"))
from other_commands import other_commands  # noqa: E402  what the package's pages have, too

_NO_BREAK = "\N{NO-BREAK SPACE}"
_COLUMNS = 4  # pairs of columns of the table of constants
_PLANE = re.compile(r"_(principal|orthogonal|section)$")
_AT_PLANE = re.compile(r", (principal plane|perpendicular plane|plane of the case)$")
#: A mark, with the kept table below it, if there is one.
MARK = re.compile(
    r"^<!-- (?P<name>\w+)(?:: (?P<argument>[\w.-]+))? -->$"
    r"(?:\n(?:(?!<!-- \w).*\n)*?<!-- /(?P=name) -->$)?",
    re.MULTILINE,
)


def keys_of(file: str) -> str:
    """Return all tables of one kind of file as sections with a list of keys each."""
    return "\n\n".join(_section(table) for table in tables() if table.file == file)


def _section(table: KeyTable) -> str:
    title = f"`{table.heading}`" if table.heading else "Keys above all tables"
    anchor = f"(keys-{table.file}-{table.name.replace('.', '-')})=\n"
    text = f"{table.description[:1].upper()}{table.description[1:]}."
    level = (
        "##" if table.file == CASE_FILE.name else "###"
    )  # the pages of others have several kinds of files
    entries = [_entry(table, key) for key in table.keys]
    return "\n\n".join([f"{anchor}{level} {title}", text, *entries])


def _indexed(name: str, anchor: str) -> str:
    """Return an entry of the index, so that the search opens the anchor by the name."""
    return f"{{entry}}`{name} <{anchor}>`"


def _entry(table: KeyTable, key: Key) -> str:
    anchor = f"{table.file}.{table.name}.{key.name}".replace(".", "-").replace("_", "-").lower()
    unit = f" in {printed_unit(key.unit)}" if key.unit else ""
    facts = [
        f"Accepts {_escape(key.accepts)}.",
        *([f"{_sentence(key.usual)}"] if key.usual else []),
    ]
    indexed = ""
    if table.file == CASE_FILE.name and table.name:
        indexed = _indexed(f"{table.name}.{key.name}", anchor)
    return "\n".join(
        [
            f"{indexed}[**`{key.name}`**]{{#{anchor}}}{unit}, {_state(key)}",
            f": {_sentence(key.description)} {' '.join(facts)} Example: `{key.example}`",
        ]
    )


def _state(key: Key) -> str:
    if key.default:
        if key.default.startswith("that of "):
            return f"default {key.default}"
        return f"default `{key.default}`"
    return f"**{state(key)}**" if key.required else state(key)


def _sentence(text: str) -> str:
    return f"{_escape(text[:1].upper() + text[1:])}."


#: Formulas of the meanings of values, as the terminal prints them, and in LaTeX.
FORMULAS = {
    "(2/sqrt 3) (2/(1.6 pi))^2 E*^2 sqrt(rho) sigma_y^-2.5 v": (
        r"\frac{2}{\sqrt{3}} \left(\frac{2}{1.6\,\pi}\right)^2 "
        r"\frac{E^{*2} \sqrt{\rho}}{\sigma_\mathrm{y}^{2.5}}\, v"
    ),
    "F_y alpha_y": r"F_\mathrm{y} \alpha_\mathrm{y}",
    "sigma_y^2 D^3/E": r"\sigma_\mathrm{y}^2 D^3 / E",
    "1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2": (r"1/E^* = (1 - \nu_1^2)/E_1 + (1 - \nu_2^2)/E_2"),
}


def _escape(text: str) -> str:
    """Escape characters with a meaning in Markdown."""
    return re.sub(r"([\[\]{}*_<>|$`])", r"\\\1", text)


def _typeset(text: str) -> str:
    """Return a text in Markdown, with its formulas as mathematics."""
    text = _escape(text)
    for plain, formula in FORMULAS.items():
        text = text.replace(_escape(plain), f"${formula}$")
    return text


def quantities() -> str:
    """Return the values of summary.json of runs, with a section for each group."""
    shown = entries()
    groups = GROUPS | {"Values of extensions": shown[len(ENTRIES) :]}
    sections = [
        f"## {title}\n\n{_table_of(group, searched=True)}"
        for title, group in groups.items()
        if group
    ]
    return "\n\n".join(sections)


def _table_of(shown: Sequence[Quantity], *, searched: bool = False) -> str:
    """Return the table of the values of a summary.

    Parameters
    ----------
    searched
        Each row has an anchor, which the search opens by the name of the value.
    """
    rows = []
    for entry in shown:
        what = _typeset(" ".join(filter(None, [entry.meaning, entry.note])))
        name = f"`{entry.name}`"
        if searched and "*" not in entry.name:
            anchor = entry.name.replace("_", "-").lower()
            name = f"{_indexed(entry.name, anchor)}[{name}]{{#{anchor}}}"
        rows.append(f"| {name} | {printed_unit(entry.unit)} | {_escape(entry.label)} | {what} |")
    return "\n".join(["| value | unit | label | meaning |", "|---|---|---|---|", *rows])


def result_data_sets() -> str:
    """Return the data sets of result.h5, with a section for each group."""
    sections = []
    for title, listed in GROUPS_OF_DATA_SETS.items():
        rows = [_data_set(entry) for entry in listed]
        head = ["| data set | shape | unit | meaning |", "|---|---|---|---|"]
        sections.append("\n".join([f"## {title}", "", *head, *rows]))
    return "\n\n".join(sections)


def _data_set(entry: DataSet) -> str:
    """Return the row of a data set, with an anchor."""
    path = f"/{entry.path}"
    anchor = re.sub(r"[^a-z0-9]+", "-", f"h5-{entry.path}".lower())
    name = f"[`{path}`]{{#{anchor}}}"
    meaning = f"{entry.meaning[:1].upper()}{entry.meaning[1:]}."
    if entry.when:
        meaning += f" Only {entry.when}."
    unit = entry.unit.replace("-1", "⁻¹").replace(" ", _NO_BREAK)
    shape = entry.shape.replace(" ", _NO_BREAK)
    return f"| {name} | ({shape}) | {unit} | {meaning} |"


def commands() -> str:
    """Return all commands with their arguments and options."""
    (verbs,) = (
        action
        for action in command_line()._actions
        if isinstance(action, argparse._SubParsersAction)
    )
    helps = {action.dest: action.help or "" for action in verbs._choices_actions}
    return "\n\n".join(
        _command(name, helps[name], parser) for name, parser in verbs.choices.items()
    )


def _command(name: str, what: str, parser: argparse.ArgumentParser) -> str:
    usage = " ".join(parser.format_usage().removeprefix("usage: ").split())
    entries = [_argument(action) for action in parser._actions if action.dest != "help"]
    form = f"```{{code-block}} text\n:class: usage\n\n{usage}\n```"
    return "\n\n".join([f"(command-{name})=\n## granwave {name}", _sentence(what), form, *entries])


def _argument(action: argparse.Action) -> str:
    value = action.metavar or ("|".join(map(str, action.choices)) if action.choices else "")
    shown = " ".join(value) if isinstance(value, tuple) else str(value)
    name = (
        ", ".join(f"`{option} {shown}`".replace(" `", "`") for option in action.option_strings)
        or f"`{shown}`"
    )
    what = (action.help or "").replace("%%", "%")
    return f"{name}\n: {_sentence(what)}"


def studies_of(kind: str) -> Callable[[], str]:
    """Return a function that makes the table of the built-in cases or scans."""

    def table() -> str:
        rows = [f"| `{name}` | {_escape(library.title(name))} |" for name in library.names(kind)]
        return "\n".join(["| name | content |", "|---|---|", *rows])

    return table


def report_studies() -> str:
    """Return the table of the studies that a report can make."""
    rows = []
    for name, module in STUDIES.items():
        found = importlib.import_module(module)
        title = (
            getattr(found, "TITLE", "") or (getattr(found, "__doc__", "") or "").partition("\n")[0]
        )
        rows.append(f"| `{name}` | {_escape(title.rstrip('.'))} |")
    return "\n".join(["| name | title |", "|---|---|", *rows])


def materials() -> str:
    """Return the table of the materials that come with the package."""
    rows = []
    for name, preset in presets().items():
        strength = "-"
        if preset.yield_strength is not None:
            strength = f"{preset.yield_strength / 1e6:g}"
        elastic = f"{preset.youngs_modulus / 1e9:g} | {preset.poisson_ratio:g}"
        source = _escape(preset.source or "")
        rows.append(f"| `{name}` | {elastic} | {preset.density:g} | {strength} | {source} |")
    head = (
        "| name | Young's modulus, GPa | Poisson's ratio | density, kg/m³ | yield strength, MPa "
        "| source |"
    )
    return "\n".join([head, "|---|---|---|---|---|---|", *rows])


def lattices() -> str:
    """Return the table of the packings."""
    rows = [
        f"| `{name}` | {kind.label} | `{kind.size_form}` | {kind.layers} |"
        for name, kind in lattice_kinds().items()
    ]
    head = "| kind | name | `packing.size` | its layers |"
    return "\n".join([head, "|---|---|---|---|", *rows])


def figures() -> str:
    """Return the list of the figures of a run: name, content with the runs that have it, number of
    axes, and picture.
    """
    table = tomllib.loads((FIGURES / "figures.toml").read_text(encoding="utf-8"))
    runs = {}
    changes: dict[str, dict[str, Any]] = {}
    for entry in table["run"]:
        # an entry without changes of its own takes its figures from the first run of its case
        changes.setdefault(entry["case"], entry.get("changes", {}))
        drawn_run = {"changes": changes[entry["case"]]} | entry
        runs |= dict.fromkeys(entry["figures"], drawn_run)
    planes: dict[str, list[str]] = {}
    for name in run_figures():
        planes.setdefault(_PLANE.sub("_*", name), []).append(name)
    lines = ["| figure | content | axes | picture |", "|---|---|---|---|"]
    for title, names in planes.items():
        drawn = [name for name in names if name in runs]
        lines.append(_figure(title, names[0], drawn[0] if drawn else "", runs))
    return "\n".join(lines)


def _figure(title: str, first: str, drawn: str, runs: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the row of a figure.

    Parameters
    ----------
    title
        Its name, with a star for the plane.
    first
        Its name, on the first of the planes, whose texts are shown without a picture.
    drawn
        Name of the picture that is shown; empty for none.
    runs
        Entries of figures.toml, by the names of figures.
    """
    figure = run_figures()[drawn or first]
    caption = _AT_PLANE.sub("", figure.caption) if title.endswith("*") else figure.caption
    text = f"**{_escape(caption)}.** {_escape(figure.look)}"
    if not drawn:
        return f"| `{title}` | {text} | {figure.n_axes} | - |"
    entry = runs[drawn]
    picture = f"![{_escape(caption)}](../figures/reference/figures/{drawn}.webp)"
    here = f"`{entry['case']}`{_changed(entry['changes'])}"
    return (
        f"| `{title}` | {text} *In {entry['runs']}; here {here}.* | {figure.n_axes} | {picture} |"
    )


def _changed(changes: Mapping[str, Any]) -> str:
    """Return the changes of the run of a picture, without keys of its output."""
    keys = [
        f"`{key} = {value}`"
        for key, value in changes.items()
        if not key.startswith("output.") and key != "run.frames"
    ]
    return f" with {', '.join(keys)}" if keys else ""


def law_parameters() -> str:
    """Return the table of the parameters of the contact laws."""
    head = "| law | key | values | default | meaning |"
    rows = []
    for law, entry in LAWS.items():
        for parameter in entry.parameters.values():
            table = "material" if parameter.of_material else "contact"
            key = f"`{table}.{parameter.name}`"
            values = _escape(values_of(parameter))
            default = "required" if parameter.required else f"`{parameter.default}`"
            what = _escape(parameter.description)
            rows.append(f"| `{law}` | {key} | {values} | {default} | {what} |")
    return "\n".join([head, "|---|---|---|---|---|", *rows])


def values_of(parameter: LawParameter) -> str:
    """Return the words of a parameter, or the range of its numbers and their unit."""
    if parameter.words:
        return " or ".join(parameter.words)
    signs = {"above": ">", "at_least": "≥", "below": "<", "at_most": "≤"}
    bounds = [f"{signs[name]} {bound:g}" for name, bound in parameter.case_range.items()]
    unit = f" {printed_unit(parameter.unit)}" if parameter.unit else ""
    return (", ".join(bounds) or "any number") + unit


def interface(package: str) -> str:
    """Return the public names of a package as autodoc directives, functions first."""
    module = importlib.import_module(package)
    lines = []
    for name in sorted(
        module.__all__, key=lambda name: (isinstance(getattr(module, name), type), name)
    ):
        found = getattr(module, name)
        directive = (
            "autoexception" if isinstance(found, type) and issubclass(found, Exception) else None
        )
        directive = directive or ("autoclass" if isinstance(found, type) else "autofunction")
        lines.append(f".. {directive}:: {package}.{name}")
        lines += ["   :members:", ""] if directive == "autoclass" else [""]
    return "\n".join(["```{eval-rst}", *lines, "```"])


def bibtex_entries() -> str:
    """Return the BibTeX entries of CITATION.cff."""
    return f"```bibtex\n{bibtex((ROOT / 'CITATION.cff').read_text(encoding='utf-8'))}\n```"


#: Functions that make the parts, by the names of their marks.
def fe_constants() -> dict[str, float]:
    """Return the constants of the law elastoplastic-fe by name, from their header."""
    text = (LAW_HEADERS / "elastoplastic_fe_constants.h").read_text(encoding="utf-8")
    pairs = re.findall(r"^  double (\w+) = ([-\d.e]+);$", text, re.MULTILINE)
    return {name: float(value) for name, value in pairs}


def fe_yield_coefficients() -> list[float]:
    """Return the coefficients of the yield factor of that law by rising power, from its header."""
    text = (LAW_HEADERS / "elastoplastic_fe.h").read_text(encoding="utf-8")
    _, _, body = text.partition("static double yield_factor(double nu)")
    polynomial = body.partition("return ")[2].partition(";")[0]
    return [float(number) for number in re.findall(r"\d+\.\d+", polynomial)]


def fe_constants_table() -> str:
    """Return the constants of the law elastoplastic-fe as a table of several columns."""
    cells = [f"| {name} | {value:g} " for name, value in fe_constants().items()]
    lines = ["| constant | value " * _COLUMNS + "|", "|---|---" * _COLUMNS + "|"]
    for start in range(0, len(cells), _COLUMNS):
        row = cells[start : start + _COLUMNS]
        lines.append("".join(row) + "| | " * (_COLUMNS - len(row)) + "|")
    return "\n".join(lines)


def fe_yield() -> str:
    """Return the polynomial of the yield factor of the law elastoplastic-fe as a formula."""
    first, *others = (f"{number:.10g}" for number in fe_yield_coefficients())
    terms = [f"{number}\\, \\nu^{power}" for power, number in enumerate(others, start=1)]
    terms[0] = terms[0].removesuffix("^1")
    middle = 3
    return "\n".join(
        [
            "$$",
            " + ".join(["C(\\nu) = " + first, *terms[:middle]]),
            "$$",
            "",
            "$$",
            "\\qquad + " + " + ".join(terms[middle:]),
            "$$",
        ]
    )


PARTS: dict[str, Callable[..., str]] = {
    "fe_constants": fe_constants_table,
    "fe_yield": fe_yield,
    "keys": keys_of,
    "quantities": quantities,
    "result_data_sets": result_data_sets,
    "commands": commands,
    "cases": studies_of(library.CASES),
    "scans": studies_of(library.SCANS),
    "studies": report_studies,
    "materials": materials,
    "lattices": lattices,
    "figures": figures,
    "law_parameters": law_parameters,
    "interface": interface,
    "other_commands": lambda: other_commands(MANUAL),
    "bibtex": bibtex_entries,
}


# of summaries that only results of a kind have
for _kind in report_kinds():
    PARTS |= {name: partial(_table_of, table) for name, table in _kind.tables.items()}


def part_of(mark: re.Match[str]) -> str:
    """Return the part that a mark names as MyST Markdown; an unknown mark is returned unchanged."""
    name = mark["name"]
    argument = mark["argument"]
    if name not in PARTS:
        return mark[0]
    return PARTS[name](argument) if argument else PARTS[name]()
