"""Manual pages of the LAMMPS styles: all complete examples run unmodified with plain ``lmp``, with correct results."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.manual import PAGES, Log

BLOCK = re.compile(r"^```LAMMPS\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NAME = re.compile(r"# Complete example: (\w+)\n")
STYLES = (
    "pair_gran_hysteretic",
    "fix_wall_gran_hysteretic",
    "fix_gran_cylinder",
    "fix_gran_load",
    "fix_gran_holder",
    "fix_gran_timestep",
    "compute_gran_hysteretic_atom",
    "compute_gran_hysteretic_local",
    "compute_gran_hysteretic_contact",
    "compute_gran_hysteretic_energy",
    "gran_dents",
)
SECTIONS = ("Syntax", "Examples", "Description", "Restrictions", "Related commands", "Default")


def blocks() -> dict[str, tuple[str, str]]:
    """Complete examples by name: page and script."""
    found = {}
    for page in sorted(PAGES.glob("*.md")):
        for block in BLOCK.findall(page.read_text(encoding="utf-8")):
            if mark := NAME.match(block):
                assert mark[1] not in found, mark[1]
                found[mark[1]] = page.stem, block
    return found


EXAMPLES = blocks()


def table(path: Path) -> np.ndarray:
    """Last snapshot of a dump."""
    last = path.read_text(encoding="utf-8").rpartition("ITEM: TIMESTEP")[2].splitlines()
    start = next(k for k, line in enumerate(last) if line.startswith(("ITEM: ATOMS", "ITEM: BONDS")))
    return np.array([[float(word) for word in line.split()] for line in last[start + 1 :]])


@pytest.fixture
def example(lmp, tmp_path):
    """Run a complete example in a separate directory."""

    def run(name: str, ranks: int = 1) -> Log:
        (tmp_path / f"in.{name}").write_text(EXAMPLES[name][1], encoding="utf-8")
        done = lmp(tmp_path / f"in.{name}", ranks=ranks)
        log = tmp_path / "log.lammps"
        tail = log.read_text(encoding="utf-8")[-1000:] if log.exists() else ""
        assert done.returncode == 0, done.stdout + done.stderr + tail
        return Log(log)

    return run


@pytest.mark.parametrize("style", STYLES)
def test_pages_have_the_form_of_a_manual(style):
    text = (PAGES / f"{style}.md").read_text(encoding="utf-8")
    found = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert [section for section in found if section in SECTIONS] == list(SECTIONS)
    assert any(page == style for page, _ in EXAMPLES.values())
    assert f"({style}.md)" in (PAGES / "README.md").read_text(encoding="utf-8")


def test_links_lead_somewhere():
    for page in PAGES.glob("*.md"):
        for target, anchor in re.findall(r"\]\(([\w./]*)(?:#([\w-]+))?\)", page.read_text(encoding="utf-8")):
            other = PAGES / target if target else page
            assert other.exists(), (page.name, target)
            titles = re.findall(r"^#+ (.*)$", other.read_text(encoding="utf-8"), re.MULTILINE)
            anchors = {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}
            assert not anchor or anchor in anchors, (page.name, target, anchor)


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_example_runs_and_keeps_its_energy(example, name):
    log = example(name)
    assert log.runs and "WARNING" not in log.text
    for run in log.runs:
        assert np.abs(run["v_balance"]).max() < 1e-6
        # all checks in the script are differences relative to the input energy
        for column in ("v_drift", "v_local_stored", "v_local_lost", "v_shared"):
            assert np.abs(run.get(column, np.zeros(1))).max() < 1e-12, column


def test_second_collision_finds_the_dent(example):
    log = example("two_collisions")
    first = log.runs[0]
    assert first["c_lost[2]"][-1] == 1 and 0.2 < first["c_lost[1]"][-1] / first["c_kinetic"][0] < 0.9
    assert log.printed("restitution of the second collision") == pytest.approx(1.0, abs=1e-6)
    assert log.printed("dissipated by the second collision") == pytest.approx(0.0, abs=1e-9)


def test_unlike_spheres_all_touch_and_yield(example):
    run = example("unlike_lj").runs[0]
    assert run["c_lost[2]"][-1] == 3  # all contacts except those of a Hertzian law
    assert run["c_lost[1]"][-1] > 0.1 * run["c_kinetic"][0]
    assert run["PotEng"][-1] == 0.0  # separated


def test_restart_repeats_the_run(example):
    log = example("restart")
    straight, repeated = log.runs[1], log.runs[2]
    assert straight["f_top[5]"][-1] > 0 and straight["PotEng"][0] > 0  # the file was written during a collision
    for column, values in straight.items():
        assert repeated[column] == pytest.approx(values, rel=1e-10, abs=1e-12), column
    for what in ("dissipated energy", "wall dissipation", "rebound speed"):
        assert abs(log.printed(f"change of {what}")) < 1e-10


def test_walls_take_the_momentum_and_keep_the_dents(example, tmp_path):
    run = example("between_walls").runs[0]
    assert run["f_floor[6]"][-1] == run["f_ceiling[6]"][-1] == 1
    lost = run["f_floor[5]"] + run["f_ceiling[5]"]
    # after the first impact on each, dissipation is due only to the effect of the timestep on the overlap
    assert lost[-1] == pytest.approx(lost[len(lost) // 2], rel=1e-6) and lost[-1] > 0
    _, floor, ceiling, momentum = np.loadtxt(tmp_path / "impulse.txt").T
    assert floor.min() < 0 < ceiling.max() and floor.max() <= 0 <= ceiling.min()
    given = np.sum((floor + ceiling)[:-1] + (floor + ceiling)[1:]) / 2 * 1e-8
    assert given == pytest.approx(momentum[0] - momentum[-1], abs=1e-9 * abs(momentum[0]))
    changes = np.diff(np.sign(momentum[np.abs(momentum) > 0.1 * abs(momentum[0])]))
    assert np.count_nonzero(changes) >= 4  # impacts
    state = table(tmp_path / "state.dump")[0]
    assert state[5] == pytest.approx(run["f_floor[5]"][-1], rel=1e-12)
    assert 0 < state[6] < state[8] < state[7] < state[14]  # touch, yield and peak on the floor, then the ceiling


def test_spheres_share_the_loss(example, tmp_path):
    run = example("per_sphere").runs[0]
    grains = table(tmp_path / "grains.dump")
    assert grains[:, 4].sum() == pytest.approx(run["c_lost[1]"][-1], rel=1e-12)
    assert grains[:, 2].max() == pytest.approx(run["c_lost[5]"][-1], rel=1e-12)
    assert grains[:, 5].tolist() == [1, 2, 2, 1]
    assert np.all(grains[:, 7] <= grains[:, 9]) and np.all(grains[:, 9] <= grains[:, 8])  # touch, yield, peak
    assert np.all(np.diff(grains[1:, 7]) > 0)  # the wave arrives in order


@pytest.mark.parametrize("ranks", [1, 2])
def test_contacts_of_a_packing_on_any_number_of_processors(example, tmp_path, ranks):
    run = example("per_contact", ranks).runs[0]
    dents = table(tmp_path / "dents.dump")
    dents = dents[np.lexsort((dents[:, 1], dents[:, 0]))]
    assert np.abs(run["v_balance"]).max() < 1e-6
    assert dents[:, 7].sum() == pytest.approx(run["c_lost[1]"][-1], rel=1e-10)
    assert np.count_nonzero(dents[:, 10] >= 0) == run["c_lost[2]"][-1]
    assert np.all(dents[:, 0] < dents[:, 1])
    assert len(np.unique(dents[:, :2], axis=0)) == len(dents)  # each dent once
    assert dents[:3, 0].tolist() == [1, 1, 1] and dents[:, 5].max() == pytest.approx(run["c_lost[5]"][-1], rel=1e-12)


def test_loop_area_is_the_dissipated_energy(example, tmp_path):
    run = example("probe").runs[0]
    overlap, force, peak, stored, lost = np.loadtxt(tmp_path / "contact.txt")[:, 1:].T
    area = np.sum((force[1:] + force[:-1]) / 2 * np.diff(overlap))
    assert area == pytest.approx(lost[-1], rel=1e-4)
    assert lost[-1] == pytest.approx(run["c_lost[1]"][-1], rel=1e-12) and stored[-1] == 0
    assert peak[-1] == overlap.max() and force[overlap <= 0].max() == 0


def test_energies_summed_when_asked_for_are_those_of_the_tally(example):
    run = example("energy").runs[0]
    for number in ("", *(f"[{n}]" for n in range(1, 6))):
        assert run[f"c_now{number}"].tolist() == run[f"c_tallied{number}"].tolist()
    assert run["c_now[1]"][-1] > 0


def test_the_cylinder_that_slid_rolls(example):
    log = example("rolling")
    assert log.runs[-1]["v_surface"][-1] == pytest.approx(0.05 * 2 / 3, rel=1e-3)
    assert log.printed("speed at the end, m/s") == pytest.approx(0.05 * 2 / 3, rel=1e-3)


def test_the_holder_stops_the_bead_that_was_hit(example):
    """All of the impact's energy ends in the holder, most of it behind the second bead."""
    log = example("holder")
    run = log.runs[0]
    given = 0.5 * 7925 * np.pi / 6 * 0.01**3 * 0.05**2
    assert run["f_holder"][-1] == pytest.approx(given, rel=1e-6) and run["c_kinetic"][-1] < 1e-20 * given
    assert log.printed("path over that of the formula") == pytest.approx(1.0, abs=5e-3)
