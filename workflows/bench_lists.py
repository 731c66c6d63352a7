"""Cost of new lists of pairs, for our style and LAMMPS's own: ``granwave bench --parts lists``.

Times are processor times: lists are built where spheres move, and other work on the machine
would count twice in a difference of wall times.
"""

from __future__ import annotations

import contextlib
import re
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.load_case import load_assembly
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.workflows import bench, library
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import Engine, open_engine
from granwave.workflows.run.leftovers import scratch_directory

STEPS = 20  # steps with a new list in each, and without
SHEAR_STEPS = 400
SHEAR_WARM = 100
SHEAR_CELLS = 16  # cubic cells along each edge of the sheared box
SHEAR_RATE = 50.0  # 1/s
_SPACING = 1.02  # spacing of the sheared spheres, diameters
_GAP = 0.03  # diameters, beyond which contacts are forgotten
_SKIN = 0.05  # diameters
_SOFT = 1e8  # Pa, and a timestep to match, so that a list lasts some ten steps
_TIMESTEP = 2e-6  # s
_SPEED = 0.5  # largest initial speed of the sheared spheres, m/s
_RARELY = "neigh_modify delay 0 every 1000000 check no"
_ALWAYS = "neigh_modify delay 0 every 1 check no"
POUR_SPHERES = 500  # fix pour needs minutes to find positions for 1000 spheres
POUR_STEPS = 15000
_POUR_WIDTH = 12.0  # diameters, size of the periodic box
_POUR_LOWEST = 3.0  # diameters, size of the region in which the spheres start
_POUR_HIGHEST = 30.0  # diameters
_POUR_TIMESTEP = 2e-5  # s
_POUR_SOFT = 1e7  # Pa
_POUR_SPEED = -2.0  # m/s
_DRAG = 0.03  # kg/s: the styles have no other loss of normal motion
_BUILDS = re.compile(r"(?m)^Neighbor list builds = (\d+)")
_OUR_FLOOR = (
    "wall/gran/hysteretic zplane 0.0 NULL elastoplastic {E} {nu} {yield_strength} friction 0.3"
)
# this fix divides by its damping, 1/(m s): here it is too small to change a collision
_HISTORY_FLOOR = "wall/gran hertz/history {kn} NULL 1.0 NULL 0.3 0 zplane 0.0 NULL"
_GRANULAR_FLOOR = (
    "wall/gran granular hertz/material {E} 0.0 {nu} "
    "tangential mindlin NULL 0.0 0.3 damping velocity zplane 0.0 NULL"
)
#: Commands of each style, with names of constants in braces, and its integrating fix.
STYLES = {
    style: bench.STYLES[style][:2]
    for style in (bench.ROUGH, bench.ROUGH_BASELINE, bench.ROUGH_GRANULAR)
}
#: Floor of the poured spheres, with the law of the style.
FLOORS = {
    bench.ROUGH: _OUR_FLOOR,
    bench.ROUGH_BASELINE: _HISTORY_FLOOR,
    bench.ROUGH_GRANULAR: _GRANULAR_FLOOR,
}


def compare_lists(repeats: int) -> dict[str, Any]:
    """Time new lists of the reference packing, and a sheared and a poured packing with many of
    them.

    Returns
    -------
    dict
        Under ``rattling``, ``sheared`` and ``poured``: ``n_spheres``, and ``table`` with the times
        and ratios of each style, and with the number of new lists of a sheared or poured packing
        (``lists``). Times are processor seconds of a new list (rattling), or of a step with all
        that belongs to it (sheared, poured); ratios are those to `bench.ROUGH_BASELINE` and to
        `bench.ROUGH_GRANULAR` in that repeat.
    """
    return {
        "rattling": _new_lists(repeats),
        "sheared": _sheared(repeats),
        "poured": _poured(repeats),
    }


def _new_lists(repeats: int) -> dict[str, Any]:
    """Time the steps of a rattling packing, with a new list in each step and without new lists."""
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
    return _report(f"new lists of {n} rattling spheres, friction 0.3", n, times, "ms per list")


