"""All keys of all tables with values of every wrong type: one clear line with the key, and no
files.

The keys are those of the dataclasses that read them, so that new ones are included automatically.
Valid values of a key are determined by its type, and by the sets below: keys whose values may be
negative, zero or empty.
"""

from __future__ import annotations

import dataclasses
import datetime
import math
import shlex
import types
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import pytest
import tomli_w

from granwave.extensions.continuum.punch.case import Block, Punch, PunchRunSettings
from granwave.extensions.continuum.sphere_contact.case import Sphere, SphereContactRunSettings
from granwave.lammps_inputs.case import (
    added_grains,
    bodies,
    boundary,
    figures,
    output,
    precompression,
    run,
    schema,
)
from granwave.lammps_inputs.case.added_grains import AddedGrains, Repeat, Ring
from granwave.lammps_inputs.case.contact import contact, tables
from granwave.lammps_inputs.case.loads.registry import load_section
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.packing import packing
from granwave.workflows.cluster.profile import Profile, SlurmProfile
from granwave.workflows.scanning.header import ScanHeader
from tests.hostile.rows import entries_of, faults_in, run_here, shown_answer

BRASS = {"youngs_modulus": 115e9, "poisson_ratio": 0.3, "density": 8500.0, "yield_strength": 550e6}
PACKING = {"kind": "fcc", "size": [4, 4, 3], "diameter": 0.01}
SPHERES = {"material": BRASS, "packing": PACKING, "run": {"end_time": 4e-5, "frames": 3}}
PAIRED = SPHERES | {
    "material": BRASS | {"name": "m"},
    "pair": [{"materials": ["m", "m"], "friction": 0.1}],
}
CHAIN = SPHERES | {"packing": {"kind": "chain", "size": 6, "diameter": 0.01}}
FREE: dict[str, Any] = {"boundary": {"bottom": "free"}}
BAR = {"length": 0.1, "area": 1e-4, "elements": 50}
PULSE = {"kind": "force", "shape": "half-sine", "amplitude": 10.0, "duration": 1e-5}
BLOCK: dict[str, Any] = {"material": BRASS, "block": {}, "punch": {}, "run": {"elements": 2000}}
CONTACT = {"material": BRASS, "sphere": {"radius": 0.005}, "run": {"elements": 500}}
SCAN: dict[str, Any] = {"case": "case.toml", "grid": {"load.velocity": [1.0, 2.0]}}

