"""Size of the plastic zone: known energy distributions in packings and in the continuum,
boundaries, reflected waves.
"""

from __future__ import annotations

import math

import h5py
import numpy as np
import pytest

from granwave.analysis import Result, summarise, write_result
from granwave.analysis.measures import zone_size
from granwave.analysis.measures.zone_size import (
    WAVE_KEYS,
    Mark,
    extent_holding,
    mark_of,
    packing_zone,
    volume_holding,
    wave_arrivals,
    wave_returns,
    zone_sizes,
    zone_summary,
    zone_warning,
)
from granwave.analysis.quantities import SHARES
from granwave.extensions.continuum.material import PLASTIC
from granwave.extensions.continuum.punch import ContinuumCase
from granwave.extensions.continuum.punch.run import BlockRun
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up import synthetic

D = synthetic.DIAMETER
SPHERE = math.pi / 6 * D**3
SIZES = [f"zone_{name}_{share}_{unit}" for name, unit in (("depth", "m"), ("radius", "m"), ("volume", "m3"))
         for share in SHARES]  # fmt: skip
BETWEEN = [
    f"zone_{name}_{share}_interpolated_m" for name in ("depth", "radius") for share in SHARES
]


def summary_of(directory, dent=synthetic.DENT, **options):
    synthetic.write_run(directory, synthetic.make_case(**options), dent)
    write_result(directory)
    return summarise(directory)


# ---------------------------------------------------------------------- what holds a share


def test_ten_equal_parts():
    """Nine times 0.1 is not 0.9 in floating point; the ninth part nevertheless reaches 90 %."""
    distance = np.arange(1.0, 11.0)
    energy = np.full(10, 0.1)
    found = [extent_holding(distance, energy, share / 100) for share in SHARES]
    assert found == [5.0, 9.0, 10.0]


def test_layers_count_whole_and_parts_without_energy_not_at_all():
    distance = np.array([2.0, 0.0, 1.0, 1.0, 1.0, 9.0])
    energy = np.array([5.0, 45.0, 20.0, 20.0, 10.0, 0.0])
    assert extent_holding(distance, energy, 0.46) == 1.0
    assert extent_holding(distance, energy, 0.45) == 0.0
    assert extent_holding(distance, energy, 0.96) == extent_holding(distance, energy, 1.0) == 2.0


def test_order_does_not_matter():
    rng = np.random.default_rng(3)
    distance = rng.integers(0, 9, 200) / 7.0
    energy = rng.exponential(size=200)
    volume = rng.uniform(1, 2, 200)
    found = set()
    for _ in range(20):
        order = rng.permutation(200)
        parts = energy[order], volume[order], distance[order], distance[order]
        found.add(tuple(zone_sizes(*parts).values()))
    assert len(found) == 1


def test_exponential_decay():
    """The fraction s of a density exp(-z/L) is above the depth -L ln(1 - s)."""
    depth = (np.arange(200_000) + 0.5) * 1e-4
    for share in SHARES:
        found = extent_holding(depth, np.exp(-depth), share / 100)
        assert found == pytest.approx(-math.log(1 - share / 100), abs=1e-4)


def test_volume_is_that_of_the_densest_parts():
    # densities 1, 3, 0.5
    energy = np.array([6.0, 3.0, 1.0])
    volume = np.array([6.0, 1.0, 2.0])
    assert volume_holding(volume, energy, 0.3) == 1.0
    assert volume_holding(volume, energy, 0.5) == volume_holding(volume, energy, 0.9) == 7.0
    assert volume_holding(volume, energy, 0.99) == 9.0


def test_nothing_dissipated_takes_no_room_and_nothing_that_yields_has_no_size():
    nothing = np.zeros(3)
    assert set(zone_sizes(nothing, nothing + 1, nothing, nothing).values()) == {0.0}
    assert set(zone_sizes(None)) == {*SIZES, *BETWEEN}
    assert set(zone_sizes(None).values()) == {None}
    assert set(zone_sizes(np.empty(0), np.empty(0), np.empty(0), np.empty(0)).values()) == {0.0}


