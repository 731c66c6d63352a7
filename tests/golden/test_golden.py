"""Golden outputs, by which changes for users are detected. See `outputs` for how to regenerate them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.run_directory import SCRIPT_FILE
from tests.golden import outputs


def close(found: Any, kept: Any) -> bool:
    """Assert that values are equal, numbers to 1e-6."""
    if isinstance(kept, dict) and isinstance(found, dict):
        return found.keys() == kept.keys() and all(close(found[key], kept[key]) for key in kept)
    if isinstance(kept, list) and isinstance(found, list):
        return len(found) == len(kept) and all(map(close, found, kept))
    if isinstance(kept, float) and isinstance(found, int | float):
        return found == pytest.approx(kept, rel=1e-6, abs=1e-9)
    return bool(found == kept)


def changed_lines(found: str, kept: str) -> list[tuple[str, str]]:
    """Lines that differ in a word, or in a number by more than a unit of the last digit shown."""
    lines, before = found.splitlines(), kept.splitlines()
    changed = [(new, old) for new, old in zip(lines, before, strict=False) if not _same(new, old)]
    return changed if len(lines) == len(before) else [*changed, (f"{len(lines)} lines", f"{len(before)} lines")]


def _same(new: str, old: str) -> bool:
    (words, numbers), (words_before, numbers_before) = outputs.split(new), outputs.split(old)
    return words == words_before and numbers == pytest.approx(numbers_before, rel=2e-3, abs=1e-9)


def test_decks_of_built_in_cases(tmp_path: Path) -> None:
    digests = outputs.write_decks(tmp_path)
    kept = json.loads((outputs.FOLDER / outputs.DIGESTS).read_text())
    changed = [name for name in digests if not close(digests[name], kept.get(name))]
    assert changed == [] and digests.keys() == kept.keys(), f"data of decks changed; {outputs.RENEW}"
    for name in digests:
        script = (tmp_path / name / SCRIPT_FILE).read_text(encoding="utf-8")
        assert close_script(script, (outputs.FOLDER / f"{name}.in").read_text(encoding="utf-8")), (
            f"{name}: {outputs.RENEW}"
        )


def close_script(found: str, kept: str) -> bool:
    """Assert that words are equal, and numbers to 1e-6."""
    (words, numbers), (words_before, numbers_before) = outputs.split(found), outputs.split(kept)
    return words == words_before and numbers == pytest.approx(numbers_before, rel=1e-6, abs=1e-18)


def test_summaries_and_report_of_small_runs(tmp_path: Path) -> None:
    summaries = json.loads(json.dumps(outputs.run_small(tmp_path)))
    kept = json.loads((outputs.FOLDER / outputs.SUMMARIES).read_text())
    for name in kept:
        changed = [key for key in kept[name] if not close(summaries[name].get(key), kept[name][key])]
        assert changed == [] and summaries[name].keys() == kept[name].keys(), f"{name}; {outputs.RENEW}"
    report = (tmp_path / outputs.REPORT).read_text(encoding="utf-8")
    assert changed_lines(report, (outputs.FOLDER / outputs.REPORT).read_text(encoding="utf-8")) == [], outputs.RENEW
