"""Speed compared with LAMMPS's own granular styles on this machine.

All styles run in one process, interleaved, from one state: the reference packing during impact, with thousands of
yielded contacts. Positions and velocities are restored before each timing, so that all styles have the same overlaps
every time. Ratios are formed within a repeat, so that both timings see the same load of the machine.

The dependence on size and the scaling to two ranks are timed on packings in which all spheres rattle, so that the share
of loaded contacts is the same at every size.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.data_file import write_data
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.struck_spheres import struck_spheres
from granwave.lammps_inputs.planning.timestep import auto_timestep
from granwave.workflows import library
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import Engine, open_engine

OURS, BASELINE = "gran/hysteretic elastoplastic", "gran/hertz/history"
ROUGH_BASELINE = f"{BASELINE}, friction 0.3"


@dataclasses.dataclass(frozen=True)
class Style:
    """Style to be timed: script lines, style of the integrating fix, and style that it is compared with."""

    lines: str
    motion: str = "nve"
    beside: str = BASELINE


STYLES = {
    OURS: Style("pair_style gran/hysteretic {gap}\npair_coeff * * elastoplastic {E} {nu} {yield_strength}"),
    "gran/hysteretic hertz": Style("pair_style gran/hysteretic {gap}\npair_coeff * * hertz {E} {nu}"),
    BASELINE: Style("pair_style gran/hertz/history {kn} NULL 0.0 NULL 0.0 0\npair_coeff * *"),
    "granular hertz/material": Style(
        "pair_style granular\npair_coeff * * hertz/material {E} 0.0 {nu} tangential linear_nohistory 0.0 0.0"
    ),
    f"{OURS}, friction 0.3": Style(
        "pair_style gran/hysteretic {gap}\npair_coeff * * elastoplastic {E} {nu} {yield_strength} friction 0.3",
        "nve/sphere",
        ROUGH_BASELINE,
    ),
    ROUGH_BASELINE: Style(
        "pair_style gran/hertz/history {kn} NULL 0.0 NULL 0.3 0\npair_coeff * *", "nve/sphere", ROUGH_BASELINE
    ),
}
IMPACT_TIME = 3e-4  # s after impact at which the styles are compared
SIZES = ([24, 24, 18], [72, 72, 30], [160, 160, 78])
_STEPS, _WARM = 100, 20
_STATE = ("x", "v", "omega")
_RATTLE = 0.02  # m/s, largest velocity component; two brass spheres yield above about 0.05 m/s


@dataclasses.dataclass(frozen=True)
class Timing:
    """Repeated measurements of a speed, in sphere-steps per second."""

    name: str
    rates: list[float]

    @property
    def median(self) -> float:
        return statistics.median(self.rates)


def bench(repeats: int = 5, report: Callable[[str], None] = print, sizes: bool = True) -> dict[str, Any]:
    """Time styles, sizes and ranks; return the results as a dictionary of plain values."""
    results: dict[str, Any] = {"load_before": os.getloadavg(), "cores": os.cpu_count()}
    report(
        f"load of the machine: {results['load_before'][0]:.2f}; on a busy one the ratios still hold, the rates do not"
    )
    results["styles"] = _compare_styles(repeats, report)
    if sizes:
        results["sizes"] = _compare_sizes(repeats, report)
        results["ranks"] = _compare_ranks(repeats, report)
    results["triad_GB_per_s"] = triad()
    results["load_after"] = os.getloadavg()
    return results


# ---------------------------------------------------------------------- styles


def _compare_styles(repeats: int, report: Callable[[str], None]) -> dict[str, Any]:
    case = load_case(library.find("fcc-impact"))
    n = assemble(case).lattice.n_spheres
    with tempfile.TemporaryDirectory(prefix="granwave-bench-") as scratch:
        data = Path(scratch) / "data.granwave"
        write_data(assemble(case), data)
        engines = {}
        with _stack(case, data, Path(scratch)) as opened:
            engines = opened
            ours = engines[OURS]
            steps = round(IMPACT_TIME / auto_timestep(case))
            report(f"{n} spheres, FCC, brass; {steps} steps into the impact at {case.load.velocity:g} m/s ...")
            ours.commands(f"run {steps} post no")
            yielded = _variable(ours, "c_contact[2]")
            state = _state(ours)
            report(f"{yielded:.0f} contacts have yielded; timing {repeats} x {_STEPS} steps of each style")
            rates: dict[str, list[float]] = {name: [] for name in engines}
            for _ in range(repeats):
                for name, engine in engines.items():
                    _restore(engine, state)
                    rates[name].append(n * _STEPS / _time(engine))
            memory = {name: _memory(Path(scratch) / f"log.{k}") / n for k, name in enumerate(engines)}
    report(f"{'':44}{'sphere-steps/s':>26}{'times ' + BASELINE:>30}{'bytes/sphere':>14}")
    table = {}
    for name, values in rates.items():
        ratios = [value / base for value, base in zip(values, rates[STYLES[name].beside], strict=True)]
        table[name] = {"rates": values, "ratios": ratios, "bytes_per_sphere": memory[name]}
        report(f"{name:44}{_spread(values, 1e6):>22} M/s{_spread(ratios, 1):>30}{memory[name]:>14.0f}")
    return {"n_spheres": n, "yielded_contacts": yielded, "table": table}


class _stack:
    """Context of one LAMMPS instance for each style, on the same packing."""

    def __init__(self, case: Case, data: Path, scratch: Path) -> None:
        self._exits = contextlib.ExitStack()
        self._case, self._data, self._scratch = case, data, scratch

    def __enter__(self) -> dict[str, Engine]:
        from mpi4py import MPI

        engines = {}
        for k, (name, style) in enumerate(STYLES.items()):
            engine = self._exits.enter_context(open_engine(MPI.COMM_SELF, log=str(self._scratch / f"log.{k}")))
            engine.commands(_script(self._case, self._data, style))
            engines[name] = engine
        return engines

    def __exit__(self, *_: object) -> None:
        self._exits.close()


def _script(case: Case, data: Path, style: Style) -> str:
    material, diameter = case.material, case.packing.diameter
    modulus = material.youngs_modulus / (2 * (1 - material.poisson_ratio**2))
    coefficients = style.lines.format(
        gap=0.1 * diameter,
        E=material.youngs_modulus,
        nu=material.poisson_ratio,
        yield_strength=material.yield_strength,
        kn=4 / 3 * modulus,
    )
    totals = (
        "compute contact all pair gran/hysteretic\nthermo_style custom step c_contact[2]"
        if "hysteretic" in style.lines
        else ""
    )
    struck = struck_spheres(assemble(case).lattice, 1)[0]
    return f"""units si
