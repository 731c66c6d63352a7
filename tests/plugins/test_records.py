"""Records of contacts in restart files, those of format 12 too, the reader of these files in
Python, and files of dents of any size.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from granwave.lammps_inputs.restart_file import RestartContacts, read_restart
from tests.conftest import script_of
from tests.helpers.bodies.rubbing import BRASS, HERTZ, MU, packing, rubbing, same, state
from tests.helpers.bodies.two_spheres import LAW, R, value

EARLIER = Path(__file__).parents[1] / "earlier" / "restart_format_12"
MODELS = ("mindlin_rescale", "partial_slip")
DOUBLE = 8  # bytes
N_SPRING = 5  # doubles
N_DENT = 2
STATE = ("x", "v", "omega", "f")
SLIPS = f"friction {MU} tangential partial_slip"
LAWS = {
    "elastoplastic": BRASS,
    "friction": f"{BRASS} friction {MU}",
    "partial slip": f"{BRASS} {SLIPS}",
    "Hertz, partial slip": f"{HERTZ} {SLIPS}",
}
WITH_FRICTION = [name for name, law in LAWS.items() if "friction" in law]
# columns of compute gran/hysteretic/local
IDS = slice(0, 2)
OVERLAP = 2
NORMAL_FORCE = 3
PEAK = 4
IS_LIVE = 11
SPRING_ENERGY = 13
TANGENTIAL_FORCE = slice(17, 20)
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
    """The files next to them contain the state 300 steps later, as computed by that version."""
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


# ---------------------------------------------------------------------- the reader in Python


def rubbed(lammps, law: str, between: str = ""):
    """Packing in random motion for 600 steps, with a command after the first half."""
    places, speeds, spins = packing(2)
    lmp = lammps(rubbing(places, law, velocities=3 * speeds, spins=3 * spins))
    lmp.commands_string("compute dents all gran/hysteretic/local\nrun 300 post no\n")
    lmp.commands_string(f"{between}\nrun 300 post no\n")
    return lmp


def live_contacts(lmp) -> np.ndarray:
    """Rows of the stored contacts, in the order of the IDs: (n_contacts, 20)."""
    rows = lmp.numpy.extract_compute("dents", 2, 2).copy()
    rows = rows[rows[:, IS_LIVE] == 1]
    return rows[np.lexsort(rows[:, IDS].T[::-1])]


def contacts_of(lmp, file: Path) -> RestartContacts:
    """Contacts that the reader finds in a restart file written now, in the order of the IDs."""
    lmp.command(f"write_restart {file}")
    contacts = read_restart(file).contacts
    assert contacts is not None
    order = np.lexsort(contacts.pairs.T[::-1])
    return RestartContacts(
        contacts.pairs[order], contacts.peak[order], contacts.spring[order], contacts.block[order]
    )


@pytest.mark.parametrize("between", ["", "gran/dents begin"], ids=["", "initial dents"])
@pytest.mark.parametrize("name", LAWS)
def test_the_reader_finds_the_values_of_the_compute(lammps, tmp_path, name, between):
    """Pairs, peaks and springs of a restart file are those of compute gran/hysteretic/local."""
    lmp = rubbed(lammps, LAWS[name], between)
    rows = live_contacts(lmp)
    contacts = contacts_of(lmp, tmp_path / "packing.restart")
    assert len(rows) > 20 and (rows[:, OVERLAP] > 0).any()
    np.testing.assert_array_equal(contacts.pairs, rows[:, IDS])
    np.testing.assert_array_equal(contacts.peak, rows[:, PEAK])
    force = contacts.spring[:, :3]
    np.testing.assert_array_equal(force, rows[:, TANGENTIAL_FORCE])
    assert force.any() == (name in WITH_FRICTION)
    slips = "partial slip" in name
    assert (contacts.block.shape[1] > 0) == slips
    if not slips:  # with partial slip the energy depends on the path
        energy = contacts.spring[:, 3] * (force**2).sum(axis=1) / 2
        np.testing.assert_allclose(energy, rows[:, SPRING_ENERGY], rtol=1e-12, atol=0)


def contact_lines(contacts: RestartContacts) -> str:
    """Contacts as lines of a file that gran/dents reads."""
    values = np.column_stack([contacts.peak, contacts.spring, contacts.block])
    return "".join(
        f"{i} {j} {' '.join(f'{number:.17g}' for number in row)}\n"
        for (i, j), row in zip(contacts.pairs, values, strict=True)
    )


@pytest.mark.parametrize("name", WITH_FRICTION)
def test_contacts_of_a_restart_file_are_those_that_gran_dents_sets(lammps, tmp_path, name):
    """Forces of a packing whose contacts came from the reader, as text, compared with the first.

    The peak of a contact that came as text is an initial dent, with the same force.
    """
    lmp = rubbed(lammps, LAWS[name])
    rows = live_contacts(lmp)
    contacts = contacts_of(lmp, tmp_path / "packing.restart")
    (tmp_path / "contacts").write_text(contact_lines(contacts), encoding="ascii")
    spheres = state(lmp, "x", "v", "omega")
    again = lammps(
        rubbing(spheres["x"], LAWS[name], velocities=spheres["v"], spins=spheres["omega"])
    )
    again.commands_string("compute dents all gran/hysteretic/local\n")
    again.commands_string(f"gran/dents read {tmp_path}/contacts\nrun 0 post no\n")
    read = live_contacts(again)
    np.testing.assert_array_equal(read[:, IDS], rows[:, IDS])
    for columns in (NORMAL_FORCE, TANGENTIAL_FORCE):
        largest = np.abs(rows[:, columns]).max()
        np.testing.assert_allclose(
            read[:, columns], rows[:, columns], rtol=1e-9, atol=1e-9 * largest
        )


# ---------------------------------------------------------------------- files of dents


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
    """Rows padded to a megabyte need more than one piece of the file."""
    (tmp_path / "short").write_text("".join(rows_of_dents()))
    (tmp_path / "long").write_text("".join(rows_of_dents(1_000_000 * " ")))
    same(dented_chain(lammps, tmp_path / "short"), dented_chain(lammps, tmp_path / "long"))
    repeated = [*rows_of_dents(1_000_000 * " "), "2 1 1e-6\n"]
    (tmp_path / "twice").write_text("".join(repeated))
    with pytest.raises(Exception, match=r"line 12 of .*: this contact was given before"):
        dented_chain(lammps, tmp_path / "twice")


@pytest.mark.validation
def test_a_file_of_dents_beyond_2_gigabytes(lammps, tmp_path):
    """The rows follow 2.2e9 bytes of comments."""
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


CONTACTS_ON_RANKS = """
compute dents all gran/hysteretic/local
gran/dents read contacts
run 400
write_dump all custom out id x y z vx vy vz omegax omegay omegaz modify sort id format float %.17g
"""


def test_contacts_are_read_on_two_processors(log_of, lammps, tmp_path):
    """Every processor keeps the contacts of its own spheres; results are bitwise identical to one
    processor.
    """
    law = LAWS["partial slip"]
    lmp = rubbed(lammps, law)
    contacts = contacts_of(lmp, tmp_path / "packing.restart")
    (tmp_path / "contacts").write_text(contact_lines(contacts), encoding="ascii")
    spheres = state(lmp, "x", "v", "omega")
    script = rubbing(
        spheres["x"], law, velocities=spheres["v"], spins=spheres["omega"], extra=CONTACTS_ON_RANKS
    )
    found = []
    for ranks in (1, 2):
        log_of(script, ranks)
        found.append((tmp_path / "out").read_text(encoding="utf-8"))
    assert found[0] == found[1]


# lines of the file, and the message
FAULTS_ON_RANKS = {
    "twice": ([*rows_of_dents(), "12 11 1e-6\n", "2 1 1e-6\n"], "line 12 of dents: this contact was given before"),
    "no sphere": ([*rows_of_dents(), "1 77 1e-6\n"], "line 12 of dents: there is no sphere 77"),
    "too deep": (["1 2 1e-6\n", "11 12 0.1\n"], "line 2 of dents: the dent, 0.1, exceeds the radius of the smaller sphere"),
    "far": (["11 12 1e-6\n", "1 12 1e-6\n"], "line 2 of dents: spheres 1 and 12 are farther apart"),
    "no number": ([*rows_of_dents(), "1 2 deep\n"], "line 12 of dents: the dent must be a number"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS_ON_RANKS)
def test_faults_of_a_file_of_dents_on_two_processors(lmp, tmp_path, name):
    """The first invalid line is named, wherever its spheres are, and both processors stop."""
    lines, message = FAULTS_ON_RANKS[name]
    (tmp_path / "dents").write_text("".join(lines), encoding="ascii")
    (tmp_path / "in.chain").write_text(
        script_of(CHAIN, extra="gran/dents read dents\n"), encoding="utf-8"
    )
    done = lmp(tmp_path / "in.chain", ranks=2)
    assert done.returncode != 0
    assert message in (tmp_path / "log.lammps").read_text(encoding="utf-8")
