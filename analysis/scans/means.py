"""Means of a scan's points over replicates, and what they say: for the start of a report, and the end of a scan."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping, Sequence

from granwave.analysis.document.cells import is_number, show
from granwave.analysis.formatting.numbers import interval
from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.quantities import SCAN_FIGURES, quantity
from granwave.analysis.scans.keys import Key, key_of
from granwave.analysis.scans.result import REDUCTION, SEED, ScanResult, protects
from granwave.analysis.scans.table import CONFIDENCE, COUNT, MEAN, physical, scan_statistics
from granwave.lammps_inputs.packing.cylinders import SPHERES, in_grains

WORTH = 1e-12  # smallest value that is not rounding
_SAME = 1e-6  # relative difference of values that count as equal
_MAIN = (  # in this order
    REDUCTION, "restitution", "transmission", "dissipated_fraction", "peak_force_N", "max_force_N", "n_plastic_spheres",
)  # fmt: skip
_TRENDS = ("rises", "falls")


@dataclasses.dataclass(frozen=True)
class Means:
    """Values of a scan: a row for each combination of its keys without the seed that has finished points.

    Attributes
    ----------
    keys
        Varied keys that take more than one value, with their values by row; without run times that follow from others.
    counts
        Number of points of each row.
    values
        Means by name of the quantity, one a row; None where there is none.
    half_widths
        Half-widths of the 95 % confidence intervals; None without replicates.
    protection
        True if the scan asks what reaches a target; `granwave.analysis.scans.result.protects`.
    called
        What the grains of its runs are called.
    """

    keys: tuple[Key, ...]
    counts: tuple[int, ...]
    values: Mapping[str, Sequence[float | None]]
    half_widths: Mapping[str, Sequence[float | None]]
    protection: bool = False
    called: str = SPHERES

    def quantities(self) -> list[tuple[str, str]]:
        """Return the quantities that have figures, by names of figure and value: those that vary first."""
        found = []
        for number, (name, key) in enumerate(SCAN_FIGURES.items()):
            values = [value for value in self.values.get(key, ()) if value is not None]
            if key == REDUCTION and not self.protection:
                continue
            if len(values) == len(self.counts) > 1 and max(map(abs, values)) > WORTH:
                rank = _MAIN.index(key) if key in _MAIN else len(_MAIN) + number
                found.append((not self.varies(key), rank, name, key))
        return [(name, key) for *_, name, key in sorted(found)]

    def varies(self, name: str) -> bool:
        """Return True if a quantity takes more than one value, rounding apart."""
        values = [value for value in self.values[name] if value is not None]
        return max(values) - min(values) > _SAME * max(map(abs, values))

    def sentence(self, main: str) -> str:
        """Say between which values a quantity lies, where, and how it depends on each key."""
        return in_grains(self._sentence(main), self.called)

    def _sentence(self, main: str) -> str:
        values = self.values[main]
        low, high = (choose(range(len(values)), key=lambda row: values[row] or 0.0) for choose in (min, max))
        label, unit = quantity(main).label, quantity(main).unit.replace("^", "")
        unit = f" {unit}" if unit else ""
        least, most = (self.text(main, row) + unit for row in (low, high))
        if not self.varies(main):
            return f"{label}: {most} at all points."
        text = f"{label}: from {least} ({self.setting(low)}) to {most} ({self.setting(high)})."
        found = {word: [key for n, key in enumerate(self.keys) if self._trend(main, n) == word] for word in _TRENDS}
        said = [f"{word} with {_listed(keys)}" for word, keys in found.items() if keys]
        return f"{text} It {', '.join(said)}." if said else text

    def _trend(self, main: str, n: int) -> str:
        """Return how a quantity changes with the n-th key, all others equal; empty if not in one direction."""
        if not self.keys[n].numeric:
            return ""
        signs = set()
        for rows in self.lines_along(n):
            values = [self.values[main][row] or 0.0 for row in rows]
            largest = max(map(abs, values), default=0.0)
            changes = [b - a for a, b in itertools.pairwise(values)]
            signs |= {change > 0 for change in changes if abs(change) > _SAME * largest}
        return {frozenset({True}): "rises", frozenset({False}): "falls"}.get(frozenset(signs), "")

    def text(self, name: str, row: int) -> str:
        """Return a mean with its interval, where it has one."""
        mean, half = self.values[name][row], self.half_widths[name][row]
        return interval(mean, half) if mean is not None and half else show(mean)

    def setting(self, row: int) -> str:
        """Return the values of the keys of a row in words."""
        parts = []
        for key in self.keys:
            unit = f" {key.naming.unit}" if key.naming.unit and key.numeric else ""
            parts.append(f"{key.naming.label[:1].lower()}{key.naming.label[1:]} {key.tick(row)}{unit}")
        return ", ".join(parts)

    def lines_along(self, n: int) -> list[list[int]]:
        """Return the rows along the n-th key, in its order: a list for each combination of the other keys."""
        lines: dict[tuple[object, ...], list[int]] = {}
        for row in range(len(self.counts)):
            lines.setdefault(tuple(key.values[row] for m, key in enumerate(self.keys) if m != n), []).append(row)
        return [sorted(rows, key=lambda row: float(self.keys[n].values[row])) for rows in lines.values()]


def means_of(scan: ScanResult) -> Means:
    """Average the finished points of a scan over the seeds; without seeds each point is a row."""
    names = [key for key in scan.varied if key != SEED]
    if SEED in scan.varied:
        table = scan_statistics(scan)
        counts = table.get(COUNT, [])
        columns = {key.removesuffix(MEAN): column for key, column in table.items() if key.endswith(MEAN)}
        widths = {key: table[key + CONFIDENCE] for key in columns}
        labels = {name: table[name] for name in names}
    else:
        done = [point for point in scan.points if point.status == "done"]
        counts = [1] * len(done)
        found = dict.fromkeys(key for point in done for key in point.summary)
        columns = {key: [_number(point.summary.get(key)) for point in done] for key in found}
        widths = {key: [None] * len(done) for key in found}
        labels = {name: [point.labels.get(name) for point in done] for name in names}
    kept = [row for row, count in enumerate(counts) if count]
    summaries = [point.summary for point in scan.points if point.status == "done"]
    there = physical({name: [labels[name][row] for row in kept] for name in names})
    keys = [key_of(name, column, scan.units.get(name, "")) for name, column in there.items()]
    return Means(
        tuple(key for key in keys if len(set(key.values)) > 1),
        tuple(counts[row] for row in kept),
        {key: [column[row] for row in kept] for key, column in columns.items()},
        {key: [column[row] for row in kept] for key, column in widths.items()},
        protects(scan.varied, summaries),
        grains_called_in(summaries),
    )


def _listed(keys: Sequence[Key]) -> str:
    names = [key.naming.label[:1].lower() + key.naming.label[1:] for key in keys]
    return " and ".join(names)


def _number(value: object) -> float | None:
    return float(value) if is_number(value) else None  # type: ignore[arg-type]