CASE = "case.toml"
SLURM = "profile.toml"
COMMANDS = {
    CASE: "check case.toml",
    "scan.toml": "scan scan.toml --plan",
    SLURM: "scan scan.toml --plan --executor slurm --profile profile.toml",
}
OF_CONTACT: list[tuple[str, type, dict[str, Any]]] = [
    ("rolling", tables.Resistance, {"coefficient": 0.1, "stiffness": 1e6}),
    ("twisting", tables.Resistance, {"coefficient": 1e-5, "stiffness": 1e-2}),
    ("loss", tables.Loss, {"time": 1e-7}),
    ("cohesion", tables.Cohesion, {"kind": "dmt", "energy": 0.1}),
]
#: All tables: file, dotted name of the table, dataclass of its keys, and a valid file.
TABLES: list[tuple[str, str, type, dict[str, Any]]] = [
    (CASE, "material", Material, SPHERES),
    (CASE, "packing", packing.PackingSection, SPHERES),
    (CASE, "contact", contact.Contact, SPHERES | {"contact": {}}),
    (CASE, "load", load_section(), SPHERES | {"load": {}}),
    (CASE, "boundary", boundary.Boundary, SPHERES | {"boundary": {}}),
    (CASE, "boundary.bottom.plate", boundary.Plate, SPHERES
        | {"boundary": {"bottom": {"plate": {"mass": 1.0, "stiffness": 1e8}, "material": BRASS}}}),
    (CASE, "boundary.bottom.damper", boundary.Damper, SPHERES
        | {"boundary": {"bottom": {"damper": {"damping": 200.0}}}}),
    (CASE, "boundary.bottom.half_space", boundary.HalfSpace, SPHERES
        | {"boundary": {"bottom": {"half_space": {}, "material": BRASS}}}),
    (CASE, "boundary.bottom.bar", boundary.SupportBar, SPHERES
        | {"boundary": {"bottom": {"bar": BAR, "material": BRASS}}}),
    (CASE, "precompression", precompression.Precompression, SPHERES | {"precompression": {"kind": "uniform", "pressure": 1e4}}),
    (CASE, "run", run.RunSettings, SPHERES),
    (CASE, "output", output.Output, SPHERES | {"output": {}}),
    (CASE, "figures", figures.Figures, SPHERES | {"figures": {}}),
    (CASE, "absorb.1", bodies.Absorb, SPHERES | {"absorb": [{"layers": 1, "rate": 1e4}]}),
    (CASE, "pair.1", contact.Contact, PAIRED),
    (CASE, "pair.1", contact.Pair, PAIRED),
    *((CASE, f"contact.{name}", section, SPHERES | {"contact": {"law": "hertz", name: table}})
      for name, section, table in OF_CONTACT),
    (CASE, "contact.initial_overlap.1", tables.Dents,
        SPHERES | {"contact": {"initial_overlap": [{"overlap": 1e-7}]}}),
    (CASE, "contact.loss.dashpot", tables.DashpotRestitution,
        SPHERES | {"contact": {"loss": {"dashpot": {"restitution": 0.9}}}}),
    (CASE, "boundary.sides_touch", boundary.Touched,
        SPHERES | {"boundary": {"x": "wall", "sides_touch": {"material": ["m"]}},
                   "material": BRASS | {"name": "m"}}),
    (CASE, "output.probes.1", output.Probe, SPHERES | {"output": {"probes": [{"sphere": 3}]}}),
    (CASE, "figures.plane", figures.CutPlane,
        SPHERES | {"figures": {"plane": {"normal": [1.0, 0.0, 0.0]}}}),
    (CASE, "grains.1.ring", Ring, CHAIN | FREE
        | {"grains": [{"ring": {"n": 2, "radius": 0.02, "z": 0.01}, "diameter": 0.004}]}),
    (CASE, "grains.1.repeat", Repeat, CHAIN | FREE
        | {"grains": [{"at": [[0.02, 0.0, 0.0]], "diameter": 0.004,
                       "repeat": {"times": 2, "step": [0.0, 0.0, 0.01]}}]}),
    (CASE, "replace.1", bodies.Replace, SPHERES | {"replace": [{"index": 5, "diameter": 0.009}]}),
    (CASE, "striker.1", bodies.Striker, SPHERES | {"striker": [{"touches": 6, "velocity": [0, 0, 1]}]}),
    (CASE, "hold.1", bodies.Hold, SPHERES | {"hold": [{"index": 3}]}),
    (CASE, "guide.1", bodies.Guide, SPHERES | {"guide": [{"index": 3, "free": "z"}]}),
    (CASE, "grains.1", AddedGrains, CHAIN
        | {"grains": [{"at": [[0.02, 0.0, 0.0]], "diameter": 0.004}], "boundary": {"bottom": "free"}}),
    (CASE, "boundary.sides.tube", boundary.Tube, CHAIN | {"boundary": {"sides": {"tube": {"radius": 0.02}}}}),
    (CASE, "line.1", bodies.Line, SPHERES | {"line": [{"name": "down"}]}),
    (CASE, "sensor.1", bodies.Sensor, SPHERES | {"sensor": [{"name": "A", "id": 3}]}),
    (CASE, "bar", bodies.Bar, CHAIN | {"bar": BAR}),
    (CASE, "incident_bar", bodies.Bar, CHAIN | {"incident_bar": BAR, "load": PULSE}),
    (CASE, "block", Block, BLOCK),
    (CASE, "punch", Punch, BLOCK),
    (CASE, "run", PunchRunSettings, BLOCK),
    (CASE, "sphere", Sphere, CONTACT),
    (CASE, "run", SphereContactRunSettings, CONTACT),
    ("scan.toml", "", ScanHeader, SCAN),
    (SLURM, "slurm", SlurmProfile, {"slurm": {}}),
    (SLURM, "cluster", Profile, {"cluster": {}}),
]  # fmt: skip

MAY_BE_NEGATIVE = {
    "material.poisson_ratio", "contact.area_offset", "contact.residual_offset", "pair.1.area_offset",
    "pair.1.residual_offset", "grains.1.ring.z", "grains.1.ring.angle",
}  # fmt: skip
#: Read into a table: a number is its coefficient.
MAY_BE_A_NUMBER = {
    f"{table}.{way}" for table in ("contact", "pair.1") for way in ("rolling", "twisting")
}
MAY_BE_ZERO = MAY_BE_NEGATIVE | MAY_BE_A_NUMBER | {
    "packing.diameter_scatter", "packing.vacancies", "packing.seed", "contact.beta", "contact.friction",
    "contact.initial_overlap", "material.hardening", "material.rate_sensitivity", "run.velocity", "pair.1.beta", "pair.1.friction", "boundary.friction", "boundary.holder_friction", "load.angle",
    "contact.rolling.coefficient", "contact.rolling.damping", "contact.twisting.coefficient",
    "contact.twisting.damping", "contact.loss.time", "contact.loss.dashpot",
    "contact.loss.tangential",
    "contact.cohesion.energy",
    "contact.initial_overlap.1.overlap", "contact.initial_overlap.1.force",
    "boundary.side_gap", "line.1.leave_out", "boundary.bottom.plate.damping", "output.history", "punch.taper", "run.unloadings",
}  # fmt: skip
MAY_BE_EMPTY = {
    "boundary.sides_touch.group",
    "boundary.sides_touch.material",
    "figures.formats",
    "figures.only",
    "output.probes",
    "packing.vacancies",
    "cluster.before",
    "cluster.options",
    "slurm.before",
    "slurm.options",
}