atom_style sphere
atom_modify map yes sort 0 0
newton off
comm_modify vel yes
boundary m m m
read_data {data}
neighbor {0.1 * diameter} bin
neigh_modify delay 0 every 10 check yes
{coefficients}
fix motion all {style.motion}
timestep {auto_timestep(case)}
group struck id {struck}
velocity struck set 0.0 0.0 {case.load.velocity} units box
thermo 1000000
{totals}
"""


def _state(engine: Engine) -> tuple[np.ndarray, ...]:
    order = np.argsort(engine.lammps.numpy.extract_atom("id"))
    return tuple(engine.lammps.numpy.extract_atom(name)[: len(order)][order].copy() for name in _STATE)


def _restore(engine: Engine, state: tuple[np.ndarray, ...]) -> None:
    ids = engine.lammps.numpy.extract_atom("id")
    for name, values in zip(_STATE, state, strict=True):
        engine.lammps.numpy.extract_atom(name)[: len(ids)] = values[ids - 1]


def _time(engine: Engine) -> float:
    """Measure the wall time of the timed steps, s, without set-up and warm-up steps."""
    engine.commands(f"run {_WARM} post no")
    begin = time.perf_counter()
    engine.commands(f"run {_STEPS} pre no post no")
    return time.perf_counter() - begin


def _variable(engine: Engine, formula: str) -> float:
    engine.commands(f"variable bench_value equal {formula}")
    return float(engine.lammps.extract_variable("bench_value"))


def _memory(log: Path) -> float:
    """Return the memory that LAMMPS reports, bytes."""
    lines = [line for line in log.read_text().splitlines() if line.startswith("Per MPI rank memory allocation")]
    return float(lines[-1].split("=")[1].split("|")[1]) * 2**20


# ---------------------------------------------------------------------- sizes and ranks


def rattle(size: list[int], repeats: int) -> Timing:
    """Time our elasto-plastic style on a packing of rattling spheres that hardly yield, on all ranks."""
    comm = mpi.world()
    case = load_case(library.find("fcc-impact"), {"packing.size": size})
    n = assemble(case).lattice.n_spheres
    with tempfile.TemporaryDirectory(prefix="granwave-bench-") as scratch:
        data = Path(mpi.on_first(comm, lambda: scratch)) / "data.granwave"
        mpi.on_first(comm, lambda: write_data(assemble(case), data))
        with open_engine(comm, log="none") as engine:
            engine.commands(_script(case, data, STYLES[OURS]))
            speeds = engine.lammps.numpy.extract_atom("v")
            speeds[:] = np.random.default_rng(comm.rank).uniform(-_RATTLE, _RATTLE, speeds.shape)
            engine.commands("run 200 post no")
            rates = [n * _STEPS / _time(engine) for _ in range(repeats)]
    return Timing(" x ".join(map(str, size)), rates)


def _compare_sizes(repeats: int, report: Callable[[str], None]) -> list[dict[str, Any]]:
    report("\ncost against size, all spheres rattling, one rank:")
    found = []
    for size in SIZES:
        timing = rattle(size, repeats)
        n = size[0] * size[1] * size[2]
        found.append({"n_spheres": n, "rates": timing.rates})
        report(f"{n:>10} spheres{_spread(timing.rates, 1e6):>22} M/s   {1e9 / timing.median:6.1f} ns a sphere-step")
    return found


def _compare_ranks(repeats: int, report: Callable[[str], None]) -> dict[str, list[float]]:
    report("\nranks, 155520 rattling spheres (each rank's share of the time of one rank; 1 is ideal):")
    rates = {}
    for n_ranks in (1, 2):
        script = (
            "import json; from granwave.workflows.cli import bench; from granwave.workflows.run import mpi; "
            f"t = bench.rattle({SIZES[1]}, {repeats}); "
            "print(json.dumps(t.rates)) if mpi.world().rank == 0 else None"
        )
        launcher = Path(sys.prefix) / "bin" / "mpiexec"
        done = subprocess.run(
            [str(launcher), "-n", str(n_ranks), sys.executable, "-m", "mpi4py", "-c", script],
            capture_output=True,
            text=True,
            check=True,
        )
        rates[str(n_ranks)] = json.loads(done.stdout.strip().splitlines()[-1])
        efficiency = statistics.median(rates[str(n_ranks)]) / statistics.median(rates["1"]) / n_ranks
        report(f"{n_ranks:>10} ranks  {_spread(rates[str(n_ranks)], 1e6):>22} M/s   efficiency {efficiency:.2f}")
    return rates


def triad(megabytes: int = 256, repeats: int = 5) -> float:
    """Measure the memory bandwidth of one core, GB/s: a = b + s c on arrays larger than the caches."""
    n = megabytes * 2**20 // 8
    a, b, c = np.empty(n), np.ones(n), np.ones(n)
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        np.multiply(c, 3.0, out=a)
        np.add(a, b, out=a)
        best = min(best, time.perf_counter() - begin)
    return 5 * 8 * n / best / 1e9  # two passes: read c write a, read a and b write a


def _spread(values: list[float], unit: float) -> str:
    low, middle, high = min(values) / unit, statistics.median(values) / unit, max(values) / unit
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"
