"""Energy balance during a run, read from the growing ledger."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

from granwave.analysis.result.balance import misfit, work_on_packing

TOLERANCE = 1e-5  # largest accepted error at any row of the ledger over the energy input


@dataclasses.dataclass
class Balance:
    """Ledger up to its last complete line.

    Attributes
    ----------
    accepted
        Largest error that is accepted: `TOLERANCE`, or ``run.energy_tolerance`` if that is larger.
    error
        Largest error so far over the largest input, see `granwave.analysis.result.balance`; NaN if any value is NaN.
    moved
        Mass of the grains whose displacement is prescribed, kg.
    row
        Last row, by column.
    """

    path: Path
    accepted: float = TOLERANCE
    moved: float = 0.0
    error: float = 0.0
    _missed: float = 0.0
    _input: float = 0.0
    row: dict[str, float] = dataclasses.field(default_factory=dict)
    _offset: int = 0
    _columns: tuple[str, ...] = ()

    def read(self) -> Balance:
        """Read the rows that LAMMPS has written since the last call."""
        try:
            with self.path.open("rb") as stream:
                stream.seek(self._offset)
                block = stream.read()
        except FileNotFoundError:
            return self
        whole = block[: block.rfind(b"\n") + 1]
        self._offset += len(whole)
        for line in whole.decode("ascii").splitlines():
            self._take(line)
        return self

    def _take(self, line: str) -> None:
        if line.startswith("#"):
            words = tuple(line.lstrip("#").split())
            self._columns = words if words[:1] == ("step",) else self._columns
            return
        self.row = dict(zip(self._columns, map(float, line.split()), strict=True))
        missed = misfit(self.row)
        self._missed = missed if math.isnan(missed) else max(self._missed, missed)
        self._input = max(self._input, work_on_packing(self.row, self.moved))
        if self._missed != 0:  # NaN too
            self.error = self._missed / self._input if self._input else math.inf

    @property
    def closed(self) -> bool:
        """True if the balance has closed so far."""
        return self.error <= self.accepted  # false for NaN
