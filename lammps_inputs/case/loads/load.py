"""Base class of all kinds of ``[load]``, and the properties of a packing that loads use.

A kind of load is a subclass of `Load` in a file next to this one, and its name is in the table of
`granwave.lammps_inputs.case.loads.registry`. No other code compares kinds of loads: packing, input
script, plan, checks, results and reports use the attributes and methods of `Load`.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple, Protocol

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.schema import ErrorList

Vector = tuple[float, float, float]
DOWN: Vector = (0.0, 0.0, 1.0)
DEFAULT_VELOCITY = 5.0  # m/s


class LoadedPacking(Protocol):
    """Packing that a load acts on; `granwave.lammps_inputs.packing.motion.LoadedAssembly` is one.

    Ids of spheres count from 1, strikers after the grains of the packing.
    """

    @property
    def top_layer(self) -> tuple[int, ...]:
        """Ids of the spheres of the top layer."""

    @property
    def n_layers(self) -> int:
        """Number of layers."""

    @property
    def sphere_mass(self) -> float:
        """Mass of a grain that is not replaced, kg."""

    @property
    def masses(self) -> tuple[float, float]:
        """Smallest and largest mass of a sphere, kg."""

    @property
    def moving_grains(self) -> tuple[int, ...]:
        """Ids of the grains of a file that have a velocity, the fastest first."""

    @property
    def moving_strikers(self) -> tuple[int, ...]:
        """Ids of the strikers that move."""

    @property
    def is_at_rest(self) -> bool:
        """True if no sphere moves at the start."""

    @property
    def bar_impedance(self) -> float | None:
        """Impedance of the incident bar, N s/m; None without one."""

    def at_centre(self, count: int) -> tuple[int, ...]:
        """Return the ids of 1, 3 or 7 spheres at the centre of the top, the middle sphere first."""

    def mass_of(self, sphere: int) -> float:
        """Return the mass of a sphere, kg."""


class PlateOnTop(NamedTuple):
    """Rigid plate that a load brings: its mass, kg, and its velocity into the packing, m/s."""

    mass: float
    velocity: float

    @property
    def energy(self) -> float:
        """Kinetic energy, J."""
        return self.mass * self.velocity**2 / 2

    @property
    def key(self) -> str:
        """Key with its value, for the causes of bounds."""
        return f"load.mass = {self.mass:g} kg"


class LoadLimit(NamedTuple):
    """Bound on the timestep by a load: its size (s), its cause, and a remedy."""

    step: float
    cause: str
    remedy: str


class Wording(NamedTuple):
    """Functions by which a report writes a quantity, with its unit and prefix, and a number."""

    quantity: Callable[[float, str], str]
    number: Callable[[Any], str]


def velocity_field() -> Any:
    """Make the key ``velocity`` of loads with a velocity."""
    return schema.number(
        "velocity of the impacted spheres, or of the plate, into the packing",
        hints.VELOCITY,
        above=0,
        default=DEFAULT_VELOCITY,
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Load(ABC):
    """Load on a packing.

    A kind declares its keys as fields, made by the functions of
    `granwave.lammps_inputs.case.schema`, each with a default, and overrides the attributes and
    methods that differ. A key of two loads is the same field in both.

    Attributes
    ----------
    kind
        Name of the kind, as in ``load.kind``.
    means
        Noun phrase for the description of ``load.kind``.
    other_keys
        Keys that are no fields, since the reader replaces them.
    excludes
        Tables that a case cannot have together with the load, and why.
    only_stage
        The only kind of ``[precompression]`` that the load allows, and why; None: all.
    hits_spheres
        True if the load acts on spheres of the packing that the case chooses.
    hits_one_place
        True if the impacted spheres are next to each other.
    gives_velocity
        True if all impacted spheres start with the same velocity.
    strikes
        True if only impacted spheres, or strikers, move at the start.
    driven
        True if the load does work during the run: a `DrivenLoad`.
    prescribes_motion
        True if the motion of the impacted spheres is prescribed.
    takes_incident_bar
        True if the load can act on the free end of the incident bar.
    moves_grains
        True if the load consists of the velocities of the grains of a file.
    energy_is_bound
        True if `energy_in` is only an upper bound.
    amplitude_unit
        Unit of ``load.amplitude``; empty if there is none.
    shown_amplitude
        Factor and unit in which figures show the amplitude.
    input_formula
        LAMMPS formula of the energy input so far, J, with the kinetic energy at the start,
        ``v_given``.
    """

    kind: ClassVar[str] = ""
    means: ClassVar[str] = ""
    other_keys: ClassVar[tuple[str, ...]] = ()
    excludes: ClassVar[Mapping[str, str]] = {}
    only_stage: ClassVar[tuple[str, str] | None] = None
    hits_spheres: ClassVar[bool] = False
    hits_one_place: ClassVar[bool] = True
    gives_velocity: ClassVar[bool] = False
    strikes: ClassVar[bool] = False
    driven: ClassVar[bool] = False
    prescribes_motion: ClassVar[bool] = False
    takes_incident_bar: ClassVar[bool] = False
    moves_grains: ClassVar[bool] = False
    energy_is_bound: ClassVar[bool] = False
    amplitude_unit: ClassVar[str] = ""
    shown_amplitude: ClassVar[tuple[float, str]] = (1.0, "")
    input_formula: ClassVar[str] = "v_given"

    # Keys of some loads, with None for loads without them.

    @property
    def spheres(self) -> int:
        """Number of impacted spheres at the centre of the top; 0 if the load acts on others."""
        return 0

    @property
    def index(self) -> tuple[int, ...] | None:
        """Ids of the impacted spheres; None if the case does not name them."""
        return None

    @property
    def velocity(self) -> float:
        """Speed into the packing that the case gives, m/s; 0 if it gives none."""
        return 0.0

    @property
    def angle(self) -> float:
        """Angle between the velocity and +z, degrees."""
        return 0.0

    @property
    def spin(self) -> Vector:
        """Angular velocity of the impacted spheres at the start, rad/s."""
        return 0.0, 0.0, 0.0

    @property
    def table(self) -> tuple[tuple[float, float], ...] | None:
        """Points of force or displacement against time; None without."""
        return None

    # Direction and time.

    @property
    def plate(self) -> PlateOnTop | None:
        """Rigid plate on the free top; None without one."""
        return None

    @property
    def way(self) -> Vector:
        """Unit vector of the load direction; +z if none is set."""
        return DOWN

    @property
    def slants(self) -> bool:
        """True for a force or displacement that does not act straight down."""
        return self.way != DOWN

    @property
    def lasts(self) -> float:
        """Time at which the energy input ends, s: 0 if all energy is present at the start."""
        return 0.0

    @property
    def first_time(self) -> float:
        """Time at which the values of a table first differ from zero, s; 0 for all other loads."""
        return 0.0

    @property
    def oscillates(self) -> bool:
        """True for a load of given frequencies."""
        return False

    @property
    def frequencies(self) -> tuple[float, float]:
        """Lowest and highest frequency of a load that oscillates, Hz."""
        return 0.0, 0.0

    @property
    def lowest_frequency(self) -> float:
        """Lowest frequency of a load that oscillates, Hz."""
        return min(self.frequencies)

    @property
    def highest_frequency(self) -> float:
        """Highest frequency of a load that oscillates, Hz."""
        return max(self.frequencies)

    @property
    def keeps_oscillating(self) -> bool:
        """True for a load of given frequencies, except a short burst."""
        return False

    @property
    def may_stop(self) -> bool:
        """True if the impacted spheres may return most of the energy input."""
        return False

    # Impacted spheres and their initial motion.

    def named(self, at_centre: Callable[[int], tuple[int, ...]]) -> tuple[str, Sequence[int]]:
        """Return the key by which the load names spheres of the packing, and their ids; these are
        never vacant.

        Parameters
        ----------
        at_centre
            Ids of 1, 3 or 7 spheres at the centre of the top.
        """
        return "load.kind", ()

    @abstractmethod
    def struck(self, packing: LoadedPacking) -> tuple[int, ...]:
        """Return the ids of the impacted spheres, in order."""

    def start_velocity(self, packing: LoadedPacking) -> Vector | None:
        """Return the velocity of the impacted spheres at the start, m/s; None if there is none
        (see `gives_velocity`).
        """
        return None

    def start_speed(self, packing: LoadedPacking) -> float:
        """Return the magnitude of `start_velocity`, m/s; 0 without one."""
        velocity = self.start_velocity(packing)
        return math.hypot(*velocity) if velocity else 0.0

    def impulse_on(self, mass: float) -> float:
        """Return the impulse that the load gives to a first grain of this mass (kg), N s."""
        return 0.0

    # LAMMPS commands.

    @property
    def start_energy(self) -> str:
        """LAMMPS formula of the kinetic energy of the load at the start, without the energy of the
        spheres, J; empty without any.
        """
        return ""

    def release_commands(self) -> list[str]:
        """Return the commands that start the bodies of the load that were held in the static
        stage.
        """
        return []

    def commands(self, group: str) -> list[str]:
        """Return the commands of a load that acts during the run, on a group of particles."""
        return []

    # Bounds for the plan.

    def energy_in(self, packing: LoadedPacking) -> float:
        """Return the energy input beyond the kinetic energy of the spheres at the start, J."""
        return 0.0

    def speed_bound(self, packing: LoadedPacking) -> float:
        """Return an upper bound on the speed of a sphere, m/s; 0: the speeds at the start."""
        return 0.0

    def contact_energy(self, energy: float, law: ContactLaw, packing: LoadedPacking) -> float:
        """Limit the largest ``energy`` that a contact absorbs, J, by the
        load.
        """
        return energy

    def timestep_limit(self, share: float) -> LoadLimit | None:
        """Return the bound on the timestep by the shortest time of the load, where a step is at
        most the fraction ``share`` of this time; None without a bound.
        """
        return None

    # Words.

    @abstractmethod
    def sentence(self, n_strikers: int) -> str:
        """Return a description of the load for the head of the input script."""

    @property
    def label(self) -> str:
        """Short name, for titles; empty if the speeds at the start describe the load."""
        return ""

    @property
    def no_bare_target(self) -> str:
        """Reason why the load cannot act on the bare target of a packing; empty if it can."""
        return ""

    @classmethod
    def phrase(cls, case: Mapping[str, Any], write: Wording) -> str:
        """Return the load in a report, from the known keys of a case: ``5 m/s on 3 spheres``."""
        velocity = case.get("load.velocity")
        spheres = case.get("load.spheres")
        several = f" on {spheres} spheres" if isinstance(spheres, int) and spheres > 1 else ""
        return f"{write.number(velocity)} m/s{several}" if velocity is not None else ""

    # Reading and writing of the keys.

    def check(self, names: Sequence[str], errors: ErrorList) -> None:
        """Add the faults of the keys to ``errors``.

        Parameters
        ----------
        names
            Keys that the table of the case file has.
        """
        return

    def keys(self) -> dict[str, Any]:
        """Return the keys of the load, with their values."""
        fields = (field.name for field in dataclasses.fields(self))
        return {"kind": self.kind} | {name: getattr(self, name) for name in fields}
