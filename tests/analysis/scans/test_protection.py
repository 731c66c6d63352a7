"""Scans that ask what reaches a target show by how much less it is than without the packing."""

from __future__ import annotations

import json

import pytest

from granwave.analysis.document.model import Beside, Note
from granwave.analysis.scans.figures import draw_scan_figures
from granwave.analysis.scans.keys import means_of
from granwave.analysis.scans.result import ScanResult, protects
from tests.helpers.synthetic_report import build
from tests.helpers.synthetic_scan import grid, write_scan

PLATE = {"target_peak_displacement_m": 1e-6}


@pytest.mark.parametrize(
    ("varied", "summaries", "expected"),
    [
        (["contact.friction"], [{"peak_reduction": 1.4}], False),  # a wall is only what holds the packing
        (["contact.friction"], [{"peak_reduction": 1.4} | PLATE, {"peak_reduction": 1.2} | PLATE], True),
        (["contact.friction"], [{"peak_reduction": 1.4} | PLATE, {"peak_reduction": 1.2}], False),
        (["boundary.bottom"], [{"peak_reduction": 1.4} | PLATE, {"peak_reduction": 1.2}], True),
        (["boundary.bottom.plate.mass"], [{"peak_reduction": 0.7}], True),
        (["boundary.bottom"], [{"peak_reduction": 1.00004}], False),  # one sphere
        (["boundary.bottom"], [{"peak_reduction": None}, {}], False),
        (["boundary.bottom"], [], False),
    ],
)
def test_which_scans(varied, summaries, expected):
    assert protects(varied, summaries) is expected


@pytest.mark.parametrize("plate", [True, False])
def test_main_figure(tmp_path, plate):
    scan = write_scan(tmp_path / "scan", grid(contact__friction=[0, 0.1, 0.2], load__velocity=[1, 5]))
    for point in ScanResult(scan).points:
        path = scan / "points" / point.id / "summary.json"
        reduction = 2 + 10 * point.labels["contact.friction"] - 0.1 * point.labels["load.velocity"]
        more = {"peak_reduction": reduction} | (PLATE if plate else {})
        path.write_text(json.dumps(json.loads(path.read_text()) | more))
    draw_scan_figures(scan, pdf=False)
    assert (scan / "figures" / "peak_reduction_vs_contact_friction.png").exists() is plate
    means = means_of(ScanResult(scan))
    assert (means.quantities()[0][1] == "peak_reduction") is plate
    answer = build([scan], tmp_path).sections[0].blocks
    (sentence,) = [block.text for block in answer if isinstance(block, Note) and block.tone == "lead"]
    (shown,) = [block for block in answer if isinstance(block, Beside)]
    if plate:
        assert sentence.startswith("Peak reduction: from 1.5 (friction coefficient 0, impact velocity 5 m/s) to 3.9 ")
        assert "It rises with friction coefficient, falls with impact velocity." in sentence
        assert shown.gallery.figures[0].name.endswith("peak-reduction-vs-contact-friction")
        assert shown.table.columns[2].heading == "Peak reduction"
    else:
        assert sentence.startswith("Dissipated fraction") and "Peak reduction" not in str(shown.table)
