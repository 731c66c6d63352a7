"""Synthetic runs and scans for reports, and functions that read parts of a report."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np
from PIL import Image

from granwave.analysis.document.model import Beside, DocumentTable, Group, Note, Report
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.outline import build_report
from tests.helpers.made_up.synthetic_scan import case_of, grid, summary_of, write_json, write_scan

NASTY = "<script>alert(1)</script> & \"q\" 'a' | *b* `c` {{ 7*7 }}"


def write_run(directory: Path, figures: bool = True, name: str = "synthetic", **changes) -> Path:
    """A finished run of brass; `load__velocity=4` in the labels, other words change the summary."""
    labels = {
        key.replace("__", "."): value
        for key, value in changes.items()
        if "__" in key or key == "material"
    }
    values = {key: value for key, value in changes.items() if "__" not in key and key != "material"}
    case = case_of(labels)
    directory.mkdir(parents=True)
    (directory / "case.toml").write_text(case.to_toml(), encoding="utf-8")
    summary = {
        "energy_balance_error": 3e-7,
        "contacts_beyond_law": 0,
        "timestep_s": 3e-8,
    } | summary_of(case)
    write_json(directory / "summary.json", summary | {"name": name} | values)
    write_json(directory / "run.json", {"state": "finished", "attempts": []})
    with h5py.File(directory / "result.h5", "w") as file:
        file.attrs.update({"case": case.to_toml(), "run": "{}", "versions": "{}"})
        time = np.linspace(0, 1e-3, 50)
        lost = 1.6 * (1 - np.exp(-time / 1e-4))
        energies = {
            "time": time,
            "input": np.full(50, 2.0),
            "dissipated": lost,
            "kinetic": 2.0 - lost,
        }
        tables = {"energy": energies | {"step": np.arange(50), "elastic": np.zeros(50)}}
        tables["spheres"] = dict.fromkeys(
            ("id", "radius", "mass", "peak_force", "dissipated_energy"), np.ones(1)
        )
        tables["spheres"]["position"] = np.zeros((1, 3))
        tables["contacts"] = dict.fromkeys(
            ("i", "j", "peak_force", "peak_overlap", "dissipated_energy"), np.empty(0)
        )
        for table, columns in tables.items():
            for column, values in columns.items():
                file[f"{table}/{column}"] = values
        file["particles/spheres/position/value"] = np.zeros((1, 1, 3))
        file["particles/spheres/position/time"] = np.zeros(1)
    if figures:
        draw(directory, "zebra", "energies", "peak_force_principal")
    return directory


def draw(directory: Path, *names: str) -> None:
    """Pictures of noise, with data for the first."""
    (directory / "figures").mkdir(exist_ok=True)
    pixels = np.random.default_rng(1).integers(0, 255, (40, 60, 3), dtype=np.uint8)
    for name in names:
        Image.fromarray(pixels).resize((1000, 50)).save(directory / "figures" / f"{name}.png")
    (directory / "figures" / f"{names[0]}.csv").write_text("x\n1\n")


def write_inputs(directory: Path) -> list[Path]:
    """Two runs and a scan in which points failed and are missing."""
    first = write_run(directory / "first")
    second = write_run(directory / "second", figures=False, load__velocity=10)
    points = grid(load__velocity=[10, 9, 1, 40], material=["brass", "steel"])
    scan = write_scan(
        directory / "scan", points, failed={3: "the disk is full\nno space left"}, missing=[8]
    )
    draw(scan, "dissipated_fraction_vs_load_velocity")
    return [first, second, scan]


def nasty_inputs(directory: Path) -> list[Path]:
    """A run and a scan whose texts would break a page that does not escape them."""
    run = write_run(directory / "a<b>&'c", name=NASTY, end_reason=NASTY, versions={NASTY: NASTY})
    draw(run, 'x<y>"&')
    case = (run / "case.toml").read_text() + f"[{json.dumps('<i>')}]\nx = {json.dumps(NASTY)}\n"
    (run / "case.toml").write_text(case)
    with h5py.File(run / "result.h5", "r+") as file:
        file.attrs["case"] = case
    scan = write_scan(
        directory / "scan",
        grid(load__velocity=[1, 2]),
        failed={1: NASTY + "\x07\ud800\n" + "w" * 3000},
    )
    return [run, scan]


def build(directories: Sequence[Path], base: Path, *studies: str) -> Report:
    """The content of their report, with studies in addition to those that scans name."""
    return build_report(read_inputs(directories, base), studies)


def blocks(report: Report, slug: str) -> list:
    """Blocks of a section, including the blocks of its groups."""
    section = next(section for section in report.sections if section.slug == slug)
    found = []
    for block in section.blocks:
        parts = block.blocks if isinstance(block, Group) else [block]
        for part in parts:
            found += [part.gallery, part.table] if isinstance(part, Beside) else [part]
    return found


def table(report: Report, slug: str, caption: str) -> list[dict]:
    """Rows of a table: cells by heading."""
    part = next(
        b for b in blocks(report, slug) if isinstance(b, DocumentTable) and b.caption == caption
    )
    return [dict(zip([c.heading for c in part.columns], row, strict=True)) for row in part.rows]


def notes(report: Report, slug: str) -> list[Note]:
    """Notes of a section, without the answer and the definitions of symbols."""
    left_out = ("lead", "") if slug == "short" else ("lead",)
    return [
        block
        for block in blocks(report, slug)
        if isinstance(block, Note) and block.tone not in left_out
    ]
