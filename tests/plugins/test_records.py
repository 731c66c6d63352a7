"""Records of contacts in restart files, those of format 12 (1.0) too, and files of dents of any
size.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.bodies.rubbing import BRASS, MU, rubbing, same, state
from tests.helpers.bodies.two_spheres import LAW, R, value

EARLIER = Path(__file__).parents[1] / "earlier" / "restart_format_12"
MODELS = ("mindlin_rescale", "partial_slip")
DOUBLE = 8  # bytes
N_SPRING = 5  # doubles
N_DENT = 2
STATE = ("x", "v", "omega", "f")
CHAIN = [(2 * R * k, 0, 0) for k in range(12)]


def table(path: Path) -> np.ndarray:
    """Rows of a dump of one step."""
    lines = path.read_text(encoding="utf-8").splitlines()
    first = next(
        number for number, line in enumerate(lines) if line.startswith(("ITEM: E", "ITEM: A"))
    )
    return np.array([line.split() for line in lines[first + 1 :]], dtype=float)


@pytest.mark.parametrize("dents", ["", "-dents"])
@pytest.mark.parametrize("model", MODELS)
def test_restart_files_of_format_12_continue_as_they_did(lammps, tmp_path, model, dents):
    """The files beside them have the state 300 steps later, as that version computed it."""
    name = f"{model}{dents}"
    contact = " ".join(f"c_c[{column}]" for column in range(1, 7))
    motion = "id x y z vx vy vz omegax omegay omegaz fx fy fz"
    lammps(f"""newton off
atom_modify map yes
read_restart {EARLIER}/{name}.restart
pair_style gran/hysteretic 0.001 forgotten list
pair_coeff * * elastoplastic 110e9 0.34 300e6 friction 0.3 tangential {model}
neighbor 0.001 bin
fix m all gran/nve/sphere
timestep 2e-8
compute c all gran/hysteretic/local
run 300 post no
write_dump all local {tmp_path}/contacts {contact} modify format float %.17g
write_dump all custom {tmp_path}/end {motion} modify sort id format float %.17g
""")
    for kind in ("contacts", "end"):
        expected = table(EARLIER / f"{name}.{kind}")
        np.testing.assert_allclose(table(tmp_path / kind), expected, rtol=1e-12, atol=1e-18)


def test_a_record_has_only_what_is_in_use(lammps, tmp_path):
    """The history of the law is stored a second time only where there are initial dents."""

    def size(words: str, begin: str = "") -> int:
        """Size of the restart file of two spheres in contact: a record of each."""
        speeds = [(0, 0.3, 1.0), (0, 0, -1.0)]
        lmp = lammps(rubbing([(0, 0, 0), (0, 0, 2 * R)], BRASS + words, velocities=speeds))
        lmp.commands_string(f"run 300 post no\n{begin}\nwrite_restart {tmp_path}/r")
        return (tmp_path / "r").stat().st_size

    friction = f" friction {MU}"
    text = len(f" {friction} tangential partial_slip") + DOUBLE  # of pair_coeff, in the file
    bare = size("")
    rough = size(friction)
    slipping = size(f"{friction} tangential partial_slip")
    assert rough - bare == pytest.approx(2 * N_SPRING * DOUBLE, abs=text)
    history = round((slipping - rough) / (2 * DOUBLE))
    dented = size(f"{friction} tangential partial_slip", "gran/dents begin")
    assert dented - slipping == pytest.approx(2 * (N_DENT + history) * DOUBLE, abs=text)
    assert history > 30


def dented_chain(lammps, file: Path) -> dict[str, np.ndarray]:
    """State of a chain that begins with the dents of a file, after an impact."""
    extra = "compute en all gran/hysteretic/energy\nthermo_style custom step c_en\n"
    extra += f"gran/dents read {file}\n"
    lmp = lammps(script_of(CHAIN, velocities=[(3.0, 0, 0)], extra=extra))
    lmp.command("run 3000 post no")
    return state(lmp, "x", "v", "f") | {"stored": np.array(value(lmp, "c_en"))}


def rows_of_dents(between: str = " ") -> list[str]:
    return [
        f"{k}{between}{k + 1} {(20 + k) * LAW.yield_overlap:.17g}\n" for k in range(1, len(CHAIN))
    ]


def test_dents_are_read_in_pieces(lammps, tmp_path):
    """Rows that are filled up to a megabyte are more than one piece of the file."""
    (tmp_path / "short").write_text("".join(rows_of_dents()))
    (tmp_path / "long").write_text("".join(rows_of_dents(1_000_000 * " ")))
    same(dented_chain(lammps, tmp_path / "short"), dented_chain(lammps, tmp_path / "long"))
    repeated = [*rows_of_dents(1_000_000 * " "), "2 1 1e-6\n"]
    (tmp_path / "twice").write_text("".join(repeated))
    with pytest.raises(Exception, match=r"line 12 of .*: this contact was given before"):
        dented_chain(lammps, tmp_path / "twice")


@pytest.mark.validation
def test_a_file_of_dents_beyond_2_gigabytes(lammps, tmp_path):
    """The rows stand behind 2.2e9 bytes of comments."""
    (tmp_path / "short").write_text("".join(rows_of_dents()))
    comment = f"#{998 * ' '}\n" * 1000
    with (tmp_path / "long").open("w", encoding="ascii") as file:
        for _ in range(2200):
            file.write(comment)
        file.write("".join(rows_of_dents()))
    assert (tmp_path / "long").stat().st_size > 2**31
    same(dented_chain(lammps, tmp_path / "short"), dented_chain(lammps, tmp_path / "long"))
    with (tmp_path / "long").open("a", encoding="ascii") as file:
        file.write("1 2 deep\n")
    with pytest.raises(Exception, match=r"line 2200012 of .*: the dent must be a number"):
        dented_chain(lammps, tmp_path / "long")
    (tmp_path / "long").unlink()