NEVER: list[Any] = [{"x": 1}, math.nan, math.inf, datetime.date(2024, 2, 29), [True]]
HUGE: list[Any] = [
    1e300,
    10**30,
    "a" * 10_000,
]  # accepted or not, but immediately and without a traceback


def keys() -> Iterator[Any]:
    """Parameters of the test, one per key of each table."""
    for file, table, section, content in TABLES:
        hints = typing.get_type_hints(section)
        for field in schema.key_fields(section):
            key = f"{table}.{field.name}".removeprefix(".")
            if key != "pair.1.initial_overlap":
                kinds = kinds_of(hints[field.name], schema.info_of(field).type.words)
                yield pytest.param(file, key, kinds, content, id=f"{section.__name__} {key}")


def kinds_of(hint: Any, options: tuple[Any, ...] | None = None) -> set[Any]:
    """TOML types allowed by an annotation, `Literal` for words or numbers of a list."""
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return set().union(*(kinds_of(one, options) for one in typing.get_args(hint)))
    if options and hint in map(type, options):
        return {bool if hint is bool else Literal}
    if typing.get_origin(hint) is Literal:
        return {bool if isinstance(option, bool) else Literal for option in typing.get_args(hint)}
    return {typing.get_origin(hint) or hint}


def wrong_values(key: str, kinds: set[Any]) -> list[Any]:
    """Invalid values of a key."""
    rows = [
        (key not in MAY_BE_EMPTY, [[], ""]),
        (str not in kinds, ["nonsense"]),
        (bool not in kinds, [True]),
        (key not in MAY_BE_NEGATIVE, [-1]),
        (key not in MAY_BE_ZERO, [0]),
        (float not in kinds and key not in MAY_BE_A_NUMBER, [1.5]),
    ]
    return NEVER + [value for is_wrong, values in rows if is_wrong for value in values]


def with_value(content: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
    """Copy of the tables with one key changed; numbers in the key are indices of an array of
    tables.
    """
    name, _, rest = key.partition(".")
    if not rest:
        return content | {name: value}
    inner = content[name]
    if isinstance(inner, list):
        return content | {name: [with_value(inner[0], rest.partition(".")[2], value)]}
    return content | {name: with_value(inner, rest, value)}


@pytest.mark.parametrize(("file", "key", "kinds", "content"), list(keys()))
def test_key(
    file: str,
    key: str,
    kinds: set[type],
    content: dict[str, Any],
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    words = shlex.split(COMMANDS[file])
    (tmp_path / "case.toml").write_text(tomli_w.dumps(SPHERES), encoding="utf-8")
    (tmp_path / "scan.toml").write_text(tomli_w.dumps(SCAN), encoding="utf-8")
    for value in wrong_values(key, kinds):
        (tmp_path / file).write_text(
            tomli_w.dumps(with_value(content, key, value)), encoding="utf-8"
        )
        before = entries_of(tmp_path)
        answer = run_here(words, tmp_path, {}, capfd)
        shown = f"{key} = {value!r}\n{shown_answer(' '.join(words), answer)}"
        assert answer.returncode == 2, shown
        (fault,) = faults_in(answer.stderr)
        assert fault.startswith(f"granwave: {file}: ") and key in fault, shown
        assert entries_of(tmp_path) == before, shown
    for value in HUGE:
        (tmp_path / file).write_text(
            tomli_w.dumps(with_value(content, key, value)), encoding="utf-8"
        )
        answer = run_here(words, tmp_path, {}, capfd)
        assert answer.returncode in (0, 2), (
            f"{key} = {str(value)[:40]}\n{shown_answer(' '.join(words), answer)}"
        )
        assert bool(faults_in(answer.stderr)) == (answer.returncode == 2)


def test_the_tables_are_all_that_there_are() -> None:
    known = {section for _, _, section, _ in TABLES}
    for module in (added_grains, bodies, boundary, contact, tables, run, output, figures):
        for name, value in vars(module).items():
            if dataclasses.is_dataclass(value) and value.__module__ == module.__name__:
                fields = dataclasses.fields(value)
                assert value in known or not any(map(schema.is_key, fields)), f"{name} is not tried"
