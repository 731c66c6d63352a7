"""The site: its pages of commands, notebooks, citation, links."""

from __future__ import annotations

import argparse
import ast
import json
import re
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from granwave.analysis.exports.names import export_names
from granwave.extensions.pictures.films import QUANTITIES, VIEWS
from granwave.workflows.cli.parser import make_parser
from tests.conftest import BIN, PLAIN
from tests.documents.pages import ROOT, blocks, extension, name_of, pages, write_files

yaml = pytest.importorskip("yaml")
RUN = [page for page in pages() if any(block.language == "shell" for block in blocks(page))]


def test_pages_to_run_are_found():
    assert {"README.md", "docs/start.md", "docs/howto/questions.md"} <= set(map(name_of, RUN))


@pytest.mark.validation
@pytest.mark.parametrize("page", RUN, ids=name_of)
def test_commands_run(page, tmp_path):
    """Commands in blocks of ``shell`` run one after the other, and print the lines that the page
    shows.
    """
    write_files(page, tmp_path)
    environment = PLAIN | {"PATH": f"{BIN}:{PLAIN['PATH']}"}
    printed = ""
    for block in blocks(page):
        if block.language == "shell":
            done = subprocess.run(
                ["bash", "-euc", block.text],
                cwd=tmp_path,
                env=environment,
                capture_output=True,
                text=True,
                timeout=900,
            )
            assert done.returncode == 0, f"{block.text}{done.stderr}"
            printed = done.stdout
        elif block.output:
            for line in filter(None, block.text.splitlines()):
                assert line in printed, f"{name_of(page)} shows a line that is not printed: {line}"


STUDIES = extension("studies")  # runs the gallery


def test_every_script_of_the_gallery_has_a_title_and_a_text():
    assert len(STUDIES.scripts()) >= 10
    for script in STUDIES.scripts():
        title, text, code = STUDIES.parts_of(script)
        assert title and not title.endswith(".") and text and "picture.png" in code, script.name


def test_twelve_scripts_stand_on_the_first_page_with_few_lines_each():
    assert len(set(STUDIES.FIRST)) == 12
    for name in STUDIES.FIRST:
        lines = STUDIES.lines_of(STUDIES.SCRIPTS / f"{name}.py")
        ast.parse(lines)
        assert (
            "gw." in lines
            and 1 <= len(list(filter(None, lines.splitlines()))) <= STUDIES.MOST_LINES
        ), name
    text = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert "<!-- gallery -->" in text


def test_the_lammps_script_of_the_first_page_runs(tmp_path):
    """The script uses the packing of the case file next to it; the energy input is recovered."""
    page = ROOT / "docs" / "index.md"
    write_files(page, tmp_path)
    (script,) = (block.text for block in blocks(page) if block.language == "LAMMPS")
    (tmp_path / "in.mine").write_text(script, encoding="utf-8")
    for command in (
        ["granwave", "write", "mine.toml", "-o", "."],
        ["lmp", "-in", "in.mine", "-log", "log.mine"],
    ):
        done = subprocess.run(
            [BIN / command[0], *command[1:]],
            cwd=tmp_path,
            env=PLAIN,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stdout + done.stderr
    table = re.findall(
        r"^ +\d+ +(\S+) +(\S+) +(\S+) *$", (tmp_path / "log.mine").read_text(), re.MULTILINE
    )
    first, last = ([float(value) for value in row] for row in table)
    assert sum(last) == pytest.approx(first[0], rel=1e-5) and last[2] > 0.8 * first[0]


def test_scripts_of_the_gallery_import_the_public_door_alone():
    for script in STUDIES.scripts():
        for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.startswith("granwave.")], script.name


@pytest.mark.validation
def test_every_script_of_the_gallery_takes_less_than_a_minute(tmp_path, monkeypatch):
    monkeypatch.setattr(STUDIES, "RUNS", Path(tmp_path))
    for script in STUDIES.scripts():
        assert STUDIES.run(script, "") < STUDIES.LONGEST, script.name


def test_no_description_begins_with_an_accepted_value():
    """The page turns the text into a sentence: a word to be typed at its beginning would be
    capitalised.
    """
    accepted = {*export_names(), *QUANTITIES, *VIEWS}
    (verbs,) = (
        action
        for action in make_parser()._actions
        if isinstance(action, argparse._SubParsersAction)
    )
    for name, verb in verbs.choices.items():
        for action in verb._actions:
            first = re.split(r"[ ,;:(]", action.help or "")[0]
            words = accepted | set(map(str, action.choices or ()))
            assert first and first not in words and not first.startswith((".", "-")), (
                f"granwave {name}: {action.help}"
            )