def _sheared(repeats: int) -> dict[str, Any]:
    """Time the steps of a loose packing that is sheared across its periodic boundaries."""
    assembly = load_assembly(library.find(bench.STUDY))
    n = 4 * SHEAR_CELLS**3

    def start(engine: Engine, style: str) -> None:
        """Run the first steps, without timing."""
        engine.commands(_shear_script(assembly, *STYLES[style]))
        _stir(engine)
        engine.commands(f"run {SHEAR_WARM} post no")

    times, lists = _times_of_runs(start, SHEAR_STEPS, repeats)
    title = f"steps of {n} sheared spheres, friction 0.3"
    return _report(title, n, times, "ms per step", lists)


def _poured(repeats: int) -> dict[str, Any]:
    """Time the steps of spheres that are poured onto a floor, slowed by a drag."""
    assembly = load_assembly(library.find(bench.STUDY))

    def start(engine: Engine, style: str) -> None:
        """Set up the empty box."""
        engine.commands(_pour_script(assembly, style))

    times, lists = _times_of_runs(start, POUR_STEPS, repeats)
    title = f"steps of {POUR_SPHERES} poured spheres, friction 0.3"
    return _report(title, POUR_SPHERES, times, "ms per step", lists)


def _times_of_runs(
    start: Callable[[Engine, str], None], steps: int, repeats: int
) -> tuple[dict[str, list[float]], dict[str, int]]:
    """Return processor times of a step, s, and the numbers of new lists, by style; `start` sets up
    the run.
    """
    times: dict[str, list[float]] = {style: [] for style in STYLES}
    lists = {}
    with scratch_directory("granwave-bench-") as scratch:
        log = scratch / "log.lammps"
        for _ in range(repeats):
            for style in STYLES:
                with open_engine(mpi.this_process(), log=str(log)) as engine:
                    start(engine, style)
                    begin = time.process_time()
                    engine.commands(f"run {steps}")
                    times[style].append((time.process_time() - begin) / steps)
                lists[style] = int(_BUILDS.findall(log.read_text(encoding="utf-8"))[-1])
    return times, lists


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


def _pour_script(assembly: Assembly, style: str) -> str:
    """Return the LAMMPS commands that pour spheres onto a floor under a pair style."""
    case = assembly.case
    diameter = case.packing.diameter
    width = _POUR_WIDTH * diameter
    highest = _POUR_HIGHEST * diameter
    lines, motion = STYLES[style]
    pair = bench.coefficients(case, lines, _GAP * diameter, _POUR_SOFT)
    floor = bench.coefficients(case, FLOORS[style], _GAP * diameter, _POUR_SOFT)
    density = case.material.density
    return f"""units si
atom_style sphere
atom_modify map yes
newton off
comm_modify vel yes
boundary p p f
region box block 0 {width} 0 {width} {-diameter} {2 * highest} units box
create_box 1 box
neighbor {_SKIN * diameter} bin
neigh_modify delay 0 every 1 check yes
{pair}
fix floor all {floor}
region slot block 0 {width} 0 {width} {_POUR_LOWEST * diameter} {highest} units box
fix weight all gravity 9.81 vector 0 0 -1
fix grains all pour {POUR_SPHERES} 1 4767 vol 0.3 1000 vel 0 0 0 0 {_POUR_SPEED} diam one {diameter} dens {density} {density} region slot
fix drag all viscous {_DRAG}
fix motion all {motion}
timestep {_POUR_TIMESTEP}
thermo_modify lost error
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


def _report(
    title: str,
    n: int,
    times: dict[str, list[float]],
    unit: str,
    lists: Mapping[str, int] | None = None,
) -> dict[str, Any]:
    """Print a table of times, and return it."""
    print(f"\n{title}:")
    last = f"{'new lists':>12}" if lists else ""
    print(f"{'':44}{unit:>26}{'times ' + bench.BASELINE:>30}{'times granular':>26}{last}")
    table: dict[str, dict[str, Any]] = {}
    for style, values in times.items():
        ratios = bench.quotients(values, times[bench.ROUGH_BASELINE])
        to_granular = bench.quotients(values, times[bench.ROUGH_GRANULAR])
        table[style] = {"times": values, "ratios": ratios, "ratios_to_granular": to_granular}
        if lists:
            table[style]["lists"] = lists[style]
            last = f"{lists[style]:>12}"
        print(
            f"{style:44}{bench.spread(values, 1e-3):>26}{bench.spread(ratios):>30}"
            f"{bench.spread(to_granular):>26}{last}"
        )
    return {"n_spheres": n, "table": table}
