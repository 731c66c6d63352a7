"""Decks: the timestep's scaling, the schedule, the data file and the input script."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs import (
    auto_timestep,
    build_packing,
    expected_peak_overlap,
    flat_contact,
    make_schedule,
    write_deck,
)
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.deck.script import part
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict, load_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.arrival import expected_arrival
from granwave.lammps_inputs.planning.timestep import largest_timestep
from granwave.workflows.library import load_case as built_in_case


def make(size: Any = (6, 6, 4), kind: str = "fcc", diameter: float = 0.01, **sections: Any) -> Case:
    size = list(size) if isinstance(size, tuple) else size
    packing = {"kind": kind, "size": size, "diameter": diameter}
    return case_from_dict({"name": "test", "packing": packing, "material": "brass", **sections})


class TestTimestep:
    def test_reference(self) -> None:
        assert auto_timestep(make((72, 72, 30))) == pytest.approx(29e-9, rel=1e-12)

    def test_proportional_to_the_diameter(self) -> None:
        for diameter in (0.001, 0.1):
            assert auto_timestep(make(diameter=diameter)) == pytest.approx(
                auto_timestep(make()) * diameter / 0.01
            )

    def test_hertz_overlap_of_two_spheres(self) -> None:
        # m v^2/4 = (8/15) E* sqrt(R*) alpha^2.5
        case = make(contact={"law": "hertz"})
        law = sphere_contact(case)
        energy = case.sphere_mass * 25 / 4
        exact = (15 * energy / (8 * law.effective_modulus * law.effective_radius**0.5)) ** 0.4
        assert expected_peak_overlap(case) == pytest.approx(exact, rel=1e-9)

    def test_invariance_with_density_and_velocity(self) -> None:
        # the overlaps depend on rho v^2 only, so that all times are proportional to sqrt(rho)
        slow = make(material={"preset": "brass", "density": 4 * 8500}, load={"velocity": 2.5})
        assert expected_peak_overlap(slow) == pytest.approx(expected_peak_overlap(make()))
        assert auto_timestep(slow) == pytest.approx(
            2 * auto_timestep(make()), rel=0.02
        )  # two significant digits

    def test_harder_impacts_need_shorter_steps(self) -> None:
        steps = [
            auto_timestep(make(load={"velocity": velocity})) for velocity in (0.1, 1, 5, 20, 75)
        ]
        assert steps == sorted(steps, reverse=True) and steps[-1] > 10e-9

    def test_a_rigid_wall_that_is_hit_directly_counts(self) -> None:
        assert auto_timestep(make((3, 3, 1))) < auto_timestep(
            make((3, 3, 1), boundary={"bottom": "free"})
        )
        spheres = sphere_contact(make())
        wall = flat_contact(make(), 1)
        assert wall.effective_modulus == pytest.approx(2 * spheres.effective_modulus)
        assert wall.effective_radius == pytest.approx(2 * spheres.effective_radius)


class TestSchedule:
    def test_ends_exactly_and_on_the_ledger(self) -> None:
        for end_time in (1e-5, 3.3e-4, 1e-3, 7.77e-3):
            schedule = make_schedule(make(run={"end_time": end_time}))
            assert schedule.end_time == pytest.approx(end_time, rel=1e-12)
            assert schedule.first_timestep <= auto_timestep(make()) * (1 + 1e-12)
            assert schedule.n_steps % schedule.ledger_every == 0
            assert 500 <= schedule.n_steps // schedule.ledger_every <= 1000

    @pytest.mark.parametrize(
        "changes",
        [
            {},
            {"run": {"end_time": "auto"}},
            {"run": {"end_time": 3e-6}},
            {"run": {"frames": 1000}},
            {"output": {"probes": [{"sphere": 1}], "probe_interval": 3e-7}},
        ],
    )
    def test_records_fall_on_multiples_of_the_longest_step(self, changes: dict[str, Any]) -> None:
        schedule = make_schedule(make(**changes))
        longest = schedule.longest_step
        assert (
            longest in (4, 8, 16, 32)
            and schedule.first_step == 4
            and schedule.energy_tolerance == 3e-6
        )
        intervals = (
            schedule.ledger_every,
            schedule.wall_every,
            schedule.probe_every,
            schedule.block_steps,
        )
        for counts in (schedule.n_steps, *intervals, schedule.frame_every, *schedule.frame_steps):
            assert counts % longest == 0
        interval = changes.get("output", {}).get(
            "probe_interval", schedule.probe_every * schedule.timestep
        )
        assert (
            abs(schedule.probe_every * schedule.timestep - interval)
            <= 0.5 * schedule.first_timestep
        )

    def test_bounds_of_an_automatic_timestep(self) -> None:
        plain, least, most, short, fine = (
            make_schedule(make(run=run))
            for run in (
                {}, {"smallest_timestep": 2e-8}, {"largest_timestep": 1e-7}, {"largest_timestep": 1e-8},
                {"energy_tolerance": 3e-8},
            )
        )  # fmt: skip
        assert plain.largest_timestep == pytest.approx(8 * plain.first_timestep)
        assert plain.timestep == pytest.approx(plain.first_timestep / 4)
        assert 0.99 * 2e-8 <= least.timestep == least.first_timestep
        assert 0.5e-7 < most.largest_timestep <= 1e-7
        assert short.largest_timestep == short.first_timestep <= 1e-8
        assert fine.first_timestep == pytest.approx(plain.first_timestep / 10, rel=0.05)
        for name in ("split-hopkinson", "intruder"):  # a bar, and a support
            bound = largest_timestep(assemble(built_in_case(name)))
            assert make_schedule(built_in_case(name)).largest_timestep <= bound * (1 + 1e-9) < 1e-3

    @pytest.mark.parametrize("timestep", [1e-7, 2e-7, 3.3e-8, 9.999e-8])
    def test_a_given_timestep_is_kept(self, timestep: float) -> None:
        schedule = make_schedule(make(run={"timestep": timestep}))
        assert schedule.timestep == timestep == make_schedule(make(), timestep).timestep
        assert 1e-3 * (1 - 1e-9) <= schedule.end_time < 1e-3 * (1 + 5e-4) + timestep
        assert schedule.n_steps % schedule.ledger_every == 0
        assert 250 <= schedule.n_steps // schedule.ledger_every <= 1000

    def test_few_long_steps(self) -> None:
        schedule = make_schedule(make(run={"timestep": 4e-4}))
        assert (schedule.n_steps, schedule.ledger_every, schedule.probe_every) == (3, 1, 3)

    def test_frames_by_number_share_and_time(self) -> None:
        for n, found in [(20, 20), (6, 6), (2, 2), (1, 2), (501, 501)]:
            assert make_schedule(make(run={"frames": n})).n_frames == found
        assert make_schedule(make(run={"frames": 6, "timestep": 1e-7})).frame_every == 2000
        for end in (1e-3, 3e-4):
            run = {"end_time": end, "timestep": 1e-7}
            shares = ["0 %", "12.5 %", "50%", "100 %"]
            times = [0.0, 0.125 * end, 0.5 * end, end]
            case = make(run={**run, "frames": shares})
            assert make_schedule(case) == make_schedule(make(run={**run, "frames": times}))
            assert case.to_dict()["run"]["frames"] == shares
        listed = make_schedule(make(run={"frames": [0.0, 1.23e-4, 9.99e-4], "timestep": 1e-7}))
        assert listed.frame_steps == (1230, 9990, 10000)

    def test_blocks(self) -> None:
        schedule = make_schedule(make(run={"end_time": "auto", "frames": 20}))
        assert schedule.block_steps * schedule.timestep == pytest.approx(50e-6, rel=1e-12)
        assert schedule.n_steps == 100 * schedule.block_steps
        assert 250 <= schedule.block_steps // schedule.ledger_every <= 500
        assert schedule.block_steps % schedule.probe_every == 0
        assert schedule.frame_every * schedule.timestep == pytest.approx(50e-6)

    @pytest.mark.parametrize(("film", "n", "dense"), [("none", 20, 13), ("mp4", 60, 39)])
    @pytest.mark.parametrize("end_time", [1e-3, "auto"])
    def test_two_thirds_of_the_snapshots_follow_the_wave(
        self, film: str, n: int, dense: int, end_time: float | str
    ) -> None:
        """Default snapshots: evenly spaced until the wave reaches the bottom, and evenly spaced to
        the end; without a known end as if it were at 1 ms, up to the latest possible time.
        """
        case = make(run={"end_time": end_time}, figures={"film": film})
        schedule = make_schedule(case)
        steps = np.array([0, *schedule.frame_steps])
        times = steps * schedule.timestep
        arrival = expected_arrival(assemble(case))
        assert arrival is not None and not schedule.frame_every
        unit = schedule.longest_step * schedule.timestep
        assert times[dense] == pytest.approx(1.1 * arrival, abs=unit)
        assert times[n - 1] == pytest.approx(1e-3, abs=unit)
        apart = np.diff(times[:-1])
        assert apart[:dense] == pytest.approx(1.1 * arrival / dense, abs=1.01 * unit)
        assert apart[dense:] == pytest.approx(
            (1e-3 - 1.1 * arrival) / (n - 1 - dense), abs=1.01 * unit
        )
        assert len(times) == n if end_time == 1e-3 else steps[-1] == schedule.n_steps

    def test_a_number_of_snapshots_and_times_are_as_asked_for(self) -> None:
        even = make_schedule(make(run={"frames": 21, "end_time": 1e-3, "timestep": 1e-7}))
        assert (even.frame_every, even.n_frames) == (500, 21)
        listed = make_schedule(make(run={"frames": [1e-4, 3e-4], "timestep": 1e-7}))
        assert listed.frame_steps == (1000, 3000, 10_000)

    def test_snapshots_are_evenly_spread_where_no_wave_comes_first(self) -> None:
        """The wave travels for most of the run, or its arrival is not known."""
        short = make_schedule(make(run={"end_time": 6e-5, "timestep": 1e-7}))
        assert np.ptp(np.diff([0, *short.frame_steps])) <= 1
        square = make_schedule(make((6, 6), "square", run={"timestep": 1e-7}))
        assert square.frame_every or np.ptp(np.diff([0, *square.frame_steps])) <= 1

    def test_probe_interval(self) -> None:
        assert (
            make_schedule(make(run={"timestep": 1e-7}, output={"probe_interval": 1e-6})).probe_every
            == 10
        )
        finest = make_schedule(make(output={"probes": [{"sphere": 1}], "probe_interval": 1e-12}))
        assert finest.probe_every == finest.longest_step == finest.first_step


@pytest.mark.parametrize("sides", ["free", "periodic"])
def test_data_files_keep_every_digit_and_the_period(tmp_path: Path, sides: str) -> None:
    case = make(boundary={"sides": sides})
    text = write_deck(case, tmp_path / "run").data.read_text()
    rows = np.array(
        [line.split() for line in text.partition("Atoms #")[2].splitlines()[2:]], dtype=float
    )
    np.testing.assert_array_equal(rows[:, 0], np.arange(1, 145))
    np.testing.assert_array_equal(rows[:, 1:4], np.tile([1, 0.01, 8500], (144, 1)))
    np.testing.assert_array_equal(rows[:, 4:], build_packing(case).positions)
    if sides == "periodic":
        box = {
            m[3]: float(m[2]) - float(m[1])
            for m in re.finditer(r"^(\S+) (\S+) (.)lo .hi$", text, re.M)
        }
        assert (box["x"], box["y"]) == pytest.approx(assemble(case).lattice.lengths, rel=1e-14)


class TestDeck:
    def test_what_is_written(self, tmp_path: Path) -> None:
        directory = tmp_path / "a b" / "run"
        deck = write_deck(make(boundary={"sides": "wall"}), directory, timestep=5e-8)
        found = sorted(path.name for path in directory.iterdir())
        assert found == [".granwave", "case.toml", "data.granwave", "dumps", "in.granwave"]
        assert load_case(directory / "case.toml") == deck.case
        resolved = tomllib.loads((directory / "case.toml").read_text())["resolved"]
        assert resolved["timestep"] == deck.schedule.timestep == 5e-8
        assert resolved["n_contacts"] == assemble(deck.case).lattice.n_contacts
        assert resolved["struck"] == list(deck.struck)
        assert resolved["walls"] == ["bottom", "xlo", "xhi", "ylo", "yhi"]

    def test_nothing_half_written(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        def fail(*_: object) -> None:
            raise KeyboardInterrupt

        monkeypatch.setattr("granwave.lammps_inputs.deck.deck.write_data", fail)
        with pytest.raises(KeyboardInterrupt):
            write_deck(make(), tmp_path / "run")
        assert list((tmp_path / "run").iterdir()) == []

    def test_a_file_in_the_way(self, tmp_path: Path) -> None:
        (tmp_path / "run").write_text("")
        with pytest.raises(InputError, match="cannot be written to"):
            write_deck(make(), tmp_path / "run")


def script(tmp_path: Path, **sections: Any) -> str:
    return write_deck(make(**sections), tmp_path).script.read_text()


STEEL = {"preset": "steel"}
PLATE = {"plate": {"mass": 0.1, "stiffness": 1e7, "damping": 20.0}}
CHAIN = {"size": 6, "kind": "chain"}
PULSE = {"kind": "force", "shape": "half-sine", "amplitude": 10.0, "duration": 1e-5}
MOVED = {"kind": "displacement", "shape": "harmonic", "amplitude": 1e-6, "frequency": 1e4}
LINES = [  # what is in the script of a case; spaces count as one
    (
        {"boundary": {"bottom": "fixed", "sides": "periodic"}},
        ["boundary p p m", "group held id 109:144", "fix motion mobile gran/nve",
         "variable bottom equal f_held[3]"],
    ),
    (
        {"boundary": {"sides": "wall", "bottom": "free"}},
        ["variable xlo equal -f_xlo[1]", "variable yhi equal f_yhi[2]", 'title2 "# step time xlo xhi ylo yhi"'],
    ),
    (
        {"output": {"probes": [{"sphere": 15}, {"contact": [15, 51]}]}},
        ["compute probe2 all gran/hysteretic/contact 15 51", "sphere_15_ux", "contact_15_51_overlap"],
    ),
    (
        {**CHAIN, "load": PULSE, "boundary": {"holder_friction": 0.25}},  # after all other forces
        ["fix holder all gran/holder z 0.25 9.81", "variable dissipated equal c_contact[1]+f_bottom[5]+f_holder"],
    ),
    (
        {**CHAIN, "load": MOVED, "boundary": {"holder_friction": 0.25, "bottom": "fixed"}},
        ["group loose subtract all held hit", "fix holder loose gran/holder"],
    ),
    (
        {"boundary": {"bottom": PLATE}},
        ["support 0.1 1e+07 20", 'title2 "# step time bottom bottom_displacement bottom_velocity bottom_ground_force"',
         "variable elastic equal c_contact+f_bottom[4]+f_bottom[12]",
         "variable dissipated equal c_contact[1]+f_bottom[5]+f_bottom[13]",
         "struck_velocity support support_lost target"],
    ),
    (
        {"replace": [{"index": [1, 2], "material": "steel"}], "boundary": {"bottom": PLATE}},
        # whose plane stays
        ["fix bottom species1 wall", "support 0.1", "fix bottom_2 species2 wall"],
    ),
]  # fmt: skip


class TestScript:
    @pytest.mark.parametrize(("sections", "lines"), LINES)
    def test_lines(self, sections: dict[str, Any], lines: list[str], tmp_path: Path) -> None:
        text = script(tmp_path, **sections)
        plain = " ".join(text.replace("&", "").split())
        assert [line for line in lines if line not in plain] == []
        fixes = re.findall(r"^fix +(\S+) (\S+) (\S+)", text, re.M)
        forces = [
            name
            for name, _, style in fixes
            if style in ("wall/gran/hysteretic", "gran/load", "gran/holder")
        ]
        assert "holder" not in forces or forces[-1] == "holder"
        assert ("probes.txt" in text) == ("output" in sections)

    def test_a_name_cannot_break_the_script(self, tmp_path: Path) -> None:
        case = case_from_dict({**make().to_dict(), "name": 'caf\u00e9 """ &'})
        assert write_deck(case, tmp_path).script.read_text().startswith("# caf? ??? ?\n# Impact")

    def test_frame_formula_steps_through_the_list(self, tmp_path: Path) -> None:
        text = script(
            tmp_path, run={"timestep": 1e-7, "frames": [1e-5 * n * n for n in range(1, 10)]}
        )
        formula = re.search(r'variable +frame equal &\n +"(.*?)"', text, re.S)
        assert formula
        code = formula[1].replace("&", "").replace("\n", "").replace(" ", "")
        step = 0
        found = []
        while step < 10000:
            step = eval(code, {"step": step})
            found.append(step)
        assert found == [100 * n * n for n in range(1, 10)] + [10000]

    def test_automatic_end_is_a_loop(self, tmp_path: Path) -> None:
        text = part(script(tmp_path, run={"end_time": "auto"}), "run")
        assert "variable        block loop 100\n" in text
        assert "jump            SELF next_block" in text

    def test_parts(self, tmp_path: Path) -> None:
        text = script(tmp_path, run={"timestep": 1e-7})
        assert "run " not in re.sub("#.*", "", part(text, "setup"))
        assert part(text, "run").split() == ["run", "10000"]
        assert "write_dump" in part(text, "end")
        with pytest.raises(ValueError, match="setup, run, end"):
            part(text, "middle")
        with pytest.raises(ValueError, match="lacks"):
            part("run 3\n", "run")


