"""Table of contact laws, with their names and options everywhere; batches bitwise identical on all
processors.
"""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from granwave._contact_laws import LAWS, ContactLaw
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.deck.commands import law_coefficients
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.cli.main import main
from tests.helpers.bodies.two_spheres import R, collide, value

LAWS_FOLDER = Path(__file__).resolve().parents[3] / "plugins" / "laws"
KERNELS = LAWS_FOLDER.parent / "kernels"
MANUAL = LAWS_FOLDER.parent / "doc" / "pair_gran_hysteretic.md"
SPHERES = {"packing": {"kind": "chain", "size": 2, "diameter": 2 * R}, "material": "brass"}
OPTIONS = {
    "variant": "published",
    "yield_factor": 1.8,
    "beta": 0.6,
    "constant": 2e7,
    "exponent": 1.2,
}
TOUCHING = [law for law in LAWS if law != "none"]


def case(law: str, **contact):
    needed = {
        name: OPTIONS[name]
        for name in ("constant", "exponent")
        if law in LAWS and name in LAWS[law].parameters
    }
    return case_from_dict({**SPHERES, "contact": {"law": law, **needed, **contact}}, "case")


@pytest.mark.parametrize("law", TOUCHING)
def test_every_law_of_the_table_serves_everywhere(lammps, tmp_path, law):
    """Case, deck, LAMMPS, binding, command line and manual have the names of the table."""
    own = {name: OPTIONS[name] for name in LAWS[law].parameters if name in OPTIONS}
    made = case(law, **own)
    words = law_coefficients(made.contact, made.material)
    assert words.split()[0] == law and all(name in words.split() for name in own)
    lmp = lammps()
    collide(lmp, style=words, steps=20000)
    contact = sphere_contact(made)
    lost = value(lmp, "c_ep[1]")
    mass = 8500 * 4 / 3 * np.pi * R**3
    peak = brentq(
        lambda overlap: float(contact.loading_work(overlap)) - 0.5 * (mass / 2) * 4,
        0,
        2e-4,
        xtol=1e-15,
    )
    assert lost == pytest.approx(float(contact.dissipated_energy(peak)), rel=1e-5, abs=1e-12)
    assert (lost > 0) == LAWS[law].yields
    if not LAWS[law].is_power:
        assert main(["law", "--law", law, "-o", str(tmp_path / "curve.csv")]) == 0
    manual = MANUAL.read_text(encoding="utf-8")
    assert f"**{law}**" in manual and f"*{law}*" in manual.partition("## Examples")[0]


@pytest.mark.parametrize("law", LAWS)
def test_elastic_limit(law):
    """Energy is dissipated only beyond the elastic limit."""
    contact = sphere_contact(case(law))
    limit = contact.elastic_limit
    assert limit == contact.yield_overlap * LAWS[law].elastic_limit or math.isinf(limit)
    assert LAWS[law].yields == math.isfinite(limit)
    if LAWS[law].yields:
        assert contact.dissipated_energy(limit) == 0
        assert contact.dissipated_energy(1.2 * contact.yield_overlap) > 0
    assert contact.entry.name == law


def test_unknown_laws_are_refused_with_the_names_of_the_table():
    with pytest.raises(InputError, match=", ".join(f'"{name}"' for name in LAWS)):
        case("rubber")
    with pytest.raises(ValueError, match=", ".join(LAWS)):
        ContactLaw(
            "rubber",
            youngs_modulus=(1, 1),
            poisson_ratio=(0, 0),
            yield_strength=(1, 1),
            radius=(1, 1),
        )


