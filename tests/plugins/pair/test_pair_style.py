"""Pair style gran/hysteretic: forces, persistent dents, energies, output, and LAMMPS conventions."""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from granwave.plugins import library
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import LAW, PAIR, R, collide, value
from tests.helpers.twins.twin import Network


def test_collision_against_the_network_twin(lammps):
    lmp = lammps()
    collide(lmp)
    twin = Network(PAIR, [(0, 1)], R)
    twin.v[:, 2] = 1.0, -1.0
    twin.run(1e-8, 20000)
    assert value(lmp, "vz[1]") == pytest.approx(twin.v[0, 2], rel=1e-8)
    assert value(lmp, "c_ep[1]") == pytest.approx(twin.dissipated(), rel=1e-8)
    assert value(lmp, "c_ep[2]") == 1
    assert value(lmp, "c_ep[5]") == pytest.approx(
        LAW.loading_force(twin.peak[0] * LAW.yield_overlap), rel=1e-8
    )


@pytest.mark.parametrize(
    "between",
    ["", "run 0", "atom_modify sort 1 0.05\nrun 5", "neigh_modify every 1 check no\nrun 3"],
)
def test_the_dent_stays_when_the_spheres_part(lammps, between):
    """A second collision at the same closing speed is purely elastic: it follows the unloading
    branch of the first one.
    """
    lmp = lammps()
    collide(lmp)
    lost = value(lmp, "c_ep[1]")
    speed = value(lmp, "vz[2]-vz[1]")
    lmp.commands_string(between)
    assert value(lmp, "z[2]-z[1]") > 2 * R
    lmp.commands_string(f"set atom 1 vz {speed / 2}\nset atom 2 vz {-speed / 2}")
    lmp.command("run 30000")
    assert value(lmp, "vz[2]-vz[1]") == pytest.approx(speed, rel=1e-6)
    assert value(lmp, "c_ep[1]") == pytest.approx(lost, rel=1e-12)


def test_a_dent_is_forgotten_beyond_the_gap_and_its_loss_is_not(lammps):
    lmp = lammps()
    collide(lmp, gap=2e-5)
    lost = value(lmp, "c_ep[1]")
    speed = value(lmp, "vz[2]-vz[1]")
    lmp.command("run 6000")
    assert value(lmp, "z[2]-z[1]") > 2 * R + 2e-5
    assert value(lmp, "c_ep[1]") == pytest.approx(lost, rel=1e-12)
    lmp.commands_string(f"set atom 1 vz {speed / 2}\nset atom 2 vz {-speed / 2}\nrun 30000")
    assert value(lmp, "vz[2]-vz[1]") < 0.9 * speed  # a new contact yields again
    assert value(lmp, "c_ep[1]") > 1.1 * lost
    assert value(lmp, "c_ep[2]") == 2


def test_never_forgotten_sooner(lammps):
    """Just within the gap the dent is kept, although far beyond the range of the contact force."""
    lmp = lammps()
    collide(lmp, gap=1e-3)
    speed = value(lmp, "vz[2]-vz[1]")
    lost = value(lmp, "c_ep[1]")
    gap = value(lmp, "z[2]-z[1]") - 2 * R
    lmp.command(f"run {int((0.95e-3 - gap) / speed / 1e-8)}")
    gap = value(lmp, "z[2]-z[1]") - 2 * R
    assert 0.9e-3 < gap < 1e-3
    lmp.commands_string(
        f"set atom 1 vz {speed / 2}\nset atom 2 vz {-speed / 2}\nrun {int(2 * gap / speed / 1e-8)}"
    )
    assert value(lmp, "c_ep[1]") == pytest.approx(lost, rel=1e-12)


