"""Studies of tolerances, of bands, and of two spheres in finite elements."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.document.model import Note
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.studies import studies_of
from granwave.analysis.statistics import estimate
from granwave.analysis.studies.runs import finished_runs
from granwave.analysis.studies.study import Study, make_studies
from granwave.analysis.studies.tolerance.quantities import (
    AXES,
    DISSIPATED,
    FORCE,
    IDEAL,
    Setting,
)
from granwave.analysis.studies.tolerance.runs import PackingRuns, select
from granwave.extensions.continuum.runs import SphereContactRun
from granwave.extensions.waves.spectra.band_structure import band_structure
from granwave.extensions.waves.study import scattered_line, without_scatter
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.workflows import load_case, load_scan, run_case
from tests.helpers.made_up.synthetic_contact import write_contact
from tests.helpers.made_up.synthetic_report import build, notes, table
from tests.helpers.made_up.synthetic_scan import case_of, grid, write_json, write_scan

FORCE_IDEAL = 1332.0
SHARE_IDEAL = 0.88
TABLE = "Mean and 95 % confidence interval"
KEPT = (
    "Largest imperfections with at least 90 % of the performance of the ideal packing (a force "
    "of at most 111 %)"
)


def summary_of(case: Case, **others: Any) -> dict[str, Any]:
    """Summary in which force halves with every 2 um, dissipation decreases by 2 % per um, and
    friction reduces both.
    """
    scatter = 1e6 * case.packing.diameter_scatter
    friction = case.contact.friction
    rng = np.random.default_rng([case.packing.seed or 1, round(scatter * 10)])
    noise = 1 + 0.05 * rng.standard_normal() if is_random(case) else 1.0
    share = SHARE_IDEAL * (1 - 0.02 * scatter)
    plastic = share * (1 - 0.8 * friction)
    return {
        "name": case.name,
        "n_spheres": assemble(case).lattice.n_spheres,
        "end_time_s": 1e-3,
        "energy_input_J": 0.0556,
        "dissipated_fraction": share,
        "plastic_fraction": plastic,
        "friction_fraction": share - plastic,
        "wall_peak_force_N": FORCE_IDEAL * 0.5 ** (scatter / 2) * (1 - friction) * noise,
        "n_plastic_contacts": 3000,
        "n_plastic_spheres": round(1500 * noise),
        "plastic_zone_volume_m3": 1e-3 * noise,
        "plastic_zone_depth_m": 0.1,
        "base_arrival_s": 3e-4 * (1 + scatter / 5),
        "velocity_normalised": 47.4,
        "energy_input_normalised": 1e5,
        "versions": {},
        **others,
    }


def write(directory: Path, settings: Iterable[dict[str, Any]], **others: Any) -> list[Path]:
    """Directories of runs, by their differences from a synthetic case."""
    written = []
    for n, labels in enumerate(settings):
        case = case_of(labels)
        place = directory / f"run{n}"
        place.mkdir(parents=True)
        (place / "case.toml").write_text(case.to_toml(), encoding="utf-8")
        write_json(place / "summary.json", summary_of(case, **others))
        written.append(place)
    return written


def settings(
    scatters: Iterable[float], frictions: Iterable[float] = (0.0,), seeds: int = 6, **others: Any
) -> list[dict]:
    """Every combination, ideal packings once; scatters in um."""
    return [
        {
            "packing.diameter_scatter": 1e-6 * scatter,
            "contact.friction": friction,
            "packing.seed": seed,
            **others,
        }
        for friction in frictions
        for scatter in scatters
        for seed in range(1, (seeds if scatter else 1) + 1)
    ]


def found_in(paths: Iterable[Path], base: Path) -> list[Study]:
    return studies_of(read_inputs(list(paths), base), ["tolerance"])


def packings_in(paths: Iterable[Path], base: Path) -> list[PackingRuns]:
    found = [(run.label, run.directory, run.summary) for run in read_inputs(list(paths), base).runs]
    return select(finished_runs(found))


def test_runs_are_put_together_by_what_is_hit(tmp_path: Path) -> None:
    paths = write(tmp_path / "a", settings([0, 1], seeds=2))
    paths += write(tmp_path / "b", settings([0, 1], seeds=2, material="steel"))
    paths += write(tmp_path / "c", [{"load.velocity": 10}])  # alone
    paths += write(
        tmp_path / "d", settings([1], seeds=1, **{"run.end_time": 2e-3}), end_time_s=2e-3
    )
    brass, steel = packings_in(paths, tmp_path)
    assert list(brass.runs) == list(steel.runs) == [IDEAL, Setting(scatter=1e-6)]
    assert [run.case.packing.seed for run in brass.runs[Setting(1e-6)]] == [1, 2]
    longer, other = brass.runs[Setting(1e-6)]
    assert (
        longer.directory.parent.name == "d" and other.directory.parent.name == "a"
    )  # the longest of equal ones
    assert steel.case.material.name == "steel"


def test_many_packings_with_friction_and_without_are_a_study_where_it_is_named(
    tmp_path: Path,
) -> None:
    materials = ["brass", "steel", "aluminium", "stainless-steel-316"]
    paths = [write(tmp_path / m, settings([0], frictions=(0, 0.3), material=m)) for m in materials]
    assert studies_of(read_inputs(list(itertools.chain(*paths)), tmp_path)) == []
    found = packings_in(itertools.chain(*paths), tmp_path)
    assert [packing.case.material.name for packing in found] == materials
    assert [packing.name for packing in found] == [
        "tolerances",
        "tolerances-2",
        "tolerances-3",
        "tolerances-4",
    ]
    assert found[1].label == "FCC packing of 24 × 24 × 12 steel spheres of 10 mm"


def test_a_scan_names_the_study(tmp_path: Path) -> None:
    points = grid(contact__friction=[0.0, 0.1, 0.2])
    plain = write_scan(tmp_path / "plain", points)
    named = write_scan(tmp_path / "named", points, study=["tolerance"])
    assert [len(studies_of(read_inputs([scan], tmp_path))) for scan in (plain, named)] == [0, 1]
    for name in ("tolerance-scatter", "tolerance-friction", "tolerance"):
        assert load_scan(name).study == ("tolerance",)


def test_neither_one_setting_nor_other_loads_are_a_study(tmp_path: Path) -> None:
    assert packings_in(write(tmp_path / "a", settings([1], seeds=5)), tmp_path) == []
    assert (
        packings_in(write(tmp_path / "b", [{"load.velocity": v} for v in (1, 2)]), tmp_path) == []
    )


def test_means_and_what_is_left(tmp_path: Path) -> None:
    (packing,) = packings_in(write(tmp_path, settings([0, 2, 5, 10], [0, 0.2])), tmp_path)
    five = Setting(scatter=5e-6)
    forces = [run.summary["wall_peak_force_N"] for run in packing.runs[five]]
    means = packing.means(FORCE)
    assert means[five] == estimate(forces) and len(forces) == 6
    assert means[IDEAL].exact and means[Setting(friction=0.2)].exact
    assert packing.left(DISSIPATED)[five].mean == pytest.approx(0.9)
    assert packing.left(FORCE)[five].mean == pytest.approx(
        FORCE_IDEAL / np.mean(forces)
    )  # less force is better
    assert [axis.name for axis in AXES if packing.along(axis)] == ["scatter", "friction"]


def test_the_report_says_what_is_left(tmp_path: Path) -> None:
    paths = write(tmp_path, settings([0, 0.01, 2, 10], [0, 0.2]))
    report = build(paths, tmp_path, "tolerance")
    assert [section.slug for section in report.sections][:2] == ["short", "verdict"]
    first, *_ = (
        part.text
        for part in report.sections[0].blocks
        if isinstance(part, Note) and part.tone == "lead"
    )
    said = [first, *(note.text for note in notes(report, "verdict"))]
    assert said[0].startswith("Peak force on the bottom, 1330 N in the ideal packing: from ")
    assert said[0].endswith(" (diameter scatter 0.01 µm).")
    assert said[1] == (
        "Dissipated fraction, 0.88 in the ideal packing: from 0.704 (diameter scatter 10 µm) to 0.88 (ideal)."
    )
    alike = table(
        report,
        "studies",
        "Neighbouring settings whose means do not differ significantly",
    )
    texts = [
        [cell.text for cell in row.values()]
        for row in alike
        if row["Quantity"].text.startswith("Peak")
    ]
    assert texts == [
        ["Diameter scatter", "Peak force on the bottom", "0 µm", "0.01 µm", at]
        for at in ("", "friction coefficient 0.2")
    ]
    rows = table(report, "studies", TABLE)
    assert len(rows) == 8 and [row["Seeds"].text for row in rows[:4]] == [
        "not random",
        "not random",
        "6",
        "6",
    ]
    assert (
        rows[0]["Peak force on the bottom"].text == "1330"
        and " ± " in rows[2]["Peak force on the bottom"].text
    )
    against = table(report, "studies", "Against the ideal packing")
    assert "not significantly different" in against[1]["Peak force on the bottom"].text
    needed = [row["Seeds for the force to ± 10 %"].value for row in rows]
    assert needed[:2] == [None, None] and max(filter(None, needed)) == 5
    kept = table(report, "studies", KEPT)
    texts = [[cell.text for cell in row.values()] for row in kept]
    assert texts[0][:4] == ["Diameter scatter", "Peak force on the bottom", "1330 N", "10 µm"]
    assert texts[0][4].startswith("41") and texts[0][7] == "all values in the scan"  # 1332/32 N
    assert texts[1][2:] == [
        "0.88",
        "10 µm",
        "0.704",
        "80 %",
        "6",
        "about 5 µm (between 2 and 10 µm)",
    ]
    (study,) = found_in(paths, tmp_path)
    assert [picture.name for picture in study.pictures] == [
        "tolerances_scatter", "tolerances_friction", "tolerances_scatter_friction", "tolerances_seeds",
    ]  # fmt: skip
    columns = study.pictures[0].drawing.columns
    assert set(columns["quantity"]) >= {"wall_peak_force_N", "friction_fraction", "base_arrival_s"}
    chosen = (columns["quantity"] == "wall_peak_force_N") & (columns["diameter_scatter_m"] > 0)
    assert np.all(columns["n"][chosen] == 6) and np.all(
        columns["low_95"][chosen] < columns["mean"][chosen]
    )


def test_a_damaged_result_is_left_out(tmp_path: Path) -> None:
    paths = write(tmp_path, settings([0, 2], seeds=3))
    (paths[-1] / "result.h5").write_bytes(b"no")
    (study,) = found_in(paths, tmp_path)
    assert [row[1].text for row in study.tables[0].rows] == ["not random", "2"]
    assert "so studies and comparisons omit it" in str(build(paths, tmp_path, "tolerance"))


def test_the_ideal_packing_is_missed_only_where_it_was_asked_for(tmp_path: Path) -> None:
    alone = write(tmp_path / "alone", settings([2, 5]))
    (study,) = found_in(alone, tmp_path)
    assert study.verdict == () and [table.caption for table in study.tables] == [TABLE]
    frictions = grid(contact__friction=[0.0, 0.1, 0.2])
    for name, undone, scatter, n_said in (
        ("ideal", {"failed": {1: "it broke"}}, 0.0, 1), ("missing", {"missing": [1]}, 0.0, 1),
        ("other", {"failed": {2: "it broke"}}, 5e-6, 0), ("scattered", {"failed": {1: "it broke"}}, 5e-6, 0),
    ):  # fmt: skip
        points = [
            point | ({"packing.diameter_scatter": scatter} if scatter else {})
            for point in frictions
        ]
        scan = write_scan(tmp_path / name, points, **undone)
        index = json.loads((scan / "scan.json").read_text())
        index["varied"] = ["contact.friction"]  # the scatter is set for all points
        for entry in index["points"]:
            entry["labels"].pop("packing.diameter_scatter", None)
        write_json(scan / "scan.json", index)
        (study,) = found_in([scan], tmp_path)
        said = [
            text
            for text in study.verdict
            if "ideal packing (no scatter, no friction) has not finished" in text
        ]
        assert len(said) == n_said, name


def test_real_packings(tmp_path: Path) -> None:
    """Gaps delay the wave; the table contains the values of the runs."""
    size = {"packing.size": [6, 6, 4], "run.end_time": 2e-4}
    for name, scatter, seed in (
        ("ideal", 0.0, 1),
        ("a", 2e-6, 1),
        ("b", 2e-6, 2),
        ("c", 1e-5, 1),
        ("d", 1e-5, 2),
    ):
        changes = size | {"packing.diameter_scatter": scatter, "packing.seed": seed}
        run_case(load_case("fcc-small", changes), tmp_path / name, figures=False)
    inputs = read_inputs([tmp_path / name for name in ("d", "b", "ideal", "a", "c")], tmp_path)
    (study,) = studies_of(inputs, ["tolerance"])
    assert (
        "FCC packing of 6 × 6 × 4 brass spheres of 10 mm, elasto-plastic contacts, 5 m/s, rigid wall"
        in study.title
    )
    (found,) = [part for part in study.tables if part.caption == TABLE]
    heads = [column.heading for column in found.columns]
    rows = [dict(zip(heads, row, strict=True)) for row in found.rows]
    forces = {run.label: run.summary["wall_peak_force_N"] for run in inputs.runs}
    expected = [forces["ideal"], (forces["a"] + forces["b"]) / 2, (forces["c"] + forces["d"]) / 2]
    assert [row["Peak force on the bottom"].value for row in rows] == pytest.approx(expected)
    assert [row["Seeds"].value for row in rows] == [0, 2, 2]
    arrivals = [row["Arrival at the bottom"].value for row in rows]
    assert arrivals == sorted(arrivals) and arrivals[-1] > 1.3 * arrivals[0]


def test_the_line_of_a_hardly_scattered_packing_is_the_band():
    case = load_case(
        "precompressed-fcc", {"packing.size": [3, 4, 12], "packing.diameter_scatter": 1e-12}
    )
    k = 0.4 * math.pi / (math.sqrt(2 / 3) * 0.01)
    bands = band_structure(
        without_scatter(case), f"0,0,0; 0,0,{k!r}", points=3, allow_floppy=True
    ).bands
    assert scattered_line(case, k) == pytest.approx(float(np.nanmax(bands.frequency[-1])), rel=1e-4)


def contact(folder: Path, **changes: Any) -> SphereContactRun:
    write_contact(folder, **changes)
    summary = json.loads((folder / "summary.json").read_text())
    return SphereContactRun(folder.name, folder, read_toml(folder / "case.toml"), summary)


def differences(study: Study) -> dict[str, dict[str, Any]]:
    """Values of the table of a study, by the name of the spheres and the heading."""
    (one,) = study.tables
    heads = [column.heading for column in one.columns[1:]]
    return {
        row[0].text: dict(zip(heads, [cell.value for cell in row[1:]], strict=True))
        for row in one.rows
    }


def test_differences_are_finite_elements_over_the_law(tmp_path: Path) -> None:
    runs = (
        contact(tmp_path / "alike"),
        contact(tmp_path / "unlike", difference=-0.09, partner=9.52e-3),
    )
    (study,) = make_studies({"sphere-contact": runs})
    found = differences(study)
    assert list(found) == ["brass, equal radii", "brass, radii 2 to 1"]
    alike, unlike = found.values()
    assert (alike["At 3 alpha_y"], alike["Largest, 1 to 10 alpha_y"]) == (
        pytest.approx(0.15),
        pytest.approx(0.15),
    )
    assert (alike["Smallest, beyond"], unlike["Smallest, beyond"]) == (
        pytest.approx(-0.05),
        pytest.approx(-0.14),
    )
    assert alike["Smallest unloading exponent"] == 1.33
    assert alike["Plastic dissipation in the softer sphere"] is None
    assert len(study.pictures) == 1 and not study.failed


def test_the_softer_sphere_takes_what_its_strain_and_strength_say(tmp_path: Path) -> None:
    run = contact(tmp_path / "unlike", material={"name": "steel", "yield_strength": 1100e6})
    (study,) = make_studies({"sphere-contact": [run]})
    share = differences(study)["brass and steel"]["Plastic dissipation in the softer sphere"]
    assert share == pytest.approx(0.3 / (0.3 + 2 * 0.1))


def test_other_runs_are_left_out(tmp_path: Path) -> None:
    run = contact(tmp_path / "elastic")
    assert (
        make_studies({"sphere-contact": [SphereContactRun("e", run.directory, run.case, {})]}) == []
    )
