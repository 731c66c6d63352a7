"""Settling of a bed by LAMMPS: grains fall from a column, and come to rest with friction.

Grains fall under gravity with Hertz's law, friction and a loss; when their motion is small, drag
ends it. A small resistance to rolling and twisting stops grains that would spin or roll for ever.
The bed is at rest where the net force on each grain is a small fraction of the largest force, and
its motion carries a negligible energy. Without friction a bed has few more contacts than required
for stability: it creeps far under small forces, and is at rest at a minimum of its energy.
"""

from __future__ import annotations

import dataclasses
import math
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.packings.bed import Container
from granwave.extensions.packings.lammps_grains import (
    CONTACT_FORCE,
    FIRST,
    SECOND,
    TANGENTIAL_FORCE,
    Report,
    contact_table,
    grain_data,
    grain_script,
    positions_of,
)
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.packing.springs import springs_table
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.restart_file import read_restart
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import Engine, open_engine

Floats = NDArray[np.float64]

_DATA = "grains.data"
_STATE = "grains.restart"
# walls of a case by fix and side
WALLS = {
    ("bottom", 1): "bottom",
    ("tube", 1): "tube",
    ("x", 0): "xlo",
    ("x", 1): "xhi",
    ("y", 0): "ylo",
    ("y", 1): "yhi",
}
_OF_RAYLEIGH = 0.2  # timestep / time of a Rayleigh wave across the smallest grain
_LOOKS = 20  # checks of the motion during the time of the fall
_DRAG_TIME = 0.02  # time constant of drag / time of the fall
_MOST_TIMES = 40  # longest time of falling, and of drag, in times of the fall
# kinetic energy of a grain / m g D at which drag begins, and at the end
_SLOW = 1e-3
_AT_REST = 1e-9
_BALANCED = 3e-4  # net force on a grain / largest force, at the end
# without friction: kinetic energy at which the search for a minimum begins, and the net force there
_CREEPING = 1e-6
_AT_MINIMUM = 1e-8
_MINIMISER_STEPS = 5000  # between reports
_MOST_MINIMISATIONS = 100
_LEFT = 0.85  # remaining fraction of the search after each report: its length cannot be predicted
_MINIMISER_TIMESTEP = 0.1  # timestep over the timestep of the fall
_LARGEST_MOVE = 0.015  # largest displacement of a grain in a step of the minimiser, mean diameters


@dataclasses.dataclass(frozen=True)
class SettlingLaw:
    """Contacts while grains settle.

    Attributes
    ----------
    material
        Material of the grains; the walls are rigid.
    friction
        Coefficient of friction of grains and walls.
    rolling
        Coefficient of rolling resistance / radius; only with friction.
    restitution
        Coefficient of restitution.
    acceleration
        Acceleration of gravity, m/s^2.
    """

    material: Material
    friction: float
    rolling: float
    restitution: float
    acceleration: float

    @property
    def words(self) -> str:
        """Coefficients of pairs and walls in the input script."""
        words = f"hertz {self.material.youngs_modulus!r} {self.material.poisson_ratio!r}"
        if self.friction:
            words += f" friction {self.friction!r}"
        if self.friction and self.rolling:
            words += f" rolling sds mindlin 0.0 {self.rolling!r} twisting marshall"
        if self.restitution < 1:
            words += f" loss dashpot {self.dashpot!r}"
        return words

    @property
    def dashpot(self) -> float:
        """Factor of the dashpot of this restitution: Tsuji et al., Powder Technol. 71 (1992) 239,
        in closed form Antypov and Elliott, EPL 94 (2011) 50004.
        """
        logarithm = math.log(self.restitution)
        return -math.sqrt(5) * logarithm / math.hypot(logarithm, math.pi)

    def timestep(self, diameter: float) -> float:
        """Return the timestep for a smallest diameter (m), s."""
        material = self.material
        nu = material.poisson_ratio
        shear = material.youngs_modulus / (2 * (1 + nu))
        slowness = math.sqrt(material.density / shear)
        return _OF_RAYLEIGH * math.pi * diameter / 2 * slowness / (0.1631 * nu + 0.8766)


