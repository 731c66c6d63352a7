"""Report on any number of runs and scans, as a single HTML page, PDF or Markdown file.

Equal inputs give equal bytes: a report has no date, does not depend on the order of files on the
disk, and shows paths relative to itself.

HTML and Markdown are written by ``templates``; the PDF is the printed page of a browser.
"""

from __future__ import annotations

import base64
import hashlib
import io
import os
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

import jinja2
import matplotlib as mpl
from markupsafe import Markup, escape

from granwave.analysis.document.model import DocumentTable, Figure, Report, cleaned
from granwave.analysis.document.symbols import with_symbols
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.reports.inputs import ReportInputs, read_inputs
from granwave.analysis.reports.kinds import report_kinds
from granwave.analysis.reports.outline import build_report, report_with_studies
from granwave.analysis.reports.setting import IDEAL
from granwave.analysis.reports.studies import ReportStudies
from granwave.analysis.studies.registry import find_studies
from granwave.lammps_inputs.directories import output_path, refuse_other_file
from granwave.lammps_inputs.errors import InputError, InputFault, RunError
from granwave.lammps_inputs.files import head, replace_bytes, replace_text
from granwave.lammps_inputs.result_directory import ResultDirectory

Filters = Mapping[str, Callable[..., Any]]  # functions by their names in templates
_FOLDER = Path(__file__).with_name("templates")


def _rendered(name: str, filters: Filters, *, escapes: bool, **values: Any) -> str:
    """Fill in a template, in which an unknown name is an error; with ``escapes`` all texts are
    escaped for HTML.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_FOLDER),
        autoescape=escapes,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters.update(filters)
    return environment.get_template(name).render(**values)


def text_of(name: str) -> str:
    """Return the text of a file of the folder."""
    return (_FOLDER / name).read_text(encoding="utf-8")


_ACROSS = 12  # most columns of a table on a page of paper
_MEANING_OF_IDEAL = "identical spheres, no friction, no damping"
_IDEAL_AT_END = re.compile(rf", {IDEAL}(?=[);.]|$)")  # of the description of a run
_BREAK = re.compile(r"(_|\.(?!\d))")  # of a key, after which a line may break
_MOST_KEYS = 4  # key columns that are repeated in its parts


def html_page(report: Report, *, paper: bool = False) -> str:
    """Return the page; its Content-Security-Policy allows only its own script, style and embedded
    images.

    Parameters
    ----------
    paper
        True for the page that the PDF prints: unfolded, without script, policy and links to files.
    """
    css = text_of("report.css") + text_of("print.css")
    script = text_of("report.js")
    own = f"style-src '{_hash(css)}'; script-src '{_hash(script)}'"
    policy = f"default-src 'none'; img-src data:; {own}; base-uri 'none'; form-action 'none'"
    titles = {section.slug: section.title for section in report.sections}
    filters: Filters = {
        "data_uri": data_uri,
        "csv_uri": csv_uri,
        "breakable": breakable,
        "parts": parts,
        "symbols": partial(with_symbols, paper=paper),
        "heading": partial(heading, paper=paper),
        "lead": partial(lead, paper=paper),
    }
    values = {
        "titles": titles,
        "css": Markup(css),
        "script": Markup(script),
        "policy": policy,
        "paper": paper,
    }
    return _rendered("report.html.j2", filters, escapes=True, report=report, **values).lstrip()


def data_uri(png: bytes) -> str:
    """Return the data URI of an image."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def csv_uri(text: bytes) -> str:
    """Return the data URI of a table."""
    return "data:text/csv;base64," + base64.b64encode(text).decode("ascii")


def lead(text: str, *, paper: bool = False) -> Markup:
    """Return the first line of a report with its symbols; on a screen, the word for packings
    without imperfections is explained.
    """
    shown = with_symbols(text, paper=paper)
    if paper:
        return shown
    explained = f'<span class="explained" title="{_MEANING_OF_IDEAL}">{IDEAL}</span>'
    return Markup(_IDEAL_AT_END.sub(f", {explained}", str(shown)))


def heading(name: str, *, paper: bool = False) -> Markup:
    """Return the heading of a column: a key with line breaks, or words with their symbols."""
    text = with_symbols(name, paper=paper)
    return breakable(name) if text == escape(name) else text


def breakable(name: str) -> Markup:
    """Allow line breaks after dots and underscores of a key, but not within numbers."""
    text = str(escape(name))
    return Markup(_BREAK.sub(r"\1<wbr>", text))


