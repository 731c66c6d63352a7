"""Elastoplastic law with non-default constants: law, pair style, wall, restart, deck, and errors."""

from __future__ import annotations

import dataclasses
import json
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs import flat_contact, write_deck
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import LAW_CONSTANTS, Contact
from granwave.lammps_inputs.case.schema import info_of
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict, load_case
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import PAIR, R, collide, restitution, value
from tests.helpers.twins.twin import CONSTANTS, OTHER, PRINTED, LawTwin, Network

BRASS = {
    "youngs_modulus": (115e9, 115e9),
    "poisson_ratio": (0.3, 0.3),
    "yield_strength": (550e6, 550e6),
}
STYLE = "elastoplastic 115e9 0.3 550e6 " + " ".join(
    f"{name} {value!r}" for name, value in OTHER.items()
)
SPHERES = {"packing": {"kind": "chain", "size": 2, "diameter": 2 * R}, "material": "brass"}


def law(**constants) -> ContactLaw:
    return ContactLaw(**BRASS, radius=(R, R), **constants)


def case(**contact) -> Case:
    return case_from_dict({**SPHERES, "contact": contact}, "case")


def test_one_list_of_constants():
    """Header, case file and twin agree on the names and on the published values."""
    assert tuple(LAW_CONSTANTS) == CONSTANTS
    assert tuple(LAW_CONSTANTS.values()) == PRINTED
    described = {f.name: info_of(f).description for f in dataclasses.fields(Contact)}
    for name, printed in LAW_CONSTANTS.items():
        assert described[name].endswith(f"; {printed:g} by default"), name


def test_published_constants_given_are_the_default_law():
    a = np.linspace(0, 300, 400) * law().yield_overlap
    peak = np.maximum(a, 120 * law().yield_overlap)
    same = law(**LAW_CONSTANTS)
    assert np.array_equal(same.force(a, peak), law().force(a, peak))
    assert np.array_equal(same.dissipated_energy(a), law().dissipated_energy(a))
    assert same.constants == LAW_CONSTANTS and law(**OTHER).constants == OTHER


@pytest.mark.parametrize("peak", [0.5, 1.0001, 1.05, 1.2, 3.0, 30.0, 139.9, 140.1, 177.6, 350.0])
@pytest.mark.parametrize("names", [CONSTANTS, *((name,) for name in CONSTANTS)])
def test_against_the_second_implementation(names, peak):
    own = {name: OTHER[name] for name in names}
    compiled = law(**own)
    twin = LawTwin(**own)
    length = compiled.yield_overlap
    force = compiled.yield_force
    a = np.linspace(0, 1.2 * peak, 40)
    expected = [twin.force(x, max(x, peak)) for x in a]
    assert compiled.force(a * length, np.full(40, peak * length)) / force == pytest.approx(
        expected, rel=1e-10, abs=1e-12
    )
    assert compiled.loading_work(peak * length) / (force * length) == pytest.approx(
        twin.work(peak), rel=1e-10
    )
    lost = compiled.dissipated_energy(peak * length) / (force * length)
    assert lost == pytest.approx(twin.dissipated(peak), rel=1e-8, abs=1e-9)


def near(name: str) -> st.SearchStrategy[float]:
    return st.floats(0.5, 2.0).map(lambda share: share * LAW_CONSTANTS[name])


@settings(max_examples=150, deadline=None)
@given(st.fixed_dictionaries({name: near(name) for name in CONSTANTS}))
def test_what_is_accepted_is_continuous_and_passive(own):
    """Loading increases, unloading returns at most the work of loading, a larger peak dissipates
    more, for any constants.
    """
    try:
        compiled = law(**own)
    except ValueError:
        return
    length = compiled.yield_overlap
    peak = np.concatenate([np.linspace(1, 8, 3000), np.geomspace(8, 4000, 1000)]) * length
    loading = compiled.loading_force(peak)
    assert np.all(np.diff(loading) > -1e-9 * loading[1:])
    for joint in (1.0, own["area_switch"]):
        below, above = (
            compiled.loading_force(joint * length * (1 + side)) for side in (-1e-12, 1e-12)
        )
        assert below == pytest.approx(above, rel=1e-9)
    residual = compiled.residual_overlap(peak)
    assert np.all(residual >= -1e-12 * length) and np.all(residual[1:] < peak[1:])
    lost = compiled.dissipated_energy(peak)
    work = compiled.loading_work(peak)
    assert np.all(lost >= 0) and np.all(np.diff(lost) >= -1e-6 * work[1:])
    assert compiled.elastic_energy(peak, peak) + lost == pytest.approx(work, rel=1e-9)


def test_exponent_is_raised_as_far_as_it_takes():
    """The unloading exponent is increased far beyond first yield; with the published constants only
    up to a peak of 1.09 alpha_y.
    """
    own = {"residual_slope": 0.1, "residual_offset": 0.1, "unloading_exponent": 1.05}
    compiled = law(**own)
    twin = LawTwin(**own)
    peak = np.geomspace(1.001, 400, 60)
    exponent = compiled.unloading_exponent(peak * compiled.yield_overlap)
    assert exponent == pytest.approx([twin.exponent(p) for p in peak], rel=1e-9)
    assert np.all(exponent[peak < 30] > 1.05) and np.all(exponent[peak > 40] == 1.05)
    assert compiled.dissipated_energy(peak * compiled.yield_overlap).min() >= 0


