"""Plans: size, memory and time of a run and of a scan before the start, and remaining work of a
scan in progress.
"""

from __future__ import annotations

import dataclasses
import logging
import time
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs import plan
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.columns import SNAPSHOT, recorded, sources
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.cost import numbers_in_snapshot
from granwave.lammps_inputs.planning.plan import Plan, check_memory
from granwave.workflows.cli.tables.plan_table import plan_table
from granwave.workflows.cluster.profile import Profile
from granwave.workflows.run.progress import Progress
from granwave.workflows.scanning import batches
from granwave.workflows.scanning.batches import Machine, Outlook
from granwave.workflows.scanning.engine import request_of
from granwave.workflows.scanning.scan_file import ScanPoint
from tests.helpers.made_up.scan_texts import SMALL, reader

SETTLED = {"kind": "uniaxial", "pressure": 1e5}
PERIODIC = {"sides": "periodic"}


def make(size: Any = (12, 12, 8), packing: dict[str, Any] | None = None, **tables: Any) -> Case:
    table = {"kind": "fcc", "size": list(size), "diameter": 0.01, **(packing or {})}
    return case_from_dict({"name": "test", "packing": table, "material": "brass", **tables})


def steps(**tables: Any) -> float:
    """Expected wall-clock time of a timestep, s."""
    found = plan(make(**tables))
    return found.times.most_steps / (found.schedule.n_steps / found.schedule.first_step)


# ---------------------------------------------------------------------- a run


def test_the_reference() -> None:
    usual = plan(make((6, 6, 4)))
    assert usual.limit is None and not usual.slowness
    found = plan(make((72, 72, 30), run={"timestep": 1e-7}))
    assert (found.n_spheres, found.n_contacts, found.schedule.n_steps) == (155_520, 902_165, 10_000)
    assert found.peak_overlap_yield == pytest.approx(48.9, abs=0.1)
    hertz = plan(make((72, 72, 30), run={"timestep": 1e-7}, contact={"law": "hertz"}))
    assert hertz.times.steps == pytest.approx(
        155_520 * 10_000 * 55e-9, rel=0.1
    )  # 59 ns measured on two cores
    assert 1.001 < found.times.steps / hertz.times.steps < 1.5  # some contacts yield
    assert hertz.peak_overlap_yield is None
    assert (
        plan(make((72, 72, 30), run={"timestep": 1e-7}), n_ranks=2).times.steps
        == found.times.steps / 2
    )


def test_what_makes_a_step_longer() -> None:
    """Times per step: 1152 spheres 57 us elastic, 84 at 20 m/s, 91 with friction; 640 spheres under
    a load 70 and 125 us.
    """
    hertz = {"law": "hertz"}
    elastic = steps(contact=hertz)
    assert 1.3 < steps(contact={**hertz, "friction": 0.3}) / elastic < 2
    assert 1.1 < steps(load={"velocity": 20}) / elastic < 1.6
    loaded = steps(contact=hertz, precompression=SETTLED, boundary=PERIODIC)
    assert 1.2 < loaded / elastic < 2.5
    assert (
        1.7
        < steps(contact={**hertz, "friction": 0.3}, precompression=SETTLED, boundary=PERIODIC)
        / loaded
        < 2.7
    )


def test_figures_and_what_is_recorded_count() -> None:
    with_figures = plan(make())
    without = plan(make(), figures=False)
    assert (
        with_figures.wall_time - without.wall_time == with_figures.times.figures > 3
        and not without.times.figures
    )
    as_png = plan(make(figures={"formats": []}))
    assert with_figures.times.figures == pytest.approx(1.45 * as_png.times.figures)
    many = plan(make(run={"frames": 200}), figures=False)
    assert many.times.rest > 1.5 * without.times.rest and many.times.steps == without.times.steps


def test_the_static_stage_of_a_lattice_is_known_and_that_of_disorder_is_not() -> None:
    assert plan(make()).times.static == 0
    orderly = make(precompression=SETTLED, boundary=PERIODIC)
    times = plan(orderly).times
    assert 0 < times.static == times.most_static < times.steps
    assert "static stage  " not in plan_table(assemble(orderly), plan(orderly))
    for packing, contact in (({"diameter_scatter": 1e-6}, {}), ({}, {"initial_overlap": 1e-6})):
        case = make(packing=packing, contact=contact, precompression=SETTLED, boundary=PERIODIC)
        found = plan(case).times
        assert found.most_static > found.static > times.static
        assert "unpredictable in a disordered packing: up to" in plan_table(
            assemble(case), plan(case)
        )


