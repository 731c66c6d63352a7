"""Decks that were edited by hand: the analysis notices, and says what may be wrong."""

from __future__ import annotations

import logging

import numpy as np
import pytest

from granwave.analysis import Result, analyse
from granwave.lammps_inputs.directories import changed_files
from granwave.lammps_inputs.errors import InputError
from tests.helpers import synthetic

DATA, SCRIPT = "data.granwave", "in.granwave"


@pytest.fixture
def by_hand(tmp_path):
    """A deck of a chain that LAMMPS was run on by hand."""
    synthetic.write_run(tmp_path, synthetic.make_case("chain", 6))
    (tmp_path / "run.json").unlink()
    return tmp_path


def test_a_deck_as_written_gives_no_warning(by_hand, caplog):
    with caplog.at_level(logging.WARNING, "granwave"):
        assert analyse(by_hand, figures=False)["deck_changed"] is None
    assert not caplog.records


def test_an_edited_script_is_told(by_hand, caplog):
    path = by_hand / SCRIPT
    path.write_text(path.read_text().replace("elastoplastic", "hertz"))
    with caplog.at_level(logging.WARNING, "granwave"):
        assert analyse(by_hand, figures=False)["deck_changed"] == [SCRIPT]
    (message,) = (record.getMessage() for record in caplog.records)
    assert f"{path}: was changed after granwave wrote it" in message
    assert "material, law, load, walls, timestep and lattice are those of case.toml" in message


def test_positions_of_an_edited_data_file_are_used(by_hand, caplog):
    path = by_hand / DATA
    lines = path.read_text().splitlines()
    last = lines[-1].split()
    lines[-1] = " ".join([*last[:-1], "0.0501"])
    path.write_text("\n".join(lines) + "\n")
    with caplog.at_level(logging.WARNING, "granwave"):
        assert analyse(by_hand, figures=False)["deck_changed"] == [DATA]
    assert "positions, diameters and densities are those of the file" in caplog.text
    assert "it is newer than the output of LAMMPS" in caplog.text
    with Result(by_hand) as result:
        assert np.max(result["spheres/position"][:, 2]) == 0.0501


def test_data_changed_after_a_run_is_refused(by_hand):
    (by_hand / "run.json").write_text("{}")
    analyse(by_hand, figures=False)
    before = (by_hand / "result.h5").read_bytes()
    with (by_hand / DATA).open("a") as stream:
        stream.write("\n")
    with pytest.raises(InputError, match=r"data\.granwave: was changed after the run, and the positions"):
        analyse(by_hand, figures=False)
    assert (by_hand / "result.h5").read_bytes() == before


def test_script_changed_after_a_run_is_told(by_hand, caplog):
    (by_hand / "run.json").write_text("{}")
    with (by_hand / SCRIPT).open("a") as stream:
        stream.write("# a note\n")
    with caplog.at_level(logging.WARNING, "granwave"):
        analyse(by_hand, figures=False)
    assert "was changed after the run; the results are of what was run" in caplog.text


def test_directories_without_digests(by_hand):
    """Directories of earlier versions have none."""
    marker = by_hand / ".granwave"
    marker.write_text(marker.read_text().replace('"digests"', '"other"'))
    (by_hand / SCRIPT).write_text("")
    assert changed_files(by_hand) == []
