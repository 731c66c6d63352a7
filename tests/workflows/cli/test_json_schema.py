"""JSON Schemas of the files of users: all files of the package are valid, invalid files are
detected.
"""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

import granwave as gw
from granwave.workflows.cli.keys import reference
from granwave.workflows.cli.keys.json_schema import schema_of
from granwave.workflows.cli.main import main
from granwave.workflows.file_kinds import file_kinds
from tests.documents.pages import ROOT, blocks, pages

FOLDERS = ("workflows/cases", "workflows/scans", "reproductions", "extensions/*/cases", "extensions/*/scans")  # fmt: skip
FILES = sorted(path for folder in FOLDERS for path in ROOT.glob(f"{folder}/**/*.toml"))
OF_PAGES = {f"{page.name}: {block.caption}": block.text for page in pages() for block in blocks(page) if block.caption.endswith(".toml")}  # fmt: skip
#: A table or key that only this kind of files has.
MARKS = {
    "scans": "suite", "case": "scan", "base": "design", "slurm": "profile", "cluster": "profile",
    "infer": "inference",
    "block": "continuum", "punch": "continuum", "sphere": "sphere-contact", "packing": "case",
}  # fmt: skip
GOOD: dict[str, Any] = {
    "material": "brass",
    "packing": {"kind": "fcc", "size": [4, 4, 3], "diameter": 0.01},
    "load": {"velocity": 5.0},
}
WRONG = [
    ({"pakcing": {}}, "pakcing"),
    ({"load": {"velocty": 1.0}}, "velocty"),
    ({"load": {"velocity": "fast"}}, "fast"),
    ({"load": {"spheres": 2}}, "2"),
    ({"load": 3}, "3"),
    ({"packing": {"kind": "fcx", "size": [1, 1, 1], "diameter": 0.01}}, "fcx"),
    ({"packing": {"kind": "fcc", "size": "large", "diameter": 0.01}}, "large"),
    ({"packing": {"kind": "fcc", "size": [1, 1, 1], "diameter": -0.01}}, "-0.01"),
    ({"run": {"end_time": "never"}}, "never"),
    ({"run": {"timestep": 0}}, "0"),
    ({"material": {"youngs_modulus": "soft"}}, "soft"),
    ({"material": {"youngs": 1e9}}, "youngs"),
    ({"materials": {"soft": {"density": True}}}, "True"),
    ({"contact": {"law": "hooke"}}, "hooke"),
    ({"boundary": {"bottom": {"plate": {"mass": 1.0}}}}, "plate"),
    ({"boundary": {"bottom": "glass"}}, "glass"),
    ({"replace": {"index": 1}}, "index"),
    ({"replace": [{"index": 1, "colour": "red"}]}, "colour"),
    ({"striker": [{"velocity": [0, 0, 1]}]}, "touches"),
    ({"output": {"probes": 7}}, "7"),
]


#: Kinds of files of the core and of the extensions that are there.
KINDS = [kind.name for kind in file_kinds()]


def kind_of(data: dict[str, Any]) -> str:
    return next(kind for mark, kind in MARKS.items() if mark in data)


def faults(data: dict[str, Any], kind: str) -> list[str]:
    return [
        f"{list(one.path)}: {one.message}"
        for one in Draft202012Validator(schema_of(kind)).iter_errors(data)
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_schemas_are_schemas_and_keep_their_own_examples(kind):
    """Each key's example and default fit; the schema knows every key that `granwave keys` lists."""
    schema = schema_of(kind)
    Draft202012Validator.check_schema(schema)
    assert schema["$comment"] == f"granwave {gw.__version__}"
    for table in (table for table in reference.tables() if table.file == kind):
        for key in table.keys:
            assert f'"{key.name}": {{' in json.dumps(schema), key.name

    def walk(part: Any) -> None:
        for name, one in part.get("properties", {}).items():
            walk(one)
            for value in [
                *one.get("examples", []),
                *([one["default"]] if "default" in one else []),
            ]:
                whole = {**one, "$defs": schema.get("$defs", {})}
                assert Draft202012Validator(whole).is_valid(value), (name, value)
        for one in [*([part["items"]] if "items" in part else []), *part.get("anyOf", [])]:
            walk(one)

    walk(schema)


@pytest.mark.needs_extension("continuum", "waves", "inference", "design", "pictures", "packings")
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_files_that_are_there_fit(path: Path):
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    if not set(data) & set(MARKS):
        pytest.skip("a table of numbers")
    if (kind := kind_of(data)) not in KINDS:
        pytest.skip("of an extension that is left out")
    assert faults(data, kind) == []


@pytest.mark.parametrize("name", OF_PAGES)
def test_files_of_the_pages_fit(name: str):
    data = tomllib.loads(OF_PAGES[name])
    if set(data) & set(MARKS) and (kind := kind_of(data)) in KINDS:
        assert faults(data, kind) == []


def test_case_that_a_run_writes_fits(tmp_path, capsys):
    assert main(["write", "fcc-small", "-o", str(tmp_path / "deck"), "--set", "boundary.bottom={plate={mass=1,stiffness=1e6}}"]) == 0  # fmt: skip
    data = tomllib.loads((tmp_path / "deck" / "case.toml").read_text(encoding="utf-8"))
    assert faults(data, "case") == [] and "resolved" in data


@pytest.mark.parametrize(
    ("changes", "named"), WRONG, ids=lambda one: one if isinstance(one, str) else ""
)
def test_wrong_cases_do_not_fit(changes, named):
    assert faults(GOOD, "case") == []
    found = faults(GOOD | changes, "case")
    assert found and named in " ".join(found)


@pytest.mark.parametrize(
    ("data", "kind"),
    [
        ({"grid": {"load.velocity": [1]}}, "scan"),  # no case
        ({"case": "fcc-small", "replicates": 0}, "scan"),
        ({"case": "fcc-small", "gird": {}}, "scan"),
        ({"scans": "restitution"}, "suite"),
        ({"slurm": {"jobs": "many"}}, "profile"),
    ],
)
def test_other_wrong_files_do_not_fit(data, kind):
    assert faults(data, kind)


def test_command(capsys):
    assert main(["keys", "--schema", "scan"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(schema_of("scan")))
    with pytest.raises(SystemExit, match="2"):
        main(["keys", "--schema", "scam"])
    assert "did you mean scan?" in capsys.readouterr().err