# ---------------------------------------------------------------------- packings


def test_packing_by_counting(tmp_path):
    summary = summary_of(tmp_path, size=(9, 9, 5), dent=20.0)
    with Result(tmp_path) as result:
        energy = result["spheres/dissipated_energy"]
        offset = result["spheres/position"] - result.origin
    for name, distance in (
        ("depth", offset[:, 2]),
        ("radius", np.hypot(offset[:, 0], offset[:, 1])),
    ):
        for percent in SHARES:
            size = summary[f"zone_{name}_{percent}_m"]
            inside = energy[distance <= size + 1e-9].sum() / energy.sum()
            without = energy[distance < size - 1e-9].sum() / energy.sum()
            assert without < percent / 100 <= inside
            assert np.abs(distance - size).min() < 1e-12  # that of a sphere
    for percent in SHARES:
        n = summary[f"zone_volume_{percent}_m3"] / SPHERE
        assert n == pytest.approx(round(n), abs=1e-9)
        largest = np.sort(energy)[::-1]
        assert (
            largest[: round(n) - 1].sum()
            < percent / 100 * energy.sum()
            <= largest[: round(n)].sum() * (1 + 1e-12)
        )
    assert summary["zone_depth_99_m"] <= summary["plastic_zone_depth_m"]
    assert summary["zone_volume_99_m3"] <= summary["plastic_zone_volume_m3"] * (1 + 1e-12)


def test_friction_does_not_count(tmp_path):
    """Frictional dissipation at a distant sphere does not change the zone."""
    before = summary_of(tmp_path, contact={"friction": 0.1})
    with h5py.File(tmp_path / "result.h5", "r+") as file:
        for name in ("dissipated_energy", "friction_energy"):
            file[f"spheres/{name}"][-1] += 1.0
    with Result(tmp_path) as result:
        after = zone_summary(result)
    assert {name: after[name] for name in SIZES} == {name: before[name] for name in SIZES}


def test_parts_of_the_packing_are_read_once(tmp_path, monkeypatch):
    """A packing in parts has the same zone, and each part is read once."""
    summary_of(tmp_path)
    with Result(tmp_path) as result:
        whole = zone_summary(result)
    sizes = []

    def counted(part):
        zone = packing_zone(part)
        sizes.append(len(zone["energy"]))
        return zone

    monkeypatch.setattr(zone_size, "packing_zone", counted)
    with Result(tmp_path, at_once=16) as result:
        assert zone_summary(result) == whole
        assert sum(sizes) == result.assembly.lattice.n_spheres and len(sizes) > 3
    assert whole["zone_volume_50_m3"] > 0


def test_energy_of_yielding_adds_up(tmp_path):
    summary_of(tmp_path, contact={"friction": 0.1})
    with Result(tmp_path) as result:
        assert result.yield_energy.sum() == pytest.approx(result.yield_ledger[-1], rel=1e-12)
        assert result.yield_energy.sum() < result["spheres/dissipated_energy"].sum()


def test_strikers_are_no_part_of_the_packing(tmp_path):
    striker = [{"touches": [15, 16, 21], "velocity": [0.0, 0.0, 5.0]}]
    summary = summary_of(tmp_path, size=(6, 6, 4), striker=striker, dent=5.0)
    with Result(tmp_path) as result:
        zone = packing_zone(result)
        assert result.n_spheres == 145
        assert len(zone["energy"]) == 144
        assert zone["energy"].sum() < result.yield_energy.sum()
        assert result.yield_energy[-1] > 0
    assert summary["zone_depth_50_m"] >= 0
    assert summary["n_plastic_spheres"] > np.count_nonzero(zone["yielded"])


