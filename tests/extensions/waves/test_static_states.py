"""Static states of cases compared with those of runs, for every kind of packing, support and
load.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.result.reader import Result
from granwave.extensions.waves.spectra.band_structure import band_structure
from granwave.extensions.waves.spectra.bands import solve_modes
from granwave.extensions.waves.spectra.states import State, packing_state
from granwave.extensions.waves.spectra.stiffness import stiffness_of
from granwave.extensions.waves.spectra.transmission import losses_of, transmission
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import run_case
from tests.helpers.selection import with_every_test

D = 0.01  # m
GRAVITY = {"kind": "gravity"}
UNIAXIAL = {"kind": "uniaxial", "force": 60.0}
WALLS = {"kind": "walls", "x": 1e-6, "y": 1e-6, "force": 60.0}
PRESSED = {"kind": "walls", "x_force": 30.0, "y": 1e-6, "force": 60.0}
BOX = {"bottom": "wall", "sides": "wall"}
ROUGH = {"law": "hertz", "friction": 0.3}
GUIDED = [{"index": [1, 2, 3, 4, 5], "directions": "xy"}]


def file_of(places: list[tuple[float, float, float]]) -> dict[str, Any]:
    """A packing of equal grains at positions given in diameters."""
    rows = [",".join(repr(D * part) for part in place) + f",{D}" for place in places]
    return {"kind": "file", "grains": "\n".join(["x,y,z,diameter", *rows]) + "\n"}


def pyramid() -> list[tuple[float, float, float]]:
    """Square layers of an FCC crystal, of 4 and 3 rows in turn."""
    places = []
    for layer in range(4):
        rows = 4 - layer % 2
        aside = 0.5 * (layer % 2)
        for row in range(rows):
            for place in range(rows):
                places.append((place + aside, row + aside, layer / math.sqrt(2)))
    return places


def rings() -> list[tuple[float, float, float]]:
    """Rings of three grains in a tube, each turned by 60 degrees against the one above."""
    places = []
    radius = 1 / math.sqrt(3)
    for ring in range(5):
        for grain in range(3):
            angle = math.pi * (2 * grain + ring % 2) / 3
            across = (radius * math.cos(angle), radius * math.sin(angle))
            places.append((*across, ring * math.sqrt(2 / 3)))
    return places


CHAIN = {"kind": "chain", "size": 5, "diameter": D}
COLUMN = file_of([(0.0, 0.0, place) for place in range(5)])
GAPS = file_of([(0.0, 0.0, place * (1 + 1e-4)) for place in range(5)])
OVERLAPS = file_of([(0.0, 0.0, place * (1 - 1e-5)) for place in range(5)])
HEXAGONAL = {"kind": "hexagonal", "size": [4, 6], "diameter": D}
FCC = {"kind": "fcc", "size": [4, 4, 4], "diameter": D}
SQUARE = {"kind": "square", "size": [4, 4], "diameter": D}
PLATE = {"kind": "plate", "mass": 0.1, "velocity": 1e-3}
PERIODIC = {"sides": "periodic", "bottom": "wall"}
TUBE = {"bottom": "wall", "sides": {"tube": {"radius": D * (1 / math.sqrt(3) + 0.5 + 1e-9)}}}

#: Packing, load, and the tables that differ, by name.
STATES: dict[str, tuple[dict[str, Any], dict[str, Any], dict[str, Any]]] = {
    "gaps, gravity": (GAPS, GRAVITY, {"hold": GUIDED}),
    "overlaps and a force": (OVERLAPS, {"kind": "overlaps", "force": 60.0}, {}),
    "overlaps and gravity": (OVERLAPS, {"kind": "gravity", "overlaps": True}, {}),
    "overlaps and walls": (OVERLAPS, WALLS | {"overlaps": True}, {"boundary": BOX}),
    "a chain and a grain": (CHAIN, UNIAXIAL, {"grains": [{"at": [[0, 0, 5 * D]], "diameter": D}]}),
    "hexagonal, gravity": (HEXAGONAL, GRAVITY, {"boundary": {"x": "wall"}}),
    "hexagonal, uniaxial": (HEXAGONAL, UNIAXIAL, {"boundary": {"x": "wall"}}),
    "hexagonal, walls": (
        HEXAGONAL,
        {"kind": "walls", "x": 1e-6, "force": 60.0},
        {"boundary": {"x": "wall"}, "contact": ROUGH},
    ),
    "hexagonal, pressed": (
        HEXAGONAL,
        {"kind": "walls", "x_force": 300.0, "force": 60.0},
        {"boundary": {"x": "wall"}, "contact": ROUGH},
    ),
    "fcc, gravity": (FCC, GRAVITY, {"boundary": PERIODIC, "contact": ROUGH}),
    "fcc, held": (FCC, UNIAXIAL, {"boundary": PERIODIC | {"bottom": "fixed"}}),
    "fcc, uniform": (FCC, {"kind": "uniform", "pressure": 1e6}, {"contact": ROUGH}),
    "fcc of a file, gravity": (file_of(pyramid()), GRAVITY, {"boundary": BOX}),
    "fcc of a file, uniaxial": (file_of(pyramid()), UNIAXIAL, {"boundary": BOX}),
    "fcc of a file, walls": (
        file_of(pyramid()),
        WALLS | {"x": 2e-6, "y": 2e-6},
        {"boundary": BOX, "contact": ROUGH},
    ),
    "fcc of a file, pressed": (
        file_of(pyramid()),
        {"kind": "walls", "x_force": 1000.0, "y_force": 900.0, "force": 60.0},
        {"boundary": BOX, "contact": ROUGH},
    ),
    "rings, tube": (
        file_of(rings()),
        {"kind": "walls", "tube_force": 900.0, "force": 60.0},
        {"boundary": TUBE, "contact": ROUGH},
    ),
    "square, gravity": (SQUARE, GRAVITY, {"contact": ROUGH}),
    "unlike beads, pressed": (
        CHAIN,
        PRESSED,
        {
            "boundary": BOX,
            "contact": ROUGH,
            "replace": [{"index": [3], "material": "steel", "diameter": 0.009}],
        },
    ),
    "dents by a force, of unlike beads": (
        CHAIN,
        UNIAXIAL | {"force": 30.0},
        {
            "contact": {"law": "elastoplastic", "initial_overlap": [{"force": 50.0}]},
            "replace": [{"index": [3], "material": "steel", "diameter": 0.007}],
        },
    ),
    "a power law, pressed": (
        CHAIN,
        PRESSED,
        {
            "boundary": BOX,
            "contact": {"law": "power", "constant": 1e9, "exponent": 1.4, "friction": 0.3},
        },
    ),
}
for packing_name, packing in (("chain", CHAIN), ("file", COLUMN)):
    walls_only = {"kind": "walls", "x": 1e-6, "y": 1e-6}
    STATES |= {
        f"{packing_name}, gravity": (packing, GRAVITY, {}),
        f"{packing_name}, uniaxial": (packing, UNIAXIAL, {}),
        f"{packing_name}, fixed": (packing, UNIAXIAL, {"boundary": {"bottom": "fixed"}}),
        f"{packing_name}, held": (packing, GRAVITY, {"hold": [{"index": [3], "directions": "z"}]}),
        f"{packing_name}, walls": (packing, WALLS, {"boundary": BOX, "contact": ROUGH}),
        f"{packing_name}, pressed": (packing, PRESSED, {"boundary": BOX, "contact": ROUGH}),
        f"{packing_name}, plate": (
            packing,
            walls_only,
            {"boundary": BOX, "contact": ROUGH, "load": PLATE},
        ),
    }


#: Each packing, support and static load once.
SHORT = (
    "gaps, gravity",
    "overlaps and a force",
    "overlaps and walls",
    "a chain and a grain",
    "hexagonal, walls",
    "hexagonal, pressed",
    "fcc, held",
    "fcc, uniform",
    "fcc of a file, gravity",
    "rings, tube",
    "square, gravity",
    "unlike beads, pressed",
    "dents by a force, of unlike beads",
    "a power law, pressed",
    "chain, fixed",
    "chain, held",
    "file, uniaxial",
    "file, plate",
)


def case_of(packing: dict[str, Any], static: dict[str, Any], **tables: Any) -> Case:
    given = {
        "name": "state",
        "material": "brass",
        "packing": packing,
        "contact": {"law": "hertz"},
        "precompression": static,
        "load": {"kind": "impact", "velocity": 1e-3},
        "run": {"end_time": 1e-7},
    }
    return case_from_dict(given | tables)


def run_of(case: Case, directory: Path) -> Path:
    run_case(case, directory, figures=False)
    return directory


def along(state: State, frequency: np.ndarray) -> np.ndarray:
    """Steady ratios of some grains to the first one."""
    axis = "z" if state.network.moves[:, 2].any() else "x"
    grains = state.network.ids[state.network.moves[:, "xyz".index(axis)]]
    sensors = [int(grain) for grain in grains[1:4]]
    stiffness = stiffness_of(state.network)
    return transmission(stiffness, int(grains[0]), sensors, frequency, axis=axis).ratio


@pytest.mark.parametrize("name", with_every_test(STATES, SHORT))
def test_a_case_has_the_state_of_its_run(name: str, tmp_path: Path) -> None:
    packing, static, tables = STATES[name]
    case = case_of(packing, static, **tables)
    own = packing_state(assemble(case))
    left = packing_state(run_of(case, tmp_path / "run"))
    assert len(own.network.springs) == len(left.network.springs)
    assert len(own.network.supports) == len(left.network.supports)
    assert own.network.left_out.tolist() == left.network.left_out.tolist()
    expected = solve_modes(stiffness_of(left.network)).square
    found = solve_modes(stiffness_of(own.network)).square
    assert found == pytest.approx(expected, abs=1e-6 * expected[-1])
    frequency = np.sqrt(expected[-1]) / (2 * math.pi) * np.array([0.13, 0.37, 1.2])
    assert along(own, frequency) == pytest.approx(along(left, frequency), rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("dents", [{}, {"initial_overlap": 2e-6}])
def test_contacts_that_yield(dents: dict[str, Any], tmp_path: Path) -> None:
    """Damped motion overshoots: contacts of the run are up to 0.2 % stiffer. Indentations at walls
    are as deep as those of pairs.
    """
    law = {"law": "elastoplastic", "friction": 0.3} | dents
    case = case_of(COLUMN, WALLS, boundary=BOX, contact=law)
    own = packing_state(assemble(case))
    left = packing_state(run_of(case, tmp_path / "run"))
    expected = solve_modes(stiffness_of(left.network)).frequency
    found = solve_modes(stiffness_of(own.network)).frequency
    assert found == pytest.approx(expected, rel=2e-3)


STEEL = {"youngs_modulus": 210e9, "poisson_ratio": 0.3, "density": 7800}


@pytest.mark.parametrize("kind", ["chain", "file"])
@pytest.mark.parametrize(("static", "lowest"), [(GRAVITY, 274.71), (UNIAXIAL, 424.13)])
def test_beads_on_a_wall(kind: str, static: dict[str, Any], lowest: float) -> None:
    """21 beads of 16 mm under their weight or 30 N: a matrix of Hertz's stiffnesses, along z."""
    n = 21
    size = 0.016
    packing: dict[str, Any] = {"kind": "chain", "size": n, "diameter": size}
    if kind == "file":
        rows = "".join(f"0,0,{size * place!r},{size}\n" for place in range(n))
        packing = {"kind": "file", "grains": "x,y,z,diameter\n" + rows}
    if "force" in static:
        static = static | {"force": 30.0}
    state = packing_state(assemble(case_of(packing, static, material=STEEL)))
    network = state.network.turned_off("z")
    found = solve_modes(stiffness_of(network)).frequency
    assert found[0] == pytest.approx(lowest, abs=0.005)
    modulus = STEEL["youngs_modulus"] / (1 - STEEL["poisson_ratio"] ** 2)
    mass = STEEL["density"] * math.pi * size**3 / 6
    load = mass * 9.81 * np.arange(1, n + 1) if static is GRAVITY else np.full(n, 30.0)
    radius = np.append(np.full(n - 1, size / 4), size / 2)
    effective = np.append(np.full(n - 1, modulus / 2), modulus)
    hertz = 4 / 3 * effective * np.sqrt(radius)
    stiffness = 1.5 * hertz ** (2 / 3) * load ** (1 / 3)
    matrix = np.diag(stiffness) + np.diag(np.append(0.0, stiffness[:-1]))
    matrix -= np.diag(stiffness[:-1], 1) + np.diag(stiffness[:-1], -1)
    expected = np.sqrt(np.linalg.eigvalsh(matrix / mass)) / (2 * math.pi)
    assert found == pytest.approx(expected, rel=1e-6)


