"""Spheres with friction: input scripts, oblique impacts and a small packing for the tests of
friction.
"""

from __future__ import annotations

import numpy as np

from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import value

R = 0.005
E = 115e9
NU = 0.3
MU = 0.3
HERTZ = f"hertz {E} {NU}"
BRASS = f"elastoplastic {E} {NU} 550e6"
RATIO = 2 * (1 - NU) / (2 - NU)  # k_t/k_n
TOTAL = "c_ke+c_turn+c_en+c_en[1]+c_en[6]+c_en[7]"
LAMMPS_OWN = "pair_style granular\npair_coeff * * hertz/material {E} 0.0 {nu} tangential {model} NULL 0.0 {mu} damping velocity"


def rubbing(
    positions, law=f"{HERTZ} friction {MU}", own=None, spins=(), extra="", **options
) -> str:
    """Input script of spheres with friction; `own` uses a style of LAMMPS instead of ours."""
    options["velocities"] = np.asarray(options.get("velocities", [])).tolist()
    text = script_of(positions, style=law, **options)
    text = text.replace("newton off", "newton off\ncomm_modify vel yes").replace(
        "all nve\n", "all nve/sphere\n"
    )
    lines = text.splitlines()
    if own:
        lines = [
            line for line in lines if not line.startswith(("pair_", "compute ep", "thermo_style"))
        ]
        lines.insert(next(k for k, line in enumerate(lines) if line.startswith("fix motion")), own)
    lines.append("compute turn all erotate/sphere")
    if not own:
        lines += [
            "compute en all gran/hysteretic/energy",
            "thermo_style custom step c_ke c_turn c_en c_en[*]",
        ]
    lines += [
        f"set atom {k} omega {w[0]:.17g} {w[1]:.17g} {w[2]:.17g}"
        for k, w in enumerate(spins, start=1)
    ]
    return "\n".join([*lines, extra]) + "\n"


def state(lmp, *names) -> dict[str, np.ndarray]:
    """Per-atom arrays in the order of IDs."""
    n = lmp.get_natoms()
    order = np.argsort(lmp.numpy.extract_atom("id")[:n])
    return {name: lmp.numpy.extract_atom(name)[:n][order].copy() for name in names}


def same(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> None:
    """Assert that all arrays are bitwise identical."""
    for name, values in one.items():
        assert np.array_equal(values, other[name]), name


def oblique(
    lammps, tangential, normal=1.0, spins=(), steps=8000, radii=(R, R), density=8500.0, **options
):
    """Two spheres in contact along z; the first has the velocity (tangential, 0, normal), the
    second is at rest.
    """
    lmp = lammps(
        rubbing(
            [(0, 0, 0), (0, 0, sum(radii))],
            radius=list(radii),
            density=density,
            velocities=[(tangential, 0, normal), (0, 0, 0)],
            spins=spins,
            **options,
        )
    )
    lmp.command("run 0 post no")
    if "own" not in options:
        lmp.command(f"variable start equal $({TOTAL}:%.17g)")
    lmp.command(f"run {steps} post no")
    return lmp


def balance(lmp) -> float:
    return value(lmp, f"({TOTAL})/v_start-1")


def packing(n=3):
    """Face-centered cubic packing of touching spheres with random velocities and spins, the same in
    every run.
    """
    half = np.sqrt(2) * R
    cells = np.array([(i, j, k) for i in range(n) for j in range(n) for k in range(n)])
    basis = np.array([(0, 0, 0), (1, 1, 0), (1, 0, 1), (0, 1, 1)])
    places = ((2 * cells[:, None] + basis[None]).reshape(-1, 3) * half)[: 4 * n**3]
    rng = np.random.default_rng(3)
    return places, rng.uniform(-1, 1, places.shape), rng.uniform(-200, 200, places.shape)
