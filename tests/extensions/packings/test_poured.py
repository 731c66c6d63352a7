"""Poured beds: made once and shared, equal for equal seeds, at rest; the energy balance of an
impact closes.
"""

import json
import multiprocessing
import subprocess
import sys
import tomllib

import numpy as np
import pytest
import tomli_w

from granwave.extensions.packings.bed import BedFile
from granwave.extensions.packings.bed_statistics import statistics_of
from granwave.extensions.packings.poured import PouredMaker
from granwave.extensions.packings.recipe import bed_of
from granwave.extensions.packings.settling import SettlingLaw
from granwave.extensions.packings.sizes import SizeDistribution
from granwave.lammps_inputs.case.material import presets
from granwave.lammps_inputs.case.packing.made_packing import (
    PackingNotMadeError,
    maker_input,
    nothing_made,
)
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.walls import walls
from granwave.workflows import load_case, load_scan
from granwave.workflows.cli.main import main
from granwave.workflows.run.driver import run_case

N = 60
GRAVITY = 9.81
# soft grains settle in few steps
TABLES = {
    "material": {
        "name": "soft",
        "youngs_modulus": 1e7,
        "poisson_ratio": 0.3,
        "density": 2500.0,
        "yield_strength": 1e6,
    },
    "packing": {
        "kind": "poured",
        "grains": N,
        "diameter": {"normal": [0.010, 0.0005]},
        "box": [0.04, 0.04],
        "seed": 1,
    },
    "contact": {"law": "hertz", "friction": 0.3},
    "striker": [{"touches": "centre", "diameter": 0.02, "velocity": [0.0, 0.0, 1.0]}],
    "run": {"end_time": 1e-2, "frames": 2},
}


def case_file(folder, **changes):
    """Write the case with changes of [packing] into a folder; return its path."""
    path = folder / "bed.toml"
    path.write_text(tomli_w.dumps({**TABLES, "packing": {**TABLES["packing"], **changes}}))
    return path


