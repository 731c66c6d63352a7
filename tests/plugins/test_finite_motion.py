"""Positions, velocities and forces that are not finite stop the run with an error that contains the ID of the sphere."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.conftest import refuses, script_of
from tests.helpers.two_spheres import BOX, PAIR, WALL, R

CLOSING = [(0, 0, 1.0), (0, 0, -1.0)]
ALONE = [*PAIR, (0.1, 0, 0)]  # the third has no other sphere within reach
ROUGH = {"style": "elastoplastic 115e9 0.3 550e6 friction 0.3", "extra": "comm_modify vel yes"}
BAD = "variable bad equal exp(1000)-exp(1000)\n"  # NaN: not a valid word in LAMMPS
CHAIN = [(0, 0, 0), (0, 0, 2 * R), (0, 0, 4 * R)]


def foreign(text: str) -> str:
    """Input script with a pair style of LAMMPS that exerts no force."""
    text = re.sub("pair_style.*", "pair_style zero 0.02", text)
    text = re.sub("pair_coeff.*", "pair_coeff * *", text)
    return re.sub("compute ep.*\nthermo_style.*\n", "", text)


def spoil(lmp, name: str, ident: int, amount: float, axis: int = 0) -> None:
    ids = lmp.numpy.extract_atom("id")
    lmp.numpy.extract_atom(name)[np.flatnonzero(ids == ident)[0]][axis] = amount


@pytest.mark.parametrize("amount", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name, meaning", [("x", "position"), ("v", "velocity")])
@pytest.mark.parametrize("ident", [1, 3], ids=["of a pair", "alone"])
@pytest.mark.parametrize("begin", ["", "pre no"])
def test_not_finite_at_the_start_of_a_run(lammps, amount, name, meaning, ident, begin):
    lmp = lammps(script_of(ALONE))
    if begin:
        lmp.command("run 7")  # an odd step: detected nevertheless
    spoil(lmp, name, ident, amount)
    where = "position|velocity" if begin else meaning
    refuses(lmp, f"run 200 {begin}", rf"The ({where}) of sphere {ident} is not finite \((nan|-?inf) ")


@pytest.mark.parametrize("positions, sphere", [(PAIR, 2), (ALONE, 3)])
@pytest.mark.parametrize("check", ["check yes", "check no", "delay 1000000000 check yes"])
@pytest.mark.parametrize("options", [{}, ROUGH], ids=["smooth", "rough"])
def test_a_force_that_turns_into_nan(lammps, positions, sphere, check, options):
    """LAMMPS with `check yes` does not rebuild neighbor lists for a sphere at NaN, as if it had not moved."""
    lmp = lammps(script_of(positions, **options) + BAD)
    lmp.commands_string(
        f"neigh_modify every 1 {check}\nrun 250\ngroup hit id {sphere}\n"
        "fix gone hit addforce v_bad 0.0 0.0\nthermo 1000000"
    )
    refuses(lmp, "run 20000", rf"The position of sphere {sphere} is not finite \(nan 0 ")


def test_angular_velocity(lammps):
    lmp = lammps(script_of(ALONE, **ROUGH))
    spoil(lmp, "omega", 2, np.nan, axis=1)
    refuses(lmp, "run 200", r"The angular velocity of sphere 2 is not finite \(0 nan 0\)")


def test_nan_is_found_before_it_is_reported(lammps):
    """Positions set after a run are not included in any sum, row or dump."""
    lmp = lammps(
        script_of(ALONE)
        + "compute dents all gran/hysteretic/local\ncompute sum all reduce sum c_dents[4] inputs local\n"
    )
    lmp.command("run 7")
    spoil(lmp, "x", 3, np.nan)
    lmp.command("variable force equal c_sum")
    with pytest.raises(Exception, match="The position of sphere 3 is not finite"):
        lmp.extract_variable("force")


def test_minimization(lammps):
    lmp = lammps(script_of(PAIR, style="hertz 115e9 0.3") + "min_style fire\n")
    spoil(lmp, "x", 2, np.nan)
    refuses(lmp, "minimize 0 1e-9 500 500", "The position of sphere 2 is not finite")


@pytest.mark.parametrize("planes", ["NULL {r}", "-{r} NULL", "-{r} {r}"])
def test_a_wall_by_itself(lammps, planes):
    lmp = lammps()
    wall = WALL.replace("NULL {z:.17g}", planes.format(r=R))
    lmp.commands_string(foreign(script_of([(0, 0, 0)], box=BOX, extra=wall)) + "run 7")
    spoil(lmp, "x", 1, np.nan, axis=2)
    refuses(lmp, "run 200 pre no", r"The position of sphere 1 is not finite \(0 0 nan\)")


def test_a_force_by_itself(lammps):
    lmp = lammps()
    push = "group struck id 1\nfix push struck gran/load z force half-sine 100 1e-5"
    lmp.commands_string(foreign(script_of(PAIR, box=BOX, extra=push)) + "run 7")
    spoil(lmp, "v", 1, np.nan, axis=2)
    refuses(lmp, "run 200 pre no", r"The position of sphere 1 is not finite \(0 0 nan\)")


def test_a_prescribed_displacement_by_itself(lammps):
    """Driven atoms follow their path for any force, but the work of a force that is not finite would be NaN."""
    lmp = lammps()
    push = "group struck id 1\nfix push struck gran/load z displacement harmonic 1e-6 8e3\nunfix motion"
    lmp.commands_string(foreign(script_of(PAIR, box=BOX, extra=push)) + BAD + "run 7")
    lmp.command("fix gone struck addforce 0.0 0.0 v_bad")
    refuses(lmp, "run 200", "Fix gran/load push: the force on its atoms is not finite")


def test_a_node_of_a_bar(lammps):
    """Nodes have radius 0 and may touch nothing at all."""
    lmp = lammps(script_of([*PAIR, (0, 0, 0.03)], radius=[R, R, 1e-3]) + "set atom 3 diameter 0 mass 1e-4\nrun 7\n")
    spoil(lmp, "v", 3, np.nan, axis=2)
    refuses(lmp, "run 200 pre no", r"The position of sphere 3 is not finite \(0 0 nan\)")


@pytest.mark.parametrize(
    "spoiled", ["velocity struck set v_bad NULL NULL\n", "fix gone struck addforce v_bad 0.0 0.0\n"]
)
def test_on_two_ranks(lmp, tmp_path, spoiled):
    """An error on either rank stops both."""
    script = tmp_path / "in.nan"
    row = [(0, 0, 2 * R * k) for k in range(8)]
    script.write_text(
        script_of(row).replace("units si", "units si\nprocessors 1 1 2")
        + BAD
        + "group struck id 7\n"
        + (spoiled if "velocity" in spoiled else f"run 100\n{spoiled}")
        + "run 20000\nprint 'finished'\n"
    )
    texts = []
    for _ in range(3):  # MPI may end both ranks before it has handed on what one of them said
        done = lmp(script, ranks=2, timeout=60, screen=True)
        assert done.returncode != 0 and "finished" not in done.stdout
        texts.append(done.stdout + done.stderr)
        if re.search(r"ERROR on proc \d: The (position|velocity) of sphere 7 is not finite", texts[-1]):
            return
    pytest.fail("\n".join(texts))
