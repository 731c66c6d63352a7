"""Restart files: damaged ones, those of other formats and those with unknown laws end in an error."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from tests.helpers.rubbing import BRASS, MU, R, rubbing

WALL = f"fix wall all wall/gran/hysteretic zplane {-R:.17g} NULL hertz 115e9 0.3 support 1e-3 1e6 0"
PUSH = "fix push all gran/load z force half-sine 10 1e-3"
ATOM_STATE = struct.pack("<d", 0.7071067811865476)


def resume(lmp, path, *fixes: str) -> None:
    """Read a restart file and run no step."""
    lmp.commands_string(
        f"newton off\natom_modify map yes\ncomm_modify vel yes\nread_restart {path}\n"
        + "\n".join([*fixes, "fix motion all nve/sphere", "timestep 1e-8"])
        + "\ncompute en all gran/hysteretic/energy\nthermo_style custom step c_en[*]\nrun 0 post no"
    )


def laws(data: bytes) -> int:
    """Place of the state with the laws: behind format and settings, each state behind its size in bytes."""
    at = data.index(b"gran/hysteretic\0") + len(b"gran/hysteretic\0") + 4
    return at + 4 + struct.unpack("<i", data[at : at + 4])[0] + 4


def checksum(numbers: bytes) -> float:
    total = 0x9E3779B97F4A7C15 + len(numbers) // 8
    for (bits,) in struct.iter_unpack("<Q", numbers):
        total = ((total ^ bits) * 0xFF51AFD7ED558CCD) % 2**64
        total ^= total >> 32
    return float(total >> 12)


def ours(data: bytes) -> list[int]:
    """Places of our own bytes in a restart file: settings and laws, states of fixes, states with atoms."""
    at = data.index(b"gran/hysteretic\0") + len(b"gran/hysteretic\0")
    places = [*range(at, laws(data) + struct.unpack("<i", data[laws(data) - 4 : laws(data)])[0])]
    for style in (b"wall/gran/hysteretic\0", b"gran/load\0"):
        at = data.index(style) + len(style)
        (size,) = struct.unpack("<i", data[at : at + 4])
        places += range(at + 4, at + 4 + size)
    at = data.find(ATOM_STATE)
    while at >= 0:
        size = int(struct.unpack("<d", data[at - 8 : at])[0])
        places += range(at - 8, at - 8 + 8 * size)
        at = data.find(ATOM_STATE, at + 1)
    return places


def test_a_damaged_byte_is_an_error(lammps, tmp_path):
    """Any byte of settings, laws, contacts, forgotten contacts, walls and loads, and no signal and no other result."""
    lmp = lammps()
    places = [(0, 0, 0), (0, 0, 2 * R), (0, 0, 4 * R)]
    text = rubbing(
        places, f"{BRASS} friction {MU} loss time 1e-8", velocities=[(1, 0, 1), (0, 0, 0), (0, 0, -1)], gap=2e-5
    )
    lmp.commands_string(f"{text}{WALL}\n{PUSH}\nrun 9000 post no\nwrite_restart {tmp_path}/good.restart")
    data = (tmp_path / "good.restart").read_bytes()
    chosen = ours(data)
    assert len(chosen) > 1500
    resume(lammps(), tmp_path / "good.restart", WALL, PUSH)
    rng = np.random.default_rng(5)
    for at in rng.choice(chosen, 80, replace=False):
        damaged = bytearray(data)
        damaged[at] ^= 1 << rng.integers(8)
        (tmp_path / "bad.restart").write_bytes(damaged)
        lmp = lammps()
        with pytest.raises(Exception, match=r"damaged|format|give it again|law number"):
            resume(lmp, tmp_path / "bad.restart", WALL, PUSH)
        lmp.close()


def test_contacts_that_are_missing_are_an_error(lammps, tmp_path):
    """The name of the fix that holds them is damaged: LAMMPS alone would go on without them."""
    lmp = lammps(rubbing([(0, 0, 0), (0, 0, 2 * R)], velocities=[(0, 0, 1), (0, 0, 0)]) + "run 300 post no")
    lmp.command(f"write_restart {tmp_path}/a.restart")
    data = (tmp_path / "a.restart").read_bytes()
    (tmp_path / "a.restart").write_bytes(data.replace(b"GRAN_HYSTERETIC_HISTORY", b"GRAN_HYSTERETIC_HISTORx"))
    with pytest.raises(Exception, match="damaged: it holds no contacts"):
        resume(lammps(), tmp_path / "a.restart")


def test_an_unknown_law_is_refused(lammps, tmp_path):
    lammps(rubbing([(0, 0, 0), (0, 0, 2 * R)]) + f"run 0 post no\nwrite_restart {tmp_path}/a.restart")
    data = (tmp_path / "a.restart").read_bytes()
    at = laws(data) + 16
    (size,) = struct.unpack("<d", data[at - 8 : at])
    text = data[at + 8 : at + 8 + 8 * int(size)].replace(b"1 1 hertz", b"1 1 metal")
    assert b"metal" in text
    (tmp_path / "a.restart").write_bytes(
        data[:at] + struct.pack("<d", checksum(text)) + text + data[at + 8 + len(text) :]
    )
    with pytest.raises(Exception, match="unknown contact law 'metal'"):
        resume(lammps(), tmp_path / "a.restart")
