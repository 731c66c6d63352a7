"""The manual pages of the LAMMPS styles, and the output of their examples."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

PAGES = Path(__file__).resolve().parents[2] / "plugins" / "doc"


class Log:
    """Thermodynamic output of all runs of a log, by column, and the lines that the script printed."""

    def __init__(self, path: Path) -> None:
        self.text = path.read_text(encoding="utf-8")
        self.runs: list[dict[str, np.ndarray]] = []
        lines = iter(self.text.splitlines())
        for line in lines:
            if line.split()[:2] != ["Step", "Time"]:
                continue
            columns = line.split()
            rows = []
            for row in lines:
                if row.startswith("Loop time"):
                    break
                rows.append([float(word) for word in row.split()])
            self.runs.append(dict(zip(columns, np.array(rows).T, strict=True)))

    def printed(self, words: str) -> float:
        """The number after these words, from the last line that begins with them."""
        return float(re.findall(rf"^{words}: *(\S+)", self.text, re.MULTILINE)[-1])
