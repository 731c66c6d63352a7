"""Slabs: closed forms, modes of the same packing, Rayleigh's wave; attenuation in larger cells."""

from __future__ import annotations

import math

import numpy as np
import pytest

from granwave.analysis.spectra import wave_vectors
from granwave.analysis.spectra.band_structure import band_structure
from granwave.analysis.spectra.network import Network, Springs, across
from granwave.analysis.spectra.states import cell_state, packing_state
from granwave.analysis.spectra.stiffness import stiffness_of
from granwave.analysis.spectra.wave_vectors import complex_bands
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows import load_case

ALONG_Z = np.array([0.0, 0.0, 1.0])


def layers(kind="fcc", size=(3, 4, 4), **changes):
    return case_from_dict(
        {
            "name": "slab",
            "material": "brass",
            "packing": {"kind": kind, "size": list(size), "diameter": 0.01},
            "contact": {"law": "hertz", "friction": 0.3},
            "precompression": {"kind": "uniaxial", "pressure": 1e6},
            "boundary": {"sides": "periodic", "bottom": "wall"},
        }
        | changes
    )


@pytest.mark.parametrize("load", [{"kind": "uniaxial", "pressure": 1e6}, {"kind": "gravity", "acceleration": 9.81}])
def test_modes_of_a_packing_are_bands_of_its_column(load):
    """At the wave vectors that fit into a packing with periodic sides; under its own weight too."""
    case = layers(precompression=load)
    own = cell_state(case, slab=True)
    whole = packing_state(case)
    n, m = 3, 4
    reciprocal = 2 * np.pi * np.linalg.pinv(whole.periods).T
    k = np.array([i * reciprocal[0] + j * reciprocal[1] for i in range(n) for j in range(m)])
    bands = np.linalg.eigvalsh(stiffness_of(own.network).dense(k)).ravel()
    modes = np.linalg.eigvalsh(stiffness_of(whole.network).dense(np.zeros((1, 3)))[0])
    assert own.network.n_grains == 4 and len(modes) == len(bands) == 12 * 24
    assert np.sort(bands) == pytest.approx(modes, abs=1e-7 * modes[-1])


def test_columns_on_a_rigid_wall():
    """Simple cubic under a load along z: each column is a row that ends at the wall, and nothing couples them."""
    found = band_structure(layers("sc", (3, 3, 3), contact={"law": "hertz"}), points=5, directions="z", slab=True)
    network = found.state.network
    k, wall = network.springs.stiffness[0], network.supports.stiffness[0]
    matrix = np.array([[k, -k, 0], [-k, 2 * k, -k], [0, -k, k + wall]]) / network.mass[0]
    due = np.sqrt(np.linalg.eigvalsh(matrix)) / (2 * math.pi)
    assert found.bands.frequency == pytest.approx(np.tile(due, (len(found.bands.path.k), 1)), rel=1e-9)
    assert found.bands.share[0].sum() == pytest.approx(1)  # of three layers one is in the upper quarter


def test_a_held_grain_and_a_vacancy_make_the_packing_the_cell():
    held = cell_state(layers(hold=[{"index": [17], "directions": "xyz", "rotation": True}]), slab=True).network
    assert held.n_grains == 48 and held.n_freedoms == 47 * 6
    packing = {"kind": "fcc", "size": [3, 4, 4], "diameter": 0.01, "vacancies": [20]}
    gap = cell_state(layers(packing=packing), slab=True)
    assert gap.network.n_grains == 47


def test_what_has_no_sides_that_repeat_is_no_slab():
    with pytest.raises(InputError, match="--slab: found a packing that does not repeat sideways"):
        cell_state(load_case("precompressed-chain"), slab=True)


def strip(n):
    """Rows of a triangular crystal of unit springs and masses, n deep."""
    below = [np.array([0.5, 0, math.sqrt(0.75)]), np.array([-0.5, 0, math.sqrt(0.75)])]
    first, second, image, normal = [], [], [], []
    for row in range(n):
        first.append(row), second.append(row), image.append([1]), normal.append([1.0, 0, 0])
        for step in below if row < n - 1 else []:
            shift = round(step[0] - (0.5 if row % 2 == 0 else -0.5))
            first.append(row), second.append(row + 1), image.append([shift]), normal.append(step)
    one, none = np.ones(len(first)), np.zeros(len(first))
    springs = Springs(np.array(first), np.array(second), np.array(image), np.array(normal), one, none, one, none,
                      np.zeros((len(first), 2)), across(np.array(normal)))  # fmt: skip
    moves = np.zeros((n, 6), dtype=bool)
    moves[:, [0, 2]] = True
    places = np.array([[0.5 * (row % 2), 0, row * math.sqrt(0.75)] for row in range(n)])
    return Network(np.arange(1, n + 1), places, np.ones(n), np.ones(n), moves, np.array([[1.0, 0, 0]]), springs)


def test_rayleigh_s_wave():
    """A triangular crystal is isotropic for long waves, lambda = mu: c_R = sqrt(2 - 2/sqrt(3)) c_T, c_T^2 = 3 k a^2/(8 m)."""
    k = np.array([[0.08, 0, 0]])
    square = np.linalg.eigvalsh(stiffness_of(strip(400)).dense(k))[0]
    speed = np.sqrt(square[:2]) / k[0, 0]  # the waves of both surfaces
    assert speed == pytest.approx(math.sqrt((2 - 2 / math.sqrt(3)) * 3 / 8), rel=2e-3)


@pytest.mark.parametrize("direction", [(0, 0, 1.0), (1.0, 0, 0)])
def test_attenuation_from_the_faces_is_that_of_the_whole_cell(monkeypatch, direction):
    case = load_case("precompressed-fcc", {"contact.friction": 0.3})
    stiffness, way = stiffness_of(cell_state(case).network), np.array(direction)
    frequency = np.linspace(3e3, 6e4, 12)
    whole = complex_bands(stiffness, np.zeros(3), way, frequency)
    monkeypatch.setattr(wave_vectors, "MOST_UNKNOWNS", 0)
    faces = complex_bands(stiffness, np.zeros(3), way, frequency)
    assert whole is not None and faces is not None
    assert faces.least == pytest.approx(whole.least, abs=1e-9)
    assert faces.attenuation[:, :3] == pytest.approx(whole.attenuation[:, :3], abs=1e-8, nan_ok=True)


def test_attenuation_of_a_long_cell():
    """A chain of 100 beads as one cell: cosh of half of the decay from bead to bead is f/f_c."""
    case = load_case("precompressed-chain", {"packing.size": 100, "boundary.bottom": "periodic",
                                             "replace": [{"index": [1], "diameter": 9.52e-3 * (1 + 1e-12)}]})  # fmt: skip
    network = cell_state(case).network
    assert network.n_grains == 100
    cut_off = math.sqrt(network.springs.stiffness[0] / network.mass[0]) / math.pi
    found = complex_bands(stiffness_of(network), np.zeros(3), ALONG_Z, cut_off * np.array([0.5, 1.001, 1.005]))
    due = [0.0, *(2 * math.acosh(ratio) * 100 for ratio in (1.001, 1.005))]
    assert found is not None and found.least == pytest.approx(due, rel=1e-5, abs=1e-6)
