"""First sentences and values of reports on runs that are no simple impacts, and on results that are
no runs.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.document.model import Figure, Gallery, Note, text_table
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.leading_wave import FirstWave
from granwave.analysis.reports.answer import in_words
from granwave.analysis.reports.first_wave import course_in_words
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.kinds import GRANULAR, ReportRun
from granwave.analysis.reports.results import value_rows
from granwave.analysis.reports.setting import setting_of, symbols_note
from granwave.analysis.reports.used_symbols import uses_symbol
from granwave.analysis.summary_table import summary_table
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.result_directory import ResultDirectory
from tests.helpers.made_up.synthetic_report import blocks, build, write_run

MASS = 8500 * math.pi * 0.00952**3 / 6  # kg, a bead of the row


def run_with(case=None, **summary):
    return ReportRun("one", GRANULAR, ResultDirectory(Path()), "done", summary, case or {}, {})


def labels(run):
    return [row[0].text for row in value_rows(run).rows]


def test_a_driven_row():
    run = run_with(
        energy_input_J=2e-7, dissipated_fraction=0.95, absorbed_fraction=0.9, transmission=0.5,
        driven_velocity_m_s=4e-4, peak_reduction=20.0, impactor_velocity_m_s=1e-4,
    )  # fmt: skip
    words = in_words(run)
    assert words.startswith(
        "90 % of the input energy of 200 nJ was absorbed by the absorbing boundary. 5 % of the "
        "input energy of 200 nJ was "
    )
    assert "50 % of the velocity of the driven end, 400 µm/s, was transmitted." in words
    assert labels(run)[0] == "Transmission"
    assert not {"Peak reduction", "Impacted sphere or striker at the end"} & set(labels(run))


def test_the_sentence_on_the_zone_is_true_of_whole_layers():
    """90 % of the dissipation is within whole layers; less is within the interpolated depth."""
    run = run_with(
        energy_input_J=1.0, zone_depth_90_m=7.348e-3, zone_radius_90_m=5.196e-3,
        zone_depth_90_interpolated_m=5.299e-3, zone_radius_90_interpolated_m=4.804e-3,
    )  # fmt: skip
    assert (
        "90 % of the plastic dissipation is within 7.348 mm below the impact and 5.196 mm from its "
        "axis (whole layers and shells); interpolated between them, the 90 % depth is 5.299 mm and "
        "the 90 % radius 4.804 mm." in in_words(run)
    )
    old = run_with(energy_input_J=1.0, zone_depth_90_m=7.348e-3, zone_radius_90_m=5.196e-3)
    assert "is within 7.348 mm below the impact and 5.196 mm from its axis." in in_words(old)


def test_the_article_of_a_support():
    def case(material):
        bottom = {"material": {"name": material}, "plate": {"mass": 0.2}}
        return {"packing.kind": "sc", "packing.size": [9, 9, 8], "boundary.bottom": bottom}

    assert "on an aluminium plate of 0.2 kg" in setting_of(case("aluminium"))
    assert "on a steel plate of 0.2 kg" in setting_of(case("steel"))


def test_a_plate():
    run = run_with(
        energy_input_J=9.0,
        dissipated_fraction=0.3,
        plate_velocity_m_s=-3.5,
        impactor_velocity_m_s=-3.0,
    )
    assert "The plate rebounds at 3.5 m/s." in in_words(run)
    assert labels(run)[
        0
    ] == "Plate velocity at the end" and "Impacted sphere or striker at the end" not in labels(run)


@pytest.mark.parametrize(
    ("law", "shown"), [("elastoplastic", True), ("hertz", False), ("line", False)]
)
def test_values_of_yielding_where_the_law_yields(law, shown):
    run = run_with({"contact.law": law}, dissipated_fraction=0.0, n_plastic_contacts=0)
    assert ("Yielded contacts" in labels(run)) == shown


def test_a_target_comes_first():
    """Force on the target, its reduction by the packing, and both values for the ground."""
    bottom = {"plate": {"mass": 0.5}, "material": {"name": "steel"}}
    run = run_with(
        {"boundary.bottom": bottom, "packing.kind": "fcc"}, energy_input_J=0.05, dissipated_fraction=0.8, peak_force_N=696.8,
        wall_peak_force_N=1192.0, unprotected_peak_force_N=2097.0, peak_reduction=1.759, ground_peak_force_N=239.4,
        unprotected_ground_peak_force_N=219.9, target_peak_displacement_m=1.2e-5,
    )  # fmt: skip
    assert in_words(run).startswith(
        "The peak force on the target was 1.192 kN, 43.2 % less than the 2.097 kN without the "
        "packing. The peak force on the ground below it was 239.4 N, 8.87 % more than the 219.9 N "
        "without the packing. 80 % of the input energy of 50 mJ"
    )
    assert labels(run)[:3] == [
        "Peak force on the bottom",
        "Peak force without the packing",
        "Peak reduction",
    ]
    values = {row[0].text: (row[1].text, row[2].text) for row in value_rows(run).rows}
    assert values["Largest displacement of the target"] == ("12", "µm")
    on_a_wall = run_with({"boundary.bottom": "wall"}, wall_peak_force_N=10.0)
    assert in_words(on_a_wall) == "The peak force on the bottom was 10 N."


def test_contacts_that_were_open_at_the_start():
    """With scattered diameters hardly any spheres touch at the start."""
    run = run_with({}, n_contacts=0, n_loaded_contacts=136)
    assert "136 contacts were loaded." in in_words(run)
    run = run_with({}, n_contacts=150, n_loaded_contacts=136)
    assert "136 of 150 contacts were loaded." in in_words(run)


CONTACT_DEPTHS = 0.005 + 0.01 * np.arange(8)


def chain_wave(peaks, reflection=None, passing=()):
    """Return a first wave: peaks, NaN where not known; indices of contacts that wait for more."""
    is_passing = np.isin(np.arange(len(peaks)), passing)
    is_known = np.isfinite(peaks) & ~is_passing
    return FirstWave(np.array(peaks), is_known, is_passing, reflection)


def test_a_chain_says_speed_and_decay(monkeypatch):
    """Contacts that the wave has not reached do not count."""
    wave = chain_wave([100.0, 60.0, 9.0, 1e-9])
    monkeypatch.setattr(
        "granwave.analysis.reports.answer.course_of_peaks",
        lambda _: course_in_words(wave, CONTACT_DEPTHS[:4]),
    )
    run = run_with(
        {"packing.kind": "chain"}, wave_speed_m_s=428.3, energy_input_J=2.0, dissipated_fraction=0.0
    )
    assert in_words(run) == (
        "The wave speed was 428.3 m/s. The peak force of the wave decreases from 100 N in "
        "contact 1 to 9 N in contact 3 (half at 15.96 mm, a tenth at 24.44 mm below the impacted "
        "bead). None of the input energy of 2 J was dissipated."
    )
    assert labels(run)[0] == "Wave speed in the deeper half"


@pytest.mark.parametrize(
    ("peaks", "words"),
    [
        (
            [60.0, 50.0, 45.01, 45.0, 45.0, 45.0],
            "decreases from 60 N in contact 1 to 45.01 N in contact 3 and is constant within 0.1 % "
            "from there to contact 6",
        ),
        ([1.0, 2.0, 3.0, 0.0], "increases from 1 N in contact 1 to 3 N in contact 3"),
        ([1.0, 3.0, 2.0], "is between 1 N in contact 1 and 3 N in contact 2"),
        ([2.0, 2.0], "is constant within 0.1 %: 2 N in contact 1 to 2"),
        ([2.0, np.nan], ""),
        (
            [8.0, 4.0, 2.0],
            "decreases from 8 N in contact 1 to 2 N in contact 3 (half at 15 mm below the impacted "
            "bead)",
        ),
    ],
)
def test_the_course_of_the_first_wave(peaks, words):
    assert course_in_words(chain_wave(peaks), CONTACT_DEPTHS[: len(peaks)]) == words


@pytest.mark.parametrize(
    ("reflection", "passing", "words"),
    [
        (1e-3, (), "decreases from 9 N in contact 1 to 7 N in contact 3; beyond contact 3, the "
            "reflection arrives before the largest pulse has passed"),
        (None, (3,), "decreases from 9 N in contact 1 to 7 N in contact 3; beyond contact 3, the "
            "run ends before the largest pulse has passed"),
        (None, (), "decreases from 9 N in contact 1 to 7 N in contact 3"),
        (1e-3, (0, 1, 2, 3), "is not known: the largest pulse has passed fewer than two contacts "
            "before the reflection"),
        (None, (0, 1, 2, 3), "is not known: the largest pulse has passed fewer than two contacts "
            "before the end of the run"),
    ],
)  # fmt: skip
def test_contacts_without_a_known_peak_are_named(reflection, passing, words):
    peaks = [9.0, 8.0, 7.0, 6.0 if passing else np.nan]
    wave = chain_wave(peaks, reflection, passing)
    assert course_in_words(wave, CONTACT_DEPTHS[:4]) == words


def test_one_definition_of_the_reduction_under_a_static_load():
    """The dynamic part is compared in the sentence as in the value; forces that include the static
    force are named.
    """
    run = run_with(
        {"boundary.bottom": "wall"}, wall_peak_force_N=315.97, wall_dynamic_peak_force_N=295.97,
        unprotected_peak_force_N=431.42, peak_reduction=431.42 / 295.97, peak_force_N=217.8,
        precompression_residual=1e-9,
    )  # fmt: skip
    assert in_words(run) == (
        "The largest force between two spheres was 217.8 N. Contact forces include the static "
        "force. The peak force on the bottom was 316 N; its dynamic part of 296 N is 31.4 % less "
        "than the 431.4 N without the packing."
    )
    text = " ".join(summary_table(dict(run.summary) | {"name": "x"}).split())
    assert "dynamic part 295.97 N" in text
    assert "peak force without / with packing 1.46, of the dynamic part" in text


def test_a_bead_alone_has_a_restitution_and_no_reduction():
    run = run_with(
        {"boundary.bottom": "wall"}, restitution=0.592323, n_contacts=0, n_loaded_contacts=0,
        wall_peak_force_N=452.8, unprotected_peak_force_N=452.8, peak_reduction=1.0,
        peak_force_N=0.0, plastic_zone_volume_m3=0.0,
    )  # fmt: skip
    assert in_words(run) == (
        "The coefficient of restitution was 0.5923. The peak force on the bottom was 452.8 N."
    )
    assert not {
        "Peak reduction",
        "Plastic zone volume",
        "Peak contact force, excluding walls",
    } & set(labels(run))
    text = summary_table(dict(run.summary) | {"name": "x"})
    assert "restitution" in text
    assert "without packing" not in text
    assert "contacts" not in text


def test_lines_and_sensors():
    names = {"a": 3.0, "b": 0.002, "c": 1.0}
    seen = {f"sensor_{name}_peak_velocity_m_s": value for name, value in names.items()}
    assert in_words(run_with(**seen, line_x_front_speed_m_s=700.0, line_x_decay_per_m=20.0)) == (
        "Along the line x the front speed is 700 m/s. Its peak speed decays by 20 1/m. Sensors "
        "recorded at most 3 m/s (a) and at "
        "least 2 mm/s (b)."
    )


def test_symbols_are_defined_with_their_values(tmp_path):
    """F_y and alpha_y of two spheres of the run, with the energy input; for elastic spheres the
    largest force.
    """
    run = write_run(tmp_path / "run", energy_input_J=0.05, peak_force_N=700.0)
    (note,) = symbols_note(read_inputs([run], tmp_path))
    law = sphere_contact(load_case(run / "case.toml"))
    assert (
        f"F_y = {law.yield_force:.4g} N is the force at which a contact of two spheres first yields."
        in note.text
    )
    assert f"alpha_y = {1e6 * law.yield_overlap:.4g} µm is" in note.text
    assert "e_in = 50 mJ is the energy input" in note.text
    elastic = write_run(
        tmp_path / "elastic", contact__law="hertz", energy_input_J=0.05, peak_force_N=700.0
    )
    (note,) = symbols_note(read_inputs([elastic], tmp_path))
    assert note.text.startswith("F_max = 700 N is the largest force between two")


def test_the_yield_force_of_a_chain_of_two_materials_names_its_material(tmp_path):
    run = write_run(tmp_path / "run", energy_input_J=0.05)
    with (run / "case.toml").open("a", encoding="utf-8") as file:
        file.write('\n[[replace]]\nindex = 1\nmaterial = "aluminium"\n')
    (note,) = symbols_note(read_inputs([run], tmp_path))
    assert "is the force at which a contact of two spheres of brass first yields." in note.text


def test_symbols_that_no_table_or_figure_uses_are_not_defined(tmp_path):
    """Tables of a run without figures use none; a picture of the dissipation uses e_in."""
    run = write_run(tmp_path / "run", figures=False, energy_input_J=0.05, peak_force_N=700.0)
    texts = " ".join(
        note.text for note in blocks(build([run], tmp_path), "short") if isinstance(note, Note)
    )
    assert "e_in =" not in texts and "F_y =" not in texts
    table = text_table("Energies", ("Input / (F_y alpha_y)",), [("3",)])
    assert uses_symbol("F_y", [table]) and uses_symbol("F_y alpha_y", [table])
    assert not uses_symbol("e_in", [table])
    picture = Figure("packing", "Dissipation.", "", b"", (1, 1), csv=b"id,dissipated_over_input\n")
    assert uses_symbol("e_in", [Gallery((picture,))])
    assert not uses_symbol("F_y", [Gallery((picture,))])
    compared = dataclasses.replace(picture, name="compared-dissipation-depth")
    assert not uses_symbol("e_in", [Gallery((compared,))])
    assert uses_symbol("v\u0304_0", [Note("the velocity v\u0304_0 is small")])


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({}, "fcc 24 × 24 × 12, brass, 10 mm, 5 m/s, ideal"),
        ({"contact.friction": 0.2}, "fcc 24 × 24 × 12, brass, 10 mm, 5 m/s, friction 0.2"),
        ({"packing.diameter_scatter": 5e-6}, "fcc 24 × 24 × 12, brass, 10 mm, 5 m/s, diameters scattered by 5 µm"),
        ({"contact.law": "hertz", "precompression.kind": "uniaxial", "precompression.pressure": 1e6},
         "fcc 24 × 24 × 12, brass, 10 mm, 5 m/s, under 1 MPa, elastic, ideal"),
        ({"load.kind": "force", "load.shape": "half-sine", "load.amplitude": 2e4, "load.duration": 1e-5,
          "packing.kind": "chain", "packing.size": 20}, "chain of 20, brass, 10 mm, half-sine force of 20 kN for 10 µs, ideal"),
        ({"packing.kind": "chain", "packing.size": 2, "replace": [{"index": [1, 2], "material": {"name": "ptfe"}}]},
         "chain of 2, ptfe, 10 mm, 5 m/s, some spheres replaced"),
        ({"boundary.bottom": {"plate": {"mass": 0.5}, "material": {"name": "steel"}}},
         "fcc 24 × 24 × 12, brass, 10 mm, 5 m/s, on a steel plate of 0.5 kg, ideal"),
        ({"boundary.sides": "periodic"},
         "fcc 24 × 24 × 12, periodic sides, brass, 10 mm, 5 m/s, ideal"),
        ({"boundary.sides": "free"}, "fcc 24 × 24 × 12, brass, 10 mm, 5 m/s, ideal"),
    ],
)  # fmt: skip
def test_what_was_run(changes, line):
    case = {
        "packing.kind": "fcc", "packing.size": [24, 24, 12], "packing.diameter": 0.01, "packing.diameter_scatter": 0.0,
        "material.name": "brass", "contact.law": "elastoplastic", "contact.friction": 0.0, "load.kind": "impact",
        "load.velocity": 5.0,
    }  # fmt: skip
    assert setting_of({**case, **changes}) == line


def test_symbols_of_two_runs_name_the_run_of_each_value(tmp_path):
    """Two materials have two yield forces; the sentence names the run that has each of them."""
    softer = {"material": '{preset = "brass", yield_strength = 1e8}'}
    runs = [
        write_run(tmp_path / "brass", energy_input_J=0.05),
        write_run(tmp_path / "soft", energy_input_J=0.05, **softer),
    ]
    (note,) = symbols_note(read_inputs(runs, tmp_path))
    laws = [sphere_contact(load_case(run / "case.toml")) for run in runs]
    hard, soft = (quantity_in(law.yield_force, "N") for law in laws)
    assert f"F_y = {hard} (brass) and {soft} (soft) is the force" in note.text
    assert "e_in = 50 mJ is the energy input" in note.text


def test_a_decay_in_two_regions_has_two_rates():
    """One rate through both regions describes neither; rates within 10 % are one."""
    rates = {"decay_first_per_m": 2.79, "decay_second_per_m": 6.11, "decay_border_m": 0.076}
    line = {f"line_x_{name}": value for name, value in rates.items()}
    line |= {"line_x_front_speed_m_s": 700.0, "line_x_decay_per_m": 3.678}
    assert in_words(run_with(**line)).endswith(
        "Its peak speed decays by 2.79 1/m up to 76 mm from its first grain, and by 6.11 1/m "
        "beyond."
    )
    alike = line | {"line_x_decay_second_per_m": 2.9}
    assert in_words(run_with(**alike)).endswith("Its peak speed decays by 3.678 1/m.")