FLAGS = [
    "-std=c++17",
    "-O3",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-ffp-contract=off",
]  # of plugins/CMakeLists.txt
BATCHES = ("contact_batch", "touching_pairs")
PROGRAM = r"""
#include "line_batch.h"
#include "contact_batch.h"
#include "touching_pairs.h"
#include <cstdio>
#include <cstring>
#include <random>
using namespace granwave;

static std::mt19937_64 random_bits(7);
static double number(double low, double high) { return low + (high - low) * (random_bits() >> 11) * 0x1p-53; }

static void print(double x)
{
  std::uint64_t bits;
  std::memcpy(&bits, &x, sizeof(bits));
  std::printf("%016llx\n", (unsigned long long) bits);
}

/* A row of spheres, each with the next ones: touching, parted and far pairs. */
static void search(bool uniform)
{
  constexpr int SPHERES = 200, ROOM = SPHERES + RowGroup::LANES;
  static double x[ROOM], y[ROOM], z[ROOM], radius[ROOM], triples[SPHERES][3];
  std::vector<int> row, begin{0}, partner;
  for (int s = 0; s < SPHERES; s++) {
    triples[s][0] = x[s] = 0.5 * s + number(-0.2, 0.2);
    triples[s][1] = y[s] = number(-0.2, 0.2);
    triples[s][2] = z[s] = s % 50 == 49 ? 0.0 / 0.0 * (s > 100) : number(-0.2, 0.2);
    radius[s] = number(0.4, 0.6);
    row.push_back(s);
    const int last = std::min(s + (s % 40 < 30 ? 5 : 11), SPHERES - 1);
    for (int next = s + 1; next <= last; next++) partner.push_back(next);
    begin.push_back(static_cast<int>(partner.size()));
  }
  RowGroups groups;
  groups.build(row, begin, partner, SPHERES);
  std::vector<std::uint64_t> touched = groups.bits([](int k) { return k % 3 == 0; });
  static TouchingPairs pairs;
  pairs.x = x, pairs.y = y, pairs.z = z, pairs.radius = uniform ? nullptr : radius;
  pairs.uniform_radius = 0.5;
  pairs.gap = 0.7;
  pairs.start(groups.begin(0), groups.end(0), touched.data());
  for (bool done = false; !done;) {
    static ContactBatch batch;
    batch.size = 0;
    done = pairs.collect(batch);
    for (int m = 0; m < batch.size; m++) {
      std::printf("%d %d %d\n", batch.k[m], batch.i[m], batch.j[m]);
      print(batch.rsq[m] == batch.rsq[m] ? batch.rsq[m] : -1.0);
    }
    for (int k : pairs.parted) std::printf("parted %d\n", k);
    for (int r : pairs.far) std::printf("far %d\n", r);
  }
  char moved[SPHERES / 40] = {0, 1, 0, 0, 1};
  triples[90][1] += 1e-16;
  compare_blocks(triples[0], SPHERES, 40, x, y, z, moved);
  for (char block : moved) std::printf("moved %d\n", block);
  std::printf("%d %d\n", all_zero(triples[0], 3 * SPHERES), all_finite(triples[0], 3 * SPHERES));
}

static void compress_lines()
{
  static double s[LineBatch::CAPACITY], w[LineBatch::CAPACITY];
  for (double &ratio : s) ratio = number(0, 1);
  constexpr int GROUP = LineBatch::GROUP;
  for (int m = 0; m < LineBatch::CAPACITY; m += GROUP) LineContact::exponents<GROUP>(s + m, w + m);
  for (double root : w) print(root);
}

int main()
{
  search(true);
  search(false);
  compress_lines();
  constexpr int SPHERES = 40, PAIRS = 600;
  static double v[SPHERES][3], omega[SPHERES][3], f[SPHERES][3], torque[SPHERES][3];
  static TangentialSpring springs[PAIRS + 500];    // as many more are fetched ahead
  for (int s = 0; s < SPHERES; s++)
    for (int d = 0; d < 3; d++) v[s][d] = number(-5, 5), omega[s][d] = number(-900, 900);
  for (TangentialSpring &spring : springs)
    spring = {{number(-9, 9), number(-9, 9), number(-9, 9)}, number(1e-8, 1e-6), number(0, 1e-6)};
  for (int size : {1, 2, 3, 4, 5, 7, 8, 31, 63, 64}) {
    static ContactBatch batch;
    batch.size = size;
    for (int m = 0; m < size; m++) {
      batch.k[m] = 9 * m + m % 3;
      batch.i[m] = m / 3;
      batch.j[m] = batch.i[m] + 1 + m % 3;
      double square = 0.0;
      for (int d = 0; d < 3; d++) {
        batch.del[d][m] = number(-1e-3, 1e-3);
        square += batch.del[d][m] * batch.del[d][m];
      }
      batch.rsq[m] = square;
      batch.radsum[m] = std::sqrt(square) * (1.0 + number(1e-6, 1e-3));
      batch.radius_i[m] = batch.radius_j[m] = 0.5 * batch.radsum[m];
      batch.root_radius[m] = 0.03;
      batch.hertz[m] = 3e9;
      batch.shear_stiffness[m] = 1e11;
      batch.largest_overlap[m] = 1.0;
      batch.elastic_limit[m] = number(0, 1e-6);
      batch.peak[m] = number(0, 1e-6);
      batch.friction[m] = m % 5 == 2 ? 0.0 : 0.3;    // some without, among others
      batch.keeps[m] = m % 4 == 1 ? 1.0 : 0.0;
    }
    std::uint64_t raised, yielded;
    if (batch.compute_overlap()) return 1;
    batch.compare_with_peaks(raised, yielded);
    std::printf("%016llx %016llx\n", (unsigned long long) raised, (unsigned long long) yielded);
    if (batch.prepare_friction() != (size > 2)) return 2;
    batch.read(v[0], omega[0], springs);
    batch.advance_forces_and_torques(1e-7);
    batch.write(springs);
    batch.add_forces_and_torques(f[0], torque[0], SPHERES - 10, springs);
    batch.compute_normal();
    batch.add_normal(f[0], SPHERES - 10);
  }
  for (const TangentialSpring &spring : springs)
    for (double x : {spring.force[0], spring.force[1], spring.force[2], spring.compliance, spring.loss}) print(x);
  for (int s = 0; s < SPHERES; s++)
    for (int d = 0; d < 3; d++) print(f[s][d]), print(torque[s][d]);
}
"""