def parts(table: DocumentTable) -> list[DocumentTable]:
    """Split a table into tables that are narrow enough for paper, each with the key columns.

    The other columns are shared out evenly; the captions count the parts.
    """
    keys = [n for n, column in enumerate(table.columns) if column.key][:_MOST_KEYS]
    others = [n for n in range(len(table.columns)) if n not in keys]
    number = -(-len(others) // (_ACROSS - len(keys)))
    if number < 2:
        return [table]
    found = []
    for part in range(number):
        kept = [*keys, *others[part * len(others) // number : (part + 1) * len(others) // number]]
        caption = f"{table.caption}, part {part + 1} of {number}"
        is_last = part + 1 == number
        footnotes = table.footnotes if is_last else ()
        found.append(table.keeping(kept, caption=caption, captioned=True, footnotes=footnotes))
    return found


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode(
        "ascii"
    )


_SPECIAL = re.compile(r"([\\`*_\[\]|~#$])")
_LINE_START = re.compile(r"^(\d*)([-+.)])(?=\s)")  # characters that begin a list in Markdown
_BLANK_LINES = re.compile(r"\n{3,}")


def markdown(report: Report, folder: str) -> tuple[str, dict[str, bytes]]:
    """Return the text, and the images by file name.

    Parameters
    ----------
    folder
        Name of the directory of the images next to the text.
    """
    pictures: dict[str, bytes] = {}

    def file(figure: Figure) -> str:
        """Store the image of a figure, and return its path relative to the text."""
        name = f"{figure.name}.png"
        number = 2
        while name in pictures and pictures[name] != figure.png:
            name = f"{figure.name}-{number}.png"
            number = number + 1
        pictures[name] = figure.png
        return f"{quote(folder)}/{name}"

    titles = {section.slug: section.title for section in report.sections}
    anchors = {
        slug: title.lower().replace(" ", "-") for slug, title in titles.items()
    }  # replaced as by GitHub
    filters: Filters = {
        "escaped": _escape, "paragraph": lambda text: _LINE_START.sub(r"\1\\\2", _escape(text)), "file": file,
    }  # fmt: skip
    text = _rendered(
        "report.md.j2", filters, escapes=False, report=report, titles=titles, anchors=anchors
    )
    return _BLANK_LINES.sub("\n\n", text).strip() + "\n", pictures


def _escape(text: str) -> str:
    """Escape markup in a text, and put it on one line."""
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()))


_FONTS = {"normal": "DejaVuSans.ttf", "bold": "DejaVuSans-Bold.ttf"}  # come with matplotlib
_MARK = b"% report of granwave\n"  # readers skip bytes after the end of the PDF
_ADDRESS = "granwave:/"  # address of the page and of its fonts


def pdf_file(report: Report) -> bytes:
    """Return the PDF; it has no date, so that equal reports give equal bytes.

    It ends with a comment by which granwave recognises it.

    Raises
    ------
    InputError
        PlutoPrint is not installed.
    """
    try:
        import plutoprint
    except ImportError as error:
        raise InputError(
            f"PDF: requires PlutoPrint, which cannot be loaded ({error}); install it, pip install "
            '"granwave[pdf]", or write .html and print it from a browser'
        ) from None

    class OwnFiles(plutoprint.ResourceFetcher):
        """Images in the page, and its fonts: neither files nor the network are read, whatever a
        text contains.
        """

        def fetch_url(self, url: str) -> plutoprint.ResourceData:
            if url.startswith("data:"):
                return plutoprint.default_resource_fetcher.fetch_url(url)
            name = url.removeprefix(_ADDRESS)
            if name not in _FONTS.values():
                raise ValueError(f"{url}: not of this page")
            return plutoprint.ResourceData(
                (Path(mpl.get_data_path(), "fonts", "ttf", name)).read_bytes(), "font/ttf"
            )

    book = plutoprint.Book(plutoprint.PAGE_SIZE_A4.landscape(), media=plutoprint.MEDIA_TYPE_PRINT)
    book.custom_resource_fetcher = OwnFiles()
    book.load_html(html_page(report, paper=True), user_style=_font_faces(), base_url=_ADDRESS)
    book.set_metadata(plutoprint.PDF_METADATA_TITLE, report.title)
    book.set_metadata(plutoprint.PDF_METADATA_AUTHOR, "granwave")
    book.set_metadata(plutoprint.PDF_METADATA_CREATION_DATE, "2000-01-01T00:00:00Z")
    stream = io.BytesIO()
    book.write_to_pdf_stream(stream)
    return stream.getvalue().rstrip() + b"\n" + _MARK


def _font_faces() -> str:
    """Return the style that embeds the fonts, so that text looks the same on every machine."""
    faces = (
        f'@font-face {{ font-family: "Granwave Sans"; font-weight: {weight}; src: url("{_ADDRESS}{quote(name)}"); }}'
        for weight, name in _FONTS.items()
    )
    return "\n".join([*faces, 'body { font-family: "Granwave Sans" !important; }'])


SUFFIXES = (".html", ".pdf", ".md")
_OWN = {  # patterns that match every report
    ".html": rb'<meta name="generator" content="granwave">',
    ".pdf": rb"%%EOF\n% report of granwave\n\Z",
    ".md": rb"\A# (?:Report|Comparison): .*\n\n(?!1 run\.)(\d+ runs?)?( and )?(\d+ scans? with \d+ of \d+ points done)?"
    rb"(: .+|\. SI units)?\.\n",
}


def write_report(
    directories: Sequence[str | Path],
    output: str | Path,
    studies: Sequence[str] = (),
    study_files: Collection[str] = (),
) -> Path:
    """Write the report of runs and scans; an older report of this name is replaced.

    Parameters
    ----------
    directories
        Directories of runs and scans, in the order of the report. Scans may be unfinished.
    output
        Path of the report: ``.html``, ``.pdf`` or ``.md`` (with images in ``NAME_files`` next to
        it).
    studies
        Studies of all runs, in addition to those that the scans name: names, and paths of
        files, see `granwave.analysis.studies.registry`.
    study_files
        Absolute paths of files of studies that scans name and that may be loaded.

    Returns
    -------
    Path
        Path of the report.

    Raises
    ------
    InputError
        A directory is neither a run nor a scan, or is damaged; there is no such study; or the
        report cannot be written. Nothing was written.
    RunError
        Writing failed, on a full disk for instance; an older report remains.
    """
    output = output_path(output)
    errors = output_faults(output)
    report = None if errors else _whole_report(directories)
    if report is None:
        named, faults = find_studies(studies, Path())
        errors += [f"--study: {fault}" for fault in faults]
        try:
            files = {*study_files, *named}
            inputs = read_inputs(directories, output.parent, files, skip_unfinished=True)
        except InputError as error:
            errors += error.items
        if errors:
            raise InputError(errors)
        try:
            report = build_report(inputs, named)
        except (MissingOutputError, OutputFormatError) as error:  # in a file that a study needs
            raise InputError(str(error)) from None
    write_page(report, output)
    return output


def write_scan_report(inputs: ReportInputs, made: ReportStudies, output: Path) -> None:
    """Write the report of a scan or suite whose studies are made already.

    Raises
    ------
    InputError
        The report cannot be written; nothing was written.
    RunError
        Writing failed, on a full disk for instance; an older report remains.
    """
    errors = output_faults(output)
    if errors:
        raise InputError(errors)
    write_page(report_with_studies(inputs, made), output)


def write_page(report: Report, output: Path) -> None:
    """Write a report in the format of the suffix of a path; an older report of this name is
    replaced.

    Raises
    ------
    RunError
        Writing failed, on a full disk for instance; an older report remains.
    """
    try:
        _write(cleaned(report), output)
    except OSError as error:
        raise RunError(f"{output}: cannot be written: {error.strerror or error}") from None


def _whole_report(directories: Sequence[str | Path]) -> Report | None:
    """Return the report of a single directory that has a separate report; otherwise None."""
    if len(directories) != 1:
        return None
    results = ResultDirectory(directories[0])
    kinds = {kind.result_kind: kind for kind in report_kinds()}
    kind = kinds.get(results.kind.name)
    return None if kind is None else kind.whole_report(results.path)


def output_faults(output: Path) -> list[str | InputFault]:
    """Return why a report cannot be written to a path; empty if it can."""
    errors: list[str | InputFault] = []
    suffix = output.suffix.lower()
    parent = output.parent
    if suffix not in SUFFIXES:
        found = f"the suffix {output.suffix}" if suffix else "no suffix"
        errors.append(
            f"{output}: found {found}, expected {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
        )
    if output.is_dir():
        errors.append(f"{output}: is a directory, expected the name of a file")
    elif not parent.is_dir():
        errors.append(f"{output}: the directory {parent} does not exist; create it first")
    elif not os.access(parent, os.W_OK | os.X_OK):
        errors.append(
            f"{output}: the directory {parent.resolve()} cannot be written to; choose another with directory=..."
        )
    elif suffix == ".md" and (folder := _folder(output)).exists() and not folder.is_dir():
        errors.append(
            f"{folder}: is a file, but the figures of {output.name} require a directory of this "
            "name; move it elsewhere"
        )
    elif suffix in SUFFIXES:
        try:
            refuse_other_file(output, _OWN[suffix])
        except InputError as error:
            errors += error.items
    return errors


def _folder(output: Path) -> Path:
    return output.with_name(f"{output.stem}_files")


def _write(report: Report, output: Path) -> None:
    suffix = output.suffix.lower()
    if suffix != ".md":
        replace_bytes(
            output, html_page(report).encode("utf-8") if suffix == ".html" else pdf_file(report)
        )
        return
    folder = _folder(output)
    text, pictures = markdown(report, folder.name)
    # images that the older report shows
    shown = rf"!\[[^\n]*\]\({re.escape(quote(folder.name))}/([\w.-]+)\)"
    before = set(re.findall(shown, head(output).decode("utf-8", "replace")))
    if others := [
        name for name in pictures if name not in before and os.path.lexists(folder / name)
    ]:
        raise InputError(
            f"{folder / others[0]}: would be overwritten, but is not a figure of {output.name}; "
            "choose another name with directory=..."
        )
    if pictures:
        folder.mkdir(exist_ok=True)
    for name, png in pictures.items():
        replace_bytes(folder / name, png)
    replace_text(output, text)
    for name in set() if folder.is_symlink() else before - pictures.keys():
        (folder / name).unlink(missing_ok=True)
