"""Chains on elastic bars: the independent chain solver, ranks, echoes, invalid input."""

from __future__ import annotations

import pytest

from granwave.lammps_inputs.deck.deck import write_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.bodies import echoes
from granwave.workflows import load_case, run_case
from tests.helpers.chain_twin import Bar, Bead, Chain, rectangle

SHORT = {"packing.size": 8, "bar.length": 1.2, "bar.elements": 120, "run.end_time": 4e-4, "load.amplitude": 2e3}


def test_an_odd_bead_against_the_chain_twin(tmp_path):
    """Eight beads on a bar, the fifth of aluminium."""
    changes = SHORT | {"output.history": 0, "replace.1.index": 5}
    summary = run_case(load_case("intruder", changes), tmp_path / "run", figures=False).summary
    aluminium = Bead(modulus=67e9, density=2700.0, strength=150e6)
    beads = [aluminium if n == 5 else Bead() for n in range(1, 9)]
    twin = Chain(beads, "elastoplastic", right=Bar(area=1.27e-4, length=1.2, elements=120))
    record = twin.run(4e-4, 4e-8, load=rectangle(2e3, 1e-4))
    assert summary["energy_bar_J"] == pytest.approx(record.bar_energy[-1, 1], rel=2e-3)
    assert summary["wall_peak_force_N"] == pytest.approx(record.peak_force[-1], rel=1e-3)
    assert summary["energy_dissipated_J"] == pytest.approx(record.lost[-1], rel=1e-3)


def test_two_ranks_change_no_bit(lmp, tmp_path):
    changes = SHORT | {"run.end_time": 1e-4, "output.history": 50, "replace.1.index": 5, "output.dump_format": "text"}
    files = []
    for ranks in (1, 2):
        deck = write_deck(load_case("intruder", changes), tmp_path / str(ranks))
        done = lmp(deck.script, ranks=ranks)
        assert done.returncode == 0, done.stderr
        files.append([(deck.dumps / name).read_bytes() for name in ("history.dump", "spheres.dump", "walls.txt")])
    assert files[0] == files[1]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("bar.area=0", "bar.area: found 0, expected a number above 0"),
        ("bar.elements=4", "bar.elements: found 4 in 2.5 m, expected 27 or more"),
        ("replace.1.index=21", "replace.1.index: found 21, expected an id from 1 to 20"),
        ("load.duration=0", "load.duration: found 0, expected a number above 0"),
        ("boundary.bottom=wall", 'boundary.bottom: found "wall" beside [bar], expected "free"'),
        (
            "replace.1.material={youngs_modulus=67e9, poisson_ratio=0.3, density=2700}",
            "replace.1.material.yield_strength: missing; the elastoplastic law needs it",
        ),
        ("packing={kind='fcc', size=[4, 4, 4], diameter=0.01}", 'bar: found with packing.kind = "fcc"'),
    ],
)
def test_wrong_input_is_one_line(change, expected):
    with pytest.raises(InputError) as refused:
        load_case("intruder", [change])
    (line,) = refused.value.errors
    assert expected in line


def test_a_bar_that_is_too_short_is_told(caplog):
    load_case("intruder", {"bar.length": 2.0})
    assert "an echo of the end of the bar can reach the chain after 0.000805 s" in caplog.text
    caplog.clear()
    for name in ("intruder", "split-hopkinson", "bar-pulse"):
        load_case(name)
    assert not caplog.text


def test_echo_of_a_bar_behind_another():
    times = echoes(assemble(load_case("split-hopkinson")).bars)
    crossing = 2.0 / (200e9 / 8100) ** 0.5
    assert times == pytest.approx({"incident_bar": 3 * crossing, "bar": 3 * crossing})
