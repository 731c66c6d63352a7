"""A bed that was settled with soft grains, and is impacted as a hard material."""

import json

import numpy as np
import pytest
import tomli_w

from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.load_case import assembly_from_dict, load_assembly, load_case
from granwave.lammps_inputs.statics import smoothed, stiffening
from granwave.lammps_inputs.statics.energy import smoothed_overlaps
from granwave.lammps_inputs.statics.packing_bodies import loaded_bodies
from granwave.lammps_inputs.statics.stiffening import hardened_without_friction, stiffened_bed
from granwave.workflows.run.checks import check_equilibrium, rolls_on, warn_of_rolling
from granwave.workflows.run.driver import run_case
from tests.extensions.packings.test_poured import TABLES, N, made

HARDER = 1000.0
SOFT = TABLES["material"]


@pytest.fixture(scope="module")
def hard(tmp_path_factory):
    """Return a file of a case with the grains and springs of a soft bed, and a hard material."""
    folder = tmp_path_factory.mktemp("soft")
    _, bed = made(folder)
    (grains,) = (folder / "beds").glob("poured-*[0-9a-f].csv")
    width, depth = bed.container.box
    tables = {
        **TABLES,
        "material": SOFT | {"youngs_modulus": HARDER * SOFT["youngs_modulus"]},
        "packing": {
            "kind": "file",
            "file": str(grains),
            "contacts": "relax",
            "relaxation": "damped",
            "springs": bed.springs,
            "enclosure": {"x": [0.0, width], "y": [0.0, depth], "bottom": bed.bottom},
        },
        "contact": {"law": "hertz", "friction": 0.3, "rolling": 0.01},
        "boundary": {"sides": "wall", "bottom": "wall"},
        "precompression": {"kind": "gravity", "overlaps": True},
        "run": {"end_time": 1e-5, "frames": 2},
    }
    path = folder / "hard.toml"
    path.write_text(tomli_w.dumps(tables))
    return path


def test_the_modulus_of_a_bed_is_found_by_its_weight_and_forces_stay(hard, caplog):
    assembly = load_assembly(hard)
    assert "1000 times as large as the load" in caplog.text
    assert stiffened_bed(assembly) is None  # it is done once
    grains = assembly.case.packing.grains
    soft = loaded_bodies(assembly).elastic()
    before = soft.near(grains.found.position, soft.periods, 0.0)
    after = soft.near(grains.position, soft.periods, 1e-9)
    assert len(before) == pytest.approx(len(after), rel=0.05)
    shrunk = before.overlap.max() * HARDER ** (-2 / 3)
    assert after.overlap.max() == pytest.approx(shrunk, rel=2e-3)
    weight = assembly.sphere_masses()[:N].sum() * 9.81
    force = np.zeros(len(after))
    for law, rows, scale in soft.laws_of(after):
        force[rows], _, _ = law.evaluate(after.overlap[rows], scale)
    bottom = force[after.wall == "bottom"].sum()
    assert 0.6 * weight < bottom < 1.01 * weight  # friction of the walls carries the rest


def test_a_soft_bed_is_soon_in_balance_and_closes_its_energy(hard, tmp_path):
    run_case(load_case(hard), tmp_path / "run", figures=False)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    names, values = (tmp_path / "run" / "dumps" / "prestage.txt").read_text().splitlines()
    stage = dict(zip(names.removeprefix("# ").split(), map(float, values.split()), strict=True))
    assert stage["iterations"] < 100_000
    assert stage["residual"] < 1e-6
    assert stage["displacement"] < 1e-3 * TABLES["packing"]["diameter"]["normal"][0]
    assert summary["energy_balance_error"] < 1e-5
    record = tmp_path / "run" / "dumps" / "prestage.txt"
    stage |= {"residual": 2e-3, "unbalanced": 2e-3}
    record.write_text(f"{names}\n{' '.join(map(str, stage.values()))}\n")
    with pytest.raises(RunError, match="some grains still roll or swing"):
        check_equilibrium(load_assembly(hard), tmp_path / "run")


def test_grains_that_still_roll_are_named_and_not_fatal(hard, tmp_path, caplog):
    """The net forces of single grains are compared with their weight and with the weight of the
    bed.
    """
    assembly = load_assembly(hard)
    stage = {
        "residual": 2e-3, "largest_force": 0.5, "contacts": 600, "yielded": 0, "stored": 1e-6,
        "displacement": 1e-3, "iterations": 60_100, "unbalanced": 2e-4, "worst": 0.4, "rolling": 1,
    }  # fmt: skip
    (tmp_path / "dumps").mkdir()
    record = tmp_path / "dumps" / "prestage.txt"
    for changes, fault in (
        ({}, None),
        ({"worst": 2.0}, "no equilibrium"),
        ({"unbalanced": 1e-3}, "no equilibrium"),
        ({"residual": np.nan}, None),
        ({"residual": np.nan, "unbalanced": np.nan}, "no equilibrium"),
    ):
        values = stage | changes
        record.write_text(f"# {' '.join(values)}\n{' '.join(map(str, values.values()))}\n")
        if fault is None:
            assert check_equilibrium(assembly, tmp_path) == pytest.approx(values, nan_ok=True)
        else:
            with pytest.raises(RunError, match=fault):
                check_equilibrium(assembly, tmp_path)
    assert rolls_on(stage)
    assert not rolls_on(stage | {"residual": 1e-7})
    weights = assembly.sphere_masses()[:N] * 9.81
    forces = {sphere: np.zeros(3) for sphere in range(1, N + 1)}
    forces[7] = np.array([0.4 * weights[6], 0.0, 0.0])
    warn_of_rolling(assembly, stage, forces)
    assert f"1 of {N} grains still rolls" in caplog.text
    assert (
        "its contacts do not hold it: id 7. Net forces are at most 0.4 of the weight" in caplog.text
    )
    forces[3] = forces[7]
    warn_of_rolling(assembly, stage, forces)
    assert f"2 of {N} grains still roll after" in caplog.text
    assert "their contacts do not hold them: ids 3, 7. Net forces" in caplog.text