def test_the_menu_has_the_headings_of_groups():
    """Each caption stands above the first page of its group, also if that page is shown."""
    pytest.importorskip("sphinx", reason="make docs installs it")
    add_groups = extension("menu_groups").add_groups
    builder = SimpleNamespace(get_relative_uri=lambda page, other: f"../{other}.html")
    app = SimpleNamespace(menu_groups={"howto/questions": "Questions & answers"}, builder=builder)
    heading = '<li class="menu-group">Questions &amp; answers</li>'
    for page, link in {"howto/scans": "../howto/questions.html", "howto/questions": "#"}.items():
        entry = f'<li class="toctree-l2"><a class="reference internal" href="{link}">Ten</a></li>'
        context = {"furo_navigation_tree": f"<ul>{entry}</ul>"}
        add_groups(app, page, "page.html", context, None)
        assert context["furo_navigation_tree"] == f"<ul>{heading}{entry}</ul>"


def test_pictures_are_links_and_names_break_at_separators():
    pytest.importorskip("sphinx", reason="make docs installs it")
    elements = extension("page_elements")
    picture = '<img alt="a" src="../_images/a.webp" />'
    linked = f'<a class="picture" href="../_images/a.webp">{picture}</a>'
    assert elements.with_linked_pictures(f"<p>{picture}</p>") == f"<p>{linked}</p>"
    assert elements.with_linked_pictures(linked) == linked
    other_site = '<img src="https://a/b.png">'
    assert elements.with_linked_pictures(other_site) == other_site
    wide = linked.replace('"picture"', '"picture wide"')
    assert elements.with_linked_pictures(picture, {"../_images/a.webp": 1200}.get) == wide
    assert elements.with_linked_pictures(picture, {"../_images/a.webp": 450}.get) == linked
    code = '<code><span class="pre">area_slope</span></code> area_slope'
    assert elements.with_breaks(code) == code.replace("area_slope", "area_<wbr>slope", 1)


def test_numbers_stay_with_their_units():
    pytest.importorskip("sphinx", reason="make docs installs it")
    elements = extension("page_elements")
    text = "<p>+15.4 % (1.3 times), 469 m/s</p><td>12 spheres, 3 min</td>"
    code = '<pre><span>5 %</span></pre><code>5 m</code><img alt="5 m">'
    joined = text.replace("15.4 %", "15.4\xa0%").replace("469 m/s", "469\xa0m/s")
    assert elements.with_units(text + code) == joined + code


def test_equations_have_the_font_of_the_site_first(tmp_path):
    """The build copies the font next to its licence; the style sheet names it before all others."""
    pytest.importorskip("ziamath", reason="make docs installs it")
    font = extension("math_font")
    (tmp_path / "_static").mkdir()
    builder = SimpleNamespace(format="html")
    font.copy_font(SimpleNamespace(builder=builder, outdir=tmp_path), None)
    assert (tmp_path / "_static" / font.FONT).stat().st_size > 1e6
    static = ROOT / "docs" / "_static"
    styles = (static / "granwave.css").read_text(encoding="utf-8")
    name = re.search(r'font-family: ("[^"]+");\s*src: url\("' + font.FONT, styles)[1]
    assert f"math {{ font-family: {name}," in styles
    assert "SIL Open Font License" in (static / "STIXTwoMath-OFL.txt").read_text(encoding="utf-8")


def test_pages_of_notebooks_link_to_the_notebook():
    pytest.importorskip("sphinx", reason="make docs installs it")
    body = extension("notebook_links").with_link("<h1>A</h1><h1>B</h1>", "a.ipynb")
    assert body.count('href="../_downloads/a.ipynb"') == 1
    assert body.startswith("<h1>A</h1>\n<p>Download ")


def formulas(text: str) -> list[str]:
    """Return the formulas of a text in Markdown."""
    markdown = pytest.importorskip("markdown_it", reason="make docs installs it").MarkdownIt()
    markdown.enable("table")
    markdown.use(pytest.importorskip("mdit_py_plugins.dollarmath").dollarmath_plugin)
    tokens = markdown.parse(text)
    for token in tuple(tokens):
        tokens += token.children or ()
    return [token.content for token in tokens if token.type.startswith("math")]


def test_formulas_of_pages_become_mathml_without_rests_of_tex():
    pytest.importorskip("latex2mathml", reason="make docs installs it")
    mathml_of = extension("mathml").mathml_of
    texts = {name_of(page): page.read_text(encoding="utf-8") for page in pages()}
    for path in sorted((ROOT / "plugins" / "doc").glob("*.md")):
        texts[path.name] = path.read_text(encoding="utf-8")
    for script in STUDIES.scripts():
        texts[script.name] = STUDIES.parts_of(script)[1]
    read = {name: formulas(text) for name, text in texts.items()}
    assert sum(map(len, read.values())) > 200
    for name, page_formulas in read.items():
        for formula in page_formulas:
            assert mathml_of(formula, "block").startswith("<math"), name


def test_bars_of_a_magnitude_are_fences():
    pytest.importorskip("latex2mathml", reason="make docs installs it")
    mathml = extension("mathml").mathml_of(r"a - \lvert x\rvert", "inline")
    assert re.findall(r'form="(\w+)">&#x0007C;', mathml) == ["prefix", "postfix"]