@dataclasses.dataclass(frozen=True, eq=False)
class Settled:
    """Grains at rest.

    Attributes
    ----------
    position
        Centres: (n, 3), m; the bottom plane is at z = 0, above it z is negative.
    contacts
        Rows of grains in contact: (n_contacts, 2).
    normal_force, tangential_force
        Forces of the contacts: (n_contacts,), N.
    residual
        Largest net force on a grain / largest contact force.
    steps
        Number of timesteps.
    springs
        Tangential springs of the contacts, as `packing.springs` has them.
    """

    position: Floats
    contacts: NDArray[np.int64]
    normal_force: Floats
    tangential_force: Floats
    residual: float
    steps: int
    springs: str


def fall_time(height: float, acceleration: float) -> float:
    """Return the time that a grain needs to fall through the column, s."""
    return math.sqrt(2 * height / acceleration)


def settle(
    position: Floats,
    diameter: Floats,
    container: Container,
    law: SettlingLaw,
    report: Report = lambda *_: None,
) -> Settled:
    """Let grains fall and settle on one core, bitwise reproducibly, and return them at rest.

    Parameters
    ----------
    position
        Centres at the start, above the bottom plane at z = 0: (n, 3), m, z negative.
    diameter
        (n,), m.
    report
        Function that is called with the fraction that is done and a note.

    Raises
    ------
    RunError
        LAMMPS fails, or the grains do not come to rest.
    """
    with tempfile.TemporaryDirectory(prefix="granwave-bed-") as folder:
        place = Path(folder)
        (place / _DATA).write_text(_data(position, diameter, container, law), encoding="ascii")
        with open_engine(mpi.this_process(), log="none") as engine:
            engine.commands(_script(place / _DATA, diameter, container, law))
            return _Settling(engine, position, diameter, law, report, place / _STATE).run()


def _data(position: Floats, diameter: Floats, container: Container, law: SettlingLaw) -> str:
    """Return the data file of the grains."""
    largest = float(diameter.max())
    low = [0.0, 0.0]
    high = list(container.box)
    if container.tube is not None:
        low = [-container.tube, -container.tube]
        high = [container.tube, container.tube]
    margin = 0.0 if container.periodic else largest
    top = float(position[:, 2].min()) - 10 * largest
    return grain_data(
        position,
        diameter,
        law.material.density,
        [*(edge - margin for edge in low), top],
        [*(edge + margin for edge in high), largest],
    )


def _script(data: Path, diameter: Floats, container: Container, law: SettlingLaw) -> str:
    """Return the commands before the first step."""
    sides = "ppf" if container.periodic else "fff"
    walls = [f"fix bottom all wall/gran/hysteretic zplane NULL 0.0 {law.words}"]
    if container.tube is not None:
        walls.append(f"fix tube all wall/gran/hysteretic tube {container.tube!r} {law.words}")
    elif not container.periodic:
        walls += [
            f"fix {axis} all wall/gran/hysteretic {axis}plane 0.0 {width!r} {law.words}"
            for axis, width in zip("xy", container.box, strict=True)
        ]
    return "\n".join(
        [
            grain_script(data, diameter, sides, law.words),
            *walls,
            f"fix weight all gravity {law.acceleration!r} vector 0 0 1",
            "fix motion all gran/nve/sphere",
            f"timestep {law.timestep(float(diameter.min()))!r}",
            "compute moving all ke",
            "compute grain all gran/hysteretic/atom",
            "compute largest all reduce max c_grain[1]",
            # the drag is not a force of the bed: it holds a creeping grain
            "variable drag equal 0.0",
            "variable net atom sqrt((fx+v_drag*vx)^2+(fy+v_drag*vy)^2+(fz+v_drag*vz)^2)",
            "compute net all reduce max v_net",
            "variable motion equal c_moving",
            "variable largest equal c_largest",
            "variable residual equal c_net/(c_largest+(c_largest==0))",
            "thermo_style custom step c_moving c_largest c_net",
            "thermo_modify lost error norm no",
        ]
    )


