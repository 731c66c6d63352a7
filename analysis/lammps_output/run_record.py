"""Reader of the driver's record of a run, ``run.json``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.number_rows import AGAIN
from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.run_directory import RECORD_FILE

_RECORDED = {"n_steps": int, "wall_time_s": int | float, "versions": dict}  # values that are used, with their types


def read_record(directory: str | Path) -> dict[str, Any]:
    """Read the driver's record of the run (``run.json``); empty if there is none.

    Raises
    ------
    OutputFormatError
        The file is damaged.
    """
    path = Path(directory) / RECORD_FILE
    if not path.exists():
        return {}
    record = read_json(path)
    if record is None or any(not isinstance(record[name], kind) for name, kind in _RECORDED.items() if name in record):
        raise OutputFormatError(f"{path} cannot be read: delete it, or {AGAIN}")
    return record
