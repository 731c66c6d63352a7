"""Golden outputs, by which changes for users are detected. See `outputs` for how to regenerate
them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.run_directory import SCRIPT_FILE
from tests.golden import outputs

#: Cases whose equilibrium under gravity takes ten seconds.
SLOW = ("settled-gravity",)


def close(found: Any, kept: Any) -> bool:
    """Return True if values are equal, numbers to a relative difference of 1e-6."""
    if isinstance(kept, dict) and isinstance(found, dict):
        return found.keys() == kept.keys() and all(close(found[key], kept[key]) for key in kept)
    if isinstance(kept, list) and isinstance(found, list):
        return len(found) == len(kept) and all(map(close, found, kept))
    if isinstance(kept, float) and isinstance(found, int | float):
        return found == pytest.approx(kept, rel=1e-6, abs=0)
    return bool(found == kept)


def same(new: str, old: str, rel: float) -> bool:
    """Return True if the words of texts are equal, and numbers to a relative difference."""
    words, numbers = outputs.split(new)
    words_before, numbers_before = outputs.split(old)
    return words == words_before and numbers == pytest.approx(numbers_before, rel=rel, abs=0)


def test_decks_of_built_in_cases(tmp_path: Path) -> None:
    names = outputs.granular_cases()
    assert set(names) == kept_digests().keys(), outputs.RENEW
    compare_decks(tmp_path, [name for name in names if name not in SLOW])


@pytest.mark.validation
def test_decks_with_a_long_static_stage(tmp_path: Path) -> None:
    compare_decks(tmp_path, SLOW)


def kept_digests() -> dict[str, Any]:
    digests: dict[str, Any] = json.loads((outputs.FOLDER / outputs.DIGESTS).read_text())
    return digests


def compare_decks(tmp_path: Path, names: Sequence[str]) -> None:
    """Compare the decks of built-in cases with the kept ones."""
    digests = outputs.write_decks(tmp_path, names)
    kept = kept_digests()
    changed = [name for name in digests if not close(digests[name], kept.get(name))]
    assert changed == [], f"data of decks changed; {outputs.RENEW}"
    for name in digests:
        script = (tmp_path / name / SCRIPT_FILE).read_text(encoding="utf-8")
        before = (outputs.FOLDER / f"{name}.in").read_text(encoding="utf-8")
        assert same(script, before, 1e-6), f"{name}: {outputs.RENEW}"


def test_summaries_and_report_of_small_runs(tmp_path: Path) -> None:
    summaries = json.loads(json.dumps(outputs.run_small(tmp_path)))
    kept = json.loads((outputs.FOLDER / outputs.SUMMARIES).read_text())
    for name in kept:
        changed = [
            key for key in kept[name] if not close(summaries[name].get(key), kept[name][key])
        ]
        assert changed == [] and summaries[name].keys() == kept[name].keys(), (
            f"{name}; {outputs.RENEW}"
        )
    report, before = (
        (place / outputs.REPORT).read_text(encoding="utf-8").splitlines()
        for place in (tmp_path, outputs.FOLDER)
    )
    # a line is the same if its words are, and numbers to a unit of the last digit shown
    changed = [
        (new, old) for new, old in zip(report, before, strict=False) if not same(new, old, 2e-3)
    ]
    assert changed == [] and len(report) == len(before), outputs.RENEW
