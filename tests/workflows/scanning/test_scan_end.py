"""Text at the end of a scan: all points, means over replicates, and a sentence."""

from __future__ import annotations

import json

from granwave.analysis.scans.result import ScanResult
from granwave.workflows.cli.scan import outcome_text
from granwave.workflows.scanning.driver import ScanOutcome
from tests.helpers.synthetic_scan import grid, write_scan


def end_of(tmp_path, points, share) -> str:
    scan = write_scan(tmp_path / "scan", points)
    for point in ScanResult(scan).points:
        path = scan / "points" / point.id / "summary.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | {"dissipated_fraction": share(point.labels)}))
    return outcome_text(ScanOutcome(scan, done=len(points), failed=0, missing=0, stopped=None))


def test_means_and_a_sentence(tmp_path):
    points = grid(load__velocity=[1, 2], packing__seed=[1, 2, 3])
    text = end_of(tmp_path, points, lambda p: 0.3 * p["load.velocity"] + 0.1 * p["packing.seed"])
    assert "means of 3 replicates, with 95 % confidence intervals:" in text
    (head,) = [line for line in text.splitlines() if "Impact velocity (m/s)" in line]
    assert "Dissipated fraction" in head and "0.50 ± 0.25" in text
    assert "from 0.50 ± 0.25 (impact velocity 1 m/s) to 0.80 ± 0.25 (impact velocity 2 m/s). It rises with" in text


def test_without_replicates_there_is_the_sentence_alone(tmp_path):
    text = end_of(tmp_path, grid(load__velocity=[1, 2, 4]), lambda p: 0.1 * p["load.velocity"])
    assert "means of" not in text
    assert "Dissipated fraction: from 0.1 (impact velocity 1 m/s) to 0.4 (impact velocity 4 m/s)." in text