def test_reports_agree_with_each_other(lammps):
    """Output per contact, per sphere, by pair/local and of the totals is consistent, and does not
    affect the run.
    """
    lmp = lammps()
    places = [(0, 0, 0), (0, 0, 2 * R), (0, 0, 4 * R), (0, 0, 6 * R)]
    extra = """compute atoms all gran/hysteretic/atom
compute dents all gran/hysteretic/local
compute single all pair/local dist eng force p11 p12 p13 p14
compute one all gran/hysteretic/contact 2 1
compute lost all reduce sum c_atoms[4] c_atoms[10]
compute lost_local all reduce sum c_dents[8] c_single[7] c_dents[7] inputs local
thermo_style custom step c_ke pe c_ep[1] c_ep[2] c_lost[1] c_lost[2] c_lost_local[1] c_lost_local[2] c_lost_local[3] c_one[2]
thermo 100"""
    lmp.commands_string(script_of(places, velocities=[(0, 0, 6.0)], extra=extra))
    lmp.command("run 4000")
    for formula in ("c_lost[1]", "c_lost_local[1]", "c_lost_local[2]"):
        assert value(lmp, formula) == pytest.approx(value(lmp, "c_ep[1]"), rel=1e-12)
    assert value(lmp, "c_lost_local[3]") == pytest.approx(value(lmp, "pe"), rel=1e-12)
    assert value(lmp, "c_lost[2]") == pytest.approx(value(lmp, "pe"), rel=1e-12)
    atoms = lmp.numpy.extract_compute("atoms", 1, 2)[:4]
    dents = lmp.numpy.extract_compute("dents", 2, 2)
    order = np.argsort(dents[:, 0])
    peaks = dents[order, 5]
    assert dents[order, 0].tolist() == [1, 2, 3] and dents[order, 1].tolist() == [2, 3, 4]
    tags = lmp.numpy.extract_atom("id")[:4]
    by_id = atoms[np.argsort(tags)]
    assert by_id[:, 1] == pytest.approx(
        [peaks[0], max(peaks[:2]), max(peaks[1:]), peaks[2]], rel=1e-13
    )
    assert value(lmp, "c_one[3]") == pytest.approx(dents[order[0], 4], rel=1e-13)
    # first contacts are in order, and so are the times
    assert np.all(np.diff(dents[order, 8]) >= 0) and np.all(dents[:, 8] <= dents[:, 9])
    silent = lammps(script_of(places, velocities=[(0, 0, 6.0)]))
    silent.command("run 4000")
    assert value(silent, "vz[4]") == value(lmp, "vz[4]")
    assert value(silent, "c_ep[1]") == value(lmp, "c_ep[1]")


@pytest.mark.parametrize(
    "law",
    [
        "hertz 115e9 0.3",
        "power 115e9 0.3 constant 4e8 exponent 1.3",
        "elastoplastic 115e9 0.3 550e6",
        "hertz 115e9 0.3 loss time 1e-7",
        "hertz 115e9 0.3 loss prony 0.3 1e-5",
        "hertz 115e9 0.3 cohesion jkr 0.1",
        "elastoplastic 115e9 0.3 550e6 cohesion dmt 0.1",
    ],
)
def test_the_stored_energy_has_one_formula(lammps, law):
    """Values of a contact, of its two spheres and of the totals are bitwise identical, on loading
    and unloading.
    """
    lmp = lammps()
    extra = """compute dents all gran/hysteretic/local
compute single all pair/local eng
compute one all gran/hysteretic/contact 1 2
compute stored all pe/atom
compute spheres all reduce sum c_stored
compute local all reduce sum c_dents[7] c_single inputs local
thermo_style custom step pe c_ep[1] c_spheres c_local[1] c_local[2] c_one[3]
thermo_modify norm no
thermo 50"""
    velocities = [(0, 0, 1.0), (0, 0, -1.0)]
    lmp.commands_string(script_of(PAIR, style=law, velocities=velocities, extra=extra))
    stored = []
    for _ in range(8):
        lmp.command("run 450")
        stored.append(value(lmp, "pe"))
        for formula in ("c_spheres", "c_local[1]", "c_local[2]"):
            assert value(lmp, formula) == stored[-1], formula
    assert np.ptp(stored) > 0.5 * max(stored) > 0.0
    assert min(np.diff(stored)) < 0.0 < max(np.diff(stored))


@pytest.mark.parametrize("mixed", ["", "pair_coeff 1 2", "pair_coeff 2 1"])
def test_softer_sphere_gets_all_the_loss(lammps, mixed):
    """Coefficients by mixing or for a pair; LAMMPS converts 2 1 into 1 2: the first material is
    that of the lower type.
    """
    lmp = lammps()
    coefficients = [
        "pair_coeff 1 1 elastoplastic 115e9 0.3 550e6",
        "pair_coeff 2 2 elastoplastic 210e9 0.3 700e6",
    ]
    if mixed:
        coefficients.append(f"{mixed} elastoplastic 115e9 0.3 550e6 210e9 0.3 700e6")
    extra = "compute atoms all gran/hysteretic/atom\nthermo_style custom step pe c_ep[1]\nrun 0\n"
    spheres = {"radius": [R, 2 * R], "types": [1, 2], "velocities": [(0, 0, 3.0)]}
    lmp.commands_string(
        script_of([(0, 0, 0), (0, 0, 3 * R)], **spheres, coefficients=coefficients, extra=extra)
    )
    lmp.command("run 20000")
    law = ContactLaw(
        youngs_modulus=(115e9, 210e9),
        poisson_ratio=(0.3, 0.3),
        yield_strength=(550e6, 700e6),
        radius=(R, 2 * R),
    )
    atoms = lmp.numpy.extract_compute("atoms", 1, 2)[:2]
    by_id = atoms[np.argsort(lmp.numpy.extract_atom("id")[:2])]
    assert by_id[1, 3] == 0 and by_id[0, 3] == pytest.approx(value(lmp, "c_ep[1]"), rel=1e-12)
    assert value(lmp, "c_ep[1]") == pytest.approx(law.dissipated_energy(by_id[0, 2]), rel=1e-10)


