"""Cost of a step against the size of a packing, and on several ranks.

All spheres rattle, so that the share of loaded contacts is the same at every size.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.deck.data_file import write_data
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import library
from granwave.workflows.bench.styles import OURS, STYLES
from granwave.workflows.bench.timing import STEPS, STUDY, Report, rattle, script, seconds, spread
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import open_engine

SIZES = ([24, 24, 18], [72, 72, 30], [160, 160, 78])


def rattling_rates(size: list[int], repeats: int) -> list[float]:
    """Time the elasto-plastic style on a rattling packing, on all ranks; sphere-steps per second."""
    comm = mpi.world()
    case = load_case(library.find(STUDY), {"packing.size": size})
    n = assemble(case).lattice.n_spheres
    with tempfile.TemporaryDirectory(prefix="granwave-bench-") as scratch:
        data = Path(mpi.on_first(comm, lambda: scratch)) / "data.granwave"
        mpi.on_first(comm, lambda: write_data(assemble(case), data))
        with open_engine(comm, log="none") as engine:
            engine.commands(script(case, data, STYLES[OURS]))
            rattle(engine, seed=comm.rank)
            return [n * STEPS / seconds(engine) for _ in range(repeats)]


def compare_sizes(repeats: int, report: Report) -> list[dict[str, Any]]:
    """Time packings of several sizes on one rank."""
    report("\ncost against size, all spheres rattling, one rank:")
    found = []
    for size in SIZES:
        n, rates = size[0] * size[1] * size[2], rattling_rates(size, repeats)
        found.append({"n_spheres": n, "rates": rates})
        each = 1e9 / statistics.median(rates)
        report(f"{n:>10} spheres{spread(rates, 1e6):>22} M/s   {each:6.1f} ns a sphere-step")
    return found


def compare_ranks(repeats: int, report: Report) -> dict[str, list[float]]:
    """Time the reference packing on one rank and on two."""
    report("\nranks, 155520 rattling spheres (each rank's share of the time of one rank; 1 is ideal):")
    rates: dict[str, list[float]] = {}
    for n_ranks in (1, 2):
        program = (
            "import json; from granwave.workflows.bench import sizes; from granwave.workflows.run import mpi; "
            f"rates = sizes.rattling_rates({SIZES[1]}, {repeats}); "
            "print(json.dumps(rates)) if mpi.world().rank == 0 else None"
        )
        launcher = Path(sys.prefix) / "bin" / "mpiexec"
        done = subprocess.run(
            [str(launcher), "-n", str(n_ranks), sys.executable, "-m", "mpi4py", "-c", program],
            capture_output=True,
            text=True,
            check=True,
        )
        rates[str(n_ranks)] = json.loads(done.stdout.strip().splitlines()[-1])
        efficiency = statistics.median(rates[str(n_ranks)]) / statistics.median(rates["1"]) / n_ranks
        report(f"{n_ranks:>10} ranks  {spread(rates[str(n_ranks)], 1e6):>22} M/s   efficiency {efficiency:.2f}")
    return rates