class _Settling:
    """Grains on their way to rest."""

    def __init__(
        self,
        engine: Engine,
        position: Floats,
        diameter: Floats,
        law: SettlingLaw,
        report: Report,
        state: Path,
    ) -> None:
        self._engine = engine
        self._law = law
        self._diameter = diameter
        self._report = report
        self._state = state
        self._n = len(diameter)
        masses = law.material.density * math.pi / 6 * diameter**3
        self._mass = float(masses.mean())
        self._energy = float(masses.sum()) * law.acceleration * float(diameter.mean())
        self._fall = fall_time(float(-position[:, 2].min()), law.acceleration)
        self._look = max(1, int(self._fall / law.timestep(float(diameter.min())) / _LOOKS))

    def run(self) -> Settled:
        """Run until the grains are at rest."""
        for _ in range(_LOOKS):
            self._go_on()
        self._until(lambda: self._motion < _SLOW, "falling")
        drag = self._mass / (_DRAG_TIME * self._fall)
        self._engine.commands(f"fix drag all viscous {drag!r}\nvariable drag equal {drag!r}")
        if self._law.friction:
            self._until(lambda: self._motion < _AT_REST and self._residual < _BALANCED, "settling")
        else:
            self._until(lambda: self._motion < _CREEPING, "settling")
            self._minimise()
        return self._settled()

    def _minimise(self) -> None:
        """Move the grains to a minimum of their energy."""
        timestep = _MINIMISER_TIMESTEP * self._law.timestep(float(self._diameter.min()))
        move = _LARGEST_MOVE * float(self._diameter.mean())
        self._engine.commands(
            f"""
            unfix drag
            unfix weight                  # fix gravity does not act on a minimisation
            variable weight atom mass*{self._law.acceleration!r}
            variable height atom -v_weight*z
            fix weight all addforce 0.0 0.0 v_weight energy v_height
            velocity all set 0.0 0.0 0.0 units box
            timestep {timestep!r}
            min_style fire
            min_modify norm inf dmax {move!r}
            """
        )
        for number in range(1, _MOST_MINIMISATIONS + 1):
            force = _AT_MINIMUM * float(self._engine.lammps.extract_variable("largest"))
            self._engine.commands(
                f"minimize 0.0 {force!r} {_MINIMISER_STEPS} {2 * _MINIMISER_STEPS}"
            )
            if self._residual < 2 * _AT_MINIMUM:  # norm of a force; its components are smaller
                return
            self._report(1 - _LEFT**number, "to equilibrium")
        raise self._restless()

    @property
    def _motion(self) -> float:
        """Kinetic energy of a grain's translation / m g D."""
        return float(self._engine.lammps.extract_variable("motion")) / self._energy

    @property
    def _residual(self) -> float:
        return float(self._engine.lammps.extract_variable("residual"))

    def _go_on(self) -> None:
        self._engine.commands(f"run {self._look} post no")

    def _until(self, is_over: Callable[[], bool], note: str) -> None:
        """Run until a condition holds."""
        for _ in range(_MOST_TIMES * _LOOKS):
            if is_over():
                return
            self._go_on()
            level = math.log(max(self._motion, _AT_REST)) / math.log(_AT_REST)
            self._report(min(max(level, 0.0), 1.0), note)
        raise self._restless()

    def _restless(self) -> RunError:
        return RunError(
            f"the bed does not come to rest: a grain has {self._motion:.1e} of m g D, and a net "
            f"force of {self._residual:.1e} of the largest force; use a smaller "
            "packing.restitution, or another seed"
        )

    def _settled(self) -> Settled:
        """Return the state of LAMMPS."""
        table = contact_table(self._engine)
        self._engine.commands(f'write_restart "{self._state}"')
        return Settled(
            positions_of(self._engine, self._n),
            table[:, [FIRST, SECOND]].astype(np.int64) - 1,
            table[:, CONTACT_FORCE],
            table[:, TANGENTIAL_FORCE],
            self._residual,
            self._engine.step,
            springs_table(read_restart(self._state), WALLS),
        )
