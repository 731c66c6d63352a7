"""Speed of the styles, of packings, and of the reference study, measured on this machine:
``granwave bench``.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import statistics
import subprocess
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.load_case import load_assembly
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import start_speed
from granwave.lammps_inputs.packing.places import struck_spheres
from granwave.lammps_inputs.planning.timestep import auto_timestep
from granwave.lammps_inputs.run_directory import RECORD_FILE, SUMMARY_FILE
from granwave.workflows import library
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import Engine, open_engine
from granwave.workflows.run.launchers import of_this_machine
from granwave.workflows.run.leftovers import scratch_directory

STUDY = TIMED = "fcc-impact"  # reference study: its packing, and its complete run
SIZES = ([24, 24, 18], [72, 72, 30], [160, 160, 78])
# timed, and run before them
STEPS = 100
WARM = 20
IMPACT_TIME = 3e-4  # s after impact at which the styles are compared
STUDY_PARTS = ("start", "steps", "analysis", "figures")
_MOST_RUNS = 3  # most runs of the reference study; each takes half a minute
# m/s, below first yield of two brass spheres; until contacts have formed
_RATTLE = 0.02
_RATTLE_STEPS = 200
_ROUNDING = 1e-9  # overlap of spheres at rest / diameter
_BYTES_OF_GHOST = 24  # a position; friction adds velocity and spin, 48
_STATE = ("x", "v", "omega")
_TITLES = {"struck": "impact", "rattling": "rattling"}  # of the states in which styles are timed
_MEMORY = re.compile(
    r"(?m)^Per MPI rank memory allocation[^=]*= [^|]*\| *(\S+)"
)  # the mean of all ranks, MB

Measure = Callable[[int], dict[str, Any]]

OURS = "gran/hysteretic elastoplastic"
BASELINE = "gran/hertz/history"
ROUGH = f"{OURS}, friction 0.3"
ROUGH_BASELINE = f"{BASELINE}, friction 0.3"
GRANULAR = "granular hertz/material"
ROUGH_GRANULAR = f"{GRANULAR}, friction 0.3"
_ELASTOPLASTIC = (
    "pair_style gran/hysteretic {gap}\npair_coeff * * elastoplastic {E} {nu} {yield_strength}"
)
_HERTZ_MATERIAL = "pair_style granular\npair_coeff * * hertz/material {E} 0.0 {nu} tangential linear_nohistory 0.0 0.0 damping velocity"
_MINDLIN = "pair_style granular\npair_coeff * * hertz/material {E} 0.0 {nu} tangential mindlin NULL 0.0 0.3 damping velocity"
#: Commands of each style, with names of constants in braces, its integrating fix, and the style that it stands beside.
STYLES = {
    OURS: (_ELASTOPLASTIC, "gran/nve", BASELINE),
    "gran/hysteretic hertz": (
        "pair_style gran/hysteretic {gap}\npair_coeff * * hertz {E} {nu}", "gran/nve", BASELINE
    ),
    BASELINE: ("pair_style gran/hertz/history {kn} NULL 0.0 NULL 0.0 0\npair_coeff * *", "nve", BASELINE),
    GRANULAR: (_HERTZ_MATERIAL, "nve", BASELINE),
    ROUGH: (f"{_ELASTOPLASTIC} friction 0.3", "gran/nve/sphere", ROUGH_BASELINE),
    ROUGH_BASELINE: (
        "pair_style gran/hertz/history {kn} NULL 0.0 NULL 0.3 0\npair_coeff * *", "nve/sphere", ROUGH_BASELINE
    ),
    ROUGH_GRANULAR: (_MINDLIN, "nve/sphere", ROUGH_BASELINE),
}  # fmt: skip
#: Style of LAMMPS's pair style granular by style of gran/hertz/history: the second comparison.
GRANULAR_STYLES = {BASELINE: GRANULAR, ROUGH_BASELINE: ROUGH_GRANULAR}


def bench(
    parts: Iterable[str], repeats: int = 5, others: Mapping[str, Measure] | None = None
) -> dict[str, Any]:
    """Make and print the measurements of these parts; return them as plain values, each with all
    its repeats.

    Parameters
    ----------
    parts
        Parts to measure: styles, sizes, ranks, study, and ``others``.
    repeats
        Number of timings of each.
    others
        Functions for further parts, by name.
    """
    cores = len(os.sched_getaffinity(0))
    results: dict[str, Any] = {"cores": cores, "repeats": repeats, "load_before": os.getloadavg()}
    print(
        f"load of the machine: {results['load_before'][0]:.2f}; on a busy machine only the ratios "
        "are meaningful"
    )
    ways = {
        "styles": lambda: compare_styles(repeats),
        "sizes": lambda: compare_sizes(repeats),
        "ranks": lambda: compare_ranks(repeats),
        "study": lambda: time_study(repeats, min(2, cores)),
    }
    results |= {part: measure() for part, measure in ways.items() if part in parts}
    further = others or {}
    results |= {part: measure(repeats) for part, measure in further.items() if part in parts}
    results["triad_GB_per_s"] = triad()
    results["load_after"] = os.getloadavg()
    print(
        f"\nmemory bandwidth of one core (triad): {results['triad_GB_per_s']:.1f} GB/s; "
        f"load now {results['load_after'][0]:.2f}"
    )
    return results


def triad(megabytes: int = 256, repeats: int = 5) -> float:
    """Measure the memory bandwidth of one core, GB/s: a = b + s c on arrays larger than the
    caches.
    """
    n = megabytes * 2**20 // 8
    a = np.empty(n)
    b = np.ones(n)
    c = np.ones(n)
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        np.multiply(c, 3.0, out=a)
        np.add(a, b, out=a)
        best = min(best, time.perf_counter() - begin)
    return 5 * 8 * n / best / 1e9  # two passes: read c write a, read a and b write a


# ---------------------------------------------------------------------- styles


def compare_styles(repeats: int) -> dict[str, Any]:
    """Time all styles on the reference packing: under impact, with mostly unloaded contacts,
    and rattling, with mostly loaded contacts.

    They run interleaved in one process, from the same states: positions and velocities are
    restored before each timing. Ratios are computed within a repeat, so that both timings have the
    same load of the machine.

    Returns
    -------
    dict
        ``n_spheres``, and under ``struck`` and ``rattling``: ``loaded_contacts_per_sphere``, and
        ``table`` with rates and memory of each style, and its ratios to `BASELINE` and to pair
        style granular, with friction in both or in neither.
    """
    assembly = load_assembly(library.find(STUDY))
    case = assembly.case
    n = assembly.lattice.n_spheres
    results: dict[str, Any] = {"n_spheres": n}
    with (
        scratch_directory("granwave-bench-") as scratch,
        contextlib.ExitStack() as opened,
    ):
        data = scratch / "data.granwave"
        engines = {}
        logs = {style: scratch / f"log.{k}" for k, style in enumerate(STYLES)}
        write_data(assembly, data)
        for style, log in logs.items():
            engines[style] = opened.enter_context(open_engine(mpi.this_process(), log=str(log)))
            engines[style].commands(script(assembly, data, *STYLES[style][:2]))
        ours = engines[OURS]
        print(f"{n} spheres, FCC, brass, {repeats} × {STEPS} steps of each style")
        ours.commands(f"run {round(IMPACT_TIME / auto_timestep(assembly))} post no")
        for name, title in _TITLES.items():
            if name == "rattling":
                rattle(ours, seed=0)
            order = np.argsort(ours.lammps.numpy.extract_atom("id"))
            state = [
                ours.lammps.numpy.extract_atom(one)[: len(order)][order].copy() for one in _STATE
            ]
            pairs = cKDTree(state[0]).query_pairs(
                (1 - _ROUNDING) * case.packing.diameter, output_type="ndarray"
            )
            print(f"\n{title}, {len(pairs) / n:.2f} loaded contacts per sphere:")
            rates: dict[str, list[float]] = {style: [] for style in engines}
            for _ in range(repeats):
                for style, engine in engines.items():
                    _restore(engine, state)
                    rates[style].append(n * STEPS / _seconds(engine))
            print(
                f"{'':44}{'sphere-steps/s':>26}{'times ' + BASELINE:>30}"
                f"{'times granular':>26}{'bytes/sphere':>14}"
            )
            table = {}
            for style, values in rates.items():
                baseline = STYLES[style][2]
                ratios = quotients(values, rates[baseline])
                to_granular = quotients(values, rates[GRANULAR_STYLES[baseline]])
                memory = float(_MEMORY.findall(logs[style].read_text())[-1]) * 2**20 / n
                table[style] = {
                    "rates": values,
                    "ratios": ratios,
                    "ratios_to_granular": to_granular,
                    "bytes_per_sphere": memory,
                }
                print(
                    f"{style:44}{spread(values, 1e6):>22} M/s{spread(ratios):>30}"
                    f"{spread(to_granular):>26}{memory:>14.0f}"
                )
            results[name] = {"loaded_contacts_per_sphere": len(pairs) / n, "table": table}
            _restore(ours, state)
    return results


def coefficients(case: Case, lines: str, gap: float, youngs_modulus: float) -> str:
    """Return the commands of a pair style with the constants of a case and this modulus, Pa."""
    material = case.material
    return lines.format(
        gap=gap,
        E=youngs_modulus,
        nu=material.poisson_ratio,
        yield_strength=material.yield_strength,
        kn=2 / 3 * youngs_modulus / (1 - material.poisson_ratio**2),
    )


def script(assembly: Assembly, data: Path, lines: str, motion: str) -> str:
    """Return the LAMMPS commands of an impacted packing, given the commands of the pair style and
    the integrating fix.
    """
    case = assembly.case
    gap = 0.1 * case.packing.diameter
    pair = coefficients(case, lines, gap, case.material.youngs_modulus)
    totals = "compute contact all pair gran/hysteretic\nthermo_style custom step c_contact[2]"
    return f"""units si