def test_beads_between_walls_of_friction() -> None:
    """Along z: Hertz's springs of the force, and Mindlin's of four walls moved in by 1 um."""
    state = packing_state(assemble(case_of(COLUMN, WALLS, boundary=BOX, contact=ROUGH)))
    moves = np.zeros_like(state.network.moves)
    moves[:, 2] = True  # rotations are not coupled to it
    network = dataclasses.replace(state.network, moves=moves)
    found = solve_modes(stiffness_of(network)).frequency
    material = state.case.material
    modulus = material.youngs_modulus / (1 - material.poisson_ratio**2)
    shear = material.youngs_modulus / (2 * (1 + material.poisson_ratio))
    shear /= 2 - material.poisson_ratio
    mass = material.density * math.pi * D**3 / 6
    k = 1.5 * (4 / 3 * modulus / 2 * math.sqrt(D / 4)) ** (2 / 3) * 60.0 ** (1 / 3)
    bottom = 1.5 * (4 / 3 * modulus * math.sqrt(D / 2)) ** (2 / 3) * 60.0 ** (1 / 3)
    side = 4 * 8 * shear * math.sqrt(D / 2 * 1e-6)
    own = np.array([k, 2 * k, 2 * k, 2 * k, k + bottom]) + side
    matrix = np.diag(own) - k * (np.eye(5, k=1) + np.eye(5, k=-1))
    expected = np.sqrt(np.linalg.eigvalsh(matrix / mass)) / (2 * math.pi)
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("packing", "static", "tables", "says"),
    [
        (
            file_of(pyramid()),
            {"kind": "walls", "x": 2e-6, "y": 2e-6},
            {"boundary": BOX, "load": PLATE},
            "load.kind: found a plate without support, on which the packing exerts 22.5 N before "
            "the impact",
        ),
        (
            file_of(pyramid()),
            {"kind": "walls", "x": 2e-6, "y": 2e-6},
            {
                "boundary": BOX,
                "load": {"kind": "striker"},
                "striker": [{"touches": [6], "velocity": [0, 0, 1e-3]}],
            },
            "striker.1: found a striker on which grain 6 exerts a force before the impact",
        ),
        (
            HEXAGONAL,
            {"kind": "walls", "x_force": 100.0, "force": 60.0},
            {"boundary": {"x": "wall"}},
            "precompression",
        ),
        (
            COLUMN,
            {"kind": "walls", "x_force": 20.0, "force": 1.0},
            {"boundary": BOX, "contact": {"law": "elastoplastic", "initial_overlap": 2e-6}},
            "precompression.x_force: found walls that carry 0 N after the static stage, expected "
            "20",
        ),
        (
            COLUMN | {"cell": [[0, 0, 5 * D]]},
            UNIAXIAL,
            {"boundary": {"bottom": "free"}},
            "precompression.force: found a force on the top without a support",
        ),
        (
            CHAIN,
            UNIAXIAL,
            {"boundary": {"bottom": "wall", "holder_friction": 0.2}},
            "boundary.holder_friction: found 0.2, expected 0",
        ),
    ],
)
def test_states_that_nothing_holds(
    packing: dict[str, Any], static: dict[str, Any], tables: dict[str, Any], says: str
) -> None:
    with pytest.raises((InputError, RunError), match=says):
        packing_state(assemble(case_of(packing, static, **tables)))


