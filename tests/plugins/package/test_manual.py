"""Manual pages of the LAMMPS styles: all complete examples run unmodified with plain ``lmp``, with
correct results.
"""

from __future__ import annotations

import re

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
    "fix_gran_absorb",
    "fix_gran_holder",
    "fix_gran_nve",
    "fix_gran_nve_sphere",
    "fix_gran_timestep",
    "compute_gran_hysteretic_atom",
    "compute_gran_hysteretic_local",
    "compute_gran_hysteretic_contact",
    "compute_gran_hysteretic_energy",
    "compute_gran_hysteretic_sums",
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


@pytest.fixture
def example(lmp, tmp_path):
    """Run a complete example in a separate directory."""

    def run(name: str) -> Log:
        (tmp_path / f"in.{name}").write_text(EXAMPLES[name][1], encoding="utf-8")
        done = lmp(tmp_path / f"in.{name}")
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
        for target, anchor in re.findall(
            r"\]\(([\w./]*)(?:#([\w-]+))?\)", page.read_text(encoding="utf-8")
        ):
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
    assert (
        first["c_lost[2]"][-1] == 1 and 0.2 < first["c_lost[1]"][-1] / first["c_kinetic"][0] < 0.9
    )
    assert log.printed("restitution of the second collision") == pytest.approx(1.0, abs=1e-6)
    assert log.printed("dissipated by the second collision") == pytest.approx(0.0, abs=1e-9)


def test_unlike_spheres_all_touch_and_yield(example):
    run = example("unlike_lj").runs[0]
    assert run["c_lost[2]"][-1] == 3  # all contacts except those of a Hertzian law
    assert run["c_lost[1]"][-1] > 0.1 * run["c_kinetic"][0]
    assert run["PotEng"][-1] == 0.0  # separated


def test_loop_area_is_the_dissipated_energy(example, tmp_path):
    run = example("probe").runs[0]
    overlap, force, peak, stored, lost = np.loadtxt(tmp_path / "contact.txt")[:, 1:].T
    area = np.sum((force[1:] + force[:-1]) / 2 * np.diff(overlap))
    assert area == pytest.approx(lost[-1], rel=1e-4)
    assert lost[-1] == pytest.approx(run["c_lost[1]"][-1], rel=1e-12) and stored[-1] == 0
    assert peak[-1] == overlap.max() and force[overlap <= 0].max() == 0


def test_half_the_sum_is_the_force_passed_on(example):
    run = example("sums").runs[0]
    assert run["c_left[2]"].max() > 0
    assert run["v_half"] == pytest.approx(run["c_left[2]"], rel=1e-9, abs=1e-9)
    walls = np.abs(run["f_low[3]"]) + np.abs(run["f_high[3]"])
    assert walls.max() > 0
    assert run["c_total"] == pytest.approx(4 * run["c_left[2]"] + walls, rel=1e-9, abs=1e-6)


def test_the_cylinder_that_slid_rolls(example):
    log = example("rolling")
    assert log.runs[-1]["v_surface"][-1] == pytest.approx(0.05 * 2 / 3, rel=1e-3)
    assert log.printed("speed at the end, m/s") == pytest.approx(0.05 * 2 / 3, rel=1e-3)


def test_the_holder_stops_the_bead_that_was_hit(example):
    """The guide dissipates all energy of the impact, most of it behind the second bead."""
    log = example("holder")
    run = log.runs[0]
    given = 0.5 * 7925 * np.pi / 6 * 0.01**3 * 0.05**2
    assert (
        run["f_holder"][-1] == pytest.approx(given, rel=1e-6)
        and run["c_kinetic"][-1] < 1e-20 * given
    )
    assert log.printed("path divided by the path of the formula") == pytest.approx(1.0, abs=5e-3)


def test_the_struck_row_moves_as_with_fix_nve(example, lmp, tmp_path):
    log = example("struck_row")
    speed = log.printed("speed of the last bead divided by the speed of the first bead")
    assert 0.9 < speed < 1.0
    (tmp_path / "in.nve").write_text(
        EXAMPLES["struck_row"][1].replace("gran/nve", "nve"), encoding="utf-8"
    )
    assert lmp(tmp_path / "in.nve").returncode == 0
    for name, column in Log(tmp_path / "log.lammps").runs[0].items():
        assert np.array_equal(column, log.runs[0][name]), name


def test_the_pages_state_the_format_of_restart_files():
    """The numbers in the code agree with the pages."""
    header = (PAGES.parent / "styles" / "pair_gran_hysteretic.h").read_text(encoding="utf-8")
    found = re.search(r"EARLIEST_RESTART_FORMAT = (\d+), RESTART_FORMAT = (\d+);", header)
    assert found is not None
    earliest, present = map(int, found.groups())
    assert earliest == present - 1  # the pages name a single earlier format
    manual = (PAGES / "pair_gran_hysteretic.md").read_text(encoding="utf-8")
    assert f"The format number is {present}; files of format {earliest} " in manual
    documents = PAGES.parents[1] / "docs"
    stays = (documents / "reference" / "what-stays.md").read_text(encoding="utf-8")
    assert f"(the pair style now {present}; format {earliest} is read as well)" in stays
