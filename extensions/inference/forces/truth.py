"""States of a finished run with the forces at all contacts, from snapshots with contact forces."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.interpolate import CubicHermiteSpline

from granwave.analysis.lammps_output.dumps import read_frame_forces, read_frames
from granwave.analysis.lammps_output.frame import Frame
from granwave.analysis.result.reader import Result
from granwave.extensions.inference.forces.equations import make_equations
from granwave.extensions.inference.forces.grains import (
    NORMAL,
    PAIRS,
    SCALES,
    TANGENTIAL,
    TURNS,
    Array,
    CandidateContacts,
    MeasuredGrains,
    StraightWall,
    find_contacts,
    volume_of,
)
from granwave.lammps_inputs.case.material import Shape
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import Wall as CaseWall
from granwave.lammps_inputs.packing.walls import walls

_OF_SPHERE = 0.4  # moment of inertia / m R^2
#: Components of vectors of a run that become x and y of its measurement, by the axis of cylinders.
_TURNS = {
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
    "z": np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
}
_REST = 1e-6  # other force / largest contact force below which it is rounding


class Snapshots:
    """Snapshots of a run, in the coordinates of a measurement: y points upwards in packings of
    cylinders.

    Attributes
    ----------
    directory
        Name of the run's directory.
    dimension, length
        2 for cylinders, 3 for spheres; length of the cylinders, 1 for spheres, m.
    ids, radius
        (n,), m.
    density, youngs_modulus, poisson_ratio
        Properties of each grain: (n,).
    times
        (n_frames,), s.
    position, velocity
        (n_frames, n, d), m, m/s.
    spin, angular_acceleration
        (n_frames, n, 1 or 3), rad/s, rad/s^2.
    frames, forces
        Snapshots of grains and of contacts.
    turn
        Rows of the matrix that turns vectors of the run into the coordinates of the measurement:
        (d, 3).
    friction
        Largest coefficient of friction of grains and of walls.
    strikers
        True for strikers that pass walls: (n,).

    Raises
    ------
    InputError
        The run recorded no contact forces, or has periodic sides, a tube or bars.
    """

    def __init__(self, result: Result) -> None:
        case = result.case
        assembly = result.assembly
        self.directory = str(result.path.parent)
        _refuse_unseen(result, self.directory)
        cylinder = _shape_of_grains(assembly, self.directory)
        axis = ""
        self.turn = np.eye(3)
        about = np.eye(3)
        if cylinder is not None:
            axis = "y" if cylinder.axis[1] else "z"
            self.turn = _TURNS[axis]
            about = np.eye(3)[["xyz".index(axis)]]  # rotations are about the axis
        self.dimension = 3 if cylinder is None else 2
        self.length = 1.0 if cylinder is None else cylinder.length
        self.ids = result["particles/spheres/id"].astype(np.int64)
        self.radius = result["particles/spheres/radius"]
        self.strikers = np.isin(self.ids, result.assembly.passing)
        kinds = result["particles/spheres/species"].tolist()
        materials = [result.assembly.species[kind - 1].material for kind in kinds]
        self.density = np.array([material.density for material in materials])
        self.youngs_modulus = np.array([material.youngs_modulus for material in materials])
        self.poisson_ratio = np.array([material.poisson_ratio for material in materials])
        by_step = {frame.step: frame for frame in read_frame_forces(Path(self.directory))}
        frames = [frame for frame in read_frames(Path(self.directory)) if frame.step in by_step]
        number = {
            float(step): k
            for k, step in enumerate(result["particles/spheres/position/step"].tolist())
        }
        rows = [number[frame.step] for frame in frames]
        self.frames = [frame.up_to(int(self.ids[-1])) for frame in frames]
        self.forces = [by_step[frame.step] for frame in frames]
        self.times = result.frame_times[rows]
        self.position = np.stack([result.frame(row, "position") @ self.turn.T for row in rows])
        self.velocity = np.stack([result.frame(row, "velocity") @ self.turn.T for row in rows])
        n = len(self.ids)
        self.spin = np.stack(
            [frame.vector("omegax", "omegay", "omegaz")[:n] @ about.T for frame in frames]
        )
        # torques of cylinders are recorded as the integration of spheres takes them (fix
        # gran/cylinder)
        inertia = _OF_SPHERE * self.density * self.volume * self.radius**2
        torque = np.stack([frame.vector("tqx", "tqy", "tqz") @ about.T for frame in self.frames])
        self.angular_acceleration = torque / inertia[:, None]
        self.wall_fixes: dict[str, tuple[CaseWall, tuple[str, ...]]] = {}
        for wall in walls(assembly):
            if not wall.held_layer and "xyz"[wall.axis] != axis:
                fixes = tuple(fix for fix, _, _ in wall.fixes)
                self.wall_fixes[wall.name] = (wall, fixes)
        self.moved = {name: _displacement(result, name, self.times) for name in self.wall_fixes}
        frictions = [case.contact.friction, *(pair.contact.friction for pair in case.pair)]
        at_walls = frictions if case.boundary.friction is None else [case.boundary.friction]
        self.friction = max(frictions), max(at_walls)

    @property
    def volume(self) -> Array:
        """Volumes: (n,), m^3."""
        return volume_of(
            self.radius, "space" if self.dimension == 3 else "plane-stress", self.length
        )

    def walls(self, number: int) -> dict[str, StraightWall]:
        """Return the walls at a snapshot, by name."""
        planes = {}
        for name, (wall, _) in self.wall_fixes.items():
            along = self.turn[:, wall.axis]  # axis of the run in coordinates of the measurement
            level = wall.coordinate + wall.outward * float(self.moved[name][number])
            point = level * along + 0.0  # without negative zeros
            normal = -wall.outward * along + 0.0
            planes[name] = StraightWall(tuple(point.tolist()), tuple(normal.tolist()))
        return planes

    def largest_snapshot(self, spare: float = 0.0) -> int:
        """Return the number of the snapshot with the largest sum of forces, at least ``spare``
        seconds away from both ends.
        """
        inside = (self.times >= self.times[0] + spare) & (self.times <= self.times[-1] - spare)
        if not inside.any():
            raise InputError(
                f"{self.directory}: ends after {self.times[-1]:.3g} s, expected at least "
                f"{2 * spare:.3g} s for three frames; use a faster camera, or a longer run.end_time"
            )
        totals = np.array([float(frame["force"].sum()) for frame in self.forces])
        return int(np.argmax(np.where(inside, totals, -1.0)))

    def state(self, number: int, tolerance: float) -> tuple[MeasuredGrains, Array]:
        """Return grains and the true forces of the candidate contacts at a snapshot; stresses are
        exact averages.

        Returns
        -------
        Grains, ndarray
            The second: normal and tangential components, (n_contacts, d), N.
        """
        frame = self.frames[number]
        forces = self.forces[number]
        n = len(self.radius)
        d = self.dimension
        mass = self.density * self.volume
        total = frame.vector("fx", "fy", "fz")
        still = np.zeros((n, d))
        grains = MeasuredGrains(
            self.ids, self.position[number], self.radius, mass, self.volume,
            still, self.spin[number], np.zeros((n, TURNS[d])), still, np.zeros((n, len(PAIRS[d]))),
            passes_walls=self.strikers if self.wall_fixes and self.strikers.any() else None,
        )  # fmt: skip
        contacts = find_contacts(grains, self.walls(number), tolerance)
        true = np.zeros((len(contacts), d))
        on_pairs = self._pairs(grains, contacts, forces, true)
        rest = total @ self.turn.T - on_pairs
        equations = make_equations(grains, contacts)
        of_pairs = (equations.motion @ true.ravel()).reshape(n, -1)[:, d:] * self.radius[:, None]
        torque = self.angular_acceleration[number] * grains.inertia[:, None] - of_pairs
        wall_force = self._walls(grains, contacts, frame, rest, torque, true)
        # forces on held grains are unknown: these grains are left out of the measurement
        size = float(np.abs(true).max(initial=0.0))
        at_rest = (np.linalg.norm(total, axis=1) == 0) & (
            np.linalg.norm(wall_force, axis=1) > _REST * size
        )
        wall_force[np.linalg.norm(wall_force, axis=1) <= _REST * size] = 0.0
        sums = (equations.motion @ true.ravel()).reshape(n, -1)
        turning = sums[:, d:] * (self.radius / grains.inertia)[:, None]
        exact = (sums[:, :d] + wall_force) / mass[:, None]
        moments = (equations.stress @ true.ravel() - equations.spin_data).reshape(
            n, -1
        ) * self.radius[:, None]
        stress = moments / SCALES[d] / self.volume[:, None]
        for values in (exact, turning, stress):
            values[at_rest] = np.nan
        wall_force[at_rest] = 0.0
        measured = dataclasses.replace(
            grains,
            acceleration=exact,
            angular_acceleration=turning,
            known_force=wall_force,
            stress=stress,
        )
        return measured, true

    def _pairs(
        self, grains: MeasuredGrains, contacts: CandidateContacts, forces: Frame, true: Array
    ) -> Array:
        """Enter the forces of pairs into ``true``; return their sums on each grain: (n, d), N."""
        rows = np.searchsorted(self.ids, forces.vector("i", "j").astype(np.int64))
        loaded = forces["force"] > 0
        i, j = np.sort(rows[loaded], axis=1).T
        swapped = rows[loaded][:, 0] != i
        apart = grains.position[i] - grains.position[j]
        normal = apart / np.linalg.norm(apart, axis=1)[:, None]
        shear = forces.vector("tx", "ty", "tz")[loaded] @ self.turn.T
        shear[swapped] *= -1
        vectors = forces["force"][loaded, None] * normal + shear
        pairs = contacts.second >= 0  # the first pairs
        candidates = pd.MultiIndex.from_arrays([contacts.first[pairs], contacts.second[pairs]])
        columns = candidates.get_indexer(pd.MultiIndex.from_arrays([i, j]))
        if (columns < 0).any():
            raise InputError(
                f"{self.directory}: a loaded pair lies beyond infer.contact_tolerance; increase it"
            )
        true[columns] = np.einsum("mij,mi->mj", contacts.basis[columns], vectors)
        sums = np.zeros_like(grains.position)
        np.add.at(sums, i, vectors)
        np.add.at(sums, j, -vectors)
        return sums

    def _walls(
        self,
        grains: MeasuredGrains,
        contacts: CandidateContacts,
        frame: Frame,
        rest: Array,
        torque: Array,
        true: Array,
    ) -> Array:
        """Enter the forces of walls into ``true``; return the remaining force on each grain:
        (n, d), N.

        The normal forces are recorded. Tangential forces follow from the remaining force and
        torque on a grain. In LAMMPS their lever is the radius minus half the overlap, for cylinders
        the radius minus the overlap.
        """
        recorded = []
        for _, fixes in self.wall_fixes.values():
            recorded.append(sum((frame[f"wall_{fix}"] for fix in fixes), np.zeros(len(grains))))
        at_walls = np.flatnonzero(contacts.second < 0)
        own = contacts.first[at_walls]
        pushes = np.reshape(recorded, (-1, len(grains)))[contacts.wall[at_walls], own]
        true[at_walls, NORMAL] = pushes
        left = rest.copy()
        np.subtract.at(left, own, pushes[:, None] * contacts.normal[at_walls])
        if not self.friction[1] or not len(at_walls):
            return left
        loaded = at_walls[pushes > 0]
        for grain in np.unique(contacts.first[loaded]).tolist():
            own = loaded[contacts.first[loaded] == grain]
            tangents = np.concatenate(
                [contacts.basis[m][:, TANGENTIAL] for m in own.tolist()], axis=1
            )
            levers = contacts.arm[own].repeat(self.dimension - 1, axis=0).T
            scale = grains.radius[grain]
            if self.dimension == 3:  # levers end half-way into the overlap
                apart = np.linalg.norm(levers, axis=0)
                moments = np.cross((scale + apart) / 2 * levers / apart, tangents, axis=0)
            else:
                moments = (levers[0] * tangents[1] - levers[1] * tangents[0])[None]
            matrix = np.concatenate([tangents, moments / scale])
            solution, _, rank, _ = np.linalg.lstsq(
                matrix, np.concatenate([left[grain], torque[grain] / scale]), rcond=None
            )
            if rank < matrix.shape[1]:
                raise InputError(
                    f"{self.directory}: grain {self.ids[grain]} slides on {len(own)} walls, whose "
                    "forces cannot be separated from its motion; choose another --time, or a "
                    "packing with frictionless walls"
                )
            true[own, TANGENTIAL] = solution.reshape(len(own), -1)
            left[grain] -= tangents @ solution
        return left


def _refuse_unseen(result: Result, directory: str) -> None:
    """Raise InputError for a run whose grains are not visible to a camera, and for a run without
    contact forces.
    """
    assembly = result.assembly
    if not result.case.output.contact_forces:
        raise InputError(
            f"{directory}: its snapshots contain no contact forces; run the case again with "
            "output.contact_forces=true"
        )
    hindrances = {
        "periodic sides": assembly.lattice.periodic,
        "bars": bool(assembly.bars),
        "clumps": bool(assembly.clumps),
        "region walls": bool(assembly.case.wall),
        "a tube": any(wall.tube for wall in walls(assembly)),
    }
    for name, is_present in hindrances.items():
        if is_present:
            raise InputError(
                f"{directory}: has {name}, expected grains between planes, as seen by a camera"
            )


def _shape_of_grains(assembly: Assembly, directory: str) -> Shape:
    """Return the shape of all grains: a cylinder, or None for spheres."""
    shapes = set(assembly.grain_shapes())
    cylinder = shapes.pop()
    if shapes or (cylinder is not None and 1.0 not in np.abs(cylinder.axis[1:])):
        raise InputError(
            f"{directory}: has cylinders of several lengths or axes, or also spheres; expected "
            "spheres, or cylinders of one length along y or z"
        )
    return cylinder


def _displacement(result: Result, wall: str, times: Array) -> Array:
    """Return the outward displacement of a wall at some times, m: (n_times,)."""
    group = f"walls/{wall}"
    if f"{group}/displacement" not in result:
        return np.zeros(len(times))
    return np.interp(times, result[f"{group}/time"], result[f"{group}/displacement"])


def seen_by_camera(
    run: Snapshots, number: int, rate: float, noise: float, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return accelerations and angular accelerations by second differences of three frames around a
    snapshot.

    Positions between snapshots follow from positions and velocities, angles from spins and their
    rates.

    Parameters
    ----------
    rate
        Frames per second.
    noise
        Standard deviation of each coordinate, m; angles by this value / radius.

    Raises
    ------
    InputError
        The snapshots are farther apart than the frames.
    """
    interval = 1 / rate
    time = run.times[number]
    apart = float(np.diff(run.times).max(initial=0.0))
    if apart > (1 + 1e-9) * interval:
        needed = int(np.ceil((run.times[-1] - run.times[0]) * rate)) + 2
        raise InputError(
            f"--frame-rate {rate:g}: {run.directory} has snapshots up to {apart:.3g} s apart, "
            f"expected at most {interval:.3g} s, one for each frame; run it again with run.frames "
            f"= {needed} or more"
        )
    at = time + interval * np.array([-1.0, 0.0, 1.0])
    if at[0] < run.times[0] or at[-1] > run.times[-1]:
        raise InputError(
            f"--time {time:g}: found no frame {interval:.3g} s before or after it, expected an "
            f"instant from {run.times[0] + interval:.3g} to {run.times[-1] - interval:.3g} s"
        )
    places = CubicHermiteSpline(run.times, run.position, run.velocity)(at)
    angles = CubicHermiteSpline(run.times, run.spin, run.angular_acceleration).antiderivative()(at)
    places = places + noise * rng.normal(size=places.shape)
    angles = angles + noise / run.radius[:, None] * rng.normal(size=angles.shape)
    second = np.array([1.0, -2.0, 1.0]) / interval**2
    return np.tensordot(second, places, axes=1), np.tensordot(second, angles, axes=1)