@pytest.mark.parametrize("static", [WALLS, PRESSED | {"x_force": 240.0}])
def test_bands_between_walls_of_friction(static: dict[str, Any], tmp_path: Path) -> None:
    """The lowest frequency of a row is that of a bead on the springs of its walls; each of 24 beads
    carries its part of the force on the walls.
    """
    case = case_of(CHAIN | {"size": 24}, static, boundary=BOX, contact=ROUGH)
    own = band_structure(assemble(case), points=5)
    network = own.state.network
    assert len(network.supports) == 4
    side = network.supports.tangential.sum()
    expected = math.sqrt(side / network.mass[0]) / (2 * math.pi)
    assert own.bands.frequency[0, 0] == pytest.approx(expected, rel=1e-9)
    if "x_force" in static:
        pressed = network.supports.wall == "xhi"
        assert network.supports.force[pressed] == pytest.approx(10.0, rel=1e-9)
    left = band_structure(run_of(case, tmp_path / "run"), points=5)
    assert left.bands.frequency == pytest.approx(own.bands.frequency, rel=1e-6)


@pytest.mark.parametrize("stiffness", [None, (2e5, 0.3)])
def test_a_bead_that_resists_rolling_and_twisting(stiffness: tuple[float, float] | None) -> None:
    """On a wall under 20 N a sphere slides and rolls on the springs of friction and rolling, and
    rotates about the normal on the spring of twisting.
    """
    rolling: dict[str, Any] = {"coefficient": 0.01}
    twisting: dict[str, Any] = {"coefficient": 1e-5}
    if stiffness is not None:
        rolling |= {"stiffness": stiffness[0]}
        twisting |= {"stiffness": stiffness[1]}
    contact = ROUGH | {"rolling": rolling, "twisting": twisting}
    bead = file_of([(0.0, 0.0, 0.0)])
    state = packing_state(assemble(case_of(bead, UNIAXIAL | {"force": 20.0}, contact=contact)))
    network = state.network
    wall = network.supports
    tangential = float(wall.tangential[0])
    lever = float(wall.lever[0, 0])
    radius = D / 2
    circle = math.sqrt(radius * 2 * (radius - lever))
    roll = tangential if stiffness is None else stiffness[0]
    twist = tangential * circle**2 / 2 if stiffness is None else stiffness[1]
    mass = float(network.mass[0])
    inertia = float(network.inertia[0])
    sliding = np.array(
        [
            [tangential / mass, -tangential * lever / math.sqrt(mass * inertia)],
            [
                -tangential * lever / math.sqrt(mass * inertia),
                (tangential * lever**2 + roll * radius**2) / inertia,
            ],
        ]
    )
    both = np.linalg.eigvalsh(sliding)
    expected = np.sort([*both, *both, twist / inertia, float(wall.stiffness[0]) / mass])
    assert solve_modes(stiffness_of(network)).square == pytest.approx(expected, rel=1e-9)
    row = packing_state(assemble(case_of(COLUMN, WALLS, boundary=BOX, contact=contact))).network
    assert solve_modes(stiffness_of(row)).n_floppy == 0