def test_what_a_packing_does_not_extend_along_has_no_size(tmp_path):
    chain = summary_of(tmp_path / "chain", kind="chain", size=12)
    assert all(chain[f"zone_radius_{percent}_m"] is None for percent in SHARES)
    assert chain["zone_depth_99_m"] > 0
    layer = summary_of(tmp_path / "square", kind="square", size=(7, 7))
    assert all(layer[f"zone_depth_{percent}_m"] is None for percent in SHARES)
    assert layer["zone_radius_99_m"] > 0
    assert layer["zone_cut"] == ["sides"]  # contact with the bottom does not truncate the zone


def test_hertz_has_no_zone(tmp_path):
    summary = summary_of(tmp_path, law="hertz")
    names = [
        *SIZES,
        "zone_cut",
        "zone_growing",
        "wave_returned",
        "wave_return_s",
        "wave_return_share",
    ]
    assert [summary[name] for name in names] == [None] * len(names)
    assert mark_of(summary) is Mark.NONE
    assert zone_warning(summary) == ""


def test_below_yield_the_zone_is_empty(tmp_path):
    summary = summary_of(tmp_path, dent=0.5)
    assert [summary[name] for name in SIZES] == [0.0] * len(SIZES)
    assert (summary["zone_cut"], summary["wave_return_share"]) == ([], 0.0)


def test_energy_at_a_wall_stays_with_the_sphere_there(tmp_path):
    """Layer on a rigid floor, in which only the contact of the impacted sphere with the floor
    yields.
    """
    case = synthetic.make_case("square", (5, 5), load={"velocity": 1.0}, run={"end_time": 4e-5})
    summary = run_case(case, tmp_path, figures=False).summary
    assert summary["n_plastic_contacts"] == 0
    assert summary["plastic_fraction"] > 0.1
    assert summary["zone_volume_99_m3"] == pytest.approx(SPHERE)
    assert summary["zone_radius_99_m"] == 0.0


@pytest.mark.parametrize("kind", ["fcc", "hcp", "bcc", "sc"])
@pytest.mark.parametrize(
    ("size", "dent", "cut"),
    [((12, 12, 9), 2.0, []), ((14, 14, 3), 3.0, ["bottom"]), ((4, 4, 12), 3.0, ["sides"]), ((4, 4, 3), 40.0, ["bottom", "sides"])],
)  # fmt: skip
def test_bounds_that_yield_reaches(tmp_path, kind, size, dent, cut):
    summary = summary_of(tmp_path, kind=kind, size=size, dent=dent)
    assert summary["zone_cut"] == cut


def test_periodic_zone_meets_its_image(tmp_path):
    """Energy by the distance from the nearest image of the axis, up to a reach; the half periods
    are 6 D and 5.2 D.
    """
    summary_of(tmp_path, size=(12, 12, 4), boundary={"sides": "periodic"})
    periods = np.array([12 * D, 12 * D * math.sqrt(3) / 2])
    with Result(tmp_path) as result:
        origin = result.origin
    for reach, cut in ((2.5 * D, []), (6.0 * D, ["sides"])):
        with h5py.File(tmp_path / "result.h5", "r+") as file:
            position = file["spheres/position"][()]
            offset = position[:, :2] - origin[:2]
            offset -= periods * np.round(offset / periods)
            radius = np.hypot(*offset.T)
            inside = (radius < reach) & (position[:, 2] < D)
            file["spheres/dissipated_energy"][:] = np.where(inside, 1.0, 0.0)
            file["spheres/contacts_yielded"][:] = inside
        with Result(tmp_path) as result:
            found = zone_summary(result)
        assert found["zone_cut"] == cut
        assert found["sides_periodic"] is True
        assert found["zone_radius_99_m"] == pytest.approx(
            np.sort(radius[inside])[math.ceil(0.99 * inside.sum()) - 1]
        )


@pytest.mark.parametrize(("end", "growing"), [(1.2, False), (1.05, True)])
def test_yield_that_still_moves_out_at_the_end(tmp_path, end, growing):
    """Contacts of a synthetic run yield later at larger distances; in a chain the deepest contact
    yields last.
    """
    summary_of(tmp_path, kind="chain", size=8, dent=30.0)
    with h5py.File(tmp_path / "result.h5", "r+") as file:
        time = file["spheres/time_yield"][()]
        file["energy/time"][-1] = end * time[np.isfinite(time)][-1]
    with Result(tmp_path) as result:
        assert zone_summary(result)["zone_growing"] == (["depth"] if growing else [])


