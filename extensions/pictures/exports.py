"""Formats of ``granwave export`` for ParaView and OVITO."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

from granwave.analysis.exports.formats import ExportFormat, of_result, staged
from granwave.analysis.exports.selection import Selection
from granwave.extensions.pictures import ovito_scene, to_vtp
from granwave.lammps_inputs.errors import InputError

OVITO_SCRIPT = "open_in_ovito.py"


def export_scene(directory: Path, output: Path) -> list[Path]:
    """Write the script that opens a run in OVITO; return its path.

    Parameters
    ----------
    directory
        Directory of the run.
    output
        Output directory.

    Raises
    ------
    InputError
        The run is not finished, or its dumps have several parts.
    """
    if ovito_scene.in_parts(directory):
        raise InputError(
            f"{directory}: the dumps have several parts (output.parts), which OVITO cannot "
            "combine; use --to vtp"
        )
    if missing := ovito_scene.missing_files(directory):
        raise InputError(
            f"{directory}: {', '.join(missing)} missing; OVITO reads the dumps of LAMMPS: "
            "expected the directory of a finished run"
        )
    source = Path(ovito_scene.__file__).read_text(encoding="utf-8")
    run = os.path.relpath(directory.resolve(), output.resolve())
    with staged(output) as (path_of, placed):
        text = source.replace(f"RUN = {json.dumps(ovito_scene.RUN)}", f"RUN = {json.dumps(run)}", 1)
        path_of(OVITO_SCRIPT).write_text(text, encoding="utf-8")
    return placed


def _select_vtp(selected: Selection, _parts: tuple[str, ...]) -> Callable[[Path, Path], list[Path]]:
    """Return the function that writes selected spheres and contacts."""
    return of_result(partial(to_vtp.export_run, selected=selected), to_vtp.OUTDATED)


VTP = ExportFormat(
    "spheres.pvd and contacts.pvd (ParaView)",
    of_result(to_vtp.export_run, to_vtp.OUTDATED),
    select=_select_vtp,
)
OVITO = ExportFormat(f"{OVITO_SCRIPT}, which opens spheres and contacts together", export_scene)