def made(folder, **changes):
    """Return recipe and bed of the case with changes of [packing]."""
    path = case_file(folder, **changes)
    errors = ErrorList(str(path))
    given = maker_input(tomllib.loads(path.read_text()), path, errors)
    recipe = PouredMaker().read(given, errors)
    assert not errors.items
    return recipe, bed_of(recipe, given)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the case and its bed."""
    place = tmp_path_factory.mktemp("poured")
    made(place)
    return place


def test_a_bed_is_made_once(folder):
    (file,) = (folder / "beds").glob("poured-*[0-9a-f].csv")
    before = file.stat().st_mtime_ns
    made(folder)
    assert file.stat().st_mtime_ns == before
    assert not list((folder / "beds").glob("*.tmp*"))


def test_the_same_seed_is_the_same_bed_bit_for_bit(folder, tmp_path):
    _, first = made(folder)
    _, second = made(tmp_path)
    assert first.grains.text == second.grains.text
    np.testing.assert_array_equal(first.normal_force, second.normal_force)


def test_seeds_give_different_beds_with_like_statistics(folder, tmp_path):
    first = statistics_of(*made(folder))
    recipe, bed = made(tmp_path, seed=2)
    second = statistics_of(recipe, bed)
    assert bed.grains.text != made(folder)[1].grains.text
    assert second.solid_fraction == pytest.approx(first.solid_fraction, abs=0.06)
    assert second.n_contacts == pytest.approx(first.n_contacts, rel=0.2)
    for found in (first, second):
        assert 0.48 < found.solid_fraction < 0.66
        assert 3.0 < found.coordination_without_rattlers < 6.5


def test_grains_are_inside_and_at_rest(folder):
    recipe, bed = made(folder)
    position = bed.grains.position
    radius = bed.grains.diameter / 2
    width = np.array(recipe.container.box)
    deepest = 0.02 * radius.max()  # overlaps of soft grains with walls
    assert (position[:, :2] - radius[:, None] > -deepest).all()
    assert (position[:, :2] + radius[:, None] < width + deepest).all()
    assert (position[:, 2] - radius).min() == pytest.approx(0.0, abs=1e-12)
    assert (position[:, 2] + radius).max() == pytest.approx(bed.bottom, abs=deepest)
    assert bed.record["residual"] < 1e-3


def test_check_makes_no_bed(folder, tmp_path):
    path = case_file(tmp_path)
    with nothing_made(), pytest.raises(PackingNotMadeError) as raised:
        load_case(path)
    assert dict(raised.value.packings[0].rows)["bed"].startswith(f"{N} grains of 0.009 to 0.011 m")
    assert not (tmp_path / "beds").exists()
    with nothing_made():
        assert load_case(case_file(folder)).packing.n_spheres == N


def _make(folder):
    made(folder)


def test_two_processes_make_a_bed_once(tmp_path):
    context = multiprocessing.get_context("spawn")
    workers = [context.Process(target=_make, args=(tmp_path,)) for _ in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(120)
        assert worker.exitcode == 0
    (file,) = (tmp_path / "beds").glob("poured-*[0-9a-f].csv")
    assert len(BedFile(file).read().grains) == N


def test_a_struck_bed_closes_its_energy_and_starts_in_balance(folder, tmp_path):
    path = case_file(folder)
    run = run_case(load_case(path), tmp_path / "run", figures=False)
    assert run.summary["energy_balance_error"] < 1e-5
    assert run.summary["friction_fraction"] > 0.3
    # measured after all drag is gone; the stage ends at 4e-7 with the drag on the spins
    assert static_record(tmp_path / "run")["residual"] < 1e-6
    script = (tmp_path / "run" / "in.granwave").read_text()
    assert "set             group static_spheres omega 0.0 0.0 0.0" in script
    walls = np.loadtxt(tmp_path / "run" / "dumps" / "walls.txt")
    bottom = walls[:, 2]
    _, bed = made(folder)
    weight = TABLES["material"]["density"] * np.pi / 6 * (bed.grains.diameter**3).sum() * GRAVITY
    early = walls[:, 1] < 1e-4  # no wave is at the bottom yet
    assert early.sum() > 2
    assert np.abs(bottom[early] - bottom[0]).max() < 1e-3 * weight
    assert bottom[0] < 1.5 * weight
    stored = tomllib.loads((tmp_path / "run" / "case.toml").read_text())
    assert stored["packing"]["kind"] == "file"
    assert stored["packing"]["enclosure"]["x"] == [0.0, 0.04]


def static_record(directory):
    """Return the record of the static stage of a run."""
    title, values = (directory / "dumps" / "prestage.txt").read_text().splitlines()[:2]
    return dict(zip(title.lstrip("#").split(), map(float, values.split()), strict=True))


def test_springs_of_a_bed_go_on_without_a_jump(folder, tmp_path):
    """With the springs of the bed all grains are in equilibrium at the first step; without them
    they are not.
    """
    case = load_case(case_file(folder))
    _, bed = made(folder)
    weight = TABLES["material"]["density"] * np.pi / 6 * (bed.grains.diameter**3).sum() * GRAVITY
    net = {}
    for has_springs in (True, False):
        tables = case.to_dict()
        tables["packing"] |= {"contacts": "keep"}
        tables["run"]["end_time"] = 1e-4
        del tables["packing"]["relaxation"]
        if not has_springs:
            del tables["packing"]["springs"]
        directory = tmp_path / str(has_springs)
        run_case(case_from_dict(tables), directory, figures=False)
        record = static_record(directory)
        net[has_springs] = record["residual"] * record["largest_force"]
    assert net[True] < 1e-4 * weight
    assert net[False] > 1e-2 * weight


def test_a_bed_with_its_resistance_stays_where_it_settled(folder, tmp_path):
    recipe, _ = made(folder)
    moved = {}
    for rolling in (0.0, recipe.keys.rolling):
        tables = load_case(case_file(folder)).to_dict()
        tables["run"]["end_time"] = 1e-4
        if rolling:
            tables["contact"]["rolling"] = {"coefficient": rolling}
        directory = tmp_path / str(rolling)
        run_case(case_from_dict(tables), directory, figures=False)
        moved[rolling] = static_record(directory)["displacement"]
    diameter = TABLES["packing"]["diameter"]["normal"][0]
    assert moved[recipe.keys.rolling] < 1e-3 * diameter < moved[0.0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"springs": "a,b\n"}, "found the columns a, b"),
        ({"springs": "first,second,fx,fy,fz,compliance\n2,1,0,0,0,1\n"}, "line 2: found 2,1,0"),
        (
            {"springs": "bed/springs.csv"},
            r"springs\.csv\", expected a table of springs as text, with the columns first, "
            "second, fx, fy, fz, compliance; the text of the file, between triple quotes, and not "
            "its path",
        ),
        ({"springs": 3}, r"packing\.springs: found 3, expected a table of springs as text"),
        (
            {"relaxation": "minimiser"},
            r"packing\.springs: applies only to packing\.contacts = .keep.",
        ),
    ],
)
def test_wrong_springs(folder, changes, message):
    tables = load_case(case_file(folder)).to_dict()
    tables["packing"] |= changes
    with pytest.raises(InputError, match=message):
        case_from_dict(tables)


def test_the_command_prints_and_draws_statistics(folder, tmp_path):
    command = [sys.executable, "-m", "granwave.workflows", "bed", str(case_file(folder))]
    figure = tmp_path / "bed.png"
    done = subprocess.run(
        [*command, "--json", "-o", str(figure)], capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout)
    assert found["n_grains"] == N
    assert found["rattler_fraction"] < 0.3
    assert figure.is_file()
    assert figure.with_suffix(".csv").read_text().startswith("force_over_mean,")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"box": [0.015, 0.04]}, "packing.box: found a width of 0.015 m for grains of 0.011 m"),
        ({"tube": 0.05}, "packing.tube: found both box and tube, expected one of them"),
        ({"diameter": -1.0}, "packing.diameter: found -1.0, expected a diameter in m"),
        ({"grains": 0}, "packing.grains: found 0"),
        ({"size": 3}, "packing.size: unknown key"),
        ({"diameter": {"normal": [0.01, 0.004], "cut": 3.0}}, "packing.diameter: found"),
    ],
)
def test_wrong_keys(tmp_path, changes, message):
    with pytest.raises(InputError) as raised:
        load_case(case_file(tmp_path, **changes))
    assert message in str(raised.value)
    assert len(raised.value.items) == 1


def test_restitution_of_the_dashpot():
    law = SettlingLaw(presets()["brass"], 0.3, 0.01, 0.5, GRAVITY)
    # Antypov and Elliott 2011, equation 26
    assert law.dashpot == pytest.approx(0.4818, abs=1e-4)


def test_normal_diameters_are_cut_off():
    sizes = SizeDistribution(normal=(0.01, 0.001), cut=1.0)
    drawn = sizes.draw(10_000, np.random.default_rng(1))
    assert drawn.min() >= 0.009
    assert drawn.max() <= 0.011
    assert drawn.mean() == pytest.approx(0.01, rel=1e-3)
    # of a normal distribution cut off at one standard deviation
    assert drawn.std() == pytest.approx(0.5396e-3, rel=0.02)


def test_a_tube_and_periodic_sides(tmp_path):
    changes = {"grains": 30, "tube": 0.02}
    tables = {name: value for name, value in TABLES["packing"].items() if name != "box"}
    path = tmp_path / "tube.toml"
    path.write_text(tomli_w.dumps({**TABLES, "packing": {**tables, **changes}}))
    case = load_case(path)
    assert case.boundary.sides_tube == 0.02
    periodic = {**TABLES, "boundary": {"sides": "periodic"}}
    periodic["packing"] = {**TABLES["packing"], "grains": 30}
    path.write_text(tomli_w.dumps(periodic))
    case = load_case(path)
    assert case.boundary.periodic
    assert case.packing.period == (0.04, 0.04)


def test_another_load_has_the_same_bed(folder):
    changes = {"striker.1.velocity": [0.0, 0.0, 2.0], "run.end_time": 2e-2}
    with nothing_made():
        assert load_case(case_file(folder), changes).packing.n_spheres == N
    with nothing_made(), pytest.raises(PackingNotMadeError):
        load_case(case_file(folder), {"contact.friction": 0.31})


def test_a_damaged_bed_is_named(folder, tmp_path):
    made(tmp_path, grains=5)
    (file,) = (tmp_path / "beds").glob("poured-*[0-9a-f].csv")
    file.write_text("x,y\n")
    with pytest.raises(InputError, match=r"found no bed .*; remove the file to generate it again"):
        load_case(case_file(tmp_path, grains=5))


def test_walls_of_a_file_are_where_its_enclosure_puts_them(tmp_path):
    grains = "x,y,z,diameter\n0.01,0.01,0,0.01\n0.01,0.01,0.01,0.01\n"
    enclosure = {"x": [0.0, 0.03], "bottom": 0.016}
    (tmp_path / "grains.csv").write_text(grains)
    tables = {
        "material": "brass",
        "packing": {"kind": "file", "file": "grains.csv", "enclosure": enclosure},
        "boundary": {"sides": "wall"},
    }
    path = tmp_path / "case.toml"
    path.write_text(tomli_w.dumps(tables))
    case = load_case(path)
    places = {wall.name: wall.coordinate for wall in walls(assemble(case))}
    assert places == {
        "bottom": 0.016,
        "xlo": 0.0,
        "xhi": 0.03,
        "ylo": pytest.approx(0.005),
        "yhi": pytest.approx(0.015),
    }
    assert case.to_dict()["packing"]["enclosure"] == enclosure
    with pytest.raises(InputError, match=r"packing\.enclosure"):
        load_case("fcc-small", {"packing.enclosure": enclosure})


def hertz(overlap, radius):
    """Return Hertz's force of a soft grain on another, or on a rigid wall."""
    modulus = TABLES["material"]["youngs_modulus"] / (1 - TABLES["material"]["poisson_ratio"] ** 2)
    return 4 / 3 * modulus * np.sqrt(radius) * np.maximum(overlap, 0.0) ** 1.5