def test_damping_of_rolling_is_no_part_of_a_steady_motion() -> None:
    contact = ROUGH | {"rolling": {"coefficient": 0.01, "damping": 1.0}}
    case = case_of(COLUMN, WALLS, boundary=BOX, contact=contact)
    with pytest.raises(InputError, match=r"contact\.rolling\.damping: found 1, expected 0"):
        losses_of(assemble(case), packing_state(assemble(case)).network)


def test_a_bead_rolls_in_a_run_as_its_modes_say(tmp_path: Path) -> None:
    """A bead with a spin about y on its wall moves along x at both frequencies of sliding and
    rolling.
    """
    contact = ROUGH | {"rolling": {"coefficient": 0.05, "stiffness": 2e6}}
    case = case_of(
        file_of([(0.0, 0.0, 0.0)]),
        UNIAXIAL | {"force": 20.0},
        contact=contact,
        load={"kind": "impact", "velocity": 1e-6, "spin": [0.0, 0.02, 0.0]},
        run={"end_time": 3e-3, "frames": 450},
    )
    moves = np.zeros((1, 6), dtype=bool)
    moves[0, [0, 4]] = True
    network = dataclasses.replace(packing_state(assemble(case)).network, moves=moves)
    expected = solve_modes(stiffness_of(network)).frequency
    with Result(run_of(case, tmp_path / "run")) as result:
        time = result["particles/spheres/contact_force/time"]
        motion = result["particles/spheres/displacement/value"][:, 0, 0]
    motion = (motion - motion.mean()) * np.hanning(len(motion))
    for frequency in expected:
        near = frequency * np.linspace(0.99, 1.01, 201)
        size = np.abs(np.exp(-2j * np.pi * np.outer(near, time)) @ motion)
        assert near[np.argmax(size)] == pytest.approx(frequency, rel=1e-3)
        assert 0 < np.argmax(size) < len(near) - 1


def test_five_steel_beads_along_their_row() -> None:
    """26.0 to 44.3 kHz, as in an earlier run: sliding along the walls, and rotation."""
    case = case_of(COLUMN, WALLS, boundary=BOX, contact=ROUGH, material="steel")
    network = packing_state(assemble(case)).network
    assert (len(network.springs), len(network.supports)) == (4, 21)
    found = solve_modes(stiffness_of(network.turned_off("z"))).frequency
    assert found[[0, -1]] == pytest.approx([26.0e3, 44.3e3], abs=50)
    ratio = transmission(stiffness_of(network), 1, [5], np.array([3e4])).ratio
    assert abs(ratio[0, 0]) > 0.01
