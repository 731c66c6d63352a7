"""Cost of a step against the size of a packing, and on several ranks.

All spheres rattle, so that the share of loaded contacts is the same at every size.
"""

from __future__ import annotations

import dataclasses
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import library
from granwave.workflows.bench.styles import OURS, STYLES
from granwave.workflows.bench.timing import STEPS, STUDY, Report, rattle, script, seconds, spread
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import open_engine

_BYTES_OF_GHOST = 24  # a position; friction adds velocity and spin, 48
SIZES = ([24, 24, 18], [72, 72, 30], [160, 160, 78])


@dataclasses.dataclass(frozen=True)
class Timing:
    """Speed of a packing, and what its ranks exchange.

    Attributes
    ----------
    n_spheres
        Number of spheres.
    n_ranks
        Number of ranks.
    rates
        Sphere-steps per second, of all ranks together, one value a repeat.
    ghosts
        Largest number of ghost spheres of a rank: copies of its neighbours' spheres, whose positions arrive each step.
    """

    n_spheres: int
    n_ranks: int
    rates: list[float]
    ghosts: int

    @property
    def bytes_per_step(self) -> int:
        """Bytes that arrive at a rank in a step without friction."""
        return _BYTES_OF_GHOST * self.ghosts


def time_rattling(size: list[int], repeats: int) -> Timing:
    """Time the elasto-plastic style on a rattling packing, on all ranks."""
    comm = mpi.world()
    case = load_case(library.find(STUDY), {"packing.size": size})
    n = assemble(case).lattice.n_spheres
    with tempfile.TemporaryDirectory(prefix="granwave-bench-") as scratch:
        data = Path(mpi.on_first(comm, lambda: scratch)) / "data.granwave"
        mpi.on_first(comm, lambda: write_data(assemble(case), data))
        with open_engine(comm, log="none") as engine:
            engine.commands(script(case, data, STYLES[OURS]))
            rattle(engine, seed=comm.rank)
            rates = [n * STEPS / seconds(engine) for _ in range(repeats)]
            ghosts = max(comm.allgather(engine.lammps.extract_setting("nghost")))
    return Timing(n, comm.size, rates, ghosts)


def compare_sizes(repeats: int, report: Report) -> list[dict[str, Any]]:
    """Time packings of several sizes on one rank."""
    report("\ncost against size, all spheres rattling, one rank:")
    found = []
    for size in SIZES:
        timing = time_rattling(size, repeats)
        found.append(dataclasses.asdict(timing))
        each = 1e9 / statistics.median(timing.rates)
        report(f"{timing.n_spheres:>10} spheres{spread(timing.rates, 1e6):>22} M/s   {each:6.1f} ns a sphere-step")
    return found


def compare_ranks(repeats: int, report: Report) -> dict[str, list[dict[str, Any]]]:
    """Time one rank and two: the same packing (strong scaling), and as many spheres on each rank (weak scaling)."""
    one = _on_ranks(1, SIZES[1], repeats)
    longer = [SIZES[1][0], SIZES[1][1], 2 * SIZES[1][2]]
    pairs = {"strong": [one, _on_ranks(2, SIZES[1], repeats)], "weak": [one, _on_ranks(2, longer, repeats)]}
    for name, timings in pairs.items():
        report(f"\n{name} scaling, all spheres rattling (each rank's share of the speed of one rank; 1 is ideal):")
        for timing in timings:
            efficiency = statistics.median(timing.rates) / statistics.median(one.rates) / timing.n_ranks
            report(
                f"{timing.n_spheres:>10} spheres on {timing.n_ranks} ranks  {spread(timing.rates, 1e6):>22} M/s"
                f"   efficiency {efficiency:.2f}   {timing.bytes_per_step / 1e3:.0f} kB a rank and step"
            )
    return {name: [dataclasses.asdict(timing) for timing in timings] for name, timings in pairs.items()}


def _on_ranks(n_ranks: int, size: list[int], repeats: int) -> Timing:
    program = (
        "import dataclasses, json; from granwave.workflows.bench import sizes; from granwave.workflows.run import mpi; "
        f"found = dataclasses.asdict(sizes.time_rattling({size}, {repeats})); "
        "print(json.dumps(found)) if mpi.world().rank == 0 else None"
    )
    launcher = Path(sys.prefix) / "bin" / "mpiexec"
    done = subprocess.run(
        [str(launcher), "-n", str(n_ranks), *mpi.PYTHON, "-m", "mpi4py", "-c", program],
        capture_output=True,
        text=True,
        check=True,
    )
    return Timing(**json.loads(done.stdout.strip().splitlines()[-1]))