# ---------------------------------------------------------------------- waves that come back


def test_wave_returns_in_a_chain(tmp_path):
    """Contact k of a synthetic run peaks at (k + 1/2) D / (1000 m/s) + 2 us; the dissipation in the
    energy record grows uniformly.
    """
    n = 6
    summary = summary_of(tmp_path, kind="chain", size=n, dent=3.0)
    border = round(summary["zone_depth_99_m"] / D)
    assert 0 < border < n - 1
    expected = (2 * (n - 1.5) - (border - 0.5)) * D / 1000.0 + 2e-6
    end = synthetic.STEPS * synthetic.TIMESTEP
    assert summary["wave_return_s"] == pytest.approx(expected, rel=1e-9)
    assert summary["wave_returned"] == ["bottom"]
    assert summary["wave_return_share"] == pytest.approx(1 - expected / end, rel=1e-6)


def test_wave_that_does_not_come_back_within_the_run(tmp_path):
    summary = summary_of(tmp_path, kind="chain", size=12, dent=3.0)
    assert (summary["wave_returned"], summary["wave_return_share"]) == ([], 0.0)
    assert summary["wave_return_s"] > synthetic.STEPS * synthetic.TIMESTEP


def test_returns_of_waves():
    time = np.array([0.0, 1.0, 2.0, 3.0])
    lost = np.array([0.0, 8.0, 10.0, 10.0])
    found = wave_returns({"bottom": 1.5, "sides": 2.5}, time, lost)
    assert found == {
        "wave_returned": ["bottom", "sides"],
        "wave_return_s": 1.5,
        "wave_return_share": pytest.approx(0.1),
    }
    late = wave_returns({"bottom": 3.5, "sides": 2.5}, time, lost)
    assert late == {"wave_returned": ["sides"], "wave_return_s": 2.5, "wave_return_share": 0.0}
    assert wave_returns({}, time, lost) == {
        "wave_returned": [],
        "wave_return_s": None,
        "wave_return_share": 0.0,
    }
    assert set(wave_returns(None, time, lost).values()) == {None}


def test_under_precompression_the_wave_has_one_speed(tmp_path):
    """The wave reaches the bottom of a chain of 12 at t, and returns to a depth d at t + t (11 D -
    d)/(11 D).
    """
    case = synthetic.make_case(
        "chain",
        12,
        precompression={"kind": "uniaxial", "force": 2.0},
        load={"velocity": 2.0},
        run={"end_time": 5e-4},
    )
    summary = run_case(case, tmp_path, figures=False).summary
    arrival = summary["base_arrival_s"]
    length = 11 * D
    back = arrival * (2 - summary["zone_depth_99_m"] / length)
    assert summary["wave_return_s"] == pytest.approx(back, rel=1e-6)
    assert summary["wave_returned"] == ["bottom"]


def test_tiny_packing_is_cut_on_all_sides(tmp_path):
    case = synthetic.make_case("fcc", (4, 4, 3), load={"velocity": 10.0}, run={"end_time": 2e-4})
    summary = run_case(case, tmp_path, figures=False).summary
    assert summary["zone_cut"] == ["bottom", "sides"]
    assert summary["wave_returned"] == ["bottom", "sides"]
    assert 0 < summary["wave_return_s"] < 1e-4
    assert 0 < summary["wave_return_share"] < 1
    assert mark_of(summary) is Mark.CUT
    assert "reaches the bottom and the sides of the packing" in zone_warning(summary)