def test_runs_that_end_by_themselves_are_not_planned_to_their_limit() -> None:
    def planned(**contact: Any) -> Plan:
        return plan(make(run={"end_time": "auto"}, contact=contact))

    plastic = planned()
    elastic = planned(law="hertz")
    assert elastic.times.steps < plastic.times.steps < plastic.times.most_steps / 5
    text = plan_table(assemble(make(run={"end_time": "auto"})), plastic)
    assert "expected time          about" in text and "at most" in text.split("expected time")[1]
    given = plan(make(run={"timestep": 2.9e-8}))
    assert given.times.longest == given.wall_time
    assert (
        plan(make()).wall_time < plan(make()).times.longest <= given.wall_time * 1.01
    )  # as many steps, at most


# ---------------------------------------------------------------------- a scan


@pytest.fixture
def points(tmp_path: Path) -> list[ScanPoint]:
    """Six points, the last of which is expected to take longest."""
    scan = reader(tmp_path)(
        SMALL
        + "[grid]\nload.velocity = [1, 2, 3, 4, 5]\n[[points]]\nload.spheres = 3\nrun.frames = 400\n"
    )
    return list(scan.points)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Clock that advances only when it is set."""
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    return now


def test_a_scan_takes_its_points_and_what_is_around_them(points: list[ScanPoint]) -> None:
    alone = sum(point.plan.wall_time for point in points)
    assert alone + 4 < Machine(1).time(points) < alone + 40
    assert Machine(2, None, 50).time(points) < Machine(1, None, 50).time(points)
    assert Machine(100, None, 50).time(points) > 50 * points[-1].plan.wall_time
    assert Machine(2).time([]) == batches.PUBLISH
    assert Machine(1, Profile()).time(points) > Machine(1).time(points)


def test_ranks_share_the_cores_of_this_machine(points: list[ScanPoint]) -> None:
    both = [dataclasses.replace(point, ranks=2) for point in points]
    assert Machine(2, None, 50).time(both) > 1.5 * Machine(2, None, 50).time(points)
    assert Machine(2, Profile(), 50).time(both) < 1.5 * Machine(2, Profile(), 50).time(points)


def test_a_job_may_last_as_long_as_its_points_can(tmp_path: Path) -> None:
    small = SMALL.replace("run.end_time = 5e-5", 'run.end_time = "auto"')
    scan = reader(tmp_path)(
        small + "packing.diameter_scatter = 1e-6\n[grid]\nload.velocity = [1, 2]\n"
    )
    batch = Machine(1, slowness=1e4).batches(scan.points, "")[0]
    assert batch.longest > 3 * batch.wall_time  # 100 blocks, and first timesteps all along
    assert request_of(Profile(), batch, "", tmp_path).minutes * 60 >= batch.longest


def test_until_a_point_is_done_the_plan_is_shown(
    points: list[ScanPoint], clock: list[float]
) -> None:
    outlook = Outlook(points, Machine(2, slowness=100.0))
    clock[0] = 101.0
    soon = outlook.text(points, {})
    clock[0] = 130.0
    assert soon.startswith("1 s of about ") and outlook.text(points, {}) == f"30{soon[1:]}"
    clock[0] = 1e6
    assert ", longer than the planned " in outlook.text(points, {}) and outlook.text(
        [], {}
    ).endswith("are next")


def test_then_the_points_that_are_done_tell(points: list[ScanPoint], clock: list[float]) -> None:
    fresh = Outlook(points[1:], Machine(1))
    fresh.done(points[0], 1e6)  # of an earlier start, which does not tell
    assert fresh.text(points[1:], {}).startswith("0 s of about ")
    outlook = Outlook(points, Machine(1))
    first, *others, longest = points
    clock[0] += 70
    outlook.done(first, 100 * first.plan.wall_time)
    left = (
        100 * (sum(point.plan.wall_time for point in others) + longest.plan.wall_time)
        + batches.PUBLISH
    )
    assert outlook.text([*others, longest], {}) == f"70 s, about {left / 60:.0f} min left"
    ages = {
        longest.id: 100 * longest.plan.wall_time,
        others[0].id: 1e9,
    }  # nothing is subtracted twice
    left = 100 * sum(point.plan.wall_time for point in others[1:]) + batches.PUBLISH
    assert outlook.text([*others, longest], ages) == f"70 s, about {left:.0f} s left"
    assert outlook.text([], {}) == "70 s; table, figures and report are next"


@pytest.mark.parametrize(
    ("at_most", "updates", "said"),
    [
        (False, [(20, 3, ""), (20, 5, ""), (0, 6, ""), (0, 10, "60 s of about 2 min")],
         ["50 % there [40 s, about 40 s left]", "100 % there [60 s of about 2 min]"]),
        (True, [(20, 3, ""), (20, 5, "")], ["50 % there [40 s, at most 40 s left]"]),
        (False, [(20, 10, "last")], ["100 % there [20 s]"]),
        (True, [(20, 4, "last")], ["100 % there [20 s]"]),  # it settled early: nothing is left
    ],
)  # fmt: skip
def test_lines_of_a_log(
    at_most: bool, updates: list[tuple[int, int, str]], said: list[str], clock: list[float],
    caplog: pytest.LogCaptureFixture,
) -> None:  # fmt: skip
    caplog.set_level(logging.INFO)
    bar = Progress(10, "mine", enabled=True, at_most=at_most)
    for seconds, done, words in updates:
        clock[0] += seconds
        if words == "last":
            bar.update(done, "there", last=True)
        else:
            bar.update(done, "there", *filter(None, [words]))
    bar.close()
    assert [" ".join(record.getMessage().split()) for record in caplog.records] == [
        f"mine {line}" for line in said
    ]


def test_memory_of_each_rank() -> None:
    """The steps are divided among the ranks; in the analysis each rank holds a part, and the first
    rank the combined data.
    """
    check_memory(plan(make()))
    with pytest.raises(
        InputError,
        match=r"spheres require about .* GiB of memory; available: 0.1 "
        r"GiB",
    ):
        check_memory(plan(make()), available=1e8)
    case = make(packing={"size": [120, 120, 60]})
    one = plan(case)
    four = plan(case, n_ranks=4)
    assert one.memory == one.first_rank and one.disk == four.disk
    assert four.memory == four.first_rank + 3 * four.other_rank
    assert four.other_rank < min(four.first_rank, one.other_rank)
    deep = make(packing={"size": [120, 120, 600]})
    # of few spheres, so that a part of the analysis needs more than steps and checkpoints
    of_part = plan(case, n_ranks=16).other_rank
    assert plan(deep, n_ranks=100).other_rank == pytest.approx(of_part, rel=0.01)
    assert plan(deep, n_ranks=100).other_rank < 1e9
    assert plan(make(contact={"friction": 0.3})).memory >= plan(make()).memory
    assert "first rank, which collects the results" in plan_table(assemble(case), four)
    assert "first rank" not in plan_table(assemble(case), one)


def test_long_runs_need_memory_for_a_checkpoint() -> None:
    """LAMMPS collects it in memory; a run that ends before the first one needs none."""
    size = {"size": [120, 120, 60]}
    short = plan(make(packing=size, run={"end_time": 1e-6}))
    long = plan(make(packing=size))
    assert short.times.most_steps < 30 < long.times.most_steps
    records = long.n_contacts * 160
    assert long.memory > short.memory + short.n_spheres * 232 + 2 * records


def test_ranks_that_analyse_fit_into_the_memory_of_the_run() -> None:
    """The size of a part of the packing does not decrease with the number of ranks, so that fewer
    ranks have one.
    """
    case = make(packing={"size": [220, 220, 207]})
    few = plan(case, n_ranks=8)
    many = plan(case, n_ranks=128)
    assert few.n_analysing == 8
    assert 8 < many.n_analysing < 128
    others = (many.n_analysing - 1) * many.other_rank + (128 - many.n_analysing) * many.idle_rank
    assert many.memory == many.first_rank + others
    assert many.memory < 128 * 1e9
    assert "each rank without analysis" in plan_table(assemble(case), many)


def test_one_timestep_of_a_contact_in_packings_of_any_height() -> None:
    """The pulse that reaches the wall is weaker in a higher packing; the spheres are the same."""
    steps = [plan(make(packing={"size": [8, 8, layers]})).allowed for layers in (3, 10, 40, 120)]
    assert steps == pytest.approx([steps[0]] * 4, rel=1e-12)
    alone = plan(make(packing={"size": [8, 8, 3]})).schedule.first_timestep
    assert 0.8 < alone / steps[0] <= 1.0


def test_loads_far_above_the_cut_off(caplog: pytest.LogCaptureFixture) -> None:
    """A steel chain under 20 N transmits waves up to 2 sqrt(k/m)/(2 pi) = 19.8 kHz; the estimate is
    within 15 % of it.
    """

    def planned(frequency: float) -> None:
        table = {
            "name": "row", "material": "steel", "packing": {"kind": "chain", "size": 8, "diameter": 0.01},
            "contact": {"law": "hertz"}, "precompression": {"kind": "uniaxial", "force": 20.0},
            "load": {"kind": "force", "shape": "harmonic", "amplitude": 0.1, "frequency": frequency},
            "run": {"end_time": 2e-3}, "output": {"history": 0},
        }  # fmt: skip
        plan(case_from_dict(table))

    with caplog.at_level(logging.WARNING, "granwave"):
        planned(4.3 * 19.8e3)
    assert not caplog.messages
    with caplog.at_level(logging.WARNING, "granwave"):
        planned(5.8 * 19.8e3)
    (message,) = caplog.messages
    assert "load.frequency: found 114840 Hz" in message
    with pytest.raises(
        InputError,
        match=r"load.frequency: found 1e\+07 Hz, 461 times .* expected at most 100 times",
    ):
        planned(1e7)


TINY = {"kind": "force", "shape": "half-sine", "amplitude": 100.0}


@pytest.mark.parametrize(
    ("changes", "cause", "remedy"),
    [
        ({"load": TINY | {"duration": 1e-9}}, "load.duration = 1e-09 s", "a longer load"),
        (
            {"load": {"kind": "force", "shape": "noise", "amplitude": 1.0, "duration": 1e-3, "frequency": 1e3,
                      "last_frequency": 1e9}},
            "load.last_frequency = 1e+09 Hz", "a lower frequency",
        ),
        ({"contact": {"loss": {"dashpot": 3e4}}}, "contact.loss", "a smaller loss"),
        (
            {"contact": {"friction": 0.3, "loss": {"dashpot": 100.0, "tangential": 100.0}}},
            "contact.loss.tangential", "less damping",
        ),
        ({"replace": [{"index": [5], "diameter": 1e-6}]}, "a contact of R* = 5e-07 m", "larger grains"),
        ({"load": {"kind": "plate", "mass": 1e-11}}, "load.mass = 1e-11 kg", "a heavier plate"),
        ({"boundary": {"bottom": {"plate": {"mass": 1e-10, "stiffness": 1e6}}}}, "boundary.bottom", "a heavier or softer"),
        (
            {"boundary": {"bottom": {"damper": {"damping": 0.1}}}},
            "boundary.bottom", "more damping",
        ),
    ],
)  # fmt: skip
def test_what_makes_steps_short_is_told(changes: dict[str, Any], cause: str, remedy: str) -> None:
    planned = plan(make((6, 6, 4), **({"run": {"end_time": 1e-3}} | changes)))
    assert planned.limit is not None and planned.limit.cause.startswith(cause)
    assert planned.limit.step == pytest.approx(planned.schedule.first_timestep, rel=0.1)
    assert planned.allowed > 10 * planned.limit.step
    assert cause in planned.slowness and remedy in planned.slowness


def test_too_many_steps_name_their_cause() -> None:
    with pytest.raises(
        InputError, match=r"are more than 2e\+09 steps; .* load\.duration = 1e-11 s limits"
    ):
        plan(make((6, 6, 4), run={"end_time": 1e-3}, load=TINY | {"duration": 1e-11}))


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"contact": {"friction": 0.3}},
        {"contact": {"loss": {"dashpot": 100.0}}},
        {"output": {"contact_forces": True}},
    ],
)
def test_numbers_in_a_snapshot_are_those_of_the_script(changes: dict[str, Any]) -> None:
    case = make(**changes)
    columns = sources(SNAPSHOT, *recorded(case))
    assert numbers_in_snapshot(case) == len(columns)