def test_hybrid_clear_and_a_second_instance(lammps):
    first = lammps()
    second = lammps()
    collide(first)
    text = script_of(
        [*PAIR, (0.03, 0, 0)], types=[1, 1, 2], velocities=[(0, 0, 1.0), (0, 0, -1.0), (0, 0, 0)]
    ).replace(
        "pair_style gran/hysteretic 0.001\npair_coeff * *",
        "pair_style hybrid gran/hysteretic 0.001 zero 0.01\npair_coeff 1 2 zero\npair_coeff 2 2 zero\npair_coeff 1 1 gran/hysteretic",
    )
    second.commands_string(text)
    second.command("run 20000")
    assert value(second, "vz[1]") == value(first, "vz[1]")
    first.commands_string(
        f"clear\nplugin load {library()}"
    )  # available again automatically from LAMMPS 2025 on
    collide(first)
    assert value(second, "vz[1]") == value(first, "vz[1]")


@pytest.mark.parametrize(
    ("insertion", "large", "density", "modulus"),
    [
        ("pour 1 2 1 vol 0.9 10 diam one {d} dens 8500 8500 vel 0 0 0 0 -5", 0.02, 8500, 1e8),
        (
            "pour 1 2 1 vol 0.9 10 diam poly 2 {r} 0.0 {d} 1.0 dens 8500 8500 vel 0 0 0 0 -5",
            0.02,
            8500,
            1e8,
        ),
        (
            "deposit 1 2 100 1 vz -5 -5",
            0.5,
            1,
            1e4,
        ),  # new spheres have the default radius and density of LAMMPS
    ],
)
def test_spheres_to_come_are_met_at_their_surface(lammps, insertion, large, density, modulus):
    """A sphere four times as large as any present drops onto one of them: no energy is lost."""
    lmp = lammps()
    half = (
        0.01 * large if insertion.startswith("deposit") else 1.01 * large
    )  # centers in the region, or whole spheres
    bottom = 1.5 * large - half
    top = 1.5 * large + half
    spheres = {
        "types": [1, 2],
        "radius": large / 4,
        "density": density,
        "style": f"hertz {modulus} 0.3",
        "gap": large / 40,
    }
    drop = f"region drop block {-half} {half} {-half} {half} {bottom} {top} units box\nfix down all gravity 1e-3 vector 0 0 -1\n"
    drop += (
        f"fix new all {insertion.format(r=large, d=2 * large)} region drop\ntimestep {5e-5 * large}"
    )
    text = script_of(
        [(0, 0, 0), (4 * large, 0, 0)], **spheres, box=[-6 * large, 6 * large] * 3, extra=drop
    )
    lmp.commands_string(
        text + "run 16000"
    )  # a single run: the next one would include the new sphere in any case
    assert value(lmp, "vz[1]") < -1 and value(lmp, "pe") == 0
    assert value(lmp, "c_ke") == pytest.approx(
        0.5 * density * 4 / 3 * np.pi * large**3 * 25, rel=1e-3
    )


def test_plane_of_spheres(lammps):
    """LAMMPS requires a periodic third dimension of any thickness with `dimension 2`: there are no
    contacts across it.
    """
    lmp = lammps()
    plane = lammps()
    collide(lmp)
    places = [(0, 0, 0), (2 * R, 0, 0)]
    text = script_of(
        places,
        velocities=[(1.0, 0, 0), (-1.0, 0, 0)],
        box=[-0.02, 0.03, -0.02, 0.02, -R / 10, R / 10],
    )
    plane.command("dimension 2")
    plane.commands_string(
        text.replace("boundary m m m", "boundary m m p") + "fix plane all enforce2d\nrun 20000"
    )
    assert value(plane, "vx[1]") == pytest.approx(value(lmp, "vz[1]"), rel=1e-12)


def test_quiet_lattice_stays_quiet(lammps):
    """Spheres that touch to within rounding have no spurious forces, at any position."""
    lmp = lammps()
    places = [(0.7 + 2 * R * i, 0.3, 0.5) for i in range(10)]
    lmp.commands_string(script_of(places))
    lmp.command("run 100")
    assert value(lmp, "c_ke") == 0 and value(lmp, "c_ep[2]") == 0