def test_no_wave_returns_faster_than_sound_in_brass(tmp_path):
    """Rounding loads a contact at the side within some steps, which is no arrival; a wave takes at
    least x / 4260 m/s to the side and (x + x - r) / 4260 m/s to return.
    """
    case = synthetic.make_case("fcc", (8, 8, 5), load={"velocity": 5.0}, run={"end_time": 1e-4})
    summary = run_case(case, tmp_path, figures=False).summary
    with Result(tmp_path) as result:
        zone = packing_zone(result)
        first = result["spheres/time_first"][zone["sides"]].min()
        nearest = zone["radius"][zone["sides"]].min()
        (arrival,) = wave_arrivals(result, [zone["bottom"]])
        time = result["walls/bottom/time"]
        force = result["walls/bottom/force"]
    assert summary["wave_return_s"] > first > nearest / 4260
    felt = time[np.argmax(force > 0.01 * force.max())]
    assert felt < arrival < time[force.argmax()]


# ---------------------------------------------------------------------- continuum


@pytest.fixture
def block():
    """Run with uniform plastic work in a cylinder below the punch."""
    case = ContinuumCase.from_dict(
        {"name": "block", "material": "brass", "run": {"elements": 20_000}}
    )
    run = BlockRun(case)
    solver = run.solver
    r, z = solver.mesh.centres
    inside = (r[None, :] < 0.004) & (z[:, None] < 0.006)
    solver.state[:, :, PLASTIC] = np.where(inside, 3e6, 0.0)
    solver.ever[:] = inside
    run.add(0)
    return run


def test_elements_weigh_with_their_volume(block):
    """The fraction s of a uniform density in a cylinder of radius a and height h is within h s, a
    sqrt(s) and the volume V s.
    """
    sizes = block.zone_summary()
    mesh = block.solver.mesh
    r, z = mesh.centres
    a = mesh.r[1:][r < 0.004].max()
    h = mesh.z[1:][z < 0.006].max()
    for percent in SHARES:
        share = percent / 100
        assert sizes[f"zone_depth_{percent}_m"] == pytest.approx(
            h * share, abs=np.diff(mesh.z[mesh.z < 0.007]).max()
        )
        assert sizes[f"zone_radius_{percent}_m"] == pytest.approx(
            a * math.sqrt(share), abs=np.diff(mesh.r[mesh.r < 0.005]).max()
        )
        assert sizes[f"zone_volume_{percent}_m3"] == pytest.approx(
            math.pi * a**2 * h * share, rel=0.03
        )
    assert sizes["zone_cut"] == []


def test_small_dense_elements_come_before_large_ones(block):
    solver = block.solver
    solver.state[0, 0, PLASTIC] = 3e9
    volume = solver.operators.volume[0, 0]
    energy = (solver.state[:, :, PLASTIC] * solver.operators.volume).sum()
    assert 3e9 * volume < 0.5 * energy
    held = block.zone_summary()["zone_volume_50_m3"]
    rest = 0.5 * energy - 3e9 * volume
    assert held == pytest.approx(volume + rest / 3e6, rel=0.02)


def test_block_that_is_cut(block):
    solver = block.solver
    solver.ever[-1, 3] = solver.ever[7, -1] = True
    assert block.zone_summary()["zone_cut"] == ["bottom", "sides"]


def test_wave_in_a_block_goes_at_the_speed_of_compression(block):
    """Path of the wave from the edge of the punch to the side at 50 mm and back; 99 % of the work
    is within the edge.
    """
    speed = math.sqrt(115e9 * 0.7 / (1.3 * 0.4 * 8500.0))
    found = block.zone_summary()
    assert found["wave_return_s"] == pytest.approx(2 * 0.045 / speed, rel=1e-6)
    assert found["wave_returned"] == []  # the history ends before


def test_a_collision_of_two_spheres_has_no_boundaries(tmp_path):
    """Its sizes are known; no boundary limits them, in agreement with its mark and its badge."""
    summary = summary_of(tmp_path, kind="chain", size=2)
    assert summary["zone_depth_90_m"] is not None
    assert [summary[name] for name in ("zone_cut", *WAVE_KEYS)] == [None] * 4
