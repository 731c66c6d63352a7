"""Kernels of pair style gran/hysteretic/kk on the back ends Serial and OpenMP of Kokkos: forces and
histories of columns of spheres are bitwise identical to those of the plain laws.
"""

from __future__ import annotations

import os
import subprocess

import pytest


def output(program, *words: str, threads: int = 1) -> str:
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads), "OMP_PROC_BIND": "false"}
    done = subprocess.run(
        [program, *words], capture_output=True, text=True, check=False, env=environment
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def plain(kokkos):
    """Forces and histories by the laws without Kokkos."""
    return output(kokkos / "columns_plain")


@pytest.fixture(scope="module")
def sliding(kokkos):
    """Forces and histories with friction by the laws without Kokkos."""
    return output(kokkos / "columns_plain", "friction")


def test_columns_yield_part_and_touch_again(plain):
    """The compared arrays are not empty."""
    rows = [line.split() for line in plain.splitlines()]
    forces = {row[-1] for row in rows if row[0] == "force"}
    contacts = [row for row in rows if row[0] == "contact"]
    never = "bff0000000000000"  # -1
    yielded = sum(row[5] != never for row in contacts)
    assert len(forces) > 50_000
    assert 0.2 * len(contacts) < yielded < 0.9 * len(contacts)


BACK_ENDS = [("serial", 1), ("openmp", 1), ("openmp", 2), ("openmp", 5)]


@pytest.mark.parametrize(("back_end", "threads"), BACK_ENDS)
def test_kernels_give_the_bits_of_the_laws(kokkos, plain, back_end, threads):
    computed = output(kokkos / "columns_kokkos", back_end, threads=threads)
    assert "wrong" not in computed
    assert computed == plain


def test_columns_with_friction_slide_stick_and_part(sliding):
    springs = [line.split()[3:] for line in sliding.splitlines() if line.startswith("spring")]
    zero = "0" * 16
    stretched = sum(spring[3] != zero for spring in springs)
    lossy = sum(spring[4] != zero for spring in springs)
    assert 0.2 * len(springs) < stretched < 0.9 * len(springs)
    assert 0.5 * len(springs) < lossy < len(springs)


@pytest.mark.parametrize(("back_end", "threads"), BACK_ENDS)
def test_springs_have_the_bits_of_the_laws(kokkos, sliding, back_end, threads):
    computed = output(kokkos / "columns_kokkos", back_end, "friction", threads=threads)
    assert "wrong" not in computed
    assert computed == sliding
