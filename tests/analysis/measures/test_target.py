"""Load of the target, with and without the packing: closed forms, and simulated impacts of single
spheres.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from granwave.analysis import Result, analyse, summarise, write_result
from granwave.analysis.measures.target import Target, impactors_of, target_of, unprotected
from granwave.analysis.measures.target import _hit as hit
from granwave.analysis.measures.target import _rebound as rebound
from granwave.analysis.measures.target_record import reached
from granwave.lammps_inputs import Case, flat_contact, write_deck
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows.library import load_case
from tests.helpers.made_up import synthetic

END = 3e-4
PLATE = {"plate": {"mass": 0.05, "stiffness": 1e6, "damping": 10.0}}
BAR = {"bar": {"length": 0.2, "area": 1e-4, "elements": 100}, "material": "steel"}


def bare_target_peak(case: Case, end_time: float) -> tuple[float, float] | None:
    """Largest force on the bare target, and on the ground."""
    found = unprotected(assemble(case), end_time)
    return found and (found.peak_force, found.ground_peak_force)


def sphere(**changes) -> Case:
    return load_case("sphere-on-wall", {"run.end_time": END, **changes})


# ------------------------------------------------------------------------------------- without packing


@pytest.mark.parametrize("law", ["elastoplastic", "hertz", "bilinear"])
def test_peak_on_a_rigid_wall_is_that_of_the_energy(law):
    case = sphere(**{"contact.law": law, "load.velocity": 3.0})
    contact = flat_contact(case, 1)
    (group,) = impactors_of(assemble(case), None)
    energy = 0.5 * case.sphere_mass * 9.0
    assert contact.loading_work(np.array([group.largest_overlap]))[0] == pytest.approx(
        energy, rel=1e-12
    )
    peak, ground = bare_target_peak(case, END)
    assert (
        peak
        == ground
        == pytest.approx(contact.loading_force(np.array([group.largest_overlap]))[0], rel=1e-14)
    )
    assert unprotected(assemble(case), END).peak_force == pytest.approx(peak, rel=1e-6)


def test_a_hertzian_sphere_gives_back_its_momentum():
    """The impulse is 2 m v; with the elastoplastic law (1 + e) m v with the coefficient of
    restitution of the law.
    """
    for law in ("hertz", "elastoplastic"):
        case = sphere(**{"contact.law": law})
        found = unprotected(assemble(case), END)
        (group,) = impactors_of(assemble(case), None)
        lost = group.law.dissipated_energy(np.array([group.largest_overlap]))[0]
        restitution = math.sqrt(1 - lost / (0.5 * group.mass * group.velocity**2))
        impulse = np.trapezoid(found.force, found.time)
        assert impulse == pytest.approx(
            (1 + restitution) * group.mass * group.velocity, rel=1e-4
        ), law


@pytest.mark.parametrize("law", ["elastoplastic", "hertz", "thornton"])
def test_course_on_a_wall_that_does_not_move_solves_the_equation_of_motion(law):
    case = sphere(**{"contact.law": law, "load.velocity": 3.0, "load.spheres": 1})
    groups = impactors_of(assemble(case), None)
    course = rebound(groups[0])
    solved = hit(groups, target_of(assemble(case)), END)
    felt = np.interp(solved.time, course.time, course.force, right=0.0)
    assert felt == pytest.approx(solved.force, abs=1e-3 * solved.peak_force)
    assert course.force[0] == course.force[-1] == 0
    assert np.trapezoid(course.force, course.time) == pytest.approx(
        np.trapezoid(felt, solved.time), rel=3e-4
    )


def test_several_struck_spheres_press_together():
    one, three = (
        case_from_dict(synthetic.make_case(load={"spheres": n, "velocity": 2.0}).to_dict())
        for n in (1, 3)
    )
    assert bare_target_peak(three, END)[0] == pytest.approx(
        3 * bare_target_peak(one, END)[0], rel=1e-12
    )


def test_an_oblique_impact_counts_with_its_normal_part():
    oblique = bare_target_peak(sphere(**{"load.angle": 60.0}), END)[0]
    assert oblique == pytest.approx(
        bare_target_peak(sphere(**{"load.velocity": 0.5}), END)[0], rel=1e-9
    )


def test_a_heavy_plate_is_a_wall_and_a_light_one_a_mass():
    """The peak is determined by the reduced mass while the spring is slow."""
    wall = bare_target_peak(sphere(), END)[0]
    heavy = sphere(**{"boundary.bottom": {"plate": {"mass": 1e4, "stiffness": 1.0}}})
    assert unprotected(assemble(heavy), 5e-5).peak_force == pytest.approx(wall, rel=1e-5)
    case = sphere(
        **{"boundary.bottom": {"plate": {"mass": sphere().sphere_mass, "stiffness": 1.0}}}
    )
    (group,) = impactors_of(assemble(case), None)
    half = 0.25 * group.mass * group.velocity**2  # 1/2 (m/2) v^2
    force = unprotected(assemble(case), 5e-5).force
    overlap = np.interp(
        half, group.law.loading_work(grid := np.linspace(0, group.largest_overlap, 20001)), grid
    )
    assert force.max() == pytest.approx(group.law.loading_force(np.array([overlap]))[0], rel=1e-6)


def test_an_endless_bar_is_a_damper():
    """Before a reflection returns, a bar acts as a damper with its impedance: v = F / Z."""
    case = sphere(**{"boundary.bottom": BAR})
    target = target_of(assemble(case))
    impedance = 1e-4 * math.sqrt(target.material.youngs_modulus * target.material.density)
    assert target.ground_damping == pytest.approx(impedance, rel=1e-12)
    damper = Target(target.material, np.zeros(1), 0.0, 0.0, impedance)
    groups = impactors_of(assemble(case), target.material)
    assert hit(groups, target, END).peak_force == pytest.approx(
        hit(groups, damper, END).peak_force, rel=2e-3
    )
    fixed = unprotected(
        assemble(sphere(**{"boundary.bottom": {**BAR, "bar": {**BAR["bar"], "end": "fixed"}}})), END
    )
    assert fixed.ground_peak_force == pytest.approx(2 * fixed.peak_force, rel=3e-3)


def test_a_force_acts_on_the_target_itself():
    """A half-sine much shorter than the period of the plate acts by its impulse, F = J sqrt(K/m); a
    long one passes.
    """
    load = {"kind": "force", "shape": "half-sine", "amplitude": 100.0}
    assert bare_target_peak(sphere(load={**load, "duration": 1e-4}), END) == pytest.approx(
        (100.0, 100.0), rel=1e-12
    )
    plate = {"plate": {"mass": 1.0, "stiffness": 1e6}}
    short = sphere(
        load={**load, "duration": 1e-5}, **{"boundary.bottom": plate, "run.end_time": 1e-2}
    )
    impulse = 2 / math.pi * 100.0 * 1e-5
    assert bare_target_peak(short, 1e-2) == pytest.approx((100.0, impulse * 1e3), rel=1e-3)
    long = sphere(load={**load, "duration": 0.1}, **{"boundary.bottom": plate, "run.end_time": 0.2})
    assert bare_target_peak(long, 0.2)[1] == pytest.approx(100.0, rel=5e-2)


def test_nothing_to_compare_with():
    assert bare_target_peak(sphere(**{"boundary.bottom": "free"}), END) is None
    shaken = {"kind": "force", "shape": "harmonic", "amplitude": 1.0, "frequency": 1e4}
    assert bare_target_peak(sphere(load=shaken), END) is None
    moved = {"kind": "displacement", "shape": "harmonic", "amplitude": 1e-5, "frequency": 1e4}
    assert bare_target_peak(sphere(load=moved), END) is None


# ------------------------------------------------------------------------------------------ with LAMMPS


@pytest.mark.parametrize(
    "bottom", ["wall", {"material": "steel"}, PLATE, BAR], ids=["wall", "steel", "plate", "bar"]
)
def test_a_single_sphere_is_its_own_reference(tmp_path, lmp, bottom):
    """LAMMPS agrees with the differential equation: a packing of one sphere reduces no quantity.

    Forces on planes are recorded every fifth step: the error of a peak is up to (5 dt pi / T)^2 /
    8, 2e-4.
    """
    case = sphere(**{"boundary.bottom": bottom, "contact.friction": 0.3, "load.angle": 20.0})
    done = lmp(write_deck(case, tmp_path).script)
    assert done.returncode == 0, done.stdout + done.stderr
    summary = analyse(tmp_path, figures=False)
    assert summary["peak_reduction"] == pytest.approx(1.0, abs=3e-4)
    assert summary["ground_peak_reduction"] == pytest.approx(1.0, abs=3e-4)
    assert summary["packing_mass_kg"] == pytest.approx(case.sphere_mass, rel=1e-12)
    assert summary["packing_height_m"] == pytest.approx(0.01, rel=1e-12)
    assert summary["peak_reduction_per_kg"] == pytest.approx(
        summary["peak_reduction"] / case.sphere_mass
    )
    moves = case.boundary.bottom_support is not None
    if not moves:
        assert summary["energy_target_J"] == 0 and summary["support_energy_J"] is None
        return
    kept = summary["support_energy_J"] + summary["support_lost_J"]
    assert summary["energy_target_J"] == pytest.approx(kept, rel=1e-5)
    with Result(tmp_path) as result:
        found = reached(result)
        work = np.trapezoid(found.force, found.displacement)
        assert work == pytest.approx(summary["energy_target_J"], rel=1e-3)
        assert summary["target_peak_displacement_m"] == np.abs(found.displacement).max() > 0
        assert {"velocity", "ground_force"} <= set(result.names("walls/bottom"))


# ------------------------------------------------------------------------------------------ what reached it


def test_reduction_of_a_packing(tmp_path):
    case = synthetic.make_case()
    write_result(synthetic.write_run(tmp_path, case))
    summary = summarise(tmp_path)
    force = synthetic.BOTTOM_FORCE
    assert summary["ground_peak_force_N"] == summary["wall_peak_force_N"] == pytest.approx(force)
    assert summary["peak_reduction"] == pytest.approx(summary["unprotected_peak_force_N"] / force)
    assert summary["packing_mass_kg"] == pytest.approx(144 * case.sphere_mass)
    assert summary["packing_height_m"] == pytest.approx(0.01 * (1 + 3 * math.sqrt(2 / 3)))
    first = math.asin(0.01) / math.pi * synthetic.STEPS * synthetic.TIMESTEP
    assert summary["base_arrival_s"] == pytest.approx(first, rel=1e-4)


def test_packing_without_a_bottom(tmp_path):
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(boundary={"bottom": "free"})))
    summary = summarise(tmp_path)
    absent = (
        "ground_peak_force_N",
        "unprotected_peak_force_N",
        "peak_reduction",
        "base_arrival_s",
        "energy_target_J",
    )
    assert all(summary[key] is None for key in absent)
    assert summary["packing_mass_kg"] > 0