atom_style sphere
atom_modify map yes sort 0 0
newton off
comm_modify vel yes
boundary m m m
read_data {data}
neighbor {gap} bin
neigh_modify delay 0 every 10 check yes
{pair}
fix motion all {motion}
timestep {auto_timestep(assembly)}
group struck id {struck_spheres(assembly.lattice, 1)[0]}
velocity struck set 0.0 0.0 {start_speed(assembly)} units box
thermo 1000000
{totals if "hysteretic" in lines else ""}
"""


def rattle(engine: Engine, seed: int) -> None:
    """Give all spheres of this rank random velocities, and run until contacts have formed."""
    speeds = engine.lammps.numpy.extract_atom("v")
    speeds[:] = np.random.default_rng(seed).uniform(-_RATTLE, _RATTLE, speeds.shape)
    engine.commands(f"run {_RATTLE_STEPS} post no")


def _seconds(engine: Engine) -> float:
    """Measure the wall time of `STEPS` steps, without set-up and the steps before."""
    engine.commands(f"run {WARM} post no")
    begin = time.perf_counter()
    engine.commands(f"run {STEPS} pre no post no")
    return time.perf_counter() - begin


def _restore(engine: Engine, state: list[np.ndarray]) -> None:
    ids = engine.lammps.numpy.extract_atom("id")
    for name, values in zip(_STATE, state, strict=True):
        engine.lammps.numpy.extract_atom(name)[: len(ids)] = values[ids - 1]


def quotients(values: Sequence[float], others: Sequence[float]) -> list[float]:
    """Return the ratio of both measurements in each repeat."""
    return [value / other for value, other in zip(values, others, strict=True)]


def spread(values: list[float], unit: float = 1.0) -> str:
    """Return the median and the range as text."""
    low = min(values) / unit
    middle = statistics.median(values) / unit
    high = max(values) / unit
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"


# ---------------------------------------------------------------------- sizes and ranks


def time_rattling(size: list[int], repeats: int) -> dict[str, Any]:
    """Time the elasto-plastic style on all ranks; all spheres rattle, so that equal fractions of
    contacts are loaded.

    Returns
    -------
    dict
        ``n_spheres``, ``n_ranks``, ``rates`` (sphere-steps per second of all ranks together, one
        value a repeat), and ``ghosts``, the largest number of copies of its neighbours' spheres
        that a rank receives in each step.
    """
    comm = mpi.world()
    assembly = load_assembly(library.find(STUDY), {"packing.size": size})
    n = assembly.lattice.n_spheres
    with scratch_directory("granwave-bench-") as scratch:
        data = Path(mpi.on_first(comm, lambda: scratch)) / "data.granwave"
        mpi.on_first(comm, lambda: write_data(assembly, data))
        with open_engine(comm, log="none") as engine:
            engine.commands(script(assembly, data, *STYLES[OURS][:2]))
            rattle(engine, seed=comm.rank)
            rates = [n * STEPS / _seconds(engine) for _ in range(repeats)]
            ghosts = max(comm.allgather(engine.lammps.extract_setting("nghost")))
    return {"n_spheres": n, "n_ranks": comm.size, "rates": rates, "ghosts": ghosts}


def compare_sizes(repeats: int) -> list[dict[str, Any]]:
    """Time packings of several sizes on one rank."""
    print("\ncost against size, all spheres rattling, one rank:")
    found = []
    for size in SIZES:
        found.append(timing := time_rattling(size, repeats))
        cost = 1e9 / statistics.median(timing["rates"])
        print(
            f"{timing['n_spheres']:>10} spheres {spread(timing['rates'], 1e6):>24} M/s"
            f"   {cost:6.1f} ns per sphere-step"
        )
    return found


def compare_ranks(repeats: int) -> dict[str, list[dict[str, Any]]]:
    """Time one rank and two ranks: the same packing (strong scaling), and the same number of
    spheres on each rank (weak scaling).
    """
    longer = [SIZES[1][0], SIZES[1][1], 2 * SIZES[1][2]]
    one, two, weak = (
        _on_ranks(n, size, repeats) for n, size in ((1, SIZES[1]), (2, SIZES[1]), (2, longer))
    )
    found = {"strong": [one, two], "weak": [one, weak]}
    for name, timings in found.items():
        print(
            f"\n{name} scaling, all spheres rattling (efficiency: speed of each rank, relative to a"
            " single rank):"
        )
        for timing in timings:
            n_ranks = timing["n_ranks"]
            rates = timing["rates"]
            efficiency = statistics.median(rates) / statistics.median(one["rates"]) / n_ranks
            exchanged = _BYTES_OF_GHOST * timing["ghosts"]
            print(
                f"{timing['n_spheres']:>10} spheres on {n_ranks} ranks  {spread(rates, 1e6):>22} M/s"
                f"   efficiency {efficiency:.2f}   {exchanged / 1e3:.0f} kB per rank and step"
            )
    return found


def _on_ranks(n_ranks: int, size: list[int], repeats: int) -> dict[str, Any]:
    """Run `time_rattling` on separate ranks."""
    program = (
        "import json; from granwave.workflows import bench; from granwave.workflows.run import mpi; "
        f"found = bench.time_rattling({size}, {repeats}); "
        "print(json.dumps(found)) if mpi.world().rank == 0 else None"
    )
    command = [
        mpi.find_mpiexec() or "mpiexec",
        "-n",
        str(n_ranks),
        *mpi.PYTHON,
        "-m",
        "mpi4py",
        "-c",
    ]
    done = subprocess.run(
        [*command, program],
        capture_output=True,
        text=True,
        check=True,
        env=of_this_machine(os.environ),
    )
    found: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return found


# ---------------------------------------------------------------------- reference study


def time_study(repeats: int, ranks: int) -> dict[str, Any]:
    """Run the reference study by the command, at most three times, and time its parts.

    Returns
    -------
    dict
        ``ranks``, ``n_steps``, and lists of wall times, s: ``start`` (program, packing, input
        script, set-up of LAMMPS), ``steps``, ``analysis`` (with the start of the program) and
        ``figures``.
    """
    print(f"\nreference study ({TIMED}) on {ranks} ranks, wall time of its parts, s:")
    times: dict[str, list[float]] = {part: [] for part in STUDY_PARTS}
    n_steps = 0
    with scratch_directory("granwave-bench-") as scratch:
        for number in range(min(repeats, _MOST_RUNS)):
            directory = scratch / f"run-{number}"
            whole = _timed("run", TIMED, "-o", str(directory), "--np", str(ranks), "--no-figures")
            steps = float(
                json.loads((directory / RECORD_FILE).read_text(encoding="utf-8"))["wall_time_s"]
            )
            n_steps = int(
                json.loads((directory / SUMMARY_FILE).read_text(encoding="utf-8"))["n_steps"]
            )
            analysis = _timed("analyse", str(directory), "--no-figures")
            figures = _timed("analyse", str(directory)) - analysis
            for part, value in zip(
                STUDY_PARTS, (whole - steps - analysis, steps, analysis, figures), strict=True
            ):
                times[part].append(value)
            shutil.rmtree(directory)
    for part, values in times.items():
        print(
            f"{part:>10} {spread(values):>28}" + (f"   {n_steps} steps" if part == "steps" else "")
        )
    return {"ranks": ranks, "n_steps": n_steps, **times}


def _timed(*words: str) -> float:
    """Run a command of granwave; return its wall time, s."""
    begin = time.perf_counter()
    subprocess.run(
        [*mpi.PYTHON, "-m", "granwave.workflows", *words], check=True, capture_output=True
    )
    return time.perf_counter() - begin