@pytest.mark.parametrize("formula, rest", [
    (r"\begin{aligned} F &= 1 \\ G &= 2 \end{aligned}", "&"),
    (r"a & b", "&"),
    (r"\nosuchcommand x", r"\\nosuchcommand"),
])  # fmt: skip
def test_a_formula_that_would_show_tex_stops_the_build(formula, rest):
    pytest.importorskip("latex2mathml", reason="make docs installs it")
    errors = pytest.importorskip("sphinx.errors")
    with pytest.raises(errors.ExtensionError, match=f"would be shown with .*{rest}"):
        extension("mathml").mathml_of(formula, "block")


NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
IN_EVERY_TEST = "own-material-and-fields"
LONGEST = 60.0  # s, on a machine that does other things too; alone they take less than 10


def cells(notebook: Path) -> list[dict]:
    return json.loads(notebook.read_text(encoding="utf-8"))["cells"]


def test_notebooks_have_no_outputs():
    """Each notebook begins with a title; outputs are generated with the site."""
    assert len(NOTEBOOKS) >= 3 and IN_EVERY_TEST in [notebook.stem for notebook in NOTEBOOKS]
    for notebook in NOTEBOOKS:
        first, *rest = cells(notebook)
        assert first["cell_type"] == "markdown" and "".join(first["source"]).startswith("# ")
        assert not any(cell.get("outputs") or cell.get("execution_count") for cell in rest), (
            notebook.name
        )


def test_notebooks_are_on_the_page_on_python():
    page = (ROOT / "docs" / "howto" / "python.md").read_text(encoding="utf-8")
    assert all(f"(../notebooks/{notebook.name})" in page for notebook in NOTEBOOKS)


@pytest.mark.parametrize("name", [
    IN_EVERY_TEST,
    *(pytest.param(n.stem, marks=pytest.mark.validation) for n in NOTEBOOKS if n.stem != IN_EVERY_TEST),
])  # fmt: skip
def test_notebooks_run(name, tmp_path):
    if name != IN_EVERY_TEST:
        pytest.importorskip(
            "IPython", reason="a notebook shows a picture with it; make docs installs it"
        )
    code = ["".join(cell["source"]) for cell in cells(ROOT / "docs" / "notebooks" / f"{name}.ipynb")
            if cell["cell_type"] == "code"]  # fmt: skip
    (tmp_path / "notebook.py").write_text("\n".join(code), encoding="utf-8")
    start = time.monotonic()
    environment = PLAIN | {"MPLBACKEND": "agg"}
    done = subprocess.run(
        [sys.executable, "notebook.py"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert time.monotonic() - start < LONGEST


def test_bibtex_has_all_works_and_authors():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    program = yaml.safe_load(citation)
    entries = extension("bibtex").bibtex(citation).split("\n\n")
    assert [re.match(r"@(\w+)\{(\w+),\n", entry).groups() for entry in entries] == [
        ("software", "granwave"), ("article", "thompson2022"), ("phdthesis", "pal2015"),
    ]  # fmt: skip
    for work, entry in zip([program, *program["references"]], entries, strict=True):
        fields = dict(re.findall(r"^  (\w+) *= \{(.*)\},$", entry, re.MULTILINE))
        assert len(fields["author"].split(" and ")) == len(work["authors"])
        assert fields["title"] == f"{{{work['title']}}}"
        year = work["year"] if "year" in work else work["date-released"].year
        assert fields.get("doi") == work.get("doi") and fields["year"] == str(year)
        assert entry.count("{") == entry.count("}")
    assert "school = {University of Illinois at Urbana-Champaign}" in entries[2]


def test_bibtex_escapes_and_refuses():
    module = extension("bibtex")
    work = 'type: article\ntitle: "A & B, 5 %"\nauthors: [{family-names: "O_x", given-names: A.}]\nyear: 2000\n'
    assert r"title  = {{A \& B, 5 \%}}" in module.bibtex(work) and r"O\_x, A." in module.bibtex(
        work
    )
    with pytest.raises(ValueError, match="found type map, expected one of"):
        module.bibtex(work.replace("article", "map"))


def test_dead_links_are_told_from_those_that_cannot_be_checked():
    def link(uri: str, status: str, info: str = "") -> dict[str, str]:
        return {"filename": "page.md", "lineno": 3, "uri": uri, "status": status, "info": info}

    links = [
        link("https://a", "working"),
        link("https://a", "working"),
        link("https://b", "redirected", "https://c"),
        link("https://d", "broken", "404 Client Error: Not Found for url: https://d"),
        link("https://d", "broken", "404 Client Error: Not Found for url: https://d"),
        link(
            "https://e",
            "broken",
            "HTTPSConnectionPool: Max retries exceeded (Failed to resolve 'e')",
        ),
        link("https://f", "timeout"),
        link("page", "local"),
    ]
    broken, unknown, good = extension("other_sites").sorted_out(links)
    assert broken == ["page.md:3: https://d: 404 Client Error: Not Found for url: https://d"]
    assert [line.split(": ")[1] for line in unknown] == ["https://e", "https://f"] and good == 2
