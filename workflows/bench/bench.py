"""All measurements of ``granwave bench``."""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np

from granwave.workflows.bench import PARTS
from granwave.workflows.bench.sizes import compare_ranks, compare_sizes
from granwave.workflows.bench.study import time_study
from granwave.workflows.bench.styles import compare_styles
from granwave.workflows.bench.timing import Report


def bench(parts: tuple[str, ...] = PARTS, repeats: int = 5, report: Report = print) -> dict[str, Any]:
    """Make the measurements of these parts; return them as plain values, each with all its repeats.

    Parameters
    ----------
    parts
        Some of `PARTS`.
    repeats
        Number of timings of each.
    report
        Function that prints a line.
    """
    cores = len(os.sched_getaffinity(0))
    results: dict[str, Any] = {"cores": cores, "repeats": repeats, "load_before": os.getloadavg()}
    report(f"load of the machine: {results['load_before'][0]:.2f}; on a busy one the ratios hold, the rates do not")
    if "styles" in parts:
        results["styles"] = compare_styles(repeats, report)
    if "sizes" in parts:
        results["sizes"] = compare_sizes(repeats, report)
    if "ranks" in parts:
        results["ranks"] = compare_ranks(repeats, report)
    if "study" in parts:
        results["study"] = time_study(repeats, min(2, cores), report)
    results["triad_GB_per_s"] = triad()
    results["load_after"] = os.getloadavg()
    report(
        f"\nmemory bandwidth of one core (triad): {results['triad_GB_per_s']:.1f} GB/s; "
        f"load now {results['load_after'][0]:.2f}"
    )
    return results


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
