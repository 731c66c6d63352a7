"""``granwave quantities``, and values among the words of ``granwave keys``."""

from __future__ import annotations

import pytest

from granwave.analysis.quantities import entries
from granwave.workflows.cli.main import main


@pytest.mark.parametrize("command", ["quantities", "keys"])
def test_a_value_is_looked_up_by_its_name(command, capsys):
    assert main([command, "zone_depth_90_m"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("zone_depth_90_m: ") and "(m)" in shown and "90 %" in shown


def test_all_values_are_listed(capsys):
    assert main(["quantities"]) == 0
    names = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert names == [entry.name for entry in entries()]


def test_a_member_of_a_family(capsys):
    family = next(entry.name for entry in entries() if "*" in entry.name)
    assert main(["quantities", family.replace("*", "top")]) == 0
    assert "top" in capsys.readouterr().out


def test_several_values(capsys):
    names = ("zone_depth_90_m", "peak_force_N")
    assert main(["quantities", *names]) == 0
    texts = capsys.readouterr().out.split("\n\n")
    assert [text.partition(":")[0] for text in texts] == list(names)
    assert main(["quantities", "zone_depth_90_m", "peak_forse_N"]) == 2
    shown = capsys.readouterr()
    assert "did you mean peak_force_N?" in shown.err and not shown.out


def test_an_unknown_value(capsys):
    assert main(["quantities", "peak_forse_N"]) == 2
    assert "did you mean peak_force_N?" in capsys.readouterr().err
