"""Runs of chains of like beads, or with one of another kind, on a bar (thesis 3.2.3, 3.2.4)."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence

from granwave.analysis.measures.chains.odd_bead import OddBead, constants, odd_bead_of
from granwave.analysis.studies.chains.runs import chain_runs
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.case.material import Material

FEWEST = 3  # runs of a curve


def lines(runs: Sequence[FinishedRun]) -> list[tuple[str, list[OddBead]]]:
    """Chains that differ in at most one bead, each line with the end of its name, such as ``_2``."""
    found: dict[Hashable, list[OddBead]] = {}
    for run in chain_runs(runs):
        if (chain := odd_bead_of(run)) is not None:
            found.setdefault((chain.line, constants(chain.base)), []).append(chain)
    return [(f"_{n + 1}" if n else "", line) for n, line in enumerate(found.values())]


def name_of(material: Material) -> str:
    """For tables and figures."""
    return material.name or f"E {material.youngs_modulus:.3g} Pa"


def remarks(found: Iterable[OddBead]) -> str:
    """Notes on the runs for readers."""
    unique = list({chain.run.directory: chain for chain in found}.values())
    beyond = sum(chain.run.value("contacts_beyond_law") > 0 for chain in unique)
    unfinished = sum(chain.unfinished for chain in unique)
    text = []
    if beyond:
        text.append(
            f"{beyond} of {len(unique)} runs press contacts beyond 0.2 R*, where the fit of the contact law ends: it "
            "is extrapolated there, as it is in the source."
        )
    if unfinished:
        text.append(f"In {unfinished} of the runs the bar was still given energy at the end: let them run longer.")
    return " ".join(text)
