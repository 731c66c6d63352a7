"""Granular and continuum models: comparison for a small suite that is run once, and behavior of
suites.
"""

from __future__ import annotations

import csv
import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from pandas import DataFrame, concat

from granwave.analysis.document.model import DocumentTable, Note
from granwave.analysis.reports import studies as comparison
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.kinds import GranularKind
from granwave.analysis.reports.report import write_report
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun, read_run
from granwave.extensions.continuum.packing_and_block import figures as forces
from granwave.extensions.continuum.packing_and_block import impacts as groups
from granwave.extensions.continuum.packing_and_block import study, zone
from granwave.extensions.continuum.packing_and_block.impacts import Impacts, collect
from granwave.extensions.continuum.packing_and_block.study import select
from granwave.extensions.continuum.runs import ContinuumRun, read_elements
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import RUN
from granwave.workflows import library, load_case, load_scan, run_case
from granwave.workflows.cli.main import main
from granwave.workflows.scanning import driver
from granwave.workflows.scanning.suite import load_suite, run_suite

#: Reference, equal normalized velocities with E doubled (v/4), and three spheres with the energy of one.
GRANULAR = """
case = "fcc-impact"
[set]
packing.size = [8, 8, 6]
run.frames = 2
run.end_time = 2e-4
[[zip]]
load.velocity = [1, 2, 4, 8, 16, 32, 0.25, 2]
material.youngs_modulus = [115e9, 115e9, 115e9, 115e9, 115e9, 115e9, 230e9, 230e9]
[[points]]
load.velocity = 4.618802
load.spheres = 3
"""
CONTINUUM = """
case = "half-space"
[set]
run.elements = 1500
[[zip]]
punch.mass = [0.1, 0.1, 0.1, 0.01, 0.1]
punch.velocity = [8, 12, 16, 37.94733, 11.31371]
material.youngs_modulus = [115e9, 115e9, 115e9, 115e9, 230e9]
"""
pytestmark = [
    pytest.mark.xdist_group("comparison"),
    pytest.mark.validation,
]  # the suite is made by one process only
SUITE = 'name = "small"\nscans = ["granular.toml", "continuum.toml"]\n'


