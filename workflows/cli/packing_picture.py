"""Option ``--picture`` of ``granwave check``: a drawing of the packing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly


def draw_packing(path: Path | None, assembled: Any) -> None:
    """Draw a packing if there is a path to draw it to.

    Raises
    ------
    InputError
        The case is none of a packing, or the path has another suffix, or is another's file.
    """
    if path is None:
        return
    if not isinstance(assembled, Assembly):
        raise InputError(
            "--picture: this case has no packing; remove the option, or use a case of granwave run"
        )
    # imported on demand: slow to load
    from granwave.analysis.figures.packing_sketch import write_packing

    write_packing(assembled, path)
