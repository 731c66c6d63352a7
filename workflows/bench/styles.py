"""Pair styles beside LAMMPS's own, in one process, interleaved, from the same states.

Positions and velocities are restored before each timing, so that all styles have the same overlaps every time. Ratios
are formed within a repeat, so that both timings see the same load of the machine.
"""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.timestep import auto_timestep
from granwave.workflows import library
from granwave.workflows.bench.timing import STEPS, STUDY, Report, Style, rattle, script, seconds, spread
from granwave.workflows.run.lammps_engine import Engine, open_engine

OURS, BASELINE = "gran/hysteretic elastoplastic", "gran/hertz/history"
ROUGH_BASELINE = f"{BASELINE}, friction 0.3"
STYLES = {
    OURS: Style(
        "pair_style gran/hysteretic {gap}\npair_coeff * * elastoplastic {E} {nu} {yield_strength}", "nve", BASELINE
    ),
    "gran/hysteretic hertz": Style("pair_style gran/hysteretic {gap}\npair_coeff * * hertz {E} {nu}", "nve", BASELINE),
    BASELINE: Style("pair_style gran/hertz/history {kn} NULL 0.0 NULL 0.0 0\npair_coeff * *", "nve", BASELINE),
    "granular hertz/material": Style(
        "pair_style granular\npair_coeff * * hertz/material {E} 0.0 {nu} tangential linear_nohistory 0.0 0.0",
        "nve",
        BASELINE,
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
_ROUNDING = 1e-9  # of the diameter: overlaps at rest
_STATE = ("x", "v", "omega")

State = tuple[np.ndarray, ...]


def compare_styles(repeats: int, report: Report) -> dict[str, Any]:
    """Time all styles on the reference packing: struck, where most contacts bear nothing, and rattling, where most do.

    Returns
    -------
    dict
        ``n_spheres``, and under ``struck`` and ``rattling``: ``loaded_contacts_per_sphere``, and ``table`` with rates,
        ratios and memory of each style.
    """
    case = load_case(library.find(STUDY))
    n = assemble(case).lattice.n_spheres
    results: dict[str, Any] = {"n_spheres": n}
    with tempfile.TemporaryDirectory(prefix="granwave-bench-") as scratch, contextlib.ExitStack() as opened:
        engines = _open(case, Path(scratch), opened)
        ours = engines[OURS]
        steps = round(IMPACT_TIME / auto_timestep(case))
        report(f"{n} spheres, FCC, brass, {repeats} x {STEPS} steps of each style")
        ours.commands(f"run {steps} post no")
        for name in ("struck", "rattling"):
            if name == "rattling":
                rattle(ours, seed=0)
            state = _state(ours)
            loaded = _loaded_contacts(state, case) / n
            report(f"\n{name}, {loaded:.2f} loaded contacts a sphere:")
            rates: dict[str, list[float]] = {style: [] for style in engines}
            for _ in range(repeats):
                for style, engine in engines.items():
                    _restore(engine, state)
                    rates[style].append(n * STEPS / seconds(engine))
            memory = {style: _memory(Path(scratch) / f"log.{k}") / n for k, style in enumerate(engines)}
            results[name] = {"loaded_contacts_per_sphere": loaded, "table": _table(rates, memory, report)}
            _restore(ours, state)
    return results


def _table(rates: dict[str, list[float]], memory: dict[str, float], report: Report) -> dict[str, Any]:
    report(f"{'':44}{'sphere-steps/s':>26}{'times ' + BASELINE:>30}{'bytes/sphere':>14}")
    table = {}
    for name, values in rates.items():
        ratios = [value / base for value, base in zip(values, rates[STYLES[name].beside], strict=True)]
        table[name] = {"rates": values, "ratios": ratios, "bytes_per_sphere": memory[name]}
        report(f"{name:44}{spread(values, 1e6):>22} M/s{spread(ratios):>30}{memory[name]:>14.0f}")
    return table


def _open(case: Case, scratch: Path, opened: contextlib.ExitStack) -> dict[str, Engine]:
    """Open one LAMMPS instance for each style, on the same packing."""
    from mpi4py import MPI

    data = scratch / "data.granwave"
    write_data(assemble(case), data)
    engines = {}
    for k, (name, style) in enumerate(STYLES.items()):
        engine = opened.enter_context(open_engine(MPI.COMM_SELF, log=str(scratch / f"log.{k}")))
        engine.commands(script(case, data, style))
        engines[name] = engine
    return engines


def _state(engine: Engine) -> State:
    order = np.argsort(engine.lammps.numpy.extract_atom("id"))
    return tuple(engine.lammps.numpy.extract_atom(name)[: len(order)][order].copy() for name in _STATE)


def _restore(engine: Engine, state: State) -> None:
    ids = engine.lammps.numpy.extract_atom("id")
    for name, values in zip(_STATE, state, strict=True):
        engine.lammps.numpy.extract_atom(name)[: len(ids)] = values[ids - 1]


def _loaded_contacts(state: State, case: Case) -> int:
    """Count the pairs that overlap by more than rounding."""
    reach = (1 - _ROUNDING) * case.packing.diameter
    return len(cKDTree(state[0]).query_pairs(reach, output_type="ndarray"))


def _memory(log: Path) -> float:
    """Return the memory that LAMMPS reports, bytes."""
    lines = [line for line in log.read_text().splitlines() if line.startswith("Per MPI rank memory allocation")]
    return float(lines[-1].split("=")[1].split("|")[1]) * 2**20
