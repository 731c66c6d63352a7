"""Elastic bars, and chains that end on them, of the thesis, chapter 3: small runs against closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.studies.study import Study
from tests.helpers.scripts import columns, row, study_of

SHORT = {"packing.size": 8, "bar.length": 1.2, "bar.elements": 120, "run.end_time": 4e-4, "load.amplitude": 2e3}


def run(directory: Path, name: str, changes: dict[str, Any]) -> gw.Run:
    return gw.run(name, changes, directory=directory, progress=False)


def of_shape(study: Study, start: str, shape: str) -> gw.Row:
    (found,) = [one for one in study.rows if one.quantity.startswith(start) and f", {shape} " in one.quantity]
    return found


def test_pulses_in_a_bar(tmp_path: Path) -> None:
    """A half-sine on two meshes, and a rectangle; energy converges with the square of the element, kinks with 2/3."""
    short = {"incident_bar.length": 1.0, "load.duration": 4e-5, "run.end_time": 3e-4}
    runs = [
        run(tmp_path / f"{shape}{n}", "bar-pulse", short | {"load.shape": shape, "incident_bar.elements": n})
        for shape, n in (("half-sine", 100), ("half-sine", 200), ("rectangle", 200))
    ]
    study = study_of("thesis/chapter_3/elastic_bar.py", runs)
    for start, tolerance in (("Speed", 2e-4), ("Impedance", 1e-3), ("Peak at a section", 5e-3), ("Energy", 1e-3)):
        found = of_shape(study, start, "half-sine")
        assert found.ours == pytest.approx(found.theory, rel=tolerance)
    assert of_shape(study, "Largest deviation", "half-sine").ours < 0.08
    assert 1.2 < of_shape(study, "Peak at a section", "rectangle").ours < 1.28
    assert row(study, "Order of the error").ours == pytest.approx(2 / 3, abs=0.25)
    errors = study.pictures[1].drawing.columns["half-sine: error_of_energy"]
    assert errors[0] < 0.3 * errors[1]
    energy = runs[1]["energy_input_J"]
    assert energy == pytest.approx(1e4**2 * 4e-5 / 2 / ((200e9 * 8100) ** 0.5 * 1.27e-4), rel=1e-3)


def test_places_of_an_odd_bead(tmp_path: Path) -> None:
    """A softer bead transmits least near the bar."""
    kinds = [(name, name, 1) for name in ("brass", "aluminium", "steel")]
    kinds += [("brass", "aluminium", place) for place in (2, 5, 8)] + [("brass", "steel", 8)]
    runs = []
    for base, odd, place in kinds:
        changes = {"material": base, "replace.1.material": odd, "replace.1.index": place, "output.history": 0}
        runs.append(run(tmp_path / f"{base}{odd}{place}", "intruder", SHORT | changes))
    study = study_of("thesis/chapter_3/intruder_place.py", runs)
    least = row(study, "Transmitted energy, aluminium: least")
    assert least.quantity.endswith("at place 8") and least.ours < row(study, "Transmitted energy, all brass").ours
    assert columns(study)["place_of_aluminium"].tolist() == [2, 5, 8]
    assert len(study.verdict) == 1


def test_properties_of_an_odd_bead(tmp_path: Path) -> None:
    """Heavier and softer ones transmit less."""
    changes = SHORT | {"output.history": 0, "replace.1.index": 4, "run.end_time": 6e-4, "bar.length": 1.6}
    steel = {"preset": "steel"}
    kinds: list[Any] = ["steel", *(steel | {"density": r * 7850} for r in (5, 20))]
    kinds += [steel | {"yield_strength": r * 7e8} for r in (0.1, 0.3)]
    runs = [
        run(tmp_path / str(n), "intruder", changes | {"material": "steel", "replace.1.material": kind})
        for n, kind in enumerate(kinds)
    ]
    data = columns(study_of("thesis/chapter_3/intruder_properties.py", runs))
    assert data["density_ratio"] == pytest.approx([1, 5, 20])
    assert np.all(np.diff(data["energy_ratio_by_density"]) < 0)
    assert data["yield_strength_ratio"] == pytest.approx([0.1, 0.3, 1])
    assert data["energy_ratio_by_yield_strength"][0] < 0.95


def test_split_hopkinson(tmp_path: Path) -> None:
    changes = {"packing.size": 4, "replace.1.index": 2, "bar.elements": 200, "incident_bar.elements": 200}
    changes |= {"run.end_time": 8e-4, "output.history": 400}
    found = run(tmp_path, "split-hopkinson", changes)
    study = study_of("thesis/chapter_3/split_hopkinson.py", [found])
    assert row(study, "Peak force, incident").ours == pytest.approx(30, rel=1e-2)
    transmitted, reflected = (row(study, f"Energy, {one} over incident").ours for one in ("transmitted", "reflected"))
    assert 0 < transmitted < 0.1 < reflected < 1
    assert of_shape(study, "Speed", "table").ours == pytest.approx((200e9 / 8100) ** 0.5, rel=1e-3)
    assert [picture.name for picture in study.pictures] == ["split_hopkinson", "split_hopkinson_map"]
    assert found["energy_balance_error"] < 1e-5