@pytest.fixture(scope="module")
def suite(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Directory of a finished suite."""
    files = tmp_path_factory.mktemp("suite")
    for name, text in (("granular", GRANULAR), ("continuum", CONTINUUM), ("suite", SUITE)):
        (files / f"{name}.toml").write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        # figures and reports of its scans, which are no subject here, take as long as all runs
        patch.setattr(driver, "_draw", lambda _: None)
        patch.setattr(driver, "publish", lambda *_: None)
        assert main(["scan", str(files / "suite.toml"), "-o", str(files / "out")]) == 0
    return files / "out"


@pytest.fixture(scope="module")
def impacts(suite: Path) -> Impacts:
    (found,) = select([run.kind.study_run(run) for run in read_inputs([suite], suite).whole()])
    return found


def test_refused_runs_are_left_out_of_the_comparison(
    suite: Path, tmp_path: Path, monkeypatch
) -> None:
    """This includes blocks, which have no run.json."""
    monkeypatch.setattr(comparison, "pictures_of", lambda *_: ())  # drawn elsewhere
    for point in sorted((suite / "continuum" / "points").iterdir())[:1]:
        shutil.copytree(point, tmp_path / "bad")
    values = json.loads((tmp_path / "bad" / "summary.json").read_text())
    (tmp_path / "bad" / "summary.json").write_text(json.dumps(values | {"end_reason": "refused"}))
    ResultDirectory(tmp_path / "bad").note_files(["summary.json"])
    inputs = read_inputs([suite, tmp_path / "bad"], tmp_path)
    assert [run.label for run in inputs.whole() if run.status == "refused"] == ["bad (refused)"]
    section = comparison.comparison_section(inputs, comparison.comparison_of(inputs))
    notes = [
        block.text for block in section.blocks if isinstance(block, Note) and block.tone == "bad"
    ]
    assert notes == ["Omitted here, because the energy balance did not close: bad (refused)."]
    assert "(refused)" not in str(section.blocks[:-1])


def test_a_comparison_names_what_it_leaves_out(suite: Path, tmp_path: Path) -> None:
    """Excluded runs are listed with the reason: friction, another packing."""
    whole = list(read_inputs([suite], suite).whole())
    runs = [run.kind.study_run(run) for run in whole]
    first = next(run for run in whole if isinstance(run.kind, GranularKind))
    for name, old, new in (
        ("rough", "friction = 0.0", "friction = 0.2"),
        ("other", 'kind = "fcc"', 'kind = "hcp"'),
    ):
        shutil.copytree(first.directory, tmp_path / name)
        case = tmp_path / name / "case.toml"
        assert old in case.read_text()
        case.write_text(case.read_text().replace(old, new))
        runs.append(read_run(name, tmp_path / name, first.summary))
    (note,) = study.remarks(runs)
    assert note.text.endswith("in the tables above and below: rough (friction).")
    (impacts,) = select(runs)
    labels = [row[0] for row in rows(impacts, "Dissipation per mass")]
    assert "other" in labels
    assert "other" in [row[0] for row in rows(impacts, "Plastic zone")]
    assert "granular, hcp 8 × 8 × 6, brass" in [row[1] for row in rows(impacts, "Plastic zone")]


def rows(impacts: Impacts, caption: str) -> list[list]:
    """Rows of a table of the comparison: values, or texts where there are none."""
    part = next(
        part
        for part in study.tables(impacts)
        if isinstance(part, DocumentTable) and part.caption.startswith(caption)
    )
    return [[cell.text if cell.value is None else cell.value for cell in row] for row in part.rows]


def velocities(runs: DataFrame) -> list[float]:
    return [run.case.load.velocity for run in runs.run]


def test_both_kinds_are_collected(impacts: Impacts) -> None:
    assert (len(impacts.granular), len(impacts.continuum)) == (9, 5)
    assert velocities(impacts.reference) == [1, 2, 4, 8, 16, 32]
    assert [run.case["punch"]["velocity"] for run in impacts.continuum_reference.run] == [8, 12, 16]


def test_fractions_collapse_on_normalised_axes(impacts: Impacts) -> None:
    ((name, n, largest),) = rows(impacts, "Granular scaling")
    assert (name, n) == ("modulus 230 GPa", 2)
    assert (
        largest < 5e-4
    )  # the equations are the same; timesteps and the ratios of overlap to diameter differ
    ((name, energy, fraction, volume),) = rows(impacts, "Continuum scaling")
    assert (name, energy) == ("modulus 230 GPa", pytest.approx(4.866, abs=1e-3))
    assert abs(fraction) < 0.01
    assert abs(volume) < 0.03  # sampled every 0.2 us, for all materials


def test_two_impacts_have_no_figure_of_similarity(impacts: Impacts) -> None:
    """Packings of two moduli at one velocity are no curve with which the other could agree."""

    def drawn(runs: DataFrame) -> set[str]:
        return {picture.name for picture in study.pictures(Impacts(runs, impacts.continuum[:0]))}

    single = impacts.granular[impacts.granular.struck_spheres == 1]
    energy = single.energy_J[single.youngs_modulus > 2e11].max()
    two = single[np.isclose(single.energy_J, energy)]
    assert len(two) == 2
    assert "granular_scaling" in drawn(single) and "granular_scaling" not in drawn(two)


def test_masses_are_compared_at_equal_energy(impacts: Impacts) -> None:
    light, heavy = (groups.masses(impacts)[name] for name in ("m = 0.01 kg", "m = 0.1 kg"))
    assert light.energy_normalised.iloc[0] == pytest.approx(
        heavy.energy_normalised.iloc[1], rel=1e-6
    )
    assert light.dissipated_fraction.iloc[0] == pytest.approx(
        heavy.dissipated_fraction.iloc[1], rel=0.5
    )


def test_loading_area_is_compared_at_equal_energy(impacts: Impacts) -> None:
    ((energy, one, three, difference),) = rows(impacts, "Loading area")
    run = next(impacts.reference[[v == 8 for v in velocities(impacts.reference)]].itertuples())
    assert (energy, one) == (pytest.approx(run.energy_normalised), run.dissipated_fraction)
    assert difference == pytest.approx(abs(three - one))


def test_quadratic_law_is_found_in_made_up_runs(impacts: Impacts) -> None:
    constants = (-40.0, 3.0, 0.45)

    def made(v: np.ndarray) -> Impacts:
        runs = concat([impacts.reference[:1]] * len(v)).assign(velocity_normalised=v)
        lost = np.polynomial.polynomial.polyval(v, constants)
        return Impacts(runs.assign(dissipated_fraction=lost / (0.5 * v**2)), impacts.continuum[:0])

    few = impacts.reference.velocity_normalised.to_numpy()
    assert (
        groups.quadratic_fit(made(few)) is None
    )  # too few from a tenth of the largest velocity on
    fit = groups.quadratic_fit(made(np.append(few, np.linspace(60, 290, 8))))
    assert fit is not None
    np.testing.assert_allclose(fit.constants, constants, rtol=1e-8)
    assert fit.misfit < 1e-10


def test_involved_material_did_the_dissipation(impacts: Impacts) -> None:
    for runs in (impacts.reference, impacts.continuum_reference):
        run = next(runs[-1:].itertuples())
        found = groups.involved(run)
        assert found is not None
        assert found.fraction[-1] == pytest.approx(run.dissipated_fraction, rel=1e-3)
        assert np.all(
            np.diff(np.diff(found.fraction) / np.diff(found.volume)) <= 1e-6 * found.fraction[0]
        )
        fraction, volume = found.part(0.9)
        assert 0.9 <= fraction / run.dissipated_fraction <= 1.0
        assert volume < found.volume[-1]
    mass, bulk = rows(impacts, "Dissipation per mass")[0][4:6]  # kg, cm^3 with voids
    assert 1e-6 * bulk / (mass / 8500) == pytest.approx(math.sqrt(18) / math.pi)


def test_peak_forces_grow_about_as_the_impulse(impacts: Impacts) -> None:
    found = forces.linear(impacts.reference[impacts.reference.velocity_normalised >= 40])
    assert found is not None
    assert found.contacts.exponent.median() == pytest.approx(1, abs=0.15)
    assert found.ray.shape[1] == len(found.velocity)
    assert np.all(np.diff(found.ray[0]) > 0)


def test_front_loses_its_peak(impacts: Impacts) -> None:
    found = forces.fronts(impacts.reference)
    assert len(found) == 4
    for front in found.values():
        assert front.depth[0] == 0
        assert np.all(np.diff(front.largest[1:4]) < 0)
        uniformity = front.uniformity.dropna()
        assert len(uniformity) >= 2
        assert np.all((uniformity > 0) & (uniformity <= 1))


def test_front_is_that_of_a_deeper_packing(tmp_path: Path) -> None:
    """Layers that a reflection from the base reached are left out."""
    fronts = []
    for n_layers in (10, 24):
        directory = tmp_path / str(n_layers)
        size = {"packing.size": [8, 8, n_layers], "run.end_time": 4e-4}
        run_case(load_case("fcc-small", size), directory, figures=False)
        with Result(directory) as result:
            fronts.append(forces._front(result, 1.0))
    short, deep = fronts
    assert np.isnan(short.uniformity.iloc[-1])
    for name in ("largest", "uniformity"):
        known = short[name].dropna()
        assert len(known) >= 5
        assert deep[name][known.index].to_numpy() == pytest.approx(known.to_numpy(), rel=0.03)


def test_zones_are_those_of_the_runs(impacts: Impacts) -> None:
    of_packings, of_blocks = zone.zones(impacts).values()
    assert velocities(of_packings) == [1, 2, 4, 8, 16, 32]
    assert len(of_blocks) == 3
    for one in (of_packings.iloc[-1], of_blocks.iloc[-1]):
        summary = one.run.summary
        diameter = 0.01
        assert [one[f"depth_{share}"] for share in (50, 90, 99)] == [
            summary[f"zone_depth_{share}_m"] / diameter for share in (50, 90, 99)
        ]
        assert one.volume_90 == pytest.approx(
            summary["zone_volume_90_m3"] / (math.pi * diameter**3 / 6)
        )
        assert one.energy == pytest.approx(one.energy_J / 2.630, rel=1e-3)  # J, of brass and 10 mm
    assert of_packings["mark"].iloc[-1] == zone.Mark.CUT
    assert not (of_blocks["mark"] == zone.Mark.CUT).any()
    third = impacts.reference[2:3]
    twin = third.assign(label="larger", n_spheres=800)
    found = zone.zones(Impacts(concat([impacts.granular, twin]), impacts.continuum[:0]))["packing"]
    assert "larger" in found.label.tolist()
    assert len(found) == len(impacts.reference)


def made_up(**columns) -> DataFrame:
    """Rows of packings, of which the first two are the reference."""
    n_runs = len(columns["label"])
    same = {
        "what": "granular", "substance": 0, "held": 0, "diameter": 2e-3, "material": "brass",
        "struck_spheres": 1, "yield_strength": 550e6, "youngs_modulus": 115e9,
        "poisson_ratio": 0.3, "density": 8500.0, "dissipated_fraction": 0.9,
    }  # fmt: skip
    return DataFrame({name: [value] * n_runs for name, value in same.items()} | columns)


def packings() -> Impacts:
    """Two velocities of a packing, another size, kind, diameter, and the first impact again."""
    runs = made_up(
        label=["a", "b", "size", "kind", "large", "again"],
        packing=["bcc 9", "bcc 9", "bcc 12", "hcp 9", "bcc 9", "bcc 9"],
        shape=[0, 0, 1, 2, 0, 0],
        substance=[0, 0, 0, 0, 1, 0],
        held=[0, 0, 0, 1, 0, 0],
        diameter=[2e-3, 2e-3, 2e-3, 2e-3, 4e-3, 2e-3],
        velocity_normalised=[1.0, 1.2, 4.0, 1.0, 1.0, 1.0],
        energy_J=[1.0, 1.44, 16.0, 1.0, 8.0, 1.0],
    )
    return Impacts(runs, made_up(label=[]))


def test_omitted_runs_have_their_own_reasons() -> None:
    impacts = packings()
    assert impacts.reference["label"].tolist() == ["a", "b"]
    assert groups.omitted_in_words(impacts, impacts.reference) == (
        "size (bcc 12); kind (hcp 9); large (diameter 4 mm); again (same impact as a)"
    )
    text = groups.omitted_in_words(impacts, impacts.granular[1:], "slow")
    assert text == "a (slow)"
    assert not groups.omitted_in_words(impacts, impacts.granular)


def test_rows_without_a_run_have_a_reason() -> None:
    impacts = packings()
    listed = impacts.granular[impacts.granular["label"].isin(["b", "size"])]
    assert study._unlisted(impacts, listed, ["b"]) == (
        "a (its input energy is within a factor of 2 of that of a listed run); "
        "size (nothing was dissipated by yielding, or the result cannot be read); "
        "kind (another packing); large, again (only 24 runs outside the reference are listed)"
    )


def test_lines_join_only_runs_that_differ_in_velocity() -> None:
    """The larger packing has another line, with its name."""
    impacts = packings()
    sizes = {name: np.arange(1.0, 7.0) for name in zone._columns()}
    sizes |= {f"outermost_{name}": np.arange(1.0, 7.0) for name in ("depth", "radius")}
    more = {"energy": impacts.granular.energy_J, "mark": 0, "energy_normalised": 1.0}
    ends = {f"outermost_{name}_open_ended": 0 for name in ("depth", "radius")}
    side = impacts.granular.assign(side="packing", **sizes, **ends, **more)[:3]
    empty = DataFrame(columns=side.columns)
    drawing = zone._zone_sizes({"packing": side, "continuum": empty}, ["depth"])
    axes = drawing.figure.axes[0]
    lines = [list(line.get_xdata()) for line in axes.lines if line.get_color() == zone.BLUE]
    assert [1.0, 1.44] in lines and [16.0] in lines
    assert not any(1.44 in line and 16.0 in line for line in lines)
    assert {text.get_text() for text in axes.texts} == {"bcc 9", "size"}
    words = zone._drawn_in_words(impacts, {"packing": side, "continuum": empty})
    assert words.startswith(
        "Lines join runs that differ only in the velocity. Reference: a, b; other packings: size. "
        "Not drawn: kind (hcp 9); large (diameter 4 mm); again (same impact as a)"
    )


def notes_on_zones(impacts: Impacts) -> list[str]:
    return [block.text for block in zone.tables(impacts) if isinstance(block, Note)]


def test_the_influence_of_the_bounds_is_computed_or_not_told(impacts: Impacts) -> None:
    """The numbers come from these runs only: none without two sizes, their differences with two
    sizes.
    """
    assert any("no impact was computed in two packings" in text for text in notes_on_zones(impacts))
    assert len(zone.differences_by_size(impacts, "packing")) == 0
    one = impacts.reference[2:3]
    run = one.run.iloc[0]
    size = run.summary["zone_volume_90_m3"]
    larger = run.summary | {"zone_volume_90_m3": 1.25 * size, "zone_cut": ["bottom"]}
    twin = one.assign(
        label="larger",
        n_spheres=800,
        run=FinishedRun("larger", run.directory, run.case, larger),
    )
    both = Impacts(concat([impacts.granular, twin]), impacts.continuum[:0])
    changes = zone.differences_by_size(both, "packing")
    assert len(changes) == 1
    assert changes.volume_90.tolist() == pytest.approx([0.2])
    assert changes.depth_90.tolist() == [0.0]
    text = " ".join(notes_on_zones(both))
    assert "1 impact was computed in packings of different sizes" in text
    differences = "0 % (depth), 0 % (radius), 20 % (volume)"
    assert f"for 90 % of the dissipation, {differences}" in text
    assert "36 × 36 × 18" not in text


def test_waves_from_bounds_are_told_with_the_share_of_these_blocks(impacts: Impacts) -> None:
    runs = impacts.continuum_reference
    first = runs.run.iloc[0]
    shares = {"wave_return_share": 0.0321, "zone_cut": []}
    marked = runs[:1].assign(
        run=ContinuumRun("wave", first.directory, first.case, first.summary | shares)
    )
    whole = concat([marked, runs[1:]])
    text = " ".join(notes_on_zones(Impacts(impacts.granular[:0], whole)))
    assert "at most 3.2 % of the plastic dissipation" in text
    assert "no impact was computed in two blocks of different sizes" in text
    larger = marked.assign(
        block_volume=2 * marked.block_volume,
        run=ContinuumRun(
            "larger",
            first.directory,
            first.case,
            first.summary | shares | {"zone_depth_90_m": 2 * first.summary["zone_depth_90_m"]},
        ),
    )
    changes = zone.differences_by_size(
        Impacts(impacts.granular[:0], concat([whole, larger])), "continuum"
    )
    assert changes.depth_90.tolist() == [0.5]


def test_suite_leaves_one_report_and_its_figures(suite: Path, tmp_path: Path, monkeypatch) -> None:
    page = (suite / "report.html").read_text(encoding="utf-8")
    expected = (
        "Report: small",
        "Dissipation and plastic zones",
        "Granular scaling",
        "Loading area",
        "modulus 230 GPa",
        "50, 90 and 99 %",
    )
    assert (suite / "granular" / "scan.csv").is_file() and [
        text for text in expected if text not in page
    ] == []
    names = {path.stem for path in (suite / "figures").glob("*.png")}
    assert names >= {
        "dissipated_fraction", "plastic_volume", "plastic_zone", "granular_scaling", "loading_area", "continuum_mass",
    }  # fmt: skip
    with (suite / "figures" / "dissipated_fraction.csv").open(encoding="utf-8") as file:
        assert {row["curve"] for row in csv.DictReader(file)} >= {
            "granular, D = 10 mm",
            "continuum, m = 0.1 kg",
        }
    monkeypatch.setattr(comparison, "pictures_of", lambda *_: ())
    other = write_report([suite / "granular", suite / "continuum"], tmp_path / "b.md").read_text(
        encoding="utf-8"
    )
    assert (
        other.startswith("# Report: granular, continuum\n")
        and "Dissipation and plastic zones" in other
    )


def test_finished_scan_of_a_suite_is_not_computed_again(
    suite: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    before = {path: path.stat().st_mtime_ns for path in suite.glob("*/points/*/summary.json")}
    assert main(["scan", str(suite.parent / "suite.toml"), "-o", str(suite)]) == 2
    assert "already holds results" in capfd.readouterr().err
    assert (
        main(
            [
                "scan",
                str(suite.parent / "continuum.toml"),
                "-o",
                str(suite / "continuum"),
                "--resume",
            ]
        )
        == 0
    )
    assert before == {
        path: path.stat().st_mtime_ns for path in suite.glob("*/points/*/summary.json")
    }
    assert json.loads((suite / "suite.json").read_text(encoding="utf-8"))["scans"] == [
        "granular",
        "continuum",
    ]


def test_runs_that_cannot_be_compared_are_left_out(impacts: Impacts, tmp_path: Path) -> None:
    run = impacts.reference.run.iloc[0]
    assert read_run("x", tmp_path, run.summary) is None
    assert read_elements("x", tmp_path, run.summary) is None
    assert len(collect([read_run("y", run.directory, {})]).granular) == 0
    assert select([]) == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('scans = []', "scans: found [], expected a list of names"),
        ('scans = "granular"', "expected a list of names"),
        ('scans = ["velocity-fcx"]', "did you mean velocity-fcc?"),
        ('scans = ["restitution", "restitution"]', "two scans of the name restitution"),
        ('scans = ["restitution"]\nranks = 2', "ranks"),
        ('scans = ["restitution"]\nname = "../up"', "a plain name"),
    ],
)  # fmt: skip
def test_wrong_suites_are_refused(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_suite(tmp_path / "s.toml")
    assert message in "\n".join(caught.value.errors)
    with pytest.raises(InputError, match="is a suite of scans"):
        load_scan("protection")


def test_a_suite_is_no_scan(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["scan", "protection", "-o", str(tmp_path / "out"), "--set", "load.velocity=1"]) == 2
    )
    assert "is a suite of scans" in capfd.readouterr().err


def test_nothing_runs_where_one_directory_is_taken(suite: Path, tmp_path: Path) -> None:
    small = load_suite(suite.parent / "suite.toml")
    taken = tmp_path / "continuum"
    taken.mkdir()
    ResultDirectory(taken).claim(["case.toml"], kind=RUN)
    (taken / "case.toml").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="holds a run"):
        run_suite(small, tmp_path)
    assert not (tmp_path / "granular").exists()


def test_built_in_suite_is_sound() -> None:
    names = {scan.name for scan in load_suite("protection").scans}
    assert len(names) > 1 and names <= set(library.names(library.SCANS))
