"""Measurements of speed, on a small packing: the measured parts, and the content of the results."""

from __future__ import annotations

import json

import pytest

from granwave.workflows import bench, bench_lists
from granwave.workflows.cli.main import main


@pytest.fixture(autouse=True)
def small(monkeypatch):
    small = {
        "STUDY": "fcc-small",
        "TIMED": "two-spheres",
        "IMPACT_TIME": 2e-5,
        "SIZES": ([8, 8, 4], [10, 10, 4]),
    }
    for name, value in small.items():
        monkeypatch.setattr(bench, name, value)


def test_styles_in_both_states(capsys):
    found = bench.bench(("styles",), repeats=2)
    assert (
        found["repeats"] == 2 and len(found["load_before"]) == 3 and found["triad_GB_per_s"] > 0.1
    )
    struck, rattling = (found["styles"][state] for state in ("struck", "rattling"))
    assert (
        0
        < struck["loaded_contacts_per_sphere"]
        < 1
        < 2
        < rattling["loaded_contacts_per_sphere"]
        < 6
    )
    for state in (struck, rattling):
        assert list(state["table"]) == list(bench.STYLES)
        for name, values in state["table"].items():
            beside = state["table"][bench.STYLES[name][2]]["rates"]
            assert values["ratios"] == [a / b for a, b in zip(values["rates"], beside, strict=True)]
            assert len(values["rates"]) == 2 and values["bytes_per_sphere"] > 100
        assert state["table"][bench.BASELINE]["ratios"] == [1.0, 1.0]
        for name in (bench.GRANULAR, bench.ROUGH_GRANULAR):
            assert state["table"][name]["ratios_to_granular"] == [1.0, 1.0]
        rough = state["table"][bench.ROUGH]
        granular = state["table"][bench.ROUGH_GRANULAR]
        assert rough["ratios_to_granular"][1] == rough["rates"][1] / granular["rates"][1]
    printed = capsys.readouterr().out
    assert "load of the machine" in printed and "2 × 100 steps" in printed
    assert printed.count(bench.ROUGH_BASELINE) == 2 == printed.count(bench.ROUGH_GRANULAR)


def test_lists(capsys, monkeypatch):
    small = {
        "STEPS": 2,
        "SHEAR_CELLS": 4,
        "SHEAR_STEPS": 40,
        "SHEAR_WARM": 10,
        "POUR_SPHERES": 60,
        "POUR_STEPS": 6000,
    }
    for name, value in small.items():
        monkeypatch.setattr(bench_lists, name, value)
    found = bench_lists.compare_lists(repeats=2)
    n_spheres = {state: table["n_spheres"] for state, table in found.items()}
    assert n_spheres == {"rattling": 6912, "sheared": 256, "poured": 60}
    for state in found.values():
        assert list(state["table"]) == list(bench_lists.STYLES)
        assert state["table"][bench.ROUGH_BASELINE]["ratios"] == [1.0, 1.0]
        assert state["table"][bench.ROUGH_GRANULAR]["ratios_to_granular"] == [1.0, 1.0]
    for name in ("sheared", "poured"):
        for values in found[name]["table"].values():
            assert len(values["times"]) == 2 and min(values["times"]) > 0
            assert values["lists"] > 0
    printed = capsys.readouterr().out
    assert "new lists of 6912 rattling spheres" in printed and printed.count(bench.ROUGH) == 3


@pytest.mark.validation
def test_sizes_and_ranks():
    found = bench.bench(("sizes",), repeats=2)
    assert [row["n_spheres"] for row in found["sizes"]] == [256, 400] and "study" not in found
    assert all(len(row["rates"]) == 2 for row in found["sizes"])
    ranks = bench.compare_ranks(1)
    for name, n_spheres in (("strong", [400, 400]), ("weak", [400, 800])):
        one, two = ranks[name]
        assert [one["n_spheres"], two["n_spheres"]] == n_spheres and [
            one["n_ranks"],
            two["n_ranks"],
        ] == [1, 2]
        assert one["ghosts"] == 0 < two["ghosts"] and two["rates"][0] > 0


@pytest.mark.validation
def test_parts_of_a_study_as_json(tmp_path, capsys):
    assert (
        main(["bench", "--parts", "study", "--repeats", "1", "--json", str(tmp_path / "b.json")])
        == 0
    )
    found = json.loads((tmp_path / "b.json").read_text())["study"]
    assert found["n_steps"] > 100 and all(len(found[part]) == 1 for part in bench.STUDY_PARTS)
    assert found["analysis"][0] > 0.1 and found["steps"][0] > 0
    printed = capsys.readouterr().out
    assert all(part in printed for part in bench.STUDY_PARTS)
