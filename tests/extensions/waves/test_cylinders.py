"""Bands, modes and static states of packings with cylinders, and of laws that do not grow with R*."""

from __future__ import annotations

import math

import numpy as np
import pytest

from granwave.extensions.waves.spectra.band_structure import band_structure
from granwave.extensions.waves.spectra.bands import solve_modes
from granwave.extensions.waves.spectra.states import cell_state, packing_state
from granwave.extensions.waves.spectra.stiffness import stiffness_of
from granwave.extensions.waves.spectra.transmission import transmission
from granwave.lammps_inputs import pair_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows.library import load_case
from tests.helpers.bodies.springs import endless

# of thesis 7.2, m
D = 9.525e-3
ROD = 4.76e-3
BESIDE = math.sqrt(
    (D / 2 + ROD / 2) ** 2 - (D / 2) ** 2
)  # of a cylinder that touches two spheres, m
CYLINDERS = {"shape": "cylinder", "diameter": ROD, "length": D, "axis": "y", "group": "cylinders"}


def tunnel(approach: float, n: int = 1):
    """Case of n spheres of the tunnel with a pair of cylinders each, under 1 N; walls approach by a
    times D.
    """
    walls = {"kind": "walls", "x": approach * D / 2} if approach > 0 else {"kind": "uniaxial"}
    repeat = {"repeat": {"times": n, "step": [0.0, 0.0, D]}} if n > 1 else {}
    return case_from_dict(
        {
            "name": "tunnel",
            "material": "brass",
            "contact": {"law": "hertz"},
            "packing": {"kind": "chain", "size": n, "diameter": D, "cell": [[0.0, 0.0, n * D]]},
            "grains": [CYLINDERS | {"at": [[BESIDE, 0.0, D / 2], [-BESIDE, 0.0, D / 2]]} | repeat],
            "guide": [
                {"index": {"first": 1, "last": n}, "free": "z"},
                {"group": "cylinders", "free": "xz"},
            ],
            "boundary": {"bottom": "free", "x": "wall", "side_gap": max(-approach * D / 2, 0.0)},
            "precompression": walls | {"force": 1.0},
        }
    )


@pytest.mark.parametrize(
    ("approach", "overlaps", "wall", "edges"),
    [
        (-1.8e-5, (3.673e-7, 5.816e-8, 5.54e-10), 1.789e8, (31795, 42051, 68093, 354119)),
        (0.0, (3.307e-7, 1.092e-7, 1.366e-9), 1.872e8, (37222, 49229, 68647, 362876)),
        (3e-5, (2.489e-7, 1.873e-7, 2.949e-9), 1.950e8, (42592, 56331, 67350, 370989)),
    ],
)
def test_tunnel_of_thesis_7_2_from_its_case(approach, overlaps, wall, edges):
    """The oracle's values (physics of chapter 7.2). Cylinders that move in opposite ways give two
    more flat bands.
    """
    found = band_structure(assemble(tunnel(approach)), "G-X", points=3)
    springs = found.state.network.springs
    walls = found.state.network.supports
    assert len(springs) == 5 and len(walls) == 2
    of_spheres = D - springs.distance.max()
    of_rods = (D + ROD) / 2 - springs.distance.min()
    np.testing.assert_allclose([of_spheres, of_rods], overlaps[:2], rtol=1e-3)
    np.testing.assert_allclose(walls.stiffness, wall, rtol=5e-4)
    omega = 2 * np.pi * found.bands.frequency
    np.testing.assert_allclose(
        [omega[:, 0].max(), omega[:, 2].min(), omega[:, 2].max(), omega[:, 3:].min()],
        edges,
        rtol=5e-5,
    )
    # the flat one: sphere still, one cylinder forth and one back, at the top of the acoustic band
    np.testing.assert_allclose(omega[:, 1], omega[:, 0].max(), rtol=1e-8)


