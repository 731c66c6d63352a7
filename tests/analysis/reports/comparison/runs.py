"""Small runs of packings and chains that the tests of comparisons share."""

from __future__ import annotations

from granwave.analysis.figures.style import Drawing, style
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.comparison import Comparison
from granwave.analysis.reports.inputs import read_inputs

SMALL = {"packing.size": [6, 6, 4], "run.end_time": 1e-4}
CHAIN = {"packing.size": 8, "run.end_time": 1e-4}
STEEL_BEAD = {"index": [3, 4], "material": "aluminium"}
CASES = {
    "fcc": ("fcc-small", SMALL),
    "hcp": ("hcp-small", SMALL),
    "fast": ("fcc-small", SMALL | {"load.velocity": 10}),
    "chain": ("elastic-impact", CHAIN),
    "mixed": ("elastic-impact", CHAIN | {"replace": [STEEL_BEAD], "run.end_time": 2e-4}),
}


def compared(place, *names: str, **options) -> Comparison:
    inputs = read_inputs([place / name for name in names], place, repeated=True)
    return compare_runs(list(inputs.results()), **options)


def in_one_line(text: str) -> str:
    """Text at the terminal without the ends of its lines."""
    return " ".join(text.split())


def drawn(comparison: Comparison) -> dict[str, Drawing]:
    with style():
        names = comparison.figures
        return {name: comparison.drawing(name) for name in names}
