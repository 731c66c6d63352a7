"""New lists of pairs take over the histories of the contacts: results are bitwise independent of
how often lists are built, and of the order of the atoms.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.helpers.bodies.rubbing import BRASS, HERTZ, MU, packing, rubbing, same, state
from tests.plugins.test_packings import ROLLS, SLIPS
from tests.plugins.test_two_processors import drifting

MOTION = ("x", "v", "omega", "f", "torque")
STEPS = 300
DISSIPATED, YIELDED, BEYOND_LAW, BEYOND_HALF = range(4)  # of the energies
RARELY = "neigh_modify delay 0 every 1 check yes\n"
ALWAYS = "neigh_modify delay 0 every 1 check no\n"
SORTED = f"{ALWAYS}atom_modify sort 20 0.005\n"
LAWS = {
    "friction": f"{BRASS} friction {MU}",
    "histories": f"{HERTZ} {SLIPS} {ROLLS} loss time 1e-8",
    "necks": f"{HERTZ} friction 0.3 cohesion jkr 100",
}


def rattling(law: str) -> str:
    """Packing in which all spheres move and turn."""
    places, velocities, spins = packing()
    return rubbing(places, law, velocities=velocities, spins=spins, extra="timestep 1e-7\n")


SCRIPTS = {"walled": rattling, "periodic": drifting}


def dents(lmp) -> np.ndarray:
    """Values of all contacts, in the order of their spheres."""
    rows = lmp.numpy.extract_compute("dents", 2, 2)
    return rows[np.lexsort(rows.T[:2])].copy()


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("place", SCRIPTS)
def test_the_bits_do_not_depend_on_when_lists_are_built(lammps, place, law):
    script = SCRIPTS[place](LAWS[law]) + "compute dents all gran/hysteretic/local\n"
    states = []
    contacts = []
    for lists in (RARELY, ALWAYS, SORTED):
        lmp = lammps(script + lists)
        lmp.command(f"run {STEPS} post no")
        lmp.command("run 0 post no")
        states.append(state(lmp, *MOTION))
        contacts.append(dents(lmp))
    for other in (1, 2):
        same(states[0], states[other])
        assert np.array_equal(contacts[0], contacts[other])
    assert len(contacts[0]) > len(states[0]["x"]) // 2


@pytest.mark.parametrize("kept", ["sum", "list"])
def test_contacts_that_leave_the_list_are_forgotten(lammps, kept):
    """Spheres that separate, with lists that are built before and after the gap is exceeded."""
    places, velocities, spins = packing(2)
    apart = places - places.mean(axis=0)
    script = rubbing(
        places,
        LAWS["friction"],
        velocities=velocities * 0.5 - 20 * apart,
        spins=spins,
        box=[-0.1, 0.1] * 3,
        extra="timestep 2e-7\n",
    ).replace("gran/hysteretic 0.001", f"gran/hysteretic 1e-4 forgotten {kept}")
    energies = []
    for lists in (RARELY, ALWAYS, SORTED):
        lmp = lammps(f"{script}neighbor 1e-4 bin\n{lists}")
        lmp.command("run 2000 post no")
        lmp.command("run 0 post no")
        energies.append(lmp.numpy.extract_compute("en", 0, 1).copy())
    for other in (1, 2):
        np.testing.assert_allclose(energies[other], energies[0], rtol=1e-12)
    assert energies[0][0] > 0.0


@pytest.mark.parametrize("kept", ["sum", "list"])
def test_contacts_of_spheres_that_are_displaced_stay_in_the_sums(lammps, kept):
    """Half of the packing is moved away between two runs: no pair between the halves is in the next
    list.
    """
    script = rattling(LAWS["friction"]).replace(
        "gran/hysteretic 0.001", f"gran/hysteretic 0.001 forgotten {kept}"
    )
    lmp = lammps(script)
    lmp.command(f"run {STEPS} post no")
    before = lmp.numpy.extract_compute("en", 0, 1).copy()
    lmp.commands_string("group half id <= 54\ndisplace_atoms half move 0 0 -0.1 units box")
    lmp.command("run 0 post no")
    after = lmp.numpy.extract_compute("en", 0, 1)
    lost = [DISSIPATED, YIELDED, BEYOND_LAW, BEYOND_HALF]
    assert before[DISSIPATED] > 0.0
    np.testing.assert_allclose(after[lost], before[lost], rtol=1e-12)
