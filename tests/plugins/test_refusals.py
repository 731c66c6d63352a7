"""Words, values and commands that the styles reject, with their messages."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from tests.conftest import refuses, script_of
from tests.helpers.bodies.rubbing import rubbing
from tests.helpers.bodies.two_spheres import BOX, PAIR, R, collide, value

ONE = script_of([(0, 0, 0)])
BARE = "newton off\natom_style sphere\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\n"
GAP = f"{BARE}pair_style gran/hysteretic 0.1\n"
LIGHT = ONE.replace(
    "pair_style gran/hysteretic 0.001\npair_coeff * * elastoplastic 115e9 0.3 550e6",
    "pair_style zero 1e-3\npair_coeff * *",
)
LIGHT = LIGHT.replace("compute ep all pair gran/hysteretic\n", "").replace(" c_ep[1] c_ep[2]", "")
PUSHED = "fix push all gran/load z force harmonic 1 1\n"
TOP = "fix top all wall/gran/hysteretic zplane NULL 0.02 hertz 1e9 0.3\n"
SOME = "group one id 1\n" + TOP.replace("top all", "some one")
POINTS = BARE.replace("sphere", "atomic") + "mass 1 1\npair_style zero 1.0\npair_coeff * *\n"
GIVEN = "variable given equal 1.0\n"
LOSSY = rubbing(PAIR, "hertz 1e9 0.3 loss time 1e-6")
AT_A_FACE = script_of(
    [(0, 0, 0), (0, 0, R)], radius=[R, 0.0], style="hertz 1e9 0.3", extra="set atom 1 vz {}"
)
# what comes before, command with {} for the words, rows of words and message
REFUSED = {
    "damping": (ONE, "fix calm all gran/absorb {}", [
        ("speed 1", "'speed' is neither rate nor impedance"),
        ("rate 0", "rate must be positive, found 0"),
        ("rate 1 z", "found 3 arguments"),
        ("rate 1 z 2 2", "must increase between two different positions, found 2 and 2"),
        ("impedance 1", "found 2 arguments"),
        ("impedance 1 w", "direction 'w', expected x, y or z"),
        ("rate", "found 1 arguments"),
        ("rate 1\ngroup none subtract all all\nfix more none gran/absorb rate 1\nrun 0", "its group none has no atoms"),
    ]),
    "nve": (LIGHT, "fix more all gran/nve {}", [
        ("z", "it takes no words, found 'z'"),
        ("\nrun_style respa 2 2\nrun 0", "gran/nve does not work with run_style respa"),
    ]),
    "nve and rotation": (LIGHT, "fix more all gran/nve/sphere {}", [
        ("update dipole", "gran/nve/sphere: it takes no words, found 'update'"),
        ("\nrun_style respa 2 2\nrun 0", "gran/nve/sphere does not work with"),
    ]),
    "rotation of points": (POINTS, "{}", [
        ("fix more all gran/nve/sphere", "requires atom attributes radius, rmass, omega"),
    ]),
    "holder": (ONE, "fix holder all gran/holder {}", [
        ("z 0.3", "found 2 arguments"),
        ("w 0.3 9.81", "direction 'w', expected x, y or z"),
        ("z -0.1 9.81", "positive or 0, found -0.1"),
        ("z 0.3 0", "acceleration must be positive, found 0"),
        # forces that come after it
        ("z 0.3 9.81\nfix pull all addforce 0 0 1\nrun 1", "but fix addforce pull"),
    ]),
    "cylinders": (ONE, "fix round all gran/cylinder {}", [
        ("1 0 0 1 0", "the length of a cylinder must be positive, found 0"),
        ("1 0.01 0 0 0", "must be a direction"),
        ("2 0.01 0 1 0", "expected a type from 1 to 1"),
        ("1 0.01 0 1 0 1 0.02 0 1 0", "found type 1 twice"),
        ("1 0.01 0 1", "expected TYPE LENGTH AX AY AZ"),
        ("1 0.01 0 1 1\nfix w all wall/gran/hysteretic zplane -1 NULL hertz 1e9 0.3\nrun 0", "oblique to the wall"),
        ("1 0.01 0 1 0\nfix w all wall/gran/hysteretic zplane -1 NULL hertz 1e9 0.3 line soft", "half-space or plane-strain"),
        ("1 0.01 0 1 0\nfix w all wall/gran/hysteretic tube 0.1 hertz 1e9 0.3\nrun 0", "a tube "
            "holds spheres"),
        ("1 0.01 0 1 0\nset group all omega 1 0 0\nrun 0", "can rotate only about its axis"),
        ("1 0.01 0 1 0 line soft", "expected line half-space or plane-strain, found soft"),
        ("1 0.01 0 1 0\nfix more all gran/cylinder 1 0.01 0 1 0", "fix round"),
        ("1 0.01 0 1 0\nfix w all wall/gran/hysteretic zplane -1 NULL hertz 1e9 0.3 friction 0.1\nrun 0", "must come after all walls with friction"),
        ("1 2e-3 0 1 0\nfix w all wall/gran/hysteretic zplane -0.003 NULL hertz 1e9 0.3\nrun 0", "the law of a line contact: it is too short"),
    ]),
    "dents": (ONE, "gran/dents {}", [
        ("", "expected 'read FILE', 'begin' or 'clear'"),
        ("begin now", "expected 'read FILE', 'begin' or 'clear'"),
        ("read /nowhere/dents", "cannot read file /nowhere/dents"),
    ]),
    "dents without the pair style": (BARE + "pair_style zero 1.0\npair_coeff * *\n", "{}", [
        ("gran/dents begin", "requires pair style gran/hysteretic"),
    ]),
    "loads": (ONE, "fix push all gran/load {}", [
        ("q force half-sine 1 1", "direction 'q', expected x, y, z or vector"),
        ("vector 0 0 0 force half-sine 1 1", "a direction must not be zero, found 0 0 0"),
        ("vector 1 0 force half-sine 1 1", "Expected floating point"),
        ("z push half-sine 1 1", "neither force nor displacement"),
        ("z force sawtooth 1 1", "'sawtooth' is not a shape of a force"),
        ("z displacement half-sine 1 1", "'half-sine' is not a shape of a displacement"),
        ("z force half-sine 0 1", "amplitude must be positive, found 0"),
        ("z force rectangle 1 -1e-5", "duration must be positive"),
        ("z force half-sine 1", "arguments after 'half-sine'"),
        ("z force harmonic 1 1 1 1", "4 arguments after 'harmonic'"),
        ("z force burst 1 1e5 0", "number of cycles must be positive, found 0"),
        ("z force sweep 1 1e5 2e5 1e-4 6e-5", "ramp must be at most half the duration"),
        ("z force noise 1 1e3 2e3 1e-4 0 1", "noise cannot be used: no multiple of 1/T lies between its frequencies"),
        ("z force half-sine", "expected x|y|z"),
        ("z force table none.txt", "cannot read the table"),
        ("z force table falls.txt", "row 3 does not"),
        ("z force table early.txt", "first time is negative"),
        ("z force table short.txt", "at least two rows, found 1"),
        ("z force table words.txt", "line 3 of table .* must be two numbers, found '1 one'"),
    ]),
    "runs with a load": (ONE + PUSHED, "{}", [
        ("min_style fire\nminimize 0 0 1 1", "does not work with minimize"),
        ("group none subtract all all\nfix more none gran/load z force harmonic 1 1\nrun 0", "has no atoms"),
        ("fix more all gran/load z displacement harmonic 1 1\nrun 0", "that fix nve motion integrates"),
    ]),
    "other integrations": (LIGHT, "{}\nrun_style respa 2 2\nrun 1", [
        (f"{PUSHED}unfix motion", "does not work with run_style respa"),
        (TOP, "Fix wall/gran/hysteretic does not work with run_style respa"),
        ("fix calm all gran/absorb rate 1\n", "Fix gran/absorb does not work with run_style respa"),
        ("fix step all gran/timestep 32 3e-6 1.0\n", "works with run_style verlet, found respa"),
    ]),
    "losses": (ONE, "pair_coeff * * hertz 115e9 0.3 {}", [
        ("loss time", "'loss time' has no value"),
        ("loss 1e-6 2", "loss must be time, dashpot or prony, found '1e-6'"),
        ("loss time -1e-6", "loss time must not be negative"),
        ("loss time 1e-6 loss dashpot 0.1", "loss is given twice"),
        ("loss_tangential -1", "loss_tangential must not be negative, found '-1'"),
        ("friction 0.3 loss_tangential 1", "the normal damping, which is 0: set loss"),
        ("loss time 1e-6 loss_tangential 1", "is limited by friction, which is 0: set friction mu"),
        ("friction -0.1", "friction must not be negative, found '-0.1'"),
        ("friction", "'friction' has no value"),
        ("tangential slip", "tangential must be mindlin_rescale, mindlin or partial_slip, found 'slip'"),
        ("rolling 0.1 2", "expected rolling sds K|mindlin GAMMA MU, found 'rolling 0.1'"),
        ("rolling sds 1e6 0", "'rolling sds' has too few values"),
        ("rolling sds 0 0 0.1", "rolling stiffness must be positive"),
        ("twisting sds 1e6 0 -0.1", "twisting coefficient must not be negative, found '-0.1'"),
        ("twisting sds 1 0 0.1 twisting marshall", "twisting is given twice"),
        ("twisting marshall", "set friction mu"),
        ("cohesion 0.1 2", "cohesion must be jkr or dmt, found '0.1'"),
        ("cohesion jkr", "'cohesion jkr' has no value"),
        ("cohesion dmt -0.1", "cohesion dmt must not be negative, found '-0.1'"),
        ("cohesion dmt 0.1 cohesion jkr 0.1", "cohesion is given twice"),
        ("cohesion jkr 1e9\ncomm_modify vel yes\nrun 0", "held together up to a gap of .*; expected a gap of the pair style above it"),
    ]),
    "cohesion": (ONE, "pair_coeff * * {}", [
        ("elastoplastic 115e9 0.3 550e6 cohesion jkr 0.1", "cohesion jkr requires elastic "
            "spheres: use law hertz, or cohesion dmt with law 'elastoplastic'"),
        ("elastoplastic 115e9 0.3 550e6 cohesion dmt 0.1 rate 0.01 1", "cohesion requires a rate-independent yield strength"),
        ("power 115e9 0.3 constant 1e9 exponent 1.5 cohesion dmt 0.1", "has no contact circle, which cohesion requires"),
        ("hertz 115e9 0.3 cohesion dmt 0.1\nfix c all gran/cylinder 1 0.01 0 1 0\ncomm_modify vel yes\nrun 0", "found cylinders"),
    ]),
    "rates": (ONE, "pair_coeff * * {}", [
        ("elastoplastic 115e9 0.3 550e6 rate 0.01", "rate needs C and r0 for each of the materials"),
        ("elastoplastic 115e9 0.3 550e6 rate -0.01 1", "rate sensitivity must not be negative, found '-0.01'"),
        ("elastoplastic 115e9 0.3 550e6 rate 0.01 0", "reference rate must be positive, found '0'"),
        ("elastoplastic 115e9 0.3 550e6 rate fast 1", "rate sensitivity must be a number, found 'fast'"),
        ("elastoplastic 115e9 0.3 550e6 variant published rate 0.01 1", "rate requires a passive "
            "law: use variant continuous"),
        ("bilinear 115e9 0.3 550e6 rate 0.01 1", "'rate' is not an option of law 'bilinear'"),
        ("hertz 115e9 0.3 rate 0.01 1", "'rate' is not an option of law 'hertz'"),
    ]),
    "laws": (script_of([(0, 0, 0), (0, 0, 0.03)], types=[1, 2]), "pair_coeff {}", [
        ("1 1", "expected I J law and its constants"),
        ("2*2 1*1 hertz 115e9 0.3", "no pair of types I <= J in 2\\*2 1\\*1"),
        ("* * hertz 115e9 0.3 115e9 0.3", "a second material requires two different types"),
        ("* * elastoplastic 115e9 0.3 550e6 variant old", "variant must be continuous or published, found 'old'"),
        ("* * elastoplastic 115e9 0.3 550e6 variant published pressure_limit 2", "variant published has fixed constants"),
        ("* * elastoplastic 115e9 0.3 550e6 pressure_limit 0.1", "these constants do not give a passive law"),
        ("* * elastoplastic 115e9 0.3 550e6 yield_factor 0", "yield_factor must be positive, found '0'"),
        ("* * bilinear 115e9 0.3 550e6 beta 1", r"beta must lie in \[0, 1\), found '1'"),
        ("* * elastoplastic-fe 115e9 0.3 550e6 hardening 1", r"hardening must lie in \[0, 1\), found '1'"),
        ("1 2 elastoplastic-fe 115e9 0.3 550e6 115e9 0.3 INF hardening 0.1", "hardening needs a value for each of the two materials"),
        ("* * power 115e9 0.3 constant 1e9", "law power needs constant K and exponent p"),
        ("* * power 115e9 0.3 constant 1e9 exponent 0.5", "exponent must be 1 or more, found '0.5'"),
        ("* * power 115e9 0.3 constant 0 exponent 2", "constant must be positive, found '0'"),
        ("* * hertz 115e9 0.3\nfix c all gran/cylinder 1 0.01 0 1 0 2 0.01 0.005 1 0\nrun 0", "cylinders of types 1 and 2 are nearly parallel"),
        ("* * hertz 115e9 0.3\nset atom 2 z 0.004 diameter 0\nset atom 2 mass 1\nfix c all gran/cylinder 1 0.01 0 1 0\nrun 0", "a flat face touches a cylinder"),
    ]),
    "laws to come": (LOSSY + "run 1\n", "pair_coeff * * elastoplastic 115e9 0.3 550e6 {}\nrun 0", [
        ("loss time 1e-6 rate 0.01 1", "cannot be added once contacts have a loss: define all laws "
            "before the first run"),
    ]),
    "computes": (ONE, "compute c all gran/hysteretic/{}", [
        *((f"{kind} 1", f"Illegal compute gran/hysteretic/{kind}") for kind in ("atom", "local", "sums", "energy", "contact")),
        ("contact 1 1", "sphere 1 has no contact with itself"),
    ]),
    "computes without the pair style": (LIGHT, "compute c all gran/hysteretic/{}\nrun 0", [
        (kind, "requires pair style gran/hysteretic") for kind in ("atom", "local", "sums", "energy", "contact 1 2")
    ]),
    "atoms without radius": (POINTS, "{}\nrun 0", [
        ("fix c all gran/cylinder 1 0.01 0 1 0", "Fix gran/cylinder requires atom attribute radius"),
        ("fix w all wall/gran/hysteretic zplane NULL 1 hertz 1e9 0.3", "Fix wall/gran/hysteretic requires atom attribute radius"),
    ]),
    "plates": (ONE + f"{TOP.strip()} support free 0.5 6.0\nfix low all wall/gran/hysteretic zplane -1 NULL hertz 1e9 0.3\n", "{}", [
        ("fix_modify top velocity", "expected velocity V"),
        ("fix_modify low velocity 1", "velocity requires a free plate"),
    ]),
    "forgotten contacts": ("", "{}", [
        (
            rubbing([(0, 0, 0)], gap=f"2e-5 {words}"),
            "'forgotten sum' or 'forgotten list' and 'normals current' or 'normals initial', found",
        )
        for words in ("forgotten", "forgotten none", "remembered list", "forgotten list 1")
    ]),
    "walls": (ONE, "fix floor all wall/gran/hysteretic {}", [
        ("zplane 0 1", "expected"),
        ("qplane 0 1 hertz 1e9 0.3", "xplane"),
        ("zplane 1 0 hertz 1e9 0.3", "below"),
        ("zplane NULL 1 rubber 1 1", "unknown contact law"),
        ("tube -1 hertz 115e9 0.3", "the radius of the tube must be positive, found -1"),
        ("pipe 0.01 hertz 115e9 0.3", "expected xplane, yplane, zplane, tube, region or mesh, found pipe"),
        ("tube 0.01 hertz 115e9 0.3 support 0.5 1e8 2e3", "support moves a plane, found a tube"),
        ("tube 0.002 hertz 1e9 0.3\nrun 0", "does not fit into the tube"),
        ("zplane -1 1 hertz 1e9 0.3 support 1 1e6 0", "found two"),
        ("zplane NULL NULL hertz 1e9 0.3 support 1 1e6 0", "found none"),
        ("zplane NULL 1 support 1 1e6 0", "no contact law; expected"),
    ]),
    "supports": (ONE, "fix plate all wall/gran/hysteretic zplane NULL 0.005 hertz 115e9 0.3 support {}", [
        ("-1 1e6 0", "MASS must be a number, 0 or more, found '-1'"),
        ("free 0 1", "MASS of a free plate must be positive, found '0'"),
        ("damper 0", "DAMPING of a damper must be positive, found '0'"),
        ("1 0 0", "STIFFNESS and DAMPING are both 0"),
        ("0 1e6 0", "MASS and DAMPING are both 0"),
        ("1 soft 0", "STIFFNESS must be a number"),
        ("1 1e6", "found 2 arguments"),
        ("bar 0 1 1e6 free", "ELEMENTS must be a whole number"),
        ("bar 10 0 1e6 free", "MASS of a bar must be positive"),
        ("bar 10 1 0 free", "STIFFNESS of a bar's element must be positive"),
        ("bar 10 1 1e6 loose", "END of a bar, unless free or fixed"),
        # a timestep beyond the critical one
        ("1e-6 1e9 0\ntimestep 1e-7\nrun 100", "of the support, 6.32"),
        ("1e-9 1e3 0\nset atom 1 vz 2\ntimestep 1e-7\nrun 100", "with the spheres on it"),
        ("0 0 0.1\nset atom 1 vz 2\ntimestep 1e-7\nrun 100", "with the spheres on it"),
    ]),
    "timesteps": (ONE + GIVEN, "fix step all gran/timestep {}", [
        ("32 3e-6", "expected N TOLERANCE ENERGY"),
        ("24 3e-6 1.0", "N must be a power of two"),
        ("32 1e-2 1.0", "tolerance must be between 1e-12 and 0.001, found 1e-2"),
        ("32 3e-6 -1", "energy must be positive, or v_NAME, found -1"),
        ("32 3e-6 1.0 first 64", "first must be a power of two up to N, 32, found 64"),
        ("32 3e-6 1.0 balance v_given 0", "balance every 0, expected 1 or more"),
        ("32 3e-6 1.0 last 4", "found 'last'; expected N"),
        ("32 3e-6 1.0\nfix more all gran/timestep 32 3e-6 1.0", "fix step"),
        ("32 3e-6 v_each\nvariable each atom vx\nrun 0", "variable each is not of style equal"),
    ]),
    "runs with a timestep": (ONE + GIVEN + "fix step all gran/timestep 32 3e-6 v_given\n", "{}\nrun 64", [
        ("fix late all ave/time 32 1 32 v_given", "must come after all fixes that act at the end of a step, but fix late"),
        ("fix other all dt/reset 10 NULL 1e-7 1e-5", "fix dt/reset also changes the timestep"),
        ("run 64\ntimestep 1e-7", "the timestep was changed to 1e-07"),
        ("timestep 1e-7", "the timestep was changed to 1e-07"),
        ("variable given delete", "there is no variable given"),
    ]),
    "two bodies that cannot yield": (script_of([(0, 0, 0), (0, 0, 0.03)], types=[1, 2]), "{}", [
        (f"{command} {law} {words}", "needs a yield strength for one of the two bodies")
        for command in ("pair_coeff 1 2", "fix w all wall/gran/hysteretic zplane NULL 1")
        for law in ("elastoplastic", "thornton", "bilinear")
        for words in ("115e9 0.3 INF", "115e9 0.3 INF 1e9 0.3 INF")
    ]),
    "pair style": ("", "{}", [
        (f"{GAP}create_atoms 1 single 0.5 0.5 0.5\nset atom 1 diameter 0.1 density 1\npair_coeff * * hertz 1e5 0.3\nrun 0"
         .replace("newton off", "newton on"), "newton off"),
        (GAP.replace("sphere", "atomic") + "mass 1 1\npair_coeff * * hertz 1e5 0.3\nrun 0", "atom_style sphere"),
        (f"{GAP}pair_coeff * * rubber 1", "unknown contact law"),
        (f"{GAP}pair_coeff * * elastoplastic 1e9 0.3", "material constants"),
        (f"{GAP}pair_coeff * * elastoplastic 1e9 0.3 0.0", "positive"),
        (f"{GAP}pair_coeff * * hertz 1e9 0.7", "Poisson"),
        ("pair_style gran/hysteretic", "gap"),
        ("pair_style gran/hysteretic -1", "positive"),
        (f"{BARE}fix 1 all gran/hysteretic/history", "belongs to pair style"),
        (f"{ONE}run_style respa 2 2\nrun 1", "Pair style gran/hysteretic does not work with run_style respa"),
        (f"{ONE}pair_style hybrid gran/hysteretic 1e-3 gran/hysteretic 1e-3\npair_coeff 1 1 gran/hysteretic 1 hertz 1e9 0.3\n"
         "pair_coeff 1 1 gran/hysteretic 2 hertz 1e9 0.3\nrun 0".replace("hybrid", "hybrid/overlay"), "Only one pair style gran/hysteretic"),
        (script_of(PAIR, types=[1, 2], coefficients=["pair_coeff 1 1 hertz 1e9 0.3", "pair_coeff 2 2 hertz 1e9 0.3 friction 0.1"])
         + "comm_modify vel yes\nrun 0", "Types 1 and 2 have different laws or options for "
             "identical spheres: give pair_coeff 1 2"),
        (f"{ONE.replace('m m m', 'm m p')}{TOP}run 0", "the box is periodic across the wall"),
    ]),
    "states": ("", "{}run 2000", [
        (script_of([(0, 0, 0), (0, 0, 1e-9)]), "overlap by"),
        (script_of([(0, 0, 0), (0, 0, 0.9 * R)]), "overlap by"),
        (script_of(PAIR, velocities=[(0, 0, 1e7), (0, 0, 0)]), "of its radius in one timestep"),
        (AT_A_FACE.format(1e4), "overlap by .* flat face"),
        (AT_A_FACE.format(1e6), "moves by .* of its radius"),
    ]),
    "lines of dents": (script_of(PAIR, extra=TOP + SOME), "gran/dents read {}", [
        ("1 3 1e-6", "line 1 of .*: there is no sphere 3"),
        ("1 4294967298 1e-6", "there is no sphere 4294967298"),
        ("# first\n1 2 -1e-6", "line 2 of .*: the dent must not be negative, found '1 2 -1e-6'"),
        ("1 2 0.006", "line 1 of .*: the dent, 0.006, exceeds the radius of the smaller sphere"),
        ("1 1 1e-6", "a sphere has no contact with itself"),
        ("1 2 deep", "the dent must be a number"),
        ("1 2 nan", "the dent must be a number"),
        ("1 2", "expected 'i j peak' with the ids of two spheres, or 'FIXID i peak' of a wall, found '1 2'"),
        ("1 2 1e-6 4", "expected 'i j peak'"),
        ("1 2 1e-6 0 0 0", "behind it fx fy fz compliance and a block"),
        ("1 2 1e-6 0 0 0 -1", "behind it fx fy fz compliance and a block"),
        ("1 2 1e-6 0 0 inf 1", "the state of the contact must be numbers"),
        ("1 2 1e-6 0 0 1 1e-6", "line 1 of .*: the contact has another law, friction, loss"),
        ("1 2 1e-6 0 0 0 0 7", "the contact has another law"),
        ("top 1 1e-6 0 0 0 0", "compliance, two coordinates and a block"),
        ("top 1 1e-6 0 0 0 0 0 0 7", "the contact has another law"),
        ("floor 1 1e-6", "there is no fix wall/gran/hysteretic with the ID 'floor'"),
        ("motion 1 1e-6", "there is no fix wall/gran/hysteretic with the ID 'motion'"),
        ("1 2 1e-6\n2 1 1e-6", "line 2 of .*: this contact was given before"),
        ("top 7 1e-6", "there is no sphere 7"),
        ("top 1 0.006", "exceeds the radius of the sphere"),
        ("some 2 1e-6", "sphere 2 cannot have a dent: it is not in the group"),
    ]),
    "dents of spheres too far apart": (script_of([(0, 0, 0), (0, 0, 3 * R)]), "gran/dents read {}", [
        ("1 2 1e-6", "spheres 1 and 2 are farther apart than the gap beyond which an indentation "
            "is forgotten"),
    ]),
}  # fmt: skip
TABLES = {
    "falls": "0 0\n1 1\n1 2\n",
    "early": "-1 0\n1 1\n",
    "short": "0 1\n",
    "words": "# t F\n0 0\n1 one\n",
}


@pytest.mark.parametrize(
    ("what", "words", "message"),
    [(what, *row) for what, (*_, rows) in REFUSED.items() for row in rows],
)
def test_one_message_says_what_is_wrong(lammps, tmp_path, monkeypatch, what, words, message):
    monkeypatch.chdir(tmp_path)
    for name, rows in TABLES.items():
        (tmp_path / f"{name}.txt").write_text(rows)
    before, command, _ = REFUSED[what]
    if command.endswith("read {}"):
        (tmp_path / "dents").write_text(words)
        words = "dents"
    refuses(lammps(before), command.format(words), message)


@pytest.mark.parametrize(
    ("support", "message"),
    [("", "with a support"), ("support 1 1e6 0", "another number of elements")],
)
def test_a_restart_needs_its_support(lammps, tmp_path, support, message):
    wall = f"fix plate all wall/gran/hysteretic zplane NULL {R:.17g} hertz 115e9 0.3"
    lammps(
        script_of(
            [(0, 0, 0)],
            box=BOX,
            extra=f"{wall} support bar 400 0.3 6e10 free\nrun 100\nwrite_restart {tmp_path}/r",
        )
    )
    refuses(
        lammps(f"newton off\natom_modify map yes\nread_restart {tmp_path}/r"),
        f"{wall} {support}",
        message,
    )


ROUGH = rubbing(PAIR, "hertz 1e9 0.3 friction 0.1 rolling sds mindlin 0.0 0.1")
STEP = "fix step all gran/timestep 32 3e-6 1.0"


@pytest.mark.parametrize(
    ("before", "fix", "other", "message"),
    [
        (ONE, "fix push all gran/load z force harmonic 1 1", "fix push all gran/load z displacement harmonic 1 1", "push with a force"),
        (ONE, "fix c all gran/cylinder 1 0.01 0 1 0", "fix c all gran/cylinder 1 0.01 1 0 0", "c with other cylinders"),
        (ONE, TOP, TOP.replace("0.3", "0.3 loss time 1e-6"), "top with another law or friction"),
        (ONE, STEP, f"timestep 2e-8\n{STEP}", "step with ticks of .*, found a timestep of 2"),
        (ROUGH, "", "pair_coeff * * hertz 1e9 0.3 loss time 1e-6 rolling sds mindlin 0.0 0.1\nfix move all nve\nrun 0", "with another loss"),
    ],
)  # fmt: skip
def test_a_restart_needs_what_it_was_written_with(lammps, tmp_path, before, fix, other, message):
    lammps(f"{before}{fix}\nrun 5\nwrite_restart {tmp_path}/r")
    refuses(
        lammps(f"newton off\natom_modify map yes\nread_restart {tmp_path}/r\ntimestep 1e-8"),
        other,
        message,
    )


@pytest.mark.parametrize(
    ("style", "skipped", "found", "message"),
    [
        ("gran/load", 4, struct.pack("<d", 2.0), "format 2 of fix gran/load; this version reads format 3"),
        ("gran/hysteretic", 0, struct.pack("<i", 99), "format 99 of pair style gran/hysteretic; this version reads formats 12 to 13"),
    ],
)  # fmt: skip
def test_restart_of_another_format(lammps, tmp_path, style, skipped, found, message):
    lammps(f"{ONE}{PUSHED}run 5\nwrite_restart {tmp_path}/r")
    data = (tmp_path / "r").read_bytes()
    at = data.index(style.encode() + b"\0") + len(style) + 1 + skipped
    (tmp_path / "r").write_bytes(data[:at] + found + data[at + len(found) :])
    refuses(lammps(), f"newton off\nread_restart {tmp_path}/r\n{PUSHED}", message)


def test_contacts_are_not_read_while_they_are_not_current(lammps):
    lmp = lammps(
        f"{script_of(**THREE)}compute en all gran/hysteretic/energy\nrun 1\ngroup gone id 1\ndelete_atoms group gone"
    )
    with pytest.raises(
        Exception,
        match=r"not current: spheres were added, deleted or reordered .* use 'run 0' first",
    ):
        lmp.extract_compute("en", 0, 0)


def test_energy_that_overflows_is_an_error(lammps):
    lmp = lammps(
        script_of(
            [(0, 0, 0), (0, 0, 1.9e100)],
            radius=1e100,
            density=1.0,
            style="hertz 1e150 0.3",
            gap=1e99,
        )
    )
    refuses(lmp, "run 0", "the energy of the contacts is not a number")


THREE = {
    "positions": [(0.05, 0, 0), (0, 0, 0), (0, 0, 2 * R)],
    "velocities": [(0, 0, 0), (0, 0, 1.0), (0, 0, -1.0)],
}


@pytest.mark.parametrize(
    ("steps", "gap", "change"),
    [
        (800, 1e-3, "delete_atoms group gone"),  # in contact
        (20000, 1e-3, "delete_atoms group gone compress no\nreset_atoms id"),  # separated
        (30000, 2e-5, "delete_atoms group gone"),  # forgotten
    ],
)
def test_new_ids_of_dented_spheres_are_refused(lammps, steps, gap, change):
    lmp = lammps(script_of(**THREE, gap=gap) + f"run {steps}\ngroup gone id 1\n")
    assert value(lmp, "c_ep[2]") == 1
    with pytest.raises(Exception, match=r"The ID of sphere \d was \d when its contacts were made"):
        lmp.commands_string(f"{change}\nrun 0")


def test_new_ids_before_any_contact_are_fine(lammps):
    whole = lammps()
    fewer = lammps()
    collide(whole)
    fewer.commands_string(
        script_of(**THREE) + "group gone id 1\ndelete_atoms group gone\nrun 20000"
    )
    assert value(fewer, "abs(vz[1])") == pytest.approx(
        abs(value(whole, "vz[1]")), rel=1e-12
    )  # IDs are given in any order


@pytest.mark.parametrize(("length", "fits"), [(0.0239, False), (0.0241, True)])
@pytest.mark.parametrize("axis", "xyz")
def test_periodic_box_has_room_for_one_meeting_of_two_spheres(lammps, axis, length, fits):
    """Twice the reach: 2 (2 R + gap + skin) = 24 mm."""
    lmp = lammps()
    box = [-0.05, 0.05] * 3
    k = "xyz".index(axis)
    box[2 * k : 2 * k + 2] = [-0.002, length - 0.002]
    boundary = " ".join("p" if name == axis else "m" for name in "xyz")
    lmp.commands_string(
        script_of([(0, 0, 0)], box=box).replace("boundary m m m", f"boundary {boundary}")
    )
    if fits:
        lmp.command("run 1")
    else:
        with pytest.raises(Exception, match=rf"the periodic box is 0.0239 long in {axis}"):
            lmp.command("run 1")


@pytest.mark.parametrize(
    ("name", "wrong", "message"),
    [
        (
            "radius",
            -0.5 * R,
            rf"the radius -{0.5 * R:g}, expected a radius above 0, or 0 for a flat face",
        ),
        ("radius", np.nan, "the radius -?nan, expected a radius above 0"),
        ("rmass", 0.0, "the mass 0, expected a mass above 0"),
    ],
)
def test_radii_and_masses_without_meaning_are_refused(lammps, name, wrong, message):
    """LAMMPS itself lets a program or a fix set them."""
    lmp = lammps(script_of([(0, 0, 0), (0, 0, 2 * R)]))
    lmp.numpy.extract_atom(name)[1] = wrong
    refuses(lmp, "run 1", f"atom 2 has {message}")


@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize(
    ("force", "timestep", "place", "first"),
    [
        (-50, 1e-6, 0.0, "the load is too strong or the impact too fast"),
        (-50, 1e-4, 0.0, "the timestep is far too large"),
        (0, 1e-5, -1.2 * R, "initial position"),
    ],
)
def test_overlaps_name_their_likely_cause_first(lammps, wall, force, timestep, place, first):
    """A soft sphere is pressed onto another one, or a wall, that does not move."""
    lmp = lammps()
    floor = f"fix floor all wall/gran/hysteretic zplane {R:.17g} NULL hertz 1e4 0.3\n"
    places = [(0.04, 0, 2.5 * R if wall else 0), (0, 0, 2 * R + place)]
    lmp.commands_string(
        script_of(
            [*places] if wall else [(0, 0, 0), places[1]],
            style="hertz 1e4 0.3",
            box=[-0.1, 0.1] * 3,
        )
        + (floor if wall else "")
        + f"group held id 1\ngroup pressed id 2\nfix hold held setforce 0 0 0\nfix push pressed addforce 0 0 {force}\n"
        + f"timestep {timestep}\n"
    )
    with pytest.raises(Exception, match=rf": [a-z ]*{first}.*, or .*, or "):
        lmp.command("run 20000")
