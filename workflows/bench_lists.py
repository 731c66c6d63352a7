"""Cost of new lists of pairs, for our style and LAMMPS's own: ``granwave bench --parts lists``.

Times are those of the processor: lists are built where spheres move, and other work on the machine
would count twice in a difference of wall times.
"""

from __future__ import annotations

import contextlib
import time
from typing import Any

import numpy as np

from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.load_case import load_assembly
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.workflows import bench, library
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import Engine, open_engine
from granwave.workflows.run.leftovers import scratch_directory

STEPS = 20  # with a new list in each, and as many without
SHEAR_STEPS = 400
SHEAR_WARM = 100
SHEAR_CELLS = 16  # cubic cells along each edge of the sheared box
SHEAR_RATE = 50.0  # 1/s
_SPACING = 1.02  # of the sheared spheres, in diameters
_GAP = 0.03  # diameters, beyond which contacts are forgotten
_SKIN = 0.05  # diameters
_SOFT = 1e8  # Pa, and a timestep to match, so that a list lasts some ten steps
_TIMESTEP = 2e-6  # s
_SPEED = 0.5  # m/s, of the sheared spheres at the start, at most
_RARELY = "neigh_modify delay 0 every 1000000 check no"
_ALWAYS = "neigh_modify delay 0 every 1 check no"
_MINDLIN = (
    "pair_style granular\npair_coeff * * hertz/material {E} 0.0 {nu} "
    "tangential mindlin NULL 0.0 0.3 damping velocity"
)
GRANULAR = "granular hertz/material, friction 0.3"
#: Commands of each style, with names of constants in braces, and its integrating fix.
STYLES = {
    bench.ROUGH: bench.STYLES[bench.ROUGH][:2],
    bench.ROUGH_BASELINE: bench.STYLES[bench.ROUGH_BASELINE][:2],
    GRANULAR: (_MINDLIN, "nve/sphere"),
}


def compare_lists(repeats: int) -> dict[str, Any]:
    """Time new lists of the reference packing, and a sheared packing with many of them.

    Returns
    -------
    dict
        Under ``rattling`` and ``sheared``: ``n_spheres``, and ``table`` with the times and ratios
        of each style. Times are processor seconds of a new list (rattling), or of a step with all
        that belongs to it (sheared); ratios are those to `bench.ROUGH_BASELINE` in that repeat.
    """
    return {"rattling": _new_lists(repeats), "sheared": _sheared(repeats)}


def _new_lists(repeats: int) -> dict[str, Any]:
    """Time the steps of a rattling packing with a new list in each, and without."""
    assembly = load_assembly(library.find(bench.STUDY))
    n = assembly.lattice.n_spheres
    times: dict[str, list[float]] = {style: [] for style in STYLES}
    with (
        scratch_directory("granwave-bench-") as scratch,
        contextlib.ExitStack() as opened,
    ):
        data = scratch / "data.granwave"
        write_data(assembly, data)
        engines = {}
        for style, (lines, motion) in STYLES.items():
            engines[style] = opened.enter_context(open_engine(mpi.this_process(), log="none"))
            engines[style].commands(bench.script(assembly, data, lines, motion))
            bench.rattle(engines[style], seed=0)
        for _ in range(repeats):
            for style, engine in engines.items():
                without = _processor_time(engine, _RARELY, STEPS)
                times[style].append((_processor_time(engine, _ALWAYS, STEPS) - without) / STEPS)
    return _report(f"new lists of {n} rattling spheres, friction 0.3", n, times, "ms a list")


def _sheared(repeats: int) -> dict[str, Any]:
    """Time the steps of a loose packing that is sheared across its periodic boundaries."""
    assembly = load_assembly(library.find(bench.STUDY))
    n = 4 * SHEAR_CELLS**3
    times: dict[str, list[float]] = {style: [] for style in STYLES}
    for _ in range(repeats):
        for style, (lines, motion) in STYLES.items():
            with open_engine(mpi.this_process(), log="none") as engine:
                engine.commands(_shear_script(assembly, lines, motion))
                _stir(engine)
                engine.commands(f"run {SHEAR_WARM} post no")
                begin = time.process_time()
                engine.commands(f"run {SHEAR_STEPS} post no")
                times[style].append((time.process_time() - begin) / SHEAR_STEPS)
    return _report(f"steps of {n} sheared spheres, friction 0.3", n, times, "ms a step")


def _shear_script(assembly: Assembly, lines: str, motion: str) -> str:
    """Return the LAMMPS commands of a sheared packing under a pair style."""
    material = assembly.case.material
    diameter = assembly.case.packing.diameter
    pair = bench.coefficients(assembly.case, lines, _GAP * diameter, _SOFT)
    return f"""units si
atom_style sphere
atom_modify map yes
newton off
comm_modify vel yes
boundary p p p
lattice fcc {np.sqrt(2) * _SPACING * diameter}
region box prism 0 {SHEAR_CELLS} 0 {SHEAR_CELLS} 0 {SHEAR_CELLS} 0 0 0
create_box 1 box
create_atoms 1 box
set group all diameter {diameter} density {material.density}
neighbor {_SKIN * diameter} bin
neigh_modify delay 0 every 1 check yes
{pair}
fix motion all {motion}
fix flow all deform 1 xy erate {SHEAR_RATE} remap v flip yes
timestep {_TIMESTEP}
thermo 1000000
"""


def _stir(engine: Engine) -> None:
    """Give all spheres random velocities."""
    velocities = engine.lammps.numpy.extract_atom("v")
    rng = np.random.default_rng(0)
    velocities[:] = rng.uniform(-_SPEED, _SPEED, velocities.shape)


def _processor_time(engine: Engine, lists: str, steps: int) -> float:
    """Measure the processor time of steps, s."""
    engine.commands(f"{lists}\nrun 1 post no")
    begin = time.process_time()
    engine.commands(f"run {steps} pre no post no")
    return time.process_time() - begin


def _report(title: str, n: int, times: dict[str, list[float]], unit: str) -> dict[str, Any]:
    """Print a table of times, and return it."""
    print(f"\n{title}:")
    print(f"{'':44}{unit:>26}{'times ' + bench.BASELINE:>30}")
    table = {}
    for style, values in times.items():
        base = times[bench.ROUGH_BASELINE]
        ratios = [value / other for value, other in zip(values, base, strict=True)]
        table[style] = {"times": values, "ratios": ratios}
        print(f"{style:44}{bench.spread(values, 1e-3):>26}{bench.spread(ratios):>30}")
    return {"n_spheres": n, "table": table}
