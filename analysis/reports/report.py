"""Report on any number of runs, scans and continuum runs, as one HTML page, PDF or Markdown.

Equal inputs give equal bytes: a report has no date, does not depend on the order of files on the disk, and shows paths
relative to itself.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Sequence
from pathlib import Path
from urllib.parse import quote

from granwave.analysis.document.model import Report, cleaned
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.reports.design import design_report
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.outline import build_report
from granwave.analysis.studies.registry import find_studies
from granwave.lammps_inputs.directories import output_path, refuse_other_file
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.files import head, replace_bytes, replace_text
from granwave.lammps_inputs.run_directory import is_design

SUFFIXES = (".html", ".pdf", ".md")
_OWN = {  # patterns that match every report
    ".html": rb'<meta name="generator" content="granwave">',
    ".pdf": rb"%%EOF\n% report of granwave\n\Z|/Creator \(granwave\)",  # the second until version 0.2
    ".md": rb"\A# Report: .*\n\n(?!1 run\.)(\d+ runs?)?( and )?(\d+ scans? with \d+ of \d+ points done)?"
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
        Path of the report: ``.html``, ``.pdf`` or ``.md`` (with pictures in ``NAME_files`` beside it).
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
        A directory is neither a run nor a scan, or is damaged; there is no such study; or the report cannot be written.
        Nothing was written.
    RunError
        Writing failed, on a full disk for instance; an older report remains.
    """
    output = output_path(output)
    errors = _errors_in(output)
    if len(directories) == 1 and is_design(directories[0]) and not errors:
        return _written(design_report(Path(directories[0])), output)
    named, faults = find_studies(studies, Path())
    errors += [f"--study: {fault}" for fault in faults]
    try:
        inputs = read_inputs(directories, output.parent, {*study_files, *named})
    except InputError as error:
        errors += error.errors
    if errors:
        raise InputError(errors)
    try:
        report = build_report(inputs, named)
    except (MissingOutputError, OutputFormatError) as error:  # in a file that a study needs
        raise InputError(str(error)) from None
    return _written(report, output)


def _written(report: Report, output: Path) -> Path:
    try:
        _write(cleaned(report), output)
    except OSError as error:
        raise RunError(f"{output}: cannot be written: {error.strerror or error}") from None
    return output


def _errors_in(output: Path) -> list[str]:
    errors = []
    if output.suffix.lower() not in SUFFIXES:
        found = f"the suffix {output.suffix}" if output.suffix else "no suffix"
        errors.append(f"{output}: found {found}, expected {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}")
    if output.is_dir():
        errors.append(f"{output}: is a directory, expected the name of a file")
    elif not output.parent.is_dir():
        errors.append(f"{output}: there is no directory {output.parent}; make it first")
    elif not os.access(output.parent, os.W_OK | os.X_OK):
        errors.append(f"{output}: the directory {output.parent.resolve()} cannot be written to; choose another with -o")
    elif output.suffix.lower() == ".md" and (folder := _folder(output)).exists() and not folder.is_dir():
        errors.append(
            f"{folder}: is a file, but pictures of {output.name} go to a directory of that name; move it away"
        )
    elif own := _OWN.get(output.suffix.lower()):
        try:
            refuse_other_file(output, own)
        except InputError as error:
            errors += error.errors
    return errors


def _folder(output: Path) -> Path:
    return output.with_name(f"{output.stem}_files")


def _write(report: Report, output: Path) -> None:
    suffix = output.suffix.lower()
    if suffix == ".html":
        from granwave.analysis.reports.writers import html_page

        replace_text(output, html_page(report))
    elif suffix == ".pdf":
        from granwave.analysis.reports.writers import pdf_file

        replace_bytes(output, pdf_file(report))
    else:
        from granwave.analysis.reports.writers import markdown

        folder = _folder(output)
        text, pictures = markdown(report, folder.name)
        before = _pictures_of(output, folder)
        if others := [name for name in pictures if name not in before and os.path.lexists(folder / name)]:
            raise InputError(
                f"{folder / others[0]}: would be overwritten, and is no picture of {output.name}; choose another -o"
            )
        if pictures:
            folder.mkdir(exist_ok=True)
        for name, png in pictures.items():
            replace_bytes(folder / name, png)
        replace_text(output, text)
        for name in set() if folder.is_symlink() else before - pictures.keys():
            (folder / name).unlink(missing_ok=True)


def _pictures_of(report: Path, folder: Path) -> set[str]:
    """Return the names of the pictures that a Markdown report shows from its folder."""
    text = head(report).decode("utf-8", "replace")
    return set(re.findall(rf"!\[[^\n]*\]\({re.escape(quote(folder.name))}/([\w.-]+)\)", text))