@pytest.mark.parametrize(
    ("own", "fault"),
    [
        ({"area_slope": 0.3}, "must both exceed 1"),
        ({"pressure_limit": 0.1}, "force does not increase"),
        ({"residual_slope": 1.1}, "not below the largest"),
        ({"residual_slope": 0.1}, "negative or decreases"),
        ({"residual_rate": 0.2}, "negative or decreases"),
        ({"unloading_exponent": 0.9}, "at least 1"),
        ({"pressure_rate": 20.0}, "between 1e-4 and 10"),
        ({"area_switch": 1.0}, "must both exceed 1"),
        ({"pressure_limit": np.inf}, "finite"),
        ({"pressure_limt": 2.0}, "pressure_limt"),
    ],
)
def test_no_passive_law(lammps, own, fault):
    with pytest.raises(ValueError, match=fault):
        law(**own)
    ((name, number),) = own.items()
    with pytest.raises(InputError, match=r"contact") as refused:
        case(**own)
    assert len(refused.value.errors) == 1 and name in refused.value.errors[0]
    with pytest.raises(Exception, match=f"{name}|passive"):
        lammps(script_of(PAIR, style=f"elastoplastic 115e9 0.3 550e6 {name} {number}"))


@pytest.mark.parametrize(
    "other", [{"law": "hertz"}, {"law": "thornton"}, {"law": "bilinear"}, {"variant": "published"}]
)
def test_only_the_continuous_elastoplastic_law_takes_them(lammps, other):
    answer = r'contact\.area_slope: .*(applies only to law = "elastoplastic"|fixed constants)'
    with pytest.raises(InputError, match=answer):
        case(area_slope=2.3, **other)
    with pytest.raises(ValueError, match=r"not an option of law|fixed constants"):
        ContactLaw(**BRASS, radius=(R, R), area_slope=2.3, **other)
    name = other.get("law", "elastoplastic")
    words = f"{name} 115e9 0.3{'' if name == 'hertz' else ' 550e6'}{' variant published' if 'variant' in other else ''}"
    with pytest.raises(Exception, match=r"not an option of law|fixed constants"):
        lammps(script_of(PAIR, style=f"{words} area_slope 2.3"))


def test_collision_against_the_network_twin(lammps):
    lmp = lammps()
    collide(lmp, style=STYLE)
    twin = Network(PAIR, [(0, 1)], R, law=LawTwin(**OTHER))
    twin.v[:, 2] = 1.0, -1.0
    twin.run(1e-8, 20000)
    assert value(lmp, "vz[1]") == pytest.approx(twin.v[0, 2], rel=1e-8)
    assert value(lmp, "c_ep[1]") == pytest.approx(twin.dissipated(), rel=1e-8)
    usual = lammps()
    collide(usual)
    assert abs(restitution(lmp) - restitution(usual)) > 0.005


def test_wall(lammps):
    lmp = lammps()
    wall = f"fix floor all wall/gran/hysteretic zplane NULL {R:.17g} {STYLE}\nthermo_style custom step f_floor[4] f_floor[5] c_ke\n"
    lmp.commands_string(
        script_of([(0, 0, 0)], velocities=[(0, 0, 2.0)], box=[-0.1, 0.1] * 3, extra=wall)
    )
    lmp.command("run 20000")
    rigid = flat_contact(case(**OTHER), 1)
    peak = lmp.numpy.extract_fix("floor", 1, 2)[0, 2]
    mass = 8500 * 4 / 3 * np.pi * R**3
    assert rigid.loading_work(peak) == pytest.approx(0.5 * mass * 4, rel=1e-5)
    assert value(lmp, "f_floor[5]") == pytest.approx(rigid.dissipated_energy(peak), rel=1e-12)
    assert value(lmp, "c_ke+f_floor[4]+f_floor[5]") == pytest.approx(0.5 * mass * 4, rel=1e-7)


def test_deck(tmp_path):
    plain = case()
    own = case(pressure_limit=2.9, residual_offset=20.0)
    script = write_deck(plain, tmp_path / "plain").script.read_text()
    assert "variant continuous yield_factor 1.6\n" in script and not any(
        name in script for name in CONSTANTS
    )
    assert not set(CONSTANTS) & set(plain.to_dict()["contact"])
    script = write_deck(own, tmp_path / "own").script.read_text()
    assert "variant continuous yield_factor 1.6 pressure_limit 2.9 residual_offset 20\n" in script
    again = load_case(tmp_path / "own" / "case.toml")
    assert again.contact == own.contact and again.to_dict() == own.to_dict()
    assert sphere_contact(again).constants == LAW_CONSTANTS | {
        "pressure_limit": 2.9,
        "residual_offset": 20.0,
    }
    assert tomllib.loads(own.to_toml())["contact"]["pressure_limit"] == 2.9


def test_a_run_with_them(granwave, tmp_path):
    """Contact with a wall and analysis: the energy balance closes, and the dissipation differs from
    the published law.
    """
    given = [f"--set=contact.{name}={number}" for name, number in OTHER.items()]
    words = (
        "run",
        "two-spheres",
        "--no-figures",
        "--set=boundary.bottom=wall",
        "--set=run.end_time=1e-4",
    )
    lost = []
    for n, more in enumerate(([], given)):
        done = granwave(*words, *more, "-o", tmp_path / str(n))
        assert done.returncode == 0, done.stderr
        summary = json.loads((tmp_path / str(n) / "summary.json").read_text())
        assert summary["energy_balance_error"] < 1e-5
        lost.append(summary["dissipated_fraction"])
    assert abs(lost[1] - lost[0]) > 0.005
