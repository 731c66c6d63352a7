"""Plan of an experiment: simulated measurements of a finished run, and the errors of the forces
inferred from them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.style import Columns
from granwave.analysis.progress_bar import progress_bar
from granwave.analysis.result.reader import Result
from granwave.extensions.inference.forces.case import Infer, InferCase
from granwave.extensions.inference.forces.equations import Noise
from granwave.extensions.inference.forces.grains import (
    Array,
    MeasuredGrains,
    State,
    StraightWall,
    find_contacts,
    stiffness,
)
from granwave.extensions.inference.forces.infer import infer, relative_noise
from granwave.extensions.inference.forces.measurement import groups
from granwave.extensions.inference.forces.output import Inferred
from granwave.extensions.inference.forces.tables import summary_of
from granwave.extensions.inference.forces.truth import Snapshots, seen_by_camera
from granwave.lammps_inputs.errors import InputError


def plan_experiment(
    source: Path,
    case: InferCase | None = None,
    *,
    noise: Sequence[float] = (0.0,),
    frame_rate: float | None = None,
    position_noise: float = 0.0,
    time: float | None = None,
    repetitions: int = 10,
    seed: int = 1,
    progress: bool = False,
) -> Inferred:
    """Simulate measurements of a run, infer the forces, and compare them with the run.

    Parameters
    ----------
    source
        Directory of a run whose snapshots hold contact forces.
    case
        Case of the inference; None: friction and material of the run.
    noise
        Errors of strains (and of accelerations, where these are not from frames) / their root mean
        squares.
    frame_rate
        Frames per second from which accelerations are differentiated; None: accelerations are
        measured.
    position_noise
        Standard deviation of each coordinate in a frame, m.
    time
        Instant, s; None: that with the largest forces.
    repetitions
        Number of measurements with different errors.
    progress
        Show a bar on a terminal.

    Raises
    ------
    InputError
        The run cannot be measured, or its forces are not determined.
    """
    if position_noise and frame_rate is None:
        raise InputError("--position-noise: requires --frame-rate, which defines the frames")
    with Result(source) as result:
        run = Snapshots(result)
        name = result.case.name
    state, settings = _settings(run, case)
    number = _snapshot(run, time, frame_rate)
    exact, true = run.state(number, settings.contact_tolerance)
    if not true.any():
        raise InputError(
            f"{source}: has no forces at {run.times[number]:.4g} s; choose another --time"
        )
    exact = _with_compliance(run, exact, case, state)
    walls = run.walls(number)
    rows = find_contacts(exact, walls, settings.contact_tolerance).touched(len(exact))
    exact = exact.take(rows)
    n_lonely = int(np.count_nonzero(~rows))
    notes = []
    if n_lonely:
        notes.append(f"{n_lonely} of {len(rows)} grains have no contact and are excluded")
    camera = None if frame_rate is None else _Camera(frame_rate, position_noise)
    experiment = _Experiment(run, number, exact, rows, camera, np.random.default_rng(seed))
    levels = sorted(noise)
    n_measurements = {level: repetitions if level or position_noise else 1 for level in levels}
    errors: dict[float, list[float]] = {level: [] for level in levels}
    acceleration_errors = []
    total = sum(n_measurements.values())
    with progress_bar(progress, total=total, desc="measurements", leave=False) as bar:
        for level, count in n_measurements.items():
            for repetition in range(count):
                measured, deviations = experiment.measure(level)
                if repetition == 0:
                    kept = measured
                    kept_noise = deviations
                once = dataclasses.replace(settings, noise=deviations, repetitions=0)
                estimate = infer(measured, walls, once)
                acceleration_errors.append(_relative(measured.acceleration, exact.acceleration))
                errors[level].append(_relative(estimate.force, true))
                bar.update()
    repeated = dataclasses.replace(settings, noise=kept_noise, repetitions=repetitions)
    inference = infer(kept, walls, repeated, progress=progress)
    means = [float(np.mean(errors[level])) for level in levels]
    spreads = [float(np.std(errors[level])) for level in levels]
    instant = float(run.times[number])
    several = len(levels) > 1
    summary = summary_of(name, str(source), state, [inference], [instant], notes) | {
        "true_force_error": means if several else means[0],
        "noise": levels if several else levels[0],
        "frame_rate_Hz": frame_rate,
        "position_noise_m": position_noise if frame_rate else None,
        "acceleration_error": float(np.mean(acceleration_errors)),
    }
    return Inferred(
        [inference],
        [instant],
        summary,
        measurement=_columns(kept, run, rows),
        case=_case(run, state, inference.settings, walls),
        true=true,
        noise=np.array([levels, means, spreads]) if several else None,
    )


def _snapshot(run: Snapshots, time: float | None, frame_rate: float | None) -> int:
    """Return the number of the snapshot at a time, or of the snapshot with the largest forces."""
    if time is None:
        return run.largest_snapshot(0.0 if frame_rate is None else 1 / frame_rate)
    if run.times[0] <= time <= run.times[-1]:
        return int(np.argmin(np.abs(run.times - time)))
    raise InputError(
        f"--time {time:g}: expected an instant from {run.times[0]:g} to {run.times[-1]:.6g} s"
    )


def _with_compliance(
    run: Snapshots, grains: MeasuredGrains, case: InferCase | None, state: State
) -> MeasuredGrains:
    """Return the grains of a run with moduli and compliances, which give strains."""
    poisson_ratio = run.poisson_ratio
    if case is not None and case.material is not None:
        poisson_ratio = np.full(len(grains), case.material.poisson_ratio)
    elastic = stiffness(run.youngs_modulus, poisson_ratio, state)
    compliance = np.linalg.inv(elastic).astype(np.float64)
    return dataclasses.replace(grains, compliance=compliance, modulus=run.youngs_modulus)


class _Camera(NamedTuple):
    """Camera that records the positions of grains.

    Attributes
    ----------
    rate
        Frames per second.
    noise
        Standard deviation of each coordinate, m.
    """

    rate: float
    noise: float


@dataclasses.dataclass(frozen=True, eq=False)
class _Experiment:
    """Simulated experiment on the grains of a snapshot.

    Attributes
    ----------
    number
        Number of the snapshot.
    exact
        Grains with exact motions and stresses: (n,).
    rows
        True for these among the grains of the run: (n_all,).
    camera
        Source of the accelerations; None if they are measured.
    """

    run: Snapshots
    number: int
    exact: MeasuredGrains
    rows: NDArray[np.bool_]
    camera: _Camera | None
    rng: np.random.Generator

    def measure(self, level: float) -> tuple[MeasuredGrains, Noise]:
        """Return grains with errors, and the standard deviations that an experimenter would know.

        ``level`` is the noise divided by the root mean square of the measured quantities.
        """
        exact = self.exact
        assert exact.compliance is not None
        noise = relative_noise(exact, level) if level else Noise()
        strain = self._with_errors(exact.strain, noise.strain)
        stress = np.linalg.solve(exact.compliance, strain[:, :, None])[:, :, 0]
        if self.camera is None:
            acceleration = self._with_errors(exact.acceleration, noise.acceleration)
            turning = self._with_errors(exact.angular_acceleration, noise.angular_acceleration)
        else:
            acceleration, turning = self._seen(self.camera)
            # the error of second differences; errors due to long intervals stay unknown
            deviation = math.sqrt(6) * self.camera.noise * self.camera.rate**2
            noise = Noise(strain=noise.strain, acceleration=deviation or None)
        measured = dataclasses.replace(
            exact,
            stress=np.asarray(stress, dtype=np.float64),
            acceleration=acceleration,
            angular_acceleration=turning,
        )
        return measured, noise

    def _with_errors(self, values: Array, deviation: float | None) -> Array:
        """Return values with normally distributed errors."""
        if not deviation:
            return values
        return values + deviation * self.rng.normal(size=values.shape)

    def _seen(self, camera: _Camera) -> tuple[Array, Array]:
        """Return accelerations and angular accelerations from frames; NaN where unknown."""
        acceleration, turning = seen_by_camera(
            self.run, self.number, camera.rate, camera.noise, self.rng
        )
        has_motion = self.exact.has_motion[:, None]
        return (
            np.where(has_motion, acceleration[self.rows], np.nan),
            np.where(has_motion, turning[self.rows], np.nan),
        )


def _case(
    run: Snapshots, state: State, settings: Infer, walls: Mapping[str, StraightWall]
) -> dict[str, Any]:
    """Return the tables of a case for `granwave infer` on the measurement; materials are in columns
    of the measurement.
    """
    setting_names = (
        "friction",
        "wall_friction",
        "contact_tolerance",
        "modulus",
        "repetitions",
        "ridge",
        "weights",
    )
    table: dict[str, Any] = {
        "state": state,
        "thickness": run.length,
        **{name: getattr(settings, name) for name in setting_names},
    }
    table["walls"] = {
        name: {"point": list(plane.point), "normal": list(plane.normal)}
        for name, plane in walls.items()
    }
    noise = {name: size for name, size in dataclasses.asdict(settings.deviations).items() if size}
    if noise:
        table["noise"] = noise
    names = ("density", "youngs_modulus", "poisson_ratio")
    material = {name: float(getattr(run, name)[0]) for name in names}
    return {
        "material": material,
        "infer": {name: value for name, value in table.items() if value is not None},
    }


def _settings(run: Snapshots, case: InferCase | None) -> tuple[State, Infer]:
    """Return the state and the settings of the case; without a case those of the run."""
    if case is None:
        state: State = "space" if run.dimension == 3 else "plane-stress"
        return state, Infer(friction=run.friction[0], wall_friction=run.friction[1])
    settings = case.infer
    if settings.wall_friction is None and case.infer.friction == run.friction[0]:
        settings = dataclasses.replace(settings, wall_friction=run.friction[1])
    if run.dimension != case.dimension:
        if case.infer.state != Infer(friction=0.0).state:
            raise InputError(
                f"{case.source}: infer.state: found {case.infer.state}, expected "
                f"{'space' if run.dimension == 3 else 'plane-stress or plane-strain'} for "
                f"{run.directory}"
            )
        return "space", settings
    return case.infer.state, settings


def _relative(inferred: Array, true: Array) -> float:
    finite = np.isfinite(true)
    size = float(np.linalg.norm(true[finite]))
    return float(np.linalg.norm((inferred - true)[finite])) / size if size > 0 else 0.0


def _columns(grains: MeasuredGrains, run: Snapshots, rows: NDArray[np.bool_]) -> Columns:
    """Return the columns of a measurement of the grains ``rows`` of a run, in the form that
    `granwave infer` reads.
    """
    names = groups(grains.dimension)
    values = {
        "position": grains.position,
        "acceleration": grains.acceleration,
        "spin": grains.spin,
        "angular_acceleration": grains.angular_acceleration,
        "force": grains.known_force,
        "strain": grains.strain,
    }
    columns: dict[str, Any] = {"id": grains.ids, "radius_m": grains.radius}
    for group, table in values.items():
        if group == "force" and not table.any():
            continue
        columns |= dict(zip(names[group], table.T, strict=True))
    if grains.passes_walls is not None and grains.passes_walls.any():
        columns["passes_walls"] = grains.passes_walls.astype(np.float64)
    material = (run.density[rows], run.youngs_modulus[rows], run.poisson_ratio[rows])
    return columns | dict(zip(names["material"], material, strict=True))
