"""Bands compared with closed forms, the theory of lines, and speeds of runs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.measures.hertz_lattices import line_of
from granwave.extensions.waves.spectra.band_structure import band_structure, long_wave_speeds
from granwave.extensions.waves.spectra.bands import band_edges, solve_bands
from granwave.extensions.waves.spectra.states import cell_state
from granwave.extensions.waves.spectra.stiffness import stiffness_of
from granwave.extensions.waves.spectra.wave_vectors import complex_bands, make_path
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from tests.helpers.bodies.springs import endless, network

AXIAL = {"kind": "uniaxial", "force": 20.0}
ALL_ROUND = {"kind": "uniform", "pressure": 1e5}
HERTZ = 4 / 3 * (115e9 / (1 - 0.09) / 2) * np.sqrt(0.0025)  # of two brass spheres of 10 mm
STIFFNESS = 1.5 * HERTZ ** (2 / 3) * 20 ** (1 / 3)
BRASS = 8500 * np.pi / 6 * 0.01**3
HALF = 4000 * np.pi / 6 * 0.01**3
RESULTS = json.loads(
    (Path(__file__).parents[3] / "docs" / "explanation" / "results.json").read_text()
)


def test_monatomic_chain():
    """omega = 2 sqrt(k/m) |sin(kD/2)|."""
    found = band_structure(assemble(endless("chain", 10, AXIAL)), "0,0,0; 0,0,600", points=41)
    k = found.bands.path.k[:, 2]
    omega = 2 * np.sqrt(STIFFNESS / BRASS) * np.abs(np.sin(k * 0.005))
    np.testing.assert_allclose(2 * np.pi * found.bands.frequency[:, 0], omega, rtol=1e-9, atol=1e-3)
    slope = 0.01 * np.sqrt(STIFFNESS / BRASS) * np.cos(k * 0.005) * np.sign(np.sin(k * 0.005))
    np.testing.assert_allclose(found.bands.velocity[1:, 0, 2], slope[1:], rtol=1e-6, atol=1e-4)
    np.testing.assert_allclose(found.speeds, 0.01 * np.sqrt(STIFFNESS / BRASS), rtol=1e-6)


def test_a_large_cell_has_fewer_wave_vectors(monkeypatch):
    chain = assemble(endless("chain", 10, AXIAL))
    assert len(band_structure(chain).bands.path.k) == 61
    monkeypatch.setattr("granwave.extensions.waves.spectra.band_structure.LARGE", 0)
    assert len(band_structure(chain).bands.path.k) == 16
    assert len(band_structure(chain, points=5).bands.path.k) == 5


def diatomic():
    return endless(
        "chain", 10, AXIAL, replace=[{"index": [2, 4, 6, 8, 10], "material": "light"}],
        materials={"light": {"youngs_modulus": 115e9, "poisson_ratio": 0.3, "density": 4000}},
    )  # fmt: skip


def test_diatomic_chain():
    """Edges sqrt(2k/M), sqrt(2k/m), sqrt(2k(1/m + 1/M)), and cosh of the attenuation in the gap."""
    found = band_structure(assemble(diatomic()))
    assert found.state.network.n_grains == 2
    edges = np.sqrt(2 * STIFFNESS * np.array([1 / BRASS, 1 / HALF, 1 / HALF + 1 / BRASS])) / (
        2 * np.pi
    )
    np.testing.assert_allclose([found.edges[0, 1], *found.edges[1]], edges, rtol=1e-9)
    assert [(gap.low, gap.below) for gap in found.gaps] == [
        (found.edges[0, 1], 1),
        (found.edges[1, 1], 2),
    ]
    decaying = found.complex_bands
    assert decaying is not None and decaying.spacing == pytest.approx(0.02)
    square = (2 * np.pi * decaying.frequency) ** 2 / STIFFNESS
    cosine = np.abs(1 - square * (BRASS + HALF) + square**2 * BRASS * HALF / 2)
    np.testing.assert_allclose(
        decaying.least, np.arccosh(np.maximum(cosine, 1)), rtol=1e-6, atol=2e-6
    )


@pytest.mark.parametrize(
    ("stiffness", "acoustic", "low", "high", "third"),
    [  # K1, K2, kw follow from delta0, delta1 and kw of the three walls' places
        ((3.673e-7, 5.816e-8, 1.789e8), 31795, 42051, 68093, 354119),
        ((3.307e-7, 1.092e-7, 1.872e8), 37222, 49229, 68647, 362876),
        ((2.489e-7, 1.873e-7, 1.950e8), 42592, 56331, 67350, 370989),
    ],
)
def test_tunnel_of_cylinders(stiffness, acoustic, low, high, third):
    """Thesis 7.12, corrected: spheres with a pair of cylinders in each gap, between two walls,
    within 0.2 %.
    """
    between, beside, wall = stiffness
    k1 = 1.5 * 4.11119e9 * np.sqrt(between)
    k2 = 1.5 * 4.52809e9 * np.sqrt(beside)
    ms = 3.84603e-3
    mc = 1.44075e-3
    cosine = 9.525 / (9.525 + 4.76)
    sine = np.sqrt(1 - cosine**2)
    right = (sine, 0.0, cosine)
    left = (-sine, 0.0, cosine)
    tunnel = network(
        [ms, mc, mc],
        [(0, 0, 1, (0, 0, 1), k1), (0, 1, 0, right, k2), (0, 2, 0, left, k2), (1, 0, 1, left, k2), (2, 0, 1, right, k2)],
        ["z", "xz", "xz"], 9.525e-3, [(1, (1, 0, 0), wall), (2, (-1, 0, 0), wall)],
    )  # fmt: skip
    bands = solve_bands(stiffness_of(tunnel), make_path("G-X", tunnel.periods, 61))
    edges = 2 * np.pi * band_edges(bands)
    # pairs of cylinders that move alike: with the spheres; apart from each other, they make bands
    # of their own
    alike = [row for row in edges if row[1] - row[0] > 1e-6 * row[1] or row[0] > 3e5]
    assert alike[0][1] == pytest.approx(acoustic, rel=2e-3)
    assert any(row[0] == pytest.approx(low, rel=2e-3) for row in edges)
    assert any(row[1] == pytest.approx(high, rel=2e-3) for row in edges)
    assert any(row[1] == pytest.approx(third, rel=2e-3) for row in edges)


@pytest.mark.parametrize("kind", ["fcc", "hcp"])
def test_speed_along_the_stacking(kind):
    """[111] of fcc and c of hcp: against the line of layers 1e-6, against runs 2e-4."""
    rows = list(_rows(RESULTS))
    for pressure in (1e4, 1e5, 1e6, 1e7):
        case = endless(
            kind,
            [4, 4, 12],
            {"kind": "uniaxial", "pressure": pressure},
            boundary={"sides": "periodic"},
        )
        speed = long_wave_speeds(
            stiffness_of(cell_state(assemble(case)).network), np.array([[0.0, 0.0, 1.0]])
        )[0]
        assert speed[-1] == pytest.approx(line_of(case, sphere_contact(case)).speed, rel=1e-6)
        name = f"Speed of small waves, {kind}, uniaxial, {pressure:.4g} Pa"
        (run,) = [row["granwave"] for row in rows if row["quantity"] == name]
        assert speed[-1] == pytest.approx(run, rel=2e-4)


@pytest.mark.parametrize("kind", ["bcc", "sc"])
def test_layers_of_other_lattices_are_a_line(kind):
    """The line of layers has a speed of long waves along z, to 1e-6."""
    load = {"kind": "uniaxial", "pressure": 1e5}
    case = endless(kind, [4, 4, 12], load, boundary={"sides": "periodic"})
    along = np.array([[0.0, 0.0, 1.0]])
    speeds = long_wave_speeds(stiffness_of(cell_state(assemble(case)).network), along)[0]
    line = line_of(case, sphere_contact(case))
    assert np.nanmin(np.abs(speeds / line.speed - 1)) < 1e-6


def _rows(found):
    if isinstance(found, dict):
        if "quantity" in found:
            yield found
        found = list(found.values())
    if isinstance(found, list):
        for one in found:
            yield from _rows(one)


def test_fcc_under_pressure_from_all_sides():
    """Cubic: in units of sqrt(k/m)/a, a = sqrt(2) D the edge of the cube, c_l^2 = 2 along [001]...
    of central forces.
    """
    case = endless("fcc", [4, 4, 6], ALL_ROUND)
    state = cell_state(assemble(case))
    springs = state.network.springs
    assert len(springs) == 6
    np.testing.assert_allclose(springs.force, 1e5 * 0.01**2 / (2 * np.sqrt(2)), rtol=1e-9)
    speeds = long_wave_speeds(
        stiffness_of(state.network), np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    )
    k = springs.stiffness[0]
    f = springs.force[0]
    d = springs.distance[0]
    m = state.network.mass[0]
    # sum over 12 contacts of (n.q)^2 D^2/(2 m) times k n n - F/d (1 - n n), q = [111] (n.q =
    # sqrt(2/3) six times)
    longitudinal = 0.01**2 / m * 3 * (2 / 3) * (k * 2 / 3 - f / d / 3)
    np.testing.assert_allclose(speeds[0, -1] ** 2, longitudinal, rtol=1e-6)
    # q = [110], along a row: n.q = 1 for two contacts, 1/2 for eight, with n n_qq = 1 and 1/4
    along = 0.01**2 / m * (k + 4 * (1 / 4) * (k / 4 - f / d * 3 / 4))
    np.testing.assert_allclose(speeds[1, -1] ** 2, along, rtol=1e-6)


def test_square_with_friction_turns():
    """Mindlin's springs stabilise a square lattice: transverse waves, and rotations with a cut-on
    at 8 k_t (R/..)/I.
    """
    case = endless("square", [5, 5], ALL_ROUND, contact={"law": "hertz", "friction": 0.3})
    found = band_structure(assemble(case), "0,0,0; 314.159265358979,0,0", points=3)
    springs = found.state.network.springs
    mass = found.state.network.mass[0]
    k, kt, f, d = (
        float(one[0])
        for one in (springs.stiffness, springs.tangential, springs.force, springs.distance)
    )
    lever = float(springs.lever[0, 0])
    inertia = found.state.network.inertia[0]
    assert kt == pytest.approx(k * 2 * (1 - 0.3) / (2 - 0.3), rel=1e-9)
    at_zero = np.sort((2 * np.pi * found.bands.frequency[0]) ** 2)
    # uniform rotation: each of four contacts slips by 2 l q, half of it belongs to the grain
    np.testing.assert_allclose(at_zero[-1], 4 * kt * lever**2 * 2 / inertia, rtol=1e-9)
    at_edge = np.sort((2 * np.pi * found.bands.frequency[-1]) ** 2)
    expected = [4 * k / mass, 4 * (kt - f / d) / mass, 4 * kt * lever**2 / inertia]
    np.testing.assert_allclose(at_edge, np.sort(expected), rtol=1e-9)


def test_scattered_packing_is_its_own_cell():
    load = {"kind": "uniform", "pressure": 1e6}
    scatter = {"diameter_scatter": 5e-7, "seed": 3}
    endless_too = {"sides": "periodic", "bottom": "periodic"}
    case = endless("fcc", [4, 4, 3], load, packing=scatter, boundary=endless_too)
    found = band_structure(assemble(case), "0,0,0; 0,0,20", points=2, n_bands=6)
    state = found.state
    assert (
        state.network.n_grains == 48 and state.residual < 1e-8 and len(state.network.springs) == 288
    )
    like = cell_state(assemble(endless("fcc", [4, 4, 6], load)))
    speeds = long_wave_speeds(stiffness_of(like.network), np.array([[0.0, 0.0, 1.0]]))[0]
    np.testing.assert_allclose(found.speeds, speeds, rtol=0.02)  # softer by the scatter, hardly
    assert np.abs(found.speeds / speeds - 1).max() > 1e-5


def test_velocities_are_slopes():
    """Group velocities are the differences of frequencies, in any direction."""
    stiffness = stiffness_of(cell_state(assemble(endless("hcp", [4, 4, 4], ALL_ROUND))).network)
    middle = np.array([120.0, 40.0, 90.0])
    step = 1e-3
    for axis in range(3):
        move = step * np.eye(3)[axis]
        text = "; ".join(",".join(map(str, middle + place * move)) for place in (-1, 0, 1))
        bands = solve_bands(stiffness, make_path(text, stiffness.network.periods, 2))
        slope = 2 * np.pi * (bands.frequency[2] - bands.frequency[0]) / (2 * step)
        np.testing.assert_allclose(bands.velocity[1, :, axis], slope, rtol=1e-5, atol=1e-3)


@pytest.mark.parametrize("limits", [("DENSE_UP_TO",), ("DENSE_UP_TO", "_FACTORISED_UP_TO")])
def test_dense_factorised_and_lanczos_agree(monkeypatch, limits):
    stiffness = stiffness_of(cell_state(assemble(endless("hcp", [4, 4, 4], ALL_ROUND))).network)
    path = make_path("0,0,20; 10,0,30", stiffness.network.periods, 2)
    dense = solve_bands(stiffness, path, 3)
    for name in limits:
        monkeypatch.setattr(f"granwave.extensions.waves.spectra.stiffness.{name}", 0)
    np.testing.assert_allclose(
        solve_bands(stiffness, path, 3).frequency, dense.frequency, rtol=1e-7
    )


def test_attenuation_leads_back_to_the_frequencies():
    """At complex k, D(k) has the eigenvalue omega^2."""
    stiffness = stiffness_of(cell_state(assemble(diatomic())).network)
    found = complex_bands(stiffness, np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([6000.0]))
    wave = np.exp(-found.attenuation[0, 0] + 1j * found.phase[0, 0])
    own, other = stiffness._dense
    matrix = own + sum(
        one * wave ** n[0] + one.T * wave ** -n[0]
        for n, one in zip(stiffness.images, other, strict=True)
    )
    values = np.linalg.eigvals(matrix)
    assert np.abs(values - (2 * np.pi * 6000) ** 2).min() < 1e-6 * np.abs(values).max()


@pytest.mark.parametrize(
    ("case", "path", "message"),
    [
        (lambda: endless("fcc", [4, 4, 6], {"kind": "gravity"}, boundary={"sides": "periodic"}), "", "gravity"),
        (lambda: endless("chain", 5, AXIAL, replace=[{"index": [2], "material": "steel"}]), "", "without a repeated sequence"),
        (lambda: endless("fcc", [4, 4, 6], ALL_ROUND, packing={"vacancies": [40]}), "", "are not"),
        (lambda: case_from_dict({"name": "c", "material": "brass",
                                 "packing": {"kind": "fcc", "size": [4, 4, 6], "diameter": 0.01}}), "", "no stiffness"),
        (lambda: endless("sc", [4, 4, 4], ALL_ROUND), "", "2 of 3 modes have no stiffness at k = "),
        (lambda: endless("chain", 5, AXIAL), "G-M", "found the point M, expected one of G, X"),
        (lambda: endless("chain", 5, AXIAL), "0,0,0; 0,5,0", "is periodic only along z"),
        (lambda: endless("chain", 5, AXIAL), "0,0,0", "found 1 wave vectors, expected two or more"),
        (lambda: endless("chain", 5, AXIAL), "0,0,0; 0,x,0", "expected three numbers"),
    ],
)  # fmt: skip
def test_wrong_input(case, path, message):
    with pytest.raises(InputError, match=message):
        band_structure(assemble(case()), path)


def test_floppy_modes_are_left_blank_where_allowed():
    found = band_structure(assemble(endless("square", [4, 4], ALL_ROUND)), "G-X", allow_floppy=True)
    assert (
        np.isnan(found.bands.frequency[1:, 0]).all()
        and np.isfinite(found.bands.frequency[:, 1]).all()
    )
    assert "along" in found.note


def test_bcc_under_pressure_buckles():
    """Eight contacts do not resist shear of the cube; the static force F/d of each contact then
    makes it grow.

    k along [110], moving along [1-10]: nothing but -F/d of the four contacts along [11z] remains.
    """
    state = cell_state(assemble(endless("bcc", [4, 4, 6], ALL_ROUND)))
    with pytest.raises(
        InputError, match=r"1 of 3 modes have no .* up to 1 of them grow, by .* the packing buckles"
    ):
        band_structure(state, "0,0,0; 100,100,0")
    springs = state.network.springs
    np.testing.assert_allclose(springs.force, 1e5 * 0.01**2 / np.sqrt(3), rtol=1e-3)
    bands = band_structure(state, "0,0,0; 100,100,0", points=3, allow_floppy=True).bands
    side = 0.01 * 2 / np.sqrt(3)
    expected = (
        -4
        * springs.force[0]
        / springs.distance[0]
        / state.network.mass[0]
        * (1 - np.cos(100 * side))
    )
    np.testing.assert_allclose(bands.square[-1, 0], expected, rtol=1e-6)


def test_beads_that_roll_like_gears_are_named():
    """Neighbours that rotate in opposite directions do not slip, so that friction does not
    stabilise them.
    """
    case = endless("square", [4, 4], ALL_ROUND, contact={"law": "hertz", "friction": 0.3})
    with pytest.raises(
        InputError, match=r"1 of 3 modes .* 100 % rotating about z .like gears.* rotation = true"
    ):
        band_structure(assemble(case), "G-M")
