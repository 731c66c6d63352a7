"""Notes of a comparison on its page: two lines of each subject, the others folded."""

from __future__ import annotations

from granwave.analysis.document.model import Group, Note
from granwave.analysis.reports.comparison.blocks import _first_lines, comparison_blocks
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.value_words import sentence
from granwave.analysis.reports.inputs import read_inputs
from tests.helpers.made_up.synthetic_report import write_run

_LINE = "The plastic zone reaches a boundary, which limits its size, as in other runs of this page."


def test_the_first_lines_are_whole_notes_or_sentences():
    assert _first_lines(["One.", "Two. Three."]) == ("One. Two. Three.", [])
    long = " ".join([_LINE] * 4)
    assert _first_lines([long, "Two."]) == (f"{_LINE} {_LINE}", [f"{_LINE} {_LINE}", "Two."])
    assert _first_lines([_LINE, long]) == (_LINE, [long])


def test_long_notes_are_folded(tmp_path):
    own = [
        {"energy_input_J": 1.0, "zone_cut": ["bottom"], "zone_growing": ["depth"]},
        {"energy_input_J": 9.0, "incomplete_values": ["dissipated_fraction"], "end_time_s": 1e-5},
    ]
    folders = [
        write_run(tmp_path / name, figures=False, **values)
        for name, values in zip("ab", own, strict=True)
    ]
    comparison = compare_runs(list(read_inputs(folders, tmp_path).results()))
    blocks = comparison_blocks(comparison)
    notes = [block.text for block in blocks if isinstance(block, Note) and block.tone == "note"]
    assert notes and all(len(text) <= 240 for text in notes)
    folded = [block for block in blocks if isinstance(block, Group) and block.folded]
    assert folded[-1].title.startswith("Limits of the compared values: ")
    shown = " ".join([*notes, *map(str, folded)])
    missing = [note for note in comparison.notes if note.split(". ")[-1] not in shown]
    assert missing == []


def test_larger_ratios_that_are_not_counted_have_a_reason(tmp_path):
    own = {
        "a": {"energy_input_J": 1.0, "energy_dissipated_J": 0.01, "peak_force_N": 10.0},
        "b": {"energy_input_J": 9.0, "energy_dissipated_J": 0.9, "peak_force_N": 40.0},
    }
    folders = [write_run(tmp_path / name, figures=False, **values) for name, values in own.items()]
    comparison = compare_runs(list(read_inputs(folders, tmp_path).results()))
    text = sentence(comparison.values, comparison.runs)
    assert "peak contact force, excluding walls, 10 N (a) and 40 N (b), a ratio of 4." in text
    assert (
        "Larger ratios that are not counted: dissipated energy (it depends on the input, which "
        "differs)." in text
    )