def test_without_friction_a_bed_is_in_balance(tmp_path):
    """Forces computed from the positions by Hertz's law, of pairs and planes, carry the weight of
    each grain.
    """
    _, bed = made(tmp_path, friction=0.0)
    position = bed.grains.position
    radius = bed.grains.diameter / 2
    first, second = np.triu_indices(N, 1)
    apart = position[second] - position[first]
    distance = np.linalg.norm(apart, axis=1)
    together = radius[first] * radius[second] / (radius[first] + radius[second])
    force = hertz(radius[first] + radius[second] - distance, together) / 2
    push = (force / distance)[:, None] * apart
    net = np.zeros((N, 3))
    np.add.at(net, second, push)
    np.add.at(net, first, -push)
    net[:, 2] += TABLES["material"]["density"] * np.pi / 6 * (2 * radius) ** 3 * GRAVITY
    net[:, 2] -= hertz(position[:, 2] + radius - bed.bottom, radius)
    for axis in (0, 1):
        width = TABLES["packing"]["box"][axis]
        net[:, axis] += hertz(radius - position[:, axis], radius)
        net[:, axis] -= hertz(position[:, axis] + radius - width, radius)
    assert np.linalg.norm(net, axis=1).max() < 1e-7 * force.max()


def scan_file(folder, text):
    """Write a scan of the case into a folder; return its path."""
    case_file(folder)
    path = folder / "scan.toml"
    path.write_text(f'case = "bed.toml"\n{text}')
    return path