def test_a_longer_cell_folds_the_bands():
    one, two = (
        band_structure(assemble(tunnel(0.0, n)), "G-X", points=2).bands.frequency for n in (1, 2)
    )
    np.testing.assert_allclose(
        np.sort(np.concatenate([one[0], one[1]])), np.sort(two[0]), rtol=1e-6, atol=1e-2
    )


def test_filter_row_is_in_static_balance():
    """Thesis 7.1, gamma 0.56, a = 8e-4: each wall carries 29.668 N from each cylinder, which moves
    by 3.60653 um.
    """
    n = 5
    case = load_case("filter-row", {"packing.size": n, "load.index": [2], "hold": [{"index": [1, n]}],
                                    "guide": [{"index": {"first": 2, "last": n - 1}, "free": "z"},
                                              {"group": "cylinders", "free": "xz"}]})  # fmt: skip
    state = packing_state(assemble(case))
    assert len(state.network.supports) == 2 * (n - 1) and len(state.network.springs) == 4 * (n - 1)
    np.testing.assert_allclose(state.network.supports.force, 29.668, rtol=3e-5)
    modes = solve_modes(stiffness_of(state.network))
    assert len(modes.frequency) == n - 2 + 4 * (n - 1) and modes.frequency.min() > 1e3
    through = transmission(stiffness_of(state.network), 2, [3], np.array([1.0]))
    assert 0 < through.amplitude[0, 0] < 1


def pile(
    *grains: str,
    length: float = 0.01,
    force: float = 20.0,
    law: str = "hertz",
    friction: float = 0.0,
    **more,
):
    """Infinite pile of grains (z, diameter, shape, length, axis), periodic along z, under a
    force.
    """
    text = "x,y,z,diameter,shape,length,axis_x,axis_y,axis_z\n" + "".join(
        f"0,0,{one}\n" for one in grains
    )
    tables = {
        "name": "pile", "material": "brass", "contact": {"law": law, "friction": friction},
        "packing": {"kind": "file", "grains": text, "cell": [[0.0, 0.0, length]]}, "boundary": {"bottom": "free"},
        "precompression": {"kind": "uniaxial", "force": force},
    }  # fmt: skip
    return case_from_dict(tables | more)


def row_of_cylinders(friction: float, law: str = "line", diameters=(0.006,)):
    """Infinite chain of parallel cylinders along z under 50 N, which move along x and z and rotate
    about y.
    """
    places = np.cumsum(diameters) - np.array(diameters) / 2
    grains = [
        f"{place!r},{size!r},cylinder,0.02,0,1,0"
        for place, size in zip(places.tolist(), diameters, strict=True)
    ]
    return pile(
        *grains,
        length=sum(diameters),
        force=50.0,
        law=law,
        friction=friction,
        guide=[{"free": "xz"}],
    )


@pytest.mark.parametrize("law", ["line", "hertz"])
def test_row_of_parallel_cylinders(law):
    """omega = 2 sqrt(k/m) at the edge, with k of the law of a line at the force; rolling as that of
    any disc.
    """
    case = row_of_cylinders(0.3, law)
    found = band_structure(assemble(case), "G-X", points=2, allow_floppy=True)
    network = found.state.network
    springs = network.springs
    mass = network.mass[0]
    overlap = 0.006 - springs.distance[0]
    contact = pair_contact(case, 1, 1)
    assert contact.loading_force(overlap) == pytest.approx(50.0, rel=1e-8)
    k = float(contact.tangent_stiffness(overlap, overlap))
    kt = float(springs.tangential[0])
    assert springs.stiffness[0] == pytest.approx(k, rel=1e-9) and kt > 0
    assert mass == pytest.approx(8500 * np.pi * 0.003**2 * 0.02, rel=1e-9)
    lever = (0.006 - overlap) / 2
    inertia = mass * 0.003**2 / 2
    at_zero = np.sort((2 * np.pi * found.bands.frequency[0]) ** 2)
    assert at_zero[-1] == pytest.approx(4 * kt * lever**2 / inertia, rel=1e-8)
    # neighbours move and turn in opposite ways: rotation is free then
    edge = (2 * np.pi * found.bands.frequency[1]) ** 2
    expected = np.sort([4 * k / mass, 4 * (kt - 50.0 / springs.distance[0]) / mass])
    np.testing.assert_allclose(np.sort(edge)[-2:], expected, rtol=1e-8)


