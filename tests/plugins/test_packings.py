"""Packings in random motion, with every kind of force: the energy balance closes, dissipation
grows, tables sum to the totals.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.helpers.bodies.rubbing import BRASS, HERTZ, MU, TOTAL, packing, rubbing
from tests.helpers.bodies.two_spheres import value

LEDGER = TOTAL + "+c_en[8]+c_en[9]+c_en[10]+c_en[11]+c_en[12]+c_en[13]"
RUBS = f"friction {MU}"
SLIPS = f"{RUBS} tangential partial_slip"
ROLLS = "rolling sds mindlin 1.0 0.05 twisting marshall"
DAMPS = "loss time 1e-7 loss_tangential 0.5"
TABLES = "compute dents all gran/hysteretic/local\ncompute grains all gran/hysteretic/atom\n"
# law, cells a side, factors of the random speeds and spins, steps, largest error of the ledger
PACKINGS = {
    "dents and friction": (f"{BRASS} {RUBS}", 3, 3, 3, 10000, 1e-6),
    "partial slip": (f"{HERTZ} {SLIPS}", 3, 3, 3, 8000, 1e-6),
    "partial slip, rolling, losses": (f"{BRASS} {SLIPS} {ROLLS} loss time 1e-7", 3, 3, 3, 8000, 1e-4),
    "damping along surfaces": (f"{BRASS} {RUBS} {DAMPS}", 2, 3, 3, 6000, 1e-4),
    "partial slip with damping": (f"{HERTZ} {SLIPS} {DAMPS}", 2, 3, 3, 6000, 1e-4),
    "rolling and twisting": (f"{HERTZ} {RUBS} {ROLLS}", 2, 1, 1, 3000, 2e-5),
    "rolling alone": (f"{HERTZ} rolling sds mindlin 0.0 0.1", 2, 1, 1, 3000, 2e-5),
    "dashpots of rolling": (f"{HERTZ} {RUBS} rolling sds 2e6 3.0 0.05 twisting sds 4.0 1e-5 2e-5", 2, 1, 1, 3000, 2e-5),
    "rolling of dents": (f"{BRASS} {RUBS} {ROLLS}", 2, 1, 1, 3000, 2e-5),
    "JKR that rolls": (f"{HERTZ} {RUBS} rolling sds mindlin 0.0 0.05 twisting marshall cohesion jkr 100.0", 2, 0.1, 0.1, 9000, 2e-5),
    "JKR with losses": (f"{HERTZ} {RUBS} loss time 3e-7 cohesion jkr 100.0", 2, 0.1, 0.1, 9000, 2e-5),
    "DMT with losses": (f"{HERTZ} {RUBS} loss dashpot 0.1 cohesion dmt 100.0", 2, 0.1, 0.1, 9000, 2e-5),
    "dents of DMT": (f"{BRASS} {RUBS} cohesion dmt 1.0", 2, 0.1, 0.1, 9000, 2e-5),
    "yielding by rate": (f"elastoplastic 200e9 0.29 100e6 {RUBS} rate 0.05 1", 2, 4, 1, 3000, 2e-5),
}  # fmt: skip
LOSSES = {
    1: "elastoplastic",
    7: "friction",
    8: "loss",
    10: "rolling",
    12: "twisting",
    13: "jkr",
}  # columns of the energies


def text_of(name: str) -> str:
    law, cells, speed, spin, *_ = PACKINGS[name]
    places, speeds, spins = packing(cells)
    return rubbing(places, law, velocities=speed * speeds, spins=spin * spins) + TABLES


@pytest.mark.parametrize("name", PACKINGS)
def test_balance_and_passivity(lammps, name):
    law, *_, steps, error = PACKINGS[name]
    lmp = lammps(text_of(name) + "run 0 post no")
    start = value(lmp, LEDGER)
    lost = np.zeros(len(LOSSES))
    for _ in range(8):
        lmp.command(f"run {steps // 8} post no")
        assert value(lmp, LEDGER) == pytest.approx(start, rel=error)
        now = np.array([value(lmp, f"c_en[{n}]") for n in LOSSES])
        assert np.all(now >= lost - 1e-9 * start)
        lost = now
    assert [loss > 0 for loss in lost] == [word in law for word in LOSSES.values()]
    assert lost.sum() > 0.01 * start
    dents = lmp.numpy.extract_compute("dents", 2, 2)
    grains = lmp.numpy.extract_compute("grains", 1, 2)[: lmp.get_natoms()]
    stored, spent = (
        value(lmp, f"c_en[{a}]+c_en[{b}]+c_en[{c}]") for a, b, c in ((6, 9, 11), (7, 10, 12))
    )
    assert grains[:, 10:12].sum(axis=0) == pytest.approx([stored, spent], rel=1e-12)
    assert dents[:, 13:15].sum(axis=0) == pytest.approx([stored, spent], rel=1e-12)
    assert (
        np.all(dents[:, 12] <= MU * dents[:, 3] * (1 + 1e-12)) or "loss" in law or "cohesion" in law
    )