def test_a_bed_of_its_own_material_stays(hard, tmp_path):
    text = hard.read_text().replace("youngs_modulus = 10000000000.0", "youngs_modulus = 1e7")
    own = tmp_path / "own.toml"
    own.write_text(text)
    assert load_assembly(own).case.packing.grains.found is None


def without_friction(folder):
    """Return the tables of a case with the grains of a soft bed without friction."""
    _, bed = made(folder, friction=0.0)
    (grains,) = (folder / "beds").glob("poured-*[0-9a-f].csv")
    width, depth = bed.container.box
    walls = {"x": [0.0, width], "y": [0.0, depth], "bottom": bed.bottom}
    return {
        **TABLES,
        "packing": {"kind": "file", "file": str(grains), "contacts": "relax", "enclosure": walls},
        "contact": {"law": "hertz"},
        "boundary": {"sides": "wall", "bottom": "wall"},
        "precompression": {"kind": "gravity", "overlaps": True},
        "run": {"end_time": 1e-4, "frames": 2},
    }


def hardened(tables):
    """Return the tables with a material that is a thousand times harder."""
    return tables | {"material": SOFT | {"youngs_modulus": HARDER * SOFT["youngs_modulus"]}}


@pytest.mark.validation
def test_a_soft_bed_without_friction_finds_a_new_balance(tmp_path, caplog):
    """With the hard material the forces carry the weight, and the static stage needs no
    iterations.
    """
    tables = without_friction(tmp_path)
    assembly = assembly_from_dict(hardened(tables))
    assert "1000 times as large as the load" in caplog.text
    assert "they rearrange until they are in equilibrium" in caplog.text
    assert hardened_without_friction(assembly) == 1.0  # it is done once
    bodies = loaded_bodies(assembly).elastic()
    contacts = bodies.near(bodies.position, bodies.periods, 0.0)
    force = np.zeros(len(contacts))
    for law, rows, scale in bodies.laws_of(contacts):
        force[rows], _, _ = law.evaluate(contacts.overlap[rows], scale)
    net = bodies.dead_load.copy()
    push = force[:, None] * contacts.normal
    pairs = contacts.second >= 0
    np.subtract.at(net, contacts.first, push)
    np.add.at(net, contacts.second[pairs], push[pairs])
    weight = bodies.dead_load[:, 2].sum()
    assert np.abs(net).max() < 2e-7 * force.max()
    assert force[contacts.wall == "bottom"].sum() == pytest.approx(weight, rel=1e-5)
    run = run_case(assembly.case, tmp_path / "run", figures=False)
    names, values = (tmp_path / "run" / "dumps" / "prestage.txt").read_text().splitlines()
    stage = dict(zip(names.removeprefix("# ").split(), map(float, values.split()), strict=True))
    assert stage["iterations"] < 20
    assert stage["residual"] < 3e-7
    assert run.summary["energy_balance_error"] < 1e-5


def test_a_soft_bed_without_friction_is_told_from_its_own_and_from_rounding(tmp_path, caplog):
    tables = without_friction(tmp_path)
    own = assembly_from_dict(tables)
    assert hardened_without_friction(own) == 1.0
    packing = tables["packing"].copy()
    rounded = own.case.packing.grains.position.round(5)
    rows = [",".join(map(repr, [*place, 0.01])) for place in rounded.tolist()]
    packing["grains"] = "\n".join(["x,y,z,diameter", *rows, ""])
    del packing["file"]
    assert hardened_without_friction(assembly_from_dict(tables | {"packing": packing})) == 1.0
    assert "as hard as the load" not in caplog.text


def test_a_soft_bed_without_friction_that_finds_no_balance_is_an_error(tmp_path, monkeypatch):
    """The remedy in the message works: a bed with the modulus of the case needs no search."""
    tables = without_friction(tmp_path)
    monkeypatch.setattr(smoothed, "_ROUNDS", 1)
    monkeypatch.setattr(smoothed, "_ROUNDS_AT_END", 1)
    remedy = "pour or settle the bed with the Young's modulus of the run"
    with pytest.raises(InputError, match=rf"a net force of .* remains; {remedy}"):
        assembly_from_dict(hardened(tables))
    monkeypatch.setattr(stiffening, "_MOST_GRAINS", N - 1)
    with pytest.raises(InputError, match=rf"found more than {N - 1} grains .*; {remedy}"):
        assembly_from_dict(hardened(tables))


def test_smoothed_overlaps_and_their_slopes():
    """The smoothed overlaps solve a (a - d) = s^2, across gaps too, and equal the overlaps far from
    touching.
    """
    overlap = np.array([-1e-3, -1e-6, 0.0, 1e-6, 1e-3])
    smoothing = 1e-7
    values, slope = smoothed_overlaps(overlap, smoothing)
    assert values * (values - overlap) == pytest.approx(smoothing**2, rel=1e-6)
    step = 1e-10
    above, _ = smoothed_overlaps(overlap + step, smoothing)
    below, _ = smoothed_overlaps(overlap - step, smoothing)
    assert slope[1:4] == pytest.approx(((above - below) / (2 * step))[1:4], rel=1e-4)
    np.testing.assert_array_equal(smoothed_overlaps(overlap, 0.0)[0], overlap)
