"""Other commands of LAMMPS: the rows of plugins/doc/other_commands.toml, from which the table of
the manual is generated.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from granwave import plugins
from granwave._contact_laws import ContactLaw
from tests.conftest import refuses, script_of
from tests.helpers.bodies.rubbing import BRASS, HERTZ, MU, TOTAL, packing, rubbing, state
from tests.helpers.bodies.two_spheres import BOX, LAW, PAIR, R, collide, value
from tests.helpers.manual import PAGES

ROOT = Path(__file__).parents[2]
TABLE = tomllib.loads((PAGES / "other_commands.toml").read_text(encoding="utf-8"))
ROWS = [row for section in TABLE["section"] for row in section["row"]]
DENTED = f"{BRASS} friction {MU}"
CUT = 1000
LENGTH = 3000
# of a periodic lattice
PITCH = 0.0099
SIDE = 3
HEADS_ON = [(0, 0, 1.0), (0, 0, -1.0)]
STIFFNESS = 4 / 3 * 115e9 / (2 * (1 - 0.3**2))  # E*


def lattice(law: str, pitch: float = PITCH, tilt: float | None = None, **options) -> str:
    """Periodic simple cubic lattice, in a box with a tilt `xy` if there is one."""
    places = pitch * (
        np.array([(x, y, z) for z in range(SIDE) for y in range(SIDE) for x in range(SIDE)]) + 0.5
    )
    side = SIDE * pitch
    if tilt is not None:
        shift = places[:, 1] * tilt / side
        places[:, 0] = shift + (places[:, 0] - shift) % side
    text = rubbing(places, law, box=[0, side] * 3, **options).replace(
        "boundary m m m", "boundary p p p"
    )
    return text if tilt is None else tilted(text, tilt)


def packed(law: str) -> str:
    places, speeds, spins = packing(2)
    walls = f"fix floor all wall/gran/hysteretic zplane {-R:.17g} {5.0001 * R:.17g} {law}\n"
    return rubbing(places, law, velocities=3 * speeds, spins=spins, extra=walls)


SCENES = {
    "rubbing": packed(DENTED),
    "smooth": packed(BRASS),
    "lossy": packed(f"{HERTZ} loss dashpot 0.1"),
    "periodic": lattice(BRASS),
    "row": script_of(PAIR, velocities=HEADS_ON),
}
BALL = "ball\n\n1 atoms\n\nCoords\n\n1 0 0 0\n\nTypes\n\n1 1\n\nDiameters\n\n1 0.01\n\nMasses\n\n1 0.004\n"
REFERENCES: dict[str, tuple[dict[str, np.ndarray], list[float]]] = {}


def ends(lmp) -> tuple[dict[str, np.ndarray], list[float]]:
    """Motion of the first spheres, and energies of contacts and walls."""
    motion = {name: values[:32] for name, values in state(lmp, "x", "v", "omega").items()}
    return motion, [value(lmp, f"c_en[{n}]") for n in (1, 6, 7)] + [
        value(lmp, f"f_floor[{n}]") for n in (4, 5, 9)
    ]


def reference(lammps, scene: str):
    if scene not in REFERENCES:
        REFERENCES[scene] = ends(
            lammps(f"{SCENES[scene]}run {CUT} post no\nrun {LENGTH - CUT} post no")
        )
    return REFERENCES[scene]


def commands(row: dict) -> str:
    script = SCENES[row.get("scene", "rubbing")]
    for word, other in row.get("replace", ()):
        changed = re.sub(word, other, script)
        assert changed != script, word
        script = changed
    second = row.get("run", f"run {LENGTH - CUT} post no")
    pieces = [
        row.get("first", ""),
        script,
        row.get("setup", ""),
        f"run {CUT} post no",
        row.get("between", ""),
        second,
    ]
    return "\n".join(pieces)


@pytest.mark.parametrize(
    "row",
    [row for row in ROWS if "message" in row or "same" in row],
    ids=lambda row: row["command"],
)
def test_a_command_works_or_is_refused(lammps, tmp_path, monkeypatch, row):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.mol").write_text(BALL)
    if "message" in row:
        refuses(lammps(), commands(row), row["message"])
        return
    scene = row.get("scene", "rubbing")
    motion, energies = ends(lammps(commands(row)))
    expected, as_much = reference(lammps, scene)
    for name, values in expected.items():
        if row["same"] == 0:
            assert np.array_equal(motion[name], values), name
        else:
            assert motion[name] == pytest.approx(
                values, rel=row["same"], abs=row["same"] * np.abs(values).max()
            ), name
    assert energies == pytest.approx(as_much, rel=max(row["same"], 1e-12))
    assert as_much[0] > 0 or scene == "lossy"


def test_each_row_is_tried():
    for row in ROWS:
        tried = [key for key in ("same", "message", "check", "elsewhere") if key in row]
        assert len(tried) == 1, row["command"]
        assert "answer" in row or "message" in row, row["command"]
        if "check" in row:
            assert hasattr(sys.modules[__name__], f"test_it_{row['check']}"), row["check"]
        if "elsewhere" in row:
            path, name = row["elsewhere"].split("::")
            assert f"def {name}(" in (ROOT / path).read_text(encoding="utf-8"), row["elsewhere"]


# ---------------------------------------------------------------------- runs


@pytest.mark.parametrize(
    "between", ["timestep 5e-9", "timestep 2e-8", "set group all density 9000"]
)
def test_it_balances(lammps, between):
    places, speeds, spins = packing(2)
    lmp = lammps(
        rubbing(places, DENTED, velocities=3 * speeds, spins=spins)
        + f"run {CUT} post no\n{between}\nrun 0 post no"
    )
    before = value(lmp, TOTAL)
    lmp.command("run 3000 post no")
    assert value(lmp, TOTAL) == pytest.approx(before, rel=1e-5)


def test_it_reruns(lammps, tmp_path):
    """On loading and unloading, from all steps of the run."""
    script = script_of(PAIR, velocities=HEADS_ON) + "timestep 1e-7\n"
    dump = "dump {0} all custom 1 {1}/{0} id type x y z fx fy fz\ndump_modify {0} format float %.17g sort id\n"
    lammps(f"{script}{dump.format('run', tmp_path)}run 600 post no").close()
    lammps(f"{script}{dump.format('again', tmp_path)}rerun {tmp_path}/run dump x y z").close()
    assert (tmp_path / "run").read_text() == (tmp_path / "again").read_text()


PRESSED = (
    "group held id 1\ngroup pressed id 2\nfix hold held setforce 0 0 0\nfix push pressed addforce 0 0 -400\n"
    "fix_modify push energy yes\ncompute one all gran/hysteretic/contact 1 2\nmin_style {}\n"
)


@pytest.mark.parametrize("style", ["fire", "quickmin"])
def test_it_minimizes(lammps, style):
    lmp = lammps(script_of(PAIR, extra=PRESSED.format(style)) + "minimize 0 1e-7 20000 100000")
    assert value(lmp, "c_one[2]") == pytest.approx(400, rel=1e-6)
    overlap = value(lmp, "c_one[1]")
    assert LAW.loading_force(overlap) == pytest.approx(400, rel=1e-6)
    assert value(lmp, "c_one[3]") == overlap > LAW.yield_overlap


@pytest.mark.parametrize("style", ["cg", "sd"])
def test_it_minimizes_elastic(lammps, style):
    lmp = lammps(
        script_of(PAIR, style=HERTZ, extra=PRESSED.format(style))
        + "min_modify dmax 1e-6\nminimize 0 1e-6 1000 10000"
    )
    assert value(lmp, "c_one[1]") == pytest.approx(
        (400 / STIFFNESS / np.sqrt(R / 2)) ** (2 / 3), rel=1e-5
    )


@pytest.mark.parametrize("command", ["plugin unload pair gran/hysteretic", "plugin clear"])
def test_it_unloads(lammps, command):
    lmp = lammps()
    collide(lmp)
    found = value(lmp, "vz[1]")
    lmp.command(command)
    assert not lmp.has_style("pair", plugins.PAIR_STYLE)
    assert "GRAN_HYSTERETIC_HISTORY" not in lmp.available_ids("fix")
    lmp.commands_string(f"clear\nplugin load {plugins.library()}")
    collide(lmp)
    assert value(lmp, "vz[1]") == found


# ---------------------------------------------------------------------- spheres that come, go, move or change

FAR = [(0.05, 0, 0), (0.05, 0, 2 * R)]


@pytest.mark.parametrize(
    "command",
    [
        "delete_atoms group gone compress no",
        "region all block INF INF INF INF INF INF\nfix thin gone evaporate 100 1 all 5",
    ],
)
def test_it_deletes(lammps, command):
    found = []
    for words in ("", command):
        lmp = lammps(
            script_of([*FAR, *PAIR], velocities=HEADS_ON * 2)
            + f"group gone id 1 2\nrun {CUT}\n{words}\nrun {CUT}"
        )
        found.append({name: values[-2:] for name, values in state(lmp, "x", "v").items()})
        if words:
            assert lmp.get_natoms() == 2 and value(lmp, "c_ep[2]") == 1
    assert all(np.array_equal(found[0][name], found[1][name]) for name in found[0])


def hertz(overlap: float, radii: tuple[float, float]) -> float:
    return STIFFNESS * np.sqrt(radii[0] * radii[1] / sum(radii)) * overlap**1.5


def test_it_sets(lammps):
    """A new type changes the law at the present peak; a new diameter changes overlap and radius."""
    one = "compute one all gran/hysteretic/contact 1 2\n"
    kinds = [f"pair_coeff 1 1 {BRASS}", f"pair_coeff 2 2 {HERTZ}", f"pair_coeff 1 2 {HERTZ}"]
    lmp = lammps(
        script_of(
            [*PAIR, (0.05, 0, 0)],
            types=[1, 1, 2],
            velocities=[*HEADS_ON, (0, 0, 0)],
            coefficients=kinds,
            extra=one,
        )
    )
    lmp.command("run 2500")
    overlap = value(lmp, "c_one[1]")
    peak = value(lmp, "c_one[3]")
    assert 0 < overlap < peak
    lmp.commands_string("set atom 1*2 type 2\nrun 0")
    assert value(lmp, "c_one[2]") == pytest.approx(hertz(overlap, (R, R)), rel=1e-12)
    assert value(lmp, "fz[2]") == pytest.approx(hertz(overlap, (R, R)), rel=1e-12)
    lmp.commands_string(f"set atom 1*2 type 1\nset atom 2 diameter {2.02 * R}\nrun 0")
    larger = ContactLaw(
        youngs_modulus=(115e9,) * 2,
        poisson_ratio=(0.3,) * 2,
        yield_strength=(550e6,) * 2,
        radius=(R, 1.01 * R),
    )
    assert value(lmp, "c_one[1]") == pytest.approx(overlap + 0.01 * R, rel=1e-12)
    force = larger.loading_force(overlap + 0.01 * R)
    assert value(lmp, "c_one[2]") == pytest.approx(force, rel=1e-12) == value(lmp, "fz[2]")


def test_it_grows(lammps):
    """Nothing moves, so that no list is rebuilt; at the end the sphere presses on another sphere
    and on a wall.
    """
    script = script_of(
        [*PAIR, (0.05, 0, 0)], radius=[R, R / 2, 1.1 * R], style=HERTZ, gap=1e-4,
        extra=f"fix top all wall/gran/hysteretic zplane NULL {3 * R:.17g} {HERTZ}\ncompute one all gran/hysteretic/contact 1 2\n"
        f"unfix motion\ngroup grows id 2\nvariable d equal {R:.17g}*(1+step/1000)\nfix grow grows adapt 1 atom diameter v_d",
    ).replace("atom_style sphere", "atom_style sphere 1")  # fmt: skip
    lmp = lammps(f"{script}run 1002")
    assert lmp.extract_setting("nlocal") == 3
    grown = R / 2 * 2.002
    assert value(lmp, "c_one[2]") == pytest.approx(hertz(grown - R, (R, grown)), rel=1e-9)
    on_wall = lmp.numpy.extract_fix("top", 1, 2)[lmp.numpy.extract_atom("id")[:3] == 2][0, 1]
    assert on_wall == pytest.approx(2 * STIFFNESS * np.sqrt(grown) * (grown - R) ** 1.5, rel=1e-9)


def test_it_is_rigid(lammps):
    """A sphere hits a rigid pair of spheres and rebounds with a third of its speed."""
    places = [*PAIR, (0, 0, 4 * R)]
    body = "unfix motion\ngroup body id 2 3\ngroup free id 1\nneigh_modify exclude group body body\nfix rigid body rigid single\nfix motion free nve"
    lmp = lammps(
        script_of(places, style=HERTZ, velocities=[(0, 0, 1), (0, 0, 0), (0, 0, 0)], extra=body)
        + "run 20000"
    )
    assert [value(lmp, f"vz[{n}]") for n in (1, 2, 3)] == pytest.approx(
        [-1 / 3, 2 / 3, 2 / 3], rel=1e-6
    )


def test_it_excludes(lammps):
    lmp = lammps(
        script_of(PAIR, velocities=HEADS_ON) + f"run {CUT}\ngroup one id 1\ngroup two id 2"
    )
    lost = value(lmp, "c_ep[1]")
    speed = value(lmp, "vz[1]")
    lmp.commands_string("neigh_modify exclude group one two\nrun 100")
    assert value(lmp, "c_ep[1]") == lost > 0 and value(lmp, "pe") == 0
    assert value(lmp, "vz[1]") == speed and value(lmp, "fz[1]") == 0


# ---------------------------------------------------------------------- the box


@pytest.mark.parametrize(
    "command",
    [
        "fix squeeze all deform 1 x scale 0.999 y scale 0.999 z scale 0.999 remap x\nrun 100",
        "change_box all x scale 0.999 y scale 0.999 z scale 0.999 remap\nrun 0",
    ],
)
def test_it_deforms(lammps, command):
    """All contacts of a lattice that just touches are pressed by a thousandth of its pitch."""
    lmp = lammps(
        lattice(BRASS, 2 * R, extra="unfix motion\ncompute dents all gran/hysteretic/local")
        + f"run 0\n{command}"
    )
    rows = lmp.numpy.extract_compute("dents", 2, 2) if lmp.command("run 0") is None else None
    overlap = 2e-3 * R
    assert len(rows) == 3 * SIDE**3 and overlap > LAW.yield_overlap
    assert rows[:, 2] == pytest.approx(overlap, rel=1e-9)
    assert rows[:, 3] == pytest.approx(LAW.loading_force(overlap), rel=1e-8)


def tilted(script: str, tilt: float) -> str:
    box = script.replace("region box block", "region box prism").replace(
        "units box\ncreate_box", f"{tilt:.17g} 0 0 units box\ncreate_box"
    )
    return f"box tilt large\n{box}"


def test_it_is_triclinic(lammps):
    """The same lattice in a cell that is tilted by its length, and then sheared, compared with the
    energy of its contacts.
    """
    rng = np.random.default_rng(4)
    speeds = rng.uniform(-2, 2, (SIDE**3, 3))
    side = SIDE * PITCH
    found = []
    for tilt in (0.0, side):
        lmp = lammps(lattice(DENTED, tilt=tilt or None, velocities=speeds) + "run 4000 post no")
        moved = state(lmp, "x", "v", "omega")
        moved["x"] = (moved["x"] + R) % side
        found.append((moved, [value(lmp, f"c_en[{n}]") for n in (1, 6, 7)]))
    (one, energies), (other, as_much) = found
    assert energies == pytest.approx(as_much, rel=1e-6) and energies[0] > 0
    for name in one:
        assert one[name] == pytest.approx(
            other[name], rel=1e-6, abs=1e-6 * np.abs(one[name]).max()
        ), name
    sheared = "unfix motion\nfix shear all deform 1 xy final 0.0029 units box remap x"
    lmp = lammps(lattice(HERTZ, tilt=0.0, extra=sheared) + "run 100\nunfix shear\nrun 0")
    overlaps = 2 * R - PITCH * np.array([1, 1, np.hypot(1, 0.0029 / side)])
    energy = SIDE**3 * 0.4 * STIFFNESS * np.sqrt(R / 2) * (overlaps**2.5).sum()
    assert value(lmp, "c_en") == pytest.approx(energy, rel=1e-9)


@pytest.mark.parametrize("tilt", [0.0, 0.013])
def test_a_dent_in_a_wall_passes_the_boundary_of_a_tilted_box(lammps, tilt):
    """The dent is at the position of an image: a second impact there is elastic."""
    floor = f"fix floor all wall/gran/hysteretic zplane {-R:.17g} NULL {BRASS}"
    script = script_of(
        [(0.01, 1e-9, 0)],
        box=[0, 0.0297] * 2 + [-0.02, 0.02],
        velocities=[(0, -1e-3, -2)],
        extra=floor,
    )
    lmp = lammps(tilted(script.replace("boundary m m m", "boundary p p m"), tilt) + "run 8000")
    lost = value(lmp, "f_floor[5]")
    speed = value(lmp, "vz[1]")
    lmp.commands_string(f"set atom 1 vz {-speed}\nrun 30000")
    assert value(lmp, "y[1]") > 0.02 and value(lmp, "vz[1]") == pytest.approx(speed, rel=1e-6)
    assert value(lmp, "f_floor[5]") == pytest.approx(lost, rel=1e-12) and lost > 0


# ---------------------------------------------------------------------- units, unfix


def test_it_has_metal_units(lammps):
    """The restitution of spheres of 5 nm, whose mass is in grams per mole, equals the restitution
    at any size.
    """
    si = lammps()
    metal = lammps()
    collide(si)
    volume = 1e-30 / 1.602176634e-19  # energy per volume, from Pa
    script = script_of(
        [(0, 0, 0), (0, 0, 100)], radius=50, density=8.5e-24 * 6.02214076e23, velocities=[(0, 0, 0.01), (0, 0, -0.01)],
        style=f"elastoplastic {115e9 * volume:.17g} 0.3 {550e6 * volume:.17g}", gap=10,
    ).replace("units si", "units metal").replace("timestep 1e-8", "timestep 0.01")  # fmt: skip
    metal.commands_string(f"{script}run 20000")
    assert value(metal, "vz[1]") == pytest.approx(value(si, "vz[1]") / 100, rel=1e-6)
    given = value(metal, "mass[1]") * 1e-4 * 1.0364269e-4
    assert value(metal, "c_ke+c_ep[1]") == pytest.approx(given, rel=1e-6)


def test_it_unfixes(lammps):
    fixes = {
        "plate": f"all wall/gran/hysteretic zplane NULL {3.001 * R:.17g} {BRASS} support 0.02 1e9 500",
        "push": "all gran/load z force half-sine 100 1e-5",
        "calm": "all gran/absorb rate 1e4",
        "holder": "all gran/holder x 0.3 9.81",
        "step": "all gran/timestep 32 3e-6 1.0",
    }
    lmp = lammps(
        script_of(PAIR, velocities=HEADS_ON, box=BOX)
        + "".join(f"fix {name} {words}\n" for name, words in fixes.items())
    )
    lmp.command("run 1024")
    assert value(lmp, "dt") > 1e-8
    for name in reversed(fixes):
        lmp.command(f"unfix {name}")
        assert value(lmp, "dt") == 1e-8
        total = value(lmp, "c_ke+pe+c_ep[1]")
        lmp.command("run 320")
    assert value(lmp, "c_ke+pe+c_ep[1]") == pytest.approx(total, rel=1e-6)


def test_unfixed_cylinders_are_there_until_the_next_run(lammps):
    """Energies between two runs refer to the present contacts."""
    crossed = [(0, 0, 0), (0, 0, 2 * R), (0, 0, -2 * R)]
    fixes = f"fix floor all wall/gran/hysteretic zplane {-3 * R:.17g} NULL {HERTZ}\nfix round all gran/cylinder 1 0.02 1 0 0 2 0.02 0 1 0"
    lmp = lammps()
    kinds = {"types": [1, 2, 2], "coefficients": [f"pair_coeff * * {HERTZ}"]}
    lmp.commands_string(
        rubbing(crossed, velocities=[(0, 0, -1)] * 3, extra=fixes, **kinds) + "run 800"
    )
    stored = value(lmp, "c_en")
    on_wall = value(lmp, "f_floor[4]")
    lmp.commands_string("unfix round\nset atom 3 diameter 0.01")
    assert value(lmp, "c_en") == stored > 0 and value(lmp, "f_floor[4]") == on_wall > 0
    lmp.command("run 0")
    assert 0 < value(lmp, "c_en") != stored
