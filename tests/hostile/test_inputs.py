"""Output of all rows of ``inputs.toml``: exit status, one clear line per error, and no unrequested
files.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from granwave.workflows.cli.main import main
from granwave.workflows.run.driver import run_case
from granwave.workflows.scanning import layout
from granwave.workflows.scanning.scan_file import load_scan
from tests.helpers.made_up.run_files import without_checksums
from tests.hostile import places
from tests.hostile.rows import Row, damage, entries_of, judge, parameters, read_rows, run_row

FOLDER, ROWS = read_rows()
RESULTS = ("run", "deck", "scan")


def write_folder(folder: Path) -> None:
    """Write the files available to every row."""
    for name, text in FOLDER.items():
        (folder / name).write_text(text, encoding="utf-8")


@pytest.fixture(scope="session")
def results(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Results of the case and scan of the folder, created on first use: ``run``, ``deck`` or
    ``scan``.
    """
    folder = tmp_path_factory.mktemp("hostile")
    write_folder(folder)

    def make(name: str) -> Path:
        directory = folder / name
        if directory.exists():
            return directory
        with pytest.MonkeyPatch.context() as patch:
            patch.chdir(folder)
            if name == "run":
                assert main(["run", "case.toml", "-o", "run", "--no-figures"]) == 0
            elif name == "deck":
                assert main(["write", "case.toml", "-o", "deck"]) == 0
            else:
                for point in load_scan("scan.toml").distinct.values():
                    run_case(point.case, layout.finished(directory, point.id), figures=False)
                    layout.write_state(
                        layout.finished(directory, point.id), state=layout.DONE_STATE, attempts=1
                    )
                assert main(["scan", "scan.toml", "-o", "scan", "--resume"]) == 0
        return directory

    return make


@pytest.fixture
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Folder with the files available to every row, which are all removable after the test.

    Its path contains nothing of the row, so that the expected words of a message do not occur in
    it.
    """
    folder = tmp_path_factory.mktemp("x") / "here"
    folder.mkdir()
    write_folder(folder)
    yield folder
    places.release(folder)


def test_every_row_has_a_name_of_its_own() -> None:
    names = [(row.kind, row.what) for row in ROWS]
    assert len(names) == len(set(names))
    kinds = {row.kind for row in ROWS}
    assert kinds >= {"files", "numbers", "names", "injection", "places", "damaged", "environment"}


@pytest.mark.parametrize("row", parameters(ROWS))
def test_input(
    row: Row, folder: Path, results: Callable[[str], Path], capfd: pytest.CaptureFixture[str]
) -> None:
    for name in row.prepared:
        if name in RESULTS:
            shutil.copytree(results(name), folder / name)
            if row.unchecked:
                without_checksums(folder / name)
        else:
            places.PLACES[name](folder)
    damage(row, folder)
    before = entries_of(folder.parent)
    answer = run_row(row, folder, capfd)
    after = entries_of(folder.parent)
    judge(row, answer, folder, before, after)