def test_sizes_of_lines_have_laws_of_their_own():
    """Two alternating diameters: alternating masses, and springs of dissimilar radii."""
    case = row_of_cylinders(0.0, "hertz", (0.006, 0.003))
    springs = cell_state(assemble(case)).network.turned_off("z").springs
    contact = pair_contact(case, 1, 2)
    overlap = 0.0045 - springs.distance
    np.testing.assert_allclose(contact.loading_force(overlap), 50.0, rtol=1e-8)
    np.testing.assert_allclose(
        springs.stiffness, contact.tangent_stiffness(overlap, overlap), rtol=1e-9
    )


def test_crossed_cylinders_move_along_their_axes_without_force():
    """A pile of crossed cylinders: the static force does not rotate, and does not resist a shift
    along an axis.
    """
    case = pile("0.002,0.004,cylinder,0.02,1,0,0", "0.007,0.006,cylinder,0.02,0,1,0")
    network = cell_state(assemble(case)).network
    contact = pair_contact(case, 1, 2)
    overlap = 0.005 - network.springs.distance
    np.testing.assert_allclose(contact.loading_force(overlap), 20.0, rtol=1e-8)
    np.testing.assert_allclose(
        network.springs.stiffness, contact.tangent_stiffness(overlap, overlap), rtol=1e-9
    )
    matrix = stiffness_of(network).own.toarray()
    assert (
        np.abs(matrix[2::3, 2::3]).min() > 0
        and np.abs(np.delete(matrix, [2, 5], axis=0)).max() == 0
    )


def test_the_force_at_the_side_of_a_cylinder_turns_across_its_axis_alone():
    """A sphere rolls off a cylinder across its axis (-F/d), and not along it."""
    network = cell_state(
        assemble(pile("0.002,0.004,sphere,0,0,0,0", "0.007,0.006,cylinder,0.02,0,1,0"))
    ).network
    own = stiffness_of(network).own.toarray()[:3, :3]
    expected = -(network.springs.force / network.springs.distance).sum()
    np.testing.assert_allclose(
        own, np.diag([expected, 0, network.springs.stiffness.sum()]), rtol=1e-9, atol=1e-6
    )


@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_power_law_has_its_own_stiffness(exponent):
    """K a^p = F: the top of the band is 2 sqrt(p F/(a m))."""
    constant = 2e7 * 1e6 ** (exponent - 1)
    force = 20.0
    contact = {"law": "power", "constant": constant, "exponent": exponent}
    found = band_structure(
        assemble(endless("chain", 6, {"kind": "uniaxial", "force": force}, contact=contact)),
        "G-X",
        points=3,
    )
    overlap = (force / constant) ** (1 / exponent)
    top = 2 * math.sqrt(exponent * force / overlap / found.state.network.mass[0]) / (2 * math.pi)
    assert found.edges[0, 1] == pytest.approx(top, rel=1e-7)


def test_oblique_cylinders_that_turn_are_refused():
    with pytest.raises(
        InputError, match=r"cylinders along \[0.6, 0.8, 0.0\] that rotate by friction"
    ):
        cell_state(
            assemble(pile("0.002,0.004,cylinder,0.02,0.6,0.8,0", length=0.004, friction=0.3))
        )


def test_a_cell_of_a_lattice_alone_is_refused():
    with pytest.raises(InputError, match=r"packing\.cell: belongs to"):
        endless(
            "chain", 3, {"kind": "uniaxial", "force": 1.0}, packing={"cell": [[0.0, 0.0, 0.01]]}
        )
