"""Coefficient of restitution against impact velocity, from the energies of the contact law.

A collision of effective mass m loads the contact until the work of loading W(a_max) equals m v^2 / 2; all of it is
returned but the dissipated energy D(a_max):  e = sqrt(1 - D / W). Runs give the same, see test_restitution.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.contact_law.curves import check_forces
from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, PURPLE, Drawing, new_figure, save_as

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw

_COLOURS = (BLUE, ORANGE, GREEN, PURPLE)
_LINES = ("-", "--", ":", "-.")
_POINTS = 400
_SLOWEST = 0.3  # overlap of the slowest impact over that at first yield

Table = dict[str, NDArray]


def restitution(
    law: ContactLaw, mass: float, max_overlap: float = 400.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return impact velocities, m/s, and coefficients of restitution: (n,) each.

    Parameters
    ----------
    mass
        Effective mass of the two bodies, kg.
    max_overlap
        Overlap of the fastest impact over that at first yield; for the elasto-plastic law at most 0.2 R*, the limit of
        its fit.
    """
    check_forces(law)
    largest = max_overlap * law.yield_overlap
    if law.entry.fitted:
        largest = min(largest, 0.2 * law.effective_radius)
    peak = np.geomspace(_SLOWEST * law.yield_overlap, largest, _POINTS)
    work = law.loading_work(peak)
    return np.sqrt(2 * work / mass), np.sqrt(np.clip(1 - law.dissipated_energy(peak) / work, 0, 1))


def restitution_table(contacts: Mapping[str, tuple[ContactLaw, float]], max_overlap: float = 400.0) -> Table:
    """Return a curve for each named contact (law, effective mass): ``contact``, ``velocity_m_s``, ``restitution``."""
    curves = {name: restitution(law, mass, max_overlap) for name, (law, mass) in contacts.items()}
    return {
        "contact": np.concatenate([np.full(_POINTS, name) for name in curves]),
        "velocity_m_s": np.concatenate([velocity for velocity, _ in curves.values()]),
        "restitution": np.concatenate([value for _, value in curves.values()]),
    }


def write_restitution(
    contacts: Mapping[str, tuple[ContactLaw, float]], path: str | Path, max_overlap: float = 400.0, title: str = ""
) -> Path:
    """Write the curves as a table (.csv) or as a figure with its table (.png or .pdf; both are written).

    Raises
    ------
    InputError
        A file of such a name exists, and granwave did not write it.
    """
    path, table = Path(path), restitution_table(contacts, max_overlap)

    def draw() -> Drawing:
        figure = new_figure(2.4)
        axes = figure.subplots()
        for name, colour, line in zip(contacts, _COLOURS, _LINES, strict=False):
            rows = table["contact"] == name
            axes.semilogx(table["velocity_m_s"][rows], table["restitution"][rows], line, color=colour, label=name)
        axes.set_xlabel("Impact velocity (m/s)")
        axes.set_ylabel("Coefficient of restitution")
        axes.set_ylim(0, 1.05)
        axes.legend(loc="lower left", title=title or None, alignment="left")
        return Drawing(figure, table)

    save_as(path, table, draw)
    return path
