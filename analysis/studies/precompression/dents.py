"""What a lasting dent changes: the same packings with dents that are kept, and forgotten where spheres part."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave._contact_laws import ContactLaw
from granwave.analysis.document.cells import percent
from granwave.analysis.document.model import Cell, Column, Note, Table
from granwave.analysis.studies.runs import FinishedRun, grouped, rising
from granwave.analysis.studies.tables import numeric, table_of
from granwave.analysis.studies.titles import packing_title
from granwave.lammps_inputs.contact.law import sphere_contact

TITLE = "What a lasting dent changes"
TEXT = (
    "Each packing twice: dents kept (boundary.forget_gap of 0.1 diameters), and forgotten as soon as the undeformed "
    "spheres part (1e-9 diameters). The second is what LIGGGHTS, YADE and MercuryDPM do with laws that yield, and "
    "LAMMPS's own granular styles with the history of a contact: it ends where the distance exceeds the sum of the "
    "radii. Dents in rigid walls are kept in both. Rows that rattle move chaotically: sign and size of a change mean "
    "something there, its digits do not."
)
_KEY = "boundary.forget_gap"
_ZERO_GAP = 1e-6  # diameters: below it a dent is forgotten where spheres part
_SAME = 5e-4  # relative: no change to the digits shown
_LITTLE = 0.01  # relative
_MICRO, _MILLI = 1e6, 1e3
#: Columns of the table: heading, unit, and the value in `summary.json`.
_VALUES = (
    ("Dissipated", "J", "energy_dissipated_J"),
    ("Largest contact force", "N", "peak_force_N"),
    ("Largest force at the bottom", "N", "wall_peak_force_N"),
)
Pair = tuple[FinishedRun, FinishedRun]


def select(runs: Sequence[FinishedRun]) -> list[list[Pair]]:
    """Pairs of runs that differ in the forgetting gap alone: dents kept, and forgotten where spheres part."""
    pairs = []
    for group in grouped(runs, _KEY):
        both = rising(group, lambda run: run.case.boundary.forget_gap)
        if len(both) > 1 and both[0].case.boundary.forget_gap < _ZERO_GAP:
            pairs.append((both[-1], both[0]))
    return [pairs] if pairs else []


def tables(pairs: Sequence[Pair]) -> Iterator[Table | Note]:
    """All pairs, and what forgetting at zero force would do."""
    heads = [(f"{heading}: {word}", unit if word != "change" else "")
             for heading, unit, _ in _VALUES for word in ("kept", "forgotten", "change")]  # fmt: skip
    rows = [[Cell(words(kept)), *_cells(kept, forgotten)] for kept, forgotten in pairs]
    yield table_of("Dents kept, and forgotten where the undeformed spheres part",
                   (Column("Packing and load", key=True), *numeric(*heads)), rows, by_row=True)  # fmt: skip
    if (found := _zero_force(pairs)) is not None:
        velocity, kept, forgotten = found
        yield Note(
            "Forgotten already at zero force, where spheres still overlap by the dent, there would be energy out of "
            f"nothing: two such spheres that meet at {velocity:g} m/s part with {kept:.3f} of it, and would with "
            f"{forgotten:.3f} (by the law alone). No run can be made of it, and no program is known to do so."
        )


def verdict(pairs: Sequence[Pair]) -> Iterator[str]:
    """Say where forgetting matters."""
    changes = [(_change(*pair, "energy_dissipated_J"), words(pair[0])) for pair in pairs]
    small = [text for size, text in changes if abs(size) < _LITTLE]
    large = [f"{text} ({_shown(size)})" for size, text in changes if abs(size) >= _LITTLE]
    if small:
        yield f"Forgetting changes the energy dissipated by less than 1 % in: {'. '.join(small)}."
    if large:
        yield f"It changes it by more in: {'. '.join(large)}."


def words(run: FinishedRun) -> str:
    """``Row of 5 brass spheres of 10 mm with gaps of 0.1 mm; 5 struck at 5 m/s``."""
    case, load = run.case, run.case.load
    parts = [packing_title(case)]
    if case.packing.kind == "file":  # what a chain with gaps becomes
        height = run.assembly.positions()[:, 2]
        gap = float(np.diff(np.sort(height)).max()) - case.packing.diameter
        spheres = f"{len(height)} {case.material.name} spheres of {_MILLI * case.packing.diameter:.4g} mm"
        parts = [f"Row of {spheres} with gaps of {_MILLI * gap:.3g} mm"]
    if case.packing.diameter_scatter:
        parts.append(f"diameters that scatter over {_MICRO * case.packing.diameter_scatter:.3g} µm")
    if case.has_initial_dents:
        parts.append("contacts pressed before")
    if load.kind == "displacement":
        motion = f"shaken by ± {_MICRO * (load.amplitude or 0):.3g} µm at {(load.frequency or 0):.4g} Hz"
    else:
        motion = f"{len(load.index) if load.index else load.spheres} struck at {load.velocity:g} m/s"
    return f"{', '.join(parts)}; {motion}"


def _cells(kept: FinishedRun, forgotten: FinishedRun) -> Iterator[Cell | float]:
    for _, _, key in _VALUES:
        change = _change(kept, forgotten, key)
        yield from (kept.value(key), forgotten.value(key), Cell(_shown(change), change))


def _shown(change: float) -> str:
    if not math.isfinite(change):
        return "from none"
    return percent(100 * change) if abs(change) >= _SAME else "0 %"


def _change(kept: FinishedRun, forgotten: FinishedRun, key: str) -> float:
    """Relative change by forgetting; infinite where there was nothing before."""
    before, after = kept.value(key), forgotten.value(key)
    return after / before - 1 if before else 0.0 if after == before else math.inf


def _zero_force(pairs: Sequence[Pair]) -> tuple[float, float, float] | None:
    """Velocity, restitution of two spheres, and the same if their dent were forgotten at zero force."""
    case = next((kept.case for kept, _ in pairs if kept.case.load.kind == "impact"), None)
    if case is None:
        return None
    velocity = case.load.velocity
    return velocity, *restitution_at_zero_force(sphere_contact(case), case.sphere_mass / 2, velocity)


def restitution_at_zero_force(law: ContactLaw, mass: float, velocity: float) -> tuple[float, float]:
    """Return the restitution with a dent that is kept, and with one that is forgotten where the force falls to zero.

    A new contact that overlaps by the dent pushes the spheres apart with what it would have stored when loaded so far,
    leaves a smaller dent, which is forgotten too, and so on.

    Parameters
    ----------
    mass
        Effective mass of the two, kg.
    """
    energy = 0.5 * mass * velocity**2
    overlap = np.geomspace(1e-3, 1, 4000) * law.valid_overlap
    peak = float(np.interp(energy, law.loading_work(overlap), overlap))
    kept = returned = energy - float(law.dissipated_energy(peak))
    while (peak := float(law.residual_overlap(peak))) > 0:
        returned += float(law.loading_work(peak)) - float(law.dissipated_energy(peak))
    return math.sqrt(kept / energy), math.sqrt(returned / energy)
