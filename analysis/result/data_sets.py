"""Data sets of ``result.h5``: path, shape, unit, meaning, and the runs that have each of them.

The units are those that the writer stores, see `granwave.analysis.result.hdf5_file.unit_of` and
`granwave.analysis.result.trajectory.unit_of_snapshots`. Names in capitals stand for names and ids
of the run: ``walls/NAME/force`` is ``walls/bottom/force`` for the bottom.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from granwave.analysis.result.hdf5_file import unit_of
from granwave.analysis.result.trajectory import GROUP, unit_of_snapshots

NEVER = "NaN: never"
_STATIC = "with `[precompression]`"
_LOSS = "with damping in contacts"
_ADAPTIVE = "with an automatic timestep"
_MOVING = "for a bottom plate or half-space, and for a plate as load"
_SUPPORTED = "for a bottom plate or half-space"
_PRESSED = "with pressed walls; `NAME` is `x`, `y` or `tube`"
_RESISTANCE = "with rolling or twisting resistance"
_BARS = "with `[bar]` or `[incident_bar]`"
_WEIGHT = "for grains that settle under their own weight"


class DataSet(NamedTuple):
    """A data set, or all data sets that differ by a name or an id.

    Attributes
    ----------
    path
        Path from the root of the file, without the slash at its beginning.
    shape
        Shape, such as ``n_times, n_spheres``.
    meaning
        Meaning, as a phrase.
    when
        Runs that have it; empty: all runs.
    """

    path: str
    shape: str
    meaning: str
    when: str = ""

    @property
    def group(self) -> str:
        """Return the path of the group."""
        return self.path.rpartition("/")[0]

    @property
    def unit(self) -> str:
        """Return the unit that the data set has as its attribute."""
        if self.path.startswith(GROUP):
            return unit_of_snapshots(self.path.removeprefix(f"{GROUP}/"))
        group, _, column = self.path.rpartition("/")
        return unit_of(group, column)

    def matches(self, path: str) -> bool:
        """Return True if a path is this path with names and ids in place of the capitals."""
        pattern = re.sub(r"[A-Z]+", ".+", re.escape(self.path))
        return re.fullmatch(pattern, path) is not None


def _of(group: str, shape: str, when: str, rows: list[tuple[str, ...]]) -> tuple[DataSet, ...]:
    """Return the data sets of a group from their names, meanings, and, where they differ from the
    others of the group, their conditions and shapes.
    """
    made = []
    for name, meaning, *others in rows:
        own_when = others[0] if others else when
        own_shape = others[1] if len(others) > 1 else shape
        made.append(DataSet(f"{group}/{name}", own_shape, meaning, own_when))
    return tuple(made)


_SPHERES = _of(
    "spheres",
    "n_spheres",
    "",
    [
        ("id", "id of the sphere; ids count the sites of the lattice, and vacancies have no row"),
        ("position", "centre at the start", "", "n_spheres, 3"),
        ("radius", "radius"),
        ("mass", "mass"),
        ("peak_force", "largest force of a contact with another sphere"),
        ("peak_force_with_walls", "largest force of a contact, including walls and bars"),
        ("peak_overlap", "largest overlap of a contact with another sphere"),
        ("dissipated_energy", "dissipated energy, with its fraction of each contact"),
        ("dissipated_energy_wall", "part of it in contacts with walls and bars"),
        ("friction_energy", "part of it dissipated by friction"),
        ("viscous_energy", "part of it dissipated by damping", _LOSS),
        ("contacts_yielded", "number of contacts that yielded"),
        ("coordination", "number of touching spheres at the start"),
        (
            "time_first",
            f"earliest arrival at a contact with at least 10 % of `peak_force` ({NEVER})",
        ),
        ("time_yield", f"earliest yield of a contact ({NEVER})"),
    ],
)
_OF_CONTACTS: list[tuple[str, ...]] = [
    ("overlap", "overlap at the end"),
    ("force", "normal force at the end"),
    ("tangential_force", "tangential force at the end"),
    ("peak_overlap", "largest overlap"),
    ("peak_force", "largest normal force"),
    ("dissipated_energy", "dissipated energy"),
    ("friction_energy", "part of it dissipated by friction"),
    ("viscous_energy", "part of it dissipated by damping", _LOSS),
    ("initial_overlap", "largest overlap before the run, which left an indentation"),
    ("initial_force", "normal force after the static stage; 0 without load", _STATIC),
    ("time_peak", f"time of the largest overlap ({NEVER})"),
    ("time_yield", f"time of first yield ({NEVER})"),
]
_CONTACTS = _of(
    "contacts",
    "n_contacts",
    "",
    [
        ("i", "id of a sphere"),
        ("j", "id of the other sphere, larger than `i`; rows are sorted by (`i`, `j`)"),
        *_OF_CONTACTS,
        (
            "time_first",
            "time at which the force first exceeds 10 % of its largest value "
            f"({NEVER}, or an overlap by rounding)",
        ),
        ("elastic_energy", "stored energy at the end"),
        ("touching", "true for spheres that touched at the start"),
        ("yielded", "true for a contact that yielded in this run"),
        ("yield_overlap", "overlap at first yield; infinite for laws that do not yield"),
        ("effective_radius", "effective radius"),
        ("n_dents", "number of indentations of the pair"),
    ],
)
_WALL_CONTACTS = _of(
    "wall_contacts",
    "n_wall_contacts",
    "",
    [
        ("wall", "name of the wall or bar"),
        ("id", "id of the sphere"),
        *_OF_CONTACTS,
        ("time_first", f"time of the first contact; for bars as in `/contacts` ({NEVER})"),
    ],
)
_ENERGY = _of(
    "energy",
    "n_records",
    "",
    [
        ("step", "step"),
        ("time", "time"),
        ("input", "energy input: initial kinetic energy, and work of the load"),
        ("kinetic", "kinetic energy"),
        ("elastic", "stored (elastic) energy"),
        ("dissipated", "dissipated energy; kinetic + elastic + dissipated = input"),
        ("elastic_wall", "part of the stored energy in contacts with walls and bars"),
        ("dissipated_wall", "part of the dissipated energy in contacts with walls and bars"),
        ("rotational", "part of the kinetic energy, of rotation"),
        ("plate", "part of the kinetic energy, of the plate", "for a plate as load"),
        ("elastic_tangential", "part of the stored energy in tangential springs"),
        ("friction", "part of the dissipated energy, by sliding"),
        ("elastic_rolling", "part of the stored energy in springs of rolling", _RESISTANCE),
        ("rolling", "part of the dissipated energy, by rolling", _RESISTANCE),
        ("elastic_twisting", "part of the stored energy in springs of twisting", _RESISTANCE),
        ("twisting", "part of the dissipated energy, by twisting", _RESISTANCE),
        (
            "adhesion",
            "part of the dissipated energy, by snapping into contact and separating",
            "with cohesion",
        ),
        ("viscous", "part of the dissipated energy, by damping in contacts", _LOSS),
        (
            "holder",
            "part of the dissipated energy, by friction in the guide",
            "with friction in the guide of a chain",
        ),
        (
            "absorbed",
            "part of the dissipated energy, in absorbing layers",
            "with `[[absorb]]`, and with other absorbing ends",
        ),
        (
            "support",
            "energy of the moving bottom: springs and kinetic energy",
            _SUPPORTED,
        ),
        (
            "support_lost",
            "part of the dissipated energy, in the damper of the bottom",
            _SUPPORTED,
        ),
        ("target", "work of the spheres on the moving bottom", _SUPPORTED),
        ("bar", "energy of the bar", "with `[bar]`"),
        ("incident_bar", "energy of the incident bar", "with `[incident_bar]`"),
        ("struck_velocity", "mean velocity of the impacted spheres or strikers along the load"),
        ("contacts_yielded", "number of contacts that have yielded"),
        ("beyond_law", "number of contacts beyond the range of the contact law"),
        ("beyond_half", "number of contacts beyond half of that range"),
        ("largest_force", "largest force of a contact between spheres at this instant"),
        ("timestep", "length of the last timestep", _ADAPTIVE),
        (
            "expected_error",
            "expected error of the energy balance, relative to the energy",
            _ADAPTIVE,
        ),
        ("timesteps", "number of timesteps so far", _ADAPTIVE),
        ("smallest_timestep", "shortest timestep so far", _ADAPTIVE),
        ("largest_timestep", "longest timestep so far", _ADAPTIVE),
    ],
)
_WALLS = _of(
    "walls/NAME",
    "n_times",
    "",
    [
        ("time", "time"),
        ("force", "force of the spheres on the wall, positive outwards"),
        ("impulse", "time integral of the force"),
        ("displacement", "displacement of the wall", _MOVING),
        ("velocity", "velocity of the wall", _MOVING),
        ("ground_force", "force of its support on the ground", _MOVING),
    ],
)
_AXES = "xyz"
_PROBES = _of(
    "probes",
    "n_times",
    "with `output.probes`",
    [
        ("step", "step"),
        ("time", "time"),
        *((f"sphere_ID_u{axis}", f"displacement of a sphere along {axis}") for axis in _AXES),
        *((f"sphere_ID_v{axis}", f"velocity of a sphere along {axis}") for axis in _AXES),
        *((f"sphere_ID_f{axis}", f"total force on a sphere along {axis}") for axis in _AXES),
        ("contact_I_J_overlap", "overlap of a contact"),
        ("contact_I_J_force", "normal force of a contact"),
    ],
)
_PRESTAGE = _of(
    "prestage",
    "1",
    _STATIC,
    [
        ("residual", "largest net force on a sphere divided by the largest contact force"),
        ("largest_force", "largest force of a contact"),
        ("contacts", "number of loaded contacts"),
        ("yielded", "number of contacts that yielded"),
        ("stored", "stored energy"),
        ("displacement", "largest displacement of a sphere"),
        ("iterations", "number of iterations"),
        ("unbalanced", "sum of the net forces divided by the total weight", _WEIGHT),
        ("worst", "largest net force on a grain divided by its weight", _WEIGHT),
        ("rolling", "number of grains that still roll", _WEIGHT),
        (
            "moved_NAME",
            "displacement of the pressed walls",
            _PRESSED,
        ),
        (
            "force_NAME",
            "mean force on the pressed walls",
            _PRESSED,
        ),
    ],
)
_CHAIN = _of(
    "chain",
    "n_times, n_beads",
    "for chains of at least five beads, and chains with bars",
    [
        ("time", "time", "", "n_times"),
        ("id", "ids of the beads, in the order of z", "", "n_beads"),
        ("position", "height of the beads at the start", "", "n_beads"),
        ("displacement", "displacement along z"),
        ("velocity", "velocity along z"),
        (
            "contact_i",
            "id of the lower bead of each contact, or of the face of a bar",
            "",
            "n_contacts",
        ),
        (
            "contact_j",
            "id of the upper bead of each contact, or of the face of a bar",
            "",
            "n_contacts",
        ),
        ("contact_position", "height of the contact at the start", "", "n_contacts"),
        ("contact_force", "normal force of the contact", "", "n_times, n_contacts"),
    ],
)
_BARS_OF_CHAIN = _of(
    "bars/NAME",
    "n_times, n_nodes",
    _BARS,
    [
        ("position", "height of the nodes at the start", "", "n_nodes"),
        ("displacement", "displacement along z"),
        ("velocity", "velocity along z"),
        ("force", "force of the elements, positive in compression", "", "n_times, n_nodes - 1"),
    ],
)
_LINES = _of(
    "lines/NAME",
    "n_grains",
    "with `[[line]]`",
    [
        ("time", "time", "", "n_times"),
        ("id", "ids of the grains, in the order of the line"),
        ("position", "centre at the start", "", "n_grains, 3"),
        ("distance", "distance along the line from its first grain"),
        ("displacement", "displacement", "", "n_times, n_grains, 3"),
        ("velocity", "velocity", "", "n_times, n_grains, 3"),
        ("angular_velocity", "angular velocity", "if grains rotate", "n_times, n_grains, 3"),
        (
            "force_sums",
            "sums of the magnitudes of the contact forces along x, y and z",
            "",
            "n_times, n_grains, 3",
        ),
        ("arrival", f"arrival of the first pulse ({NEVER})"),
        ("peak_speed", "speed at the first peak (NaN: no peak)"),
        ("peak_time", "time of the first peak (NaN: no peak)"),
        (
            "width",
            "duration between the half heights (NaN: no peak, or the record ends before)",
        ),
        (
            "lateral_force",
            "half of the sum of the forces across the line at the peak (NaN: no peak)",
        ),
        ("largest_speed", "largest speed of the record"),
    ],
)
_TRAJECTORY = _of(
    GROUP,
    "n_frames, n_spheres",
    "",
    [
        ("id", "id of the sphere", "", "n_spheres"),
        ("species", "number of the material and size, as the LAMMPS atom type", "", "n_spheres"),
        ("radius", "radius", "", "n_spheres"),
        ("mass", "mass", "", "n_spheres"),
        ("box/edges", "edges of the box", "", "3"),
        ("box/lower", "lower corner of the box", "", "3"),
        ("QUANTITY/step", "step of each snapshot; the same for all quantities", "", "n_frames"),
        ("QUANTITY/time", "time of each snapshot; the same for all quantities", "", "n_frames"),
        (
            "position/value",
            "position, not wrapped into periodic boxes",
            "",
            "n_frames, n_spheres, 3",
        ),
        ("displacement/value", "displacement from the start", "", "n_frames, n_spheres, 3"),
        ("velocity/value", "velocity", "", "n_frames, n_spheres, 3"),
        ("contact_force/value", "largest force of a contact at this instant"),
        ("peak_force/value", "largest force of a contact so far"),
        ("dissipated_energy/value", "dissipated energy so far"),
        (
            "elastic_energy/value",
            "half of the energy stored in each contact with a sphere (NaN: not recorded)",
        ),
        ("friction_energy/value", "part of the dissipated energy, by friction", "with friction"),
        ("viscous_energy/value", "part of the dissipated energy, by damping", _LOSS),
    ],
)
#: Headings of the groups, in the order of the page, and their data sets.
GROUPS = {
    "Spheres": _SPHERES,
    "Contacts between spheres": _CONTACTS,
    "Contacts with walls and bars": _WALL_CONTACTS,
    "Walls and bars in time": _WALLS,
    "Energies": _ENERGY,
    "Snapshots (H5MD)": _TRAJECTORY,
    "Probes": _PROBES,
    "Static stage": _PRESTAGE,
    "Chains": _CHAIN,
    "Bars": _BARS_OF_CHAIN,
    "Lines of grains": _LINES,
}


def data_sets() -> Iterator[DataSet]:
    """Iterate over all data sets."""
    for group in GROUPS.values():
        yield from group


def data_set_at(path: str) -> DataSet | None:
    """Return the data set of a path, with the fewest capitals; None if it is not listed."""
    matching = [entry for entry in data_sets() if entry.matches(path)]
    return min(matching, key=lambda entry: sum(map(str.isupper, entry.path)), default=None)