def compiled_batches(folder: Path, source: Path, definition: str) -> Path:
    """Return the program of batches, compiled with a definition in addition to those of the
    build.
    """
    program = folder / f"batches{definition}"
    files = [source, *(KERNELS / f"{name}.cpp" for name in BATCHES)]
    options = [*FLAGS, f"-D{definition}", "-Wno-psabi", "-I", KERNELS, "-I", LAWS_FOLDER]
    command = ["c++", *options, *files, "-o", program]
    subprocess.run(command, check=True, timeout=120)
    return program


@pytest.mark.validation
@pytest.mark.skipif(shutil.which("c++") is None, reason="needs a C++ compiler")
def test_the_same_bits_with_and_without_further_instructions(tmp_path):
    """With the instructions of this processor, with only common instructions, and in standard C++
    without compiler extensions: batches of any size, some pairs without friction; also the search
    for touching pairs, and contacts along lines.
    """
    source = tmp_path / "batches.cpp"
    source.write_text(PROGRAM)
    printed = []
    for definition in ("NDEBUG", "GRANWAVE_ONE_PROCESSOR", "GRANWAVE_PLAIN"):
        program = compiled_batches(tmp_path, source, definition)
        done = subprocess.run([program], capture_output=True, text=True, check=True)
        printed.append(done.stdout)
    for kind in ("parted", "far", "moved 0", "moved 1"):
        assert kind in printed[0]
    numbers = [line for line in printed[0].splitlines() if len(line) == 16]
    assert len(numbers) > 5 * 1100 + 6 * 40 + 64
    assert "nan" not in printed[0]
    assert printed[0] == printed[1]
    assert printed[0] == printed[2]


EXTENSIONS = ("__attribute__", "__builtin_", "vector_size", "target_clones", "immintrin")


@pytest.mark.parametrize("folder", ["laws", "kernels", "styles"])
def test_extensions_of_compilers_are_in_one_header(folder):
    """Another compiler requires changes of kernel.h and processors.h; the loader is for Linux."""
    for path in sorted((LAWS_FOLDER.parent / folder).glob("*.*")):
        if path.name in ("kernel.h", "processors.h", "granwaveplugin.cpp", "add_styles.cpp"):
            continue
        text = path.read_text(encoding="utf-8")
        assert [word for word in EXTENSIONS if word in text] == [], path.name