class TestMovingBottom:
    """Arguments of the fix of the bottom."""

    def test_half_space_under_the_footprint(self, tmp_path: Path) -> None:
        """Lysmer's analogue: 4 G r/(1 - nu) and 3.4 r^2 sqrt(rho G)/(1 - nu), with a disc of the
        area of a layer.
        """
        text = script(tmp_path, boundary={"bottom": {"half_space": {}, "material": STEEL}})
        words = re.search(r"support (\S+) (\S+) (\S+)$", text, re.M)
        assert words is not None
        shear = 210e9 / 2.6
        radius = np.sqrt(36 * 1e-4 * np.sqrt(3) / 2 / np.pi)
        expected = [0.0, 4 * shear * radius / 0.7, 3.4 * radius**2 * np.sqrt(7850 * shear) / 0.7]
        assert [float(word) for word in words.groups()] == pytest.approx(expected, rel=1e-12)

    @pytest.mark.parametrize(
        ("end", "word"),
        [("free", "free"), ("fixed", "fixed"), ("infinite", 1e-3 * np.sqrt(210e9 * 7850))],
    )
    def test_bar(self, tmp_path: Path, end: str, word: Any) -> None:
        bar = {"length": 2.0, "area": 1e-3, "elements": 50, "end": end}
        text = script(tmp_path, boundary={"bottom": {"bar": bar, "material": STEEL}})
        words = re.search(r"support bar (\S+) (\S+) (\S+) (\S+)$", text, re.M)
        assert words is not None
        assert [float(one) for one in words.groups()[:3]] == pytest.approx(
            [50, 7850 * 2e-3, 210e9 * 1e-3 / 0.04]
        )
        assert words[4] == word if end != "infinite" else float(words[4]) == pytest.approx(word)

    def test_light_plates_and_short_elements_need_short_steps(self) -> None:
        def step(bottom: Any) -> float:
            return auto_timestep(make(boundary={"bottom": bottom}))

        usual = step("wall")
        assert step({"plate": {"mass": 0.1, "stiffness": 1e7}}) == pytest.approx(usual, rel=0.1)
        assert step({"plate": {"mass": 1e-5, "stiffness": 1e7}}) < 0.3 * usual
        assert (
            step({"bar": {"length": 0.01, "area": 1e-3, "elements": 100}, "material": STEEL})
            < 0.5 * usual
        )

    def test_other_materials_than_the_plane_s_are_refused_in_the_last_layer(self) -> None:
        with pytest.raises(
            InputError, match=r"boundary.bottom: found a plate under spheres of brass and steel"
        ):
            make(replace=[{"index": 144, "material": "steel"}], boundary={"bottom": PLATE})
