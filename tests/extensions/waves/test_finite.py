"""Modes and transmission of finite packings and slabs compared with closed forms; states of cases
and of runs; space-time transform.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import sparse
from scipy.special import jv

from granwave.analysis.measures.line_waves import space_time_transform
from granwave.extensions.waves.spectra import wave_vectors
from granwave.extensions.waves.spectra.band_structure import band_structure
from granwave.extensions.waves.spectra.bands import solve_modes
from granwave.extensions.waves.spectra.network import Network, Springs
from granwave.extensions.waves.spectra.states import cell_state, packing_state
from granwave.extensions.waves.spectra.stiffness import stiffness_of
from granwave.extensions.waves.spectra.transmission import losses_of, transmission
from granwave.extensions.waves.spectra.wave_vectors import complex_bands
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.statics.bodies import across
from granwave.lammps_inputs.statics.energy import factorised
from granwave.workflows import load_case
from tests.helpers.bodies.springs import endless

AXIAL = {"kind": "uniaxial", "force": 20.0}


def chain(n: int, bottom: str = "fixed", **tables):
    return packing_state(
        assemble(endless("chain", n, AXIAL, boundary={"bottom": bottom}, **tables))
    )


def test_modes_of_a_chain_with_one_end_held():
    """omega = 2 sqrt(k/m) sin((2 j - 1) pi/(2 (2 n + 1))) of n beads that move."""
    network = chain(13).network
    modes = solve_modes(stiffness_of(network))
    n = 12
    unit = np.sqrt(network.springs.stiffness[0] / network.mass[0])
    expected = 2 * unit * np.sin((2 * np.arange(1, n + 1) - 1) * np.pi / (2 * (2 * n + 1)))
    np.testing.assert_allclose(2 * np.pi * modes.frequency, expected, rtol=1e-8)
    # sin^2 along the chain: (sum s^2)^2/(n sum s^4) with the means 1/2 and 3/8 over whole periods
    np.testing.assert_allclose(modes.participation, 2 / 3 * (2 * n + 1) / (2 * n), rtol=1e-6)
    assert np.trapezoid(modes.density, modes.density_frequency) == pytest.approx(1, abs=0.25)
    step = np.diff(modes.density_frequency)[0]
    assert modes.density.sum() * step == pytest.approx(1, rel=1e-9)


def test_density_of_states_of_many(monkeypatch):
    """From moments the density of states is that of all modes, smoothed: the same fraction is below
    a frequency.
    """
    state = packing_state(
        assemble(
            endless(
                "fcc",
                [6, 6, 6],
                {"kind": "uniaxial", "pressure": 1e6},
                boundary={"sides": "periodic"},
            )
        )
    )
    stiffness = stiffness_of(state.network.turned_off("z"))
    every = solve_modes(stiffness)
    monkeypatch.setattr("granwave.extensions.waves.spectra.bands.ALL_UP_TO", 0)
    some = solve_modes(stiffness, 5)
    np.testing.assert_allclose(some.frequency, every.frequency[:5], rtol=1e-7)
    for share in (0.25, 0.5, 0.75):
        limit = np.quantile(every.frequency, share)
        below = some.density_frequency < limit
        found = some.density[below].sum() * np.diff(some.density_frequency)[0]
        assert found == pytest.approx(share, abs=0.05)


def test_transmission_of_a_chain():
    """u_n/u_1 = cos((N + 1/2 - n) q)/cos((N - 1/2) q) with a free end; here held: sines, 2 - 2 cos
    q = m omega^2/k.
    """
    network = chain(11).network
    frequency = np.linspace(200, 18000, 23)
    found = transmission(stiffness_of(network), 1, [4, 9], frequency)
    unit = np.sqrt(network.springs.stiffness[0] / network.mass[0])
    q = np.arccos((1 - (2 * np.pi * frequency / unit) ** 2 / 2).astype(complex))
    for column, bead in enumerate((4, 9)):
        np.testing.assert_allclose(
            found.ratio[:, column], np.sin((11 - bead) * q) / np.sin(10 * q), rtol=1e-6
        )


def test_matched_end_and_layer_do_not_reflect():
    """All beads have the same amplitude, and the phase of the wave; a matched end is exact up to
    the highest frequencies.
    """
    network = chain(160, "wall").network
    for end, tolerance, frequency in (
        ("matched", 1e-6, np.array([500.0, 5000.0, 15000.0])), ("layer:80", 0.03, np.array([1500.0, 6000.0])),
    ):  # fmt: skip
        q = 2 * np.arcsin(
            np.pi * frequency / np.sqrt(network.springs.stiffness[0] / network.mass[0])
        )
        found = transmission(stiffness_of(network), 1, [20, 50], frequency, end=end)
        np.testing.assert_allclose(found.amplitude, 1, atol=tolerance)
        late = (found.phase + np.outer(q, [19, 49]) + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(late, 0, atol=tolerance)
    still = transmission(stiffness_of(network), 1, [20], frequency)
    assert np.abs(still.amplitude - 1).max() > 0.1


def test_turning_as_a_whole_costs_nothing():
    """Grains with tangential springs that rotate together as a rigid body; the static force rotates
    with them.
    """
    rng = np.random.default_rng(2)
    place = rng.normal(size=(5, 3))
    first, second = np.triu_indices(5, 1)
    step = place[second] - place[first]
    length = np.linalg.norm(step, axis=1)
    share = rng.uniform(0.2, 0.8, len(first))
    springs = Springs(
        first, second, np.empty((len(first), 0), dtype=int), step / length[:, None], length, np.zeros(len(first)),
        rng.uniform(1, 2, len(first)), rng.uniform(1, 2, len(first)),
        np.stack([share * length, (1 - share) * length], axis=1), across(step / length[:, None]),
    )  # fmt: skip
    ones = np.ones(5)
    free = np.ones((5, 6), dtype=bool)
    matrix = stiffness_of(
        Network(np.arange(1, 6), place, ones, ones, free, np.empty((0, 3)), springs)
    ).own.toarray()
    for axis in np.eye(3):
        whole = np.hstack([np.cross(axis, place), np.tile(axis, (5, 1))]).ravel()
        shift = np.hstack([np.tile(axis, (5, 1)), np.zeros((5, 3))]).ravel()
        assert np.abs(matrix @ whole).max() < 1e-12 and np.abs(matrix @ shift).max() < 1e-12
    assert np.linalg.matrix_rank(matrix, tol=1e-9) == 24


@pytest.mark.parametrize(
    ("drive", "sensors", "end", "message"),
    [
        (13, [1], "", "found 13, expected an id from 1 to 12"),
        (12, [1], "", "grain 12 is fixed along z"),
        (1, [12], "", "--sensor: grain 12 is fixed"),
        (1, [2], "soft", "found 'soft', expected"),
        (1, [2], "layer:40", "the end reaches the drive"),
    ],
)
def test_wrong_places(drive, sensors, end, message):
    with pytest.raises(InputError, match=message):
        transmission(stiffness_of(chain(12).network), drive, sensors, np.array([100.0]), end=end)


@pytest.mark.parametrize(("loss", "time"), [({"time": 3e-7}, True), ({"dashpot": 0.1}, False)])
def test_losses_of_contacts(loss, time):
    """Two beads on a wall: u_2/u_1 = K/(K + K_w - m omega^2), K = k - i omega c of each contact."""
    case = endless(
        "chain", 2, AXIAL, boundary={"bottom": "wall"}, contact={"law": "hertz", "loss": loss}
    )
    network = packing_state(assemble(case)).network
    frequency = np.array([3e3, 1.5e4, 2.2e4])
    losses = losses_of(assemble(case), network)
    found = transmission(stiffness_of(network), 1, [2], frequency, losses=losses).ratio[:, 0]
    k = float(network.springs.stiffness[0])
    wall = float(network.supports.stiffness[0])
    mass = float(network.mass[0])
    of_dashpot = 0.1 * np.sqrt(2 / 3 * np.array([mass / 2 * k, mass * wall]))
    c = 3e-7 * np.array([k, wall]) if time else of_dashpot
    omega = 2 * np.pi * frequency
    between = k - 1j * omega * c[0]
    below = wall - 1j * omega * c[1]
    np.testing.assert_allclose(found, between / (between + below - mass * omega**2), rtol=1e-9)
    lossless = endless("chain", 2, AXIAL, boundary={"bottom": "wall"})
    assert losses_of(assemble(lossless), network) is None


@pytest.mark.parametrize(
    ("driven", "tables", "masses"),
    [
        ([], {}, [1 / 2, 1 / 2]),
        ([1], {}, [1, 1 / 2]),
        ([1, 2], {}, [1 / 2, 1]),
        ([], {"hold": [{"index": [2], "directions": "z"}]}, [1]),
        ([], {"boundary": {"bottom": "fixed"}}, [1 / 2, 1]),
    ],
)
def test_effective_masses_of_dashpots(driven, tables, masses):
    """Held and driven beads do not move: the other one has the effective mass; two of them count as
    if they were free."""
    loss = {"law": "hertz", "loss": {"dashpot": 0.1}}
    case = endless(
        "chain", 3, AXIAL, **({"boundary": {"bottom": "wall"}, "contact": loss} | tables)
    )
    network = packing_state(assemble(case)).network
    losses = losses_of(assemble(case), network, driven, "z")
    between = losses.springs.stiffness
    found = (between / 0.1) ** 2 * 1.5 / network.springs.stiffness / network.mass[0]
    np.testing.assert_allclose(found, masses, rtol=1e-9)


def test_bcc_between_walls_buckles():
    """The equilibrium of equal forces is found, and its unstable modes are counted."""
    load = {"kind": "uniaxial", "pressure": 1e6}
    state = packing_state(
        assemble(endless("bcc", [4, 4, 6], load, boundary={"sides": "periodic", "bottom": "wall"}))
    )
    assert state.residual < 1e-9 and np.ptp(state.network.springs.force) < 1e-6
    modes = solve_modes(stiffness_of(state.network))
    assert "14 of 288 modes have no stiffness, and 12 of them grow, by " in modes.describe_floppy()


def test_a_bottom_that_is_a_damper():
    """Two beads in closed form: the second is between the driven bead and a massless plate on a
    damper.
    """
    case = endless("chain", 2, AXIAL, boundary={"bottom": {"damper": {"damping": 40.0}}})
    with pytest.raises(InputError, match="granwave transmission also accepts a damper"):
        packing_state(assemble(case))
    state = packing_state(assemble(case), damped=True)
    stiffness = stiffness_of(state.network)
    frequency = np.array([0.0, 500.0, 3e3, 9e3])
    found = transmission(stiffness, 1, [2], frequency, bottom=40.0)
    upper = state.network.springs.stiffness[0]
    lower = state.network.supports.stiffness[0]
    mass = state.network.mass[1]
    omega = 2 * np.pi * frequency
    plate = lower / (lower - 1j * omega * 40.0)
    expected = upper / (upper + lower * (1 - plate) - mass * omega**2)
    assert found.ratio[:, 0] == pytest.approx(expected, rel=1e-9)
    assert found.ratio[0, 0] == pytest.approx(1.0)  # the damper resists no slow motion
    stiff, soft = (
        transmission(stiffness, 1, [2], frequency[1:], bottom=one).ratio for one in (1e15, 1e-12)
    )
    assert stiff == pytest.approx(transmission(stiffness, 1, [2], frequency[1:]).ratio, rel=1e-6)
    assert soft[:, 0] == pytest.approx(upper / (upper - mass * omega[1:] ** 2), rel=1e-6)


@pytest.mark.parametrize("n", [4_100, 20_000])
def test_static_states_of_long_chains(n):
    """Otherwise the iterations would grow with the number of beads; beads that move far together do
    not count as a large step.
    """
    state = packing_state(assemble(load_case("precompressed-chain", [f"packing.size={n}"])))
    assert state.residual < 1e-6 and len(state.network.springs) == n - 1
    assert state.network.springs.force == pytest.approx(20.0, rel=1e-5)


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


@pytest.mark.parametrize(
    "load", [{"kind": "uniaxial", "pressure": 1e6}, {"kind": "gravity", "acceleration": 9.81}]
)
def test_modes_of_a_packing_are_bands_of_its_column(load):
    """Modes at the wave vectors that are compatible with periodic sides, also under the weight of
    the packing.
    """
    case = layers(precompression=load)
    own = cell_state(assemble(case), slab=True)
    whole = packing_state(assemble(case))
    n = 3
    m = 4
    reciprocal = 2 * np.pi * np.linalg.pinv(whole.periods).T
    k = np.array([i * reciprocal[0] + j * reciprocal[1] for i in range(n) for j in range(m)])
    bands = np.linalg.eigvalsh(stiffness_of(own.network).dense(k)).ravel()
    modes = np.linalg.eigvalsh(stiffness_of(whole.network).dense(np.zeros((1, 3)))[0])
    assert own.network.n_grains == 4 and len(modes) == len(bands) == 12 * 24
    assert np.sort(bands) == pytest.approx(modes, abs=1e-7 * modes[-1])


def test_columns_on_a_rigid_wall():
    """Simple cubic under a load along z: each column is an independent chain that ends at the
    wall.
    """
    found = band_structure(
        assemble(layers("sc", (3, 3, 3), contact={"law": "hertz"})),
        points=5,
        directions="z",
        slab=True,
    )
    network = found.state.network
    k = network.springs.stiffness[0]
    wall = network.supports.stiffness[0]
    matrix = np.array([[k, -k, 0], [-k, 2 * k, -k], [0, -k, k + wall]]) / network.mass[0]
    due = np.sqrt(np.linalg.eigvalsh(matrix)) / (2 * math.pi)
    assert found.bands.frequency == pytest.approx(
        np.tile(due, (len(found.bands.path.k), 1)), rel=1e-9
    )
    assert found.bands.share[0].sum() == pytest.approx(
        1
    )  # of three layers one is in the upper quarter


def test_a_held_grain_and_a_vacancy_make_the_packing_the_cell():
    held = cell_state(
        assemble(layers(hold=[{"index": [17], "directions": "xyz", "rotation": True}])), slab=True
    ).network
    assert held.n_grains == 48 and held.n_freedoms == 47 * 6
    packing = {"kind": "fcc", "size": [3, 4, 4], "diameter": 0.01, "vacancies": [20]}
    gap = cell_state(assemble(layers(packing=packing)), slab=True)
    assert gap.network.n_grains == 47


def test_what_has_no_sides_that_repeat_is_no_slab():
    with pytest.raises(InputError, match="--slab: found a packing without periodic sides"):
        cell_state(assemble(load_case("precompressed-chain")), slab=True)


def strip(n):
    """Rows of a triangular crystal of unit springs and masses, n deep."""
    below = [np.array([0.5, 0, math.sqrt(0.75)]), np.array([-0.5, 0, math.sqrt(0.75)])]
    first = []
    second = []
    image = []
    normal = []
    for row in range(n):
        first.append(row), second.append(row), image.append([1]), normal.append([1.0, 0, 0])
        for step in below if row < n - 1 else []:
            shift = round(step[0] - (0.5 if row % 2 == 0 else -0.5))
            first.append(row), second.append(row + 1), image.append([shift]), normal.append(step)
    one = np.ones(len(first))
    none = np.zeros(len(first))
    springs = Springs(np.array(first), np.array(second), np.array(image), np.array(normal), one, none, one, none,
                      np.zeros((len(first), 2)), across(np.array(normal)))  # fmt: skip
    moves = np.zeros((n, 6), dtype=bool)
    moves[:, [0, 2]] = True
    places = np.array([[0.5 * (row % 2), 0, row * math.sqrt(0.75)] for row in range(n)])
    return Network(
        np.arange(1, n + 1), places, np.ones(n), np.ones(n), moves, np.array([[1.0, 0, 0]]), springs
    )


def test_rayleigh_s_wave():
    """A triangular crystal is isotropic for long waves, lambda = mu: c_R = sqrt(2 - 2/sqrt(3)) c_T,
    c_T^2 = 3 k a^2/(8 m).
    """
    k = np.array([[0.08, 0, 0]])
    square = np.linalg.eigvalsh(stiffness_of(strip(400)).dense(k))[0]
    speed = np.sqrt(square[:2]) / k[0, 0]  # the waves of both surfaces
    assert speed == pytest.approx(math.sqrt((2 - 2 / math.sqrt(3)) * 3 / 8), rel=2e-3)


@pytest.mark.parametrize("direction", [(0, 0, 1.0), (1.0, 0, 0)])
def test_attenuation_from_the_faces_is_that_of_the_whole_cell(monkeypatch, direction):
    case = load_case("precompressed-fcc", {"contact.friction": 0.3})
    stiffness = stiffness_of(cell_state(assemble(case)).network)
    way = np.array(direction)
    frequency = np.linspace(3e3, 6e4, 12)
    whole = complex_bands(stiffness, np.zeros(3), way, frequency)
    monkeypatch.setattr(wave_vectors, "MOST_UNKNOWNS", 0)
    faces = complex_bands(stiffness, np.zeros(3), way, frequency)
    assert whole is not None and faces is not None
    assert faces.least == pytest.approx(whole.least, abs=1e-9)
    assert faces.attenuation[:, :3] == pytest.approx(
        whole.attenuation[:, :3], abs=1e-8, nan_ok=True
    )


def test_attenuation_of_a_long_cell():
    """A chain of 100 beads as one cell: cosh of half the decay per bead is f/f_c."""
    case = load_case("precompressed-chain", {"packing.size": 100, "boundary.bottom": "periodic",
                                             "replace": [{"index": [1], "diameter": 9.52e-3 * (1 + 1e-12)}]})  # fmt: skip
    network = cell_state(assemble(case)).network
    assert network.n_grains == 100
    cut_off = math.sqrt(network.springs.stiffness[0] / network.mass[0]) / math.pi
    found = complex_bands(
        stiffness_of(network), np.zeros(3), ALONG_Z, cut_off * np.array([0.5, 1.001, 1.005])
    )
    due = [0.0, *(2 * math.acosh(ratio) * 100 for ratio in (1.001, 1.005))]
    assert found is not None and found.least == pytest.approx(due, rel=1e-5, abs=1e-6)


def test_ridge_is_the_band_of_the_chain():
    """An impact on a line of masses, v_n = J_2n-2 + J_2n of 2 w t: the ridge is w |sin(kh/2)|/pi,
    within 1 %.
    """
    unit = 5e4
    h = 0.01
    n = 100
    time = np.linspace(0, 1.6e-3, 400)
    tau = 2 * unit * time[:, None]
    order = np.arange(n)
    velocity = jv(2 * order, tau) + jv(2 * order + 2, tau)
    k = np.linspace(30, 250, 12)
    found = space_time_transform(time, h * order, velocity, k, np.linspace(0, 18e3, 721))
    theory = unit * np.sin(k * h / 2) / np.pi
    np.testing.assert_allclose(found.ridge(), theory, rtol=0.01)
    backwards = space_time_transform(time, h * order, velocity, -k[::-1], np.linspace(0, 18e3, 181))
    raw = space_time_transform(
        time, h * order, velocity, np.linspace(-250, 250, 41), np.linspace(0, 18e3, 181)
    )
    assert (
        raw.amplitude[:, :18].max() < 0.05 * raw.amplitude[:, 23:].max()
    )  # it travels to larger x alone
    assert backwards.amplitude.max() == 1


def test_uneven_places_are_refused():
    with pytest.raises(ValueError, match="places with non-uniform steps"):
        space_time_transform(
            np.arange(4.0), np.array([0, 1, 3.0]), np.ones((4, 3)), np.arange(2.0), np.arange(2.0)
        )


def test_a_matched_end_keeps_its_side_walls():
    """A chain between walls whose friction acts as springs to the ground: waves above their
    frequency propagate, slower waves decay from bead to bead, and nothing is reflected.
    """
    walls = {"kind": "walls", "x_force": 400.0, "force": 20.0}
    case = endless(
        "chain",
        20,
        walls,
        boundary={"bottom": "wall", "x": "wall"},
        contact={"law": "hertz", "friction": 0.3},
    )
    network = packing_state(assemble(case)).network
    assert network.supports.force[network.supports.wall == "xlo"] == pytest.approx(20.0, rel=1e-9)
    k = float(network.springs.stiffness[0])
    side = 2 * float(network.supports.tangential[network.supports.wall == "xlo"][0])
    mass = float(network.mass[0])
    square = np.array([0.5 * side, 1.5 * side, side + 2 * k, side + 5 * k]) / mass
    cosine = (1 - (mass * square - side) / (2 * k)).astype(complex)
    one = cosine + 1j * np.sqrt(1 - cosine**2)
    forwards = np.where(np.abs(one) > 1, 1 / one, one)
    frequency = np.sqrt(square) / (2 * math.pi)
    found = transmission(stiffness_of(network), 1, [2, 9], frequency, end="matched").ratio
    assert found == pytest.approx(np.stack([forwards, forwards**8], axis=1), rel=1e-6)


def test_factors_of_an_indefinite_matrix_have_pivots():
    """Rounding in the diagonal of a matrix, which vanishes in the middle of a pass band, leaves the
    solution exact.
    """
    n = 30
    half = sparse.random(n, n, 0.2, random_state=2)
    matrix = half + half.T
    matrix = matrix - sparse.diags_array(matrix.diagonal()) + 1e-12 * sparse.eye_array(n)
    solution = np.linspace(-1.0, 1.0, n)
    found = factorised(matrix, pivots=True).solve(matrix @ solution)
    assert found == pytest.approx(solution, abs=1e-11)
