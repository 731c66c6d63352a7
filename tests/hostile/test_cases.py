"""Invalid cases and scans of ``cases.toml``: one clear line for each fault."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.case.parse import apply_overrides
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import library, load_scan
from tests.hostile.rows import REPEATED

TEXT = Path(__file__).with_name("cases.toml").read_text(encoding="utf-8")
TABLES = tomllib.loads(REPEATED.sub(lambda found: int(found[1]) * found[2], TEXT))
SCANS = TABLES.pop("scans")
ROWS = [
    pytest.param(table["base"], row, id=f"{name} {n}: {row['says']}"[:100])
    for name, table in TABLES.items()
    for n, row in enumerate(table["rows"], 1)
]


@pytest.mark.parametrize("name", TABLES)
def test_bases_are_right(name: str) -> None:
    base = TABLES[name]["base"]
    tables = read_toml(library.find(base)) if isinstance(base, str) else base
    assembly = assemble(case_from_dict(tables))
    assert assembly.n_spheres > 0
    assert set(tables) <= set(assembly.case.to_dict())


@pytest.mark.parametrize(("base", "row"), ROWS)
def test_case(base: str | dict[str, Any], row: dict[str, Any]) -> None:
    tables = read_toml(library.find(base)) if isinstance(base, str) else base
    with pytest.raises(InputError) as caught:
        assemble(case_from_dict(apply_overrides(tables, row["set"]), "my.toml"))
    errors = caught.value.errors
    words = [row["says"]] if isinstance(row["says"], str) else row["says"]
    assert any(all(word in error for word in words) for error in errors), errors
    assert len(errors) == row.get("faults", 1)
    assert all(error.startswith("my.toml: ") and "\n" not in error for error in errors)


@pytest.mark.parametrize("row", SCANS["rows"], ids=lambda row: str(row["says"])[:100])
def test_scan(row: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    after = SCANS["after"]
    text = (
        row["head"] + after
        if "head" in row
        else SCANS["before"] + row["tables"].replace("@", after)
    )
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_scan(path)
    errors = caught.value.errors
    assert len(errors) == len(row["says"]), errors
    for error, words in zip(errors, row["says"], strict=True):
        assert (
            error.startswith(f"{path}: ")
            and "\n" not in error
            and all(word in error for word in words)
        ), error