def test_a_plan_counts_the_beds_of_a_scan_and_makes_none(tmp_path, capsys):
    """Three seeds with two speeds need three beds, whose costs are shown."""
    text = "[grid]\npacking.seed = [1, 2, 3]\nrun.end_time = [1e-3, 2e-3]\n"
    path = scan_file(tmp_path, text)
    with nothing_made(), pytest.raises(PackingNotMadeError) as raised:
        load_scan(path)
    beds = raised.value.packings
    assert len({bed.file for bed in beds}) == len(beds) == 3
    assert main(["scan", str(path), "--plan", "--json"]) == 0
    values = json.loads(capsys.readouterr().out)["not_made"]
    assert values["n_packings"] == 3
    assert values["wall_time_s"] == pytest.approx(3 * beds[0].time)
    assert values["memory_bytes"] == pytest.approx(beds[0].memory)
    assert main(["scan", str(path), "--plan"]) == 0
    assert "packings to generate" in capsys.readouterr().out
    assert not (tmp_path / "beds").exists()


def test_replicates_are_beds_of_their_own(tmp_path):
    path = scan_file(tmp_path, "replicates = 2\n[grid]\nrun.end_time = [1e-3, 2e-3]\n")
    with nothing_made(), pytest.raises(PackingNotMadeError) as raised:
        load_scan(path)
    assert len(raised.value.packings) == 2
    for bed in raised.value.packings:
        assert bed.time > 0
    made(tmp_path, seed=1, grains=N)
    with nothing_made(), pytest.raises(PackingNotMadeError) as raised:
        load_scan(path)
    assert len(raised.value.packings) == 1
