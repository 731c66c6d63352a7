"""Plan of an experiment: measurements made of a finished run, and how far the forces inferred from
them are off.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

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
    """Make measurements of a run, infer the forces, and compare them with those of the run.

    Parameters
    ----------
    source
        Directory of a run whose snapshots hold contact forces.
    case
        Case of the inference; None: those of the run (friction, material).
    noise
        Errors of strains (and of accelerations, where these are not from frames) over their root
        mean squares.
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
        raise InputError(
            "--position-noise: found it without --frame-rate, which tells the frames that it falls on"
        )
    with Result(source) as result:
        run = Snapshots(result)
        name = result.case.name
    state, settings = _settings(run, case)
    if time is None:
        number = run.largest_snapshot(0.0 if frame_rate is None else 1 / frame_rate)
    elif run.times[0] <= time <= run.times[-1]:
        number = int(np.argmin(np.abs(run.times - time)))
    else:
        raise InputError(
            f"--time {time:g}: expected an instant from {run.times[0]:g} to {run.times[-1]:.6g} s"
        )
    exact, true = run.state(number, settings.contact_tolerance)
    if not true.any():
        raise InputError(
            f"{source}: bears no force at {run.times[number]:.4g} s; choose another --time"
        )
    material = None if case is None else case.material
    poisson = run.poisson_ratio if material is None else np.full(len(exact), material.poisson_ratio)
    compliance = np.linalg.inv(stiffness(run.youngs_modulus, poisson, state)).astype(np.float64)
    exact = dataclasses.replace(exact, compliance=compliance, modulus=run.youngs_modulus)
    walls = run.walls(number)
    rows = find_contacts(exact, walls, settings.contact_tolerance).touched(len(exact))
    exact = exact.take(rows)
    lonely = int(np.count_nonzero(~rows))
    notes = [f"{lonely} of {len(rows)} grains touch nothing and are left out"] if lonely else []
    rng = np.random.default_rng(seed)
    levels = sorted(noise)

    def measure(level: float) -> tuple[MeasuredGrains, Noise]:
        """Return grains with errors, and the standard deviations of these as an experimenter would
        know them.
        """
        errors = relative_noise(exact, level) if level else Noise()

        def off(values: Array, size: float | None) -> Array:
            return values + size * rng.normal(size=values.shape) if size else values

        strain = off(exact.strain, errors.strain)
        stress = np.asarray(
            np.linalg.solve(compliance[rows], strain[:, :, None])[:, :, 0], dtype=np.float64
        )
        if frame_rate is None:
            acceleration = off(exact.acceleration, errors.acceleration)
            turning = off(exact.angular_acceleration, errors.angular_acceleration)
        else:
            seen = seen_by_camera(run, number, frame_rate, position_noise, rng)
            acceleration, turning = (
                np.where(exact.has_motion[:, None], one[rows], np.nan) for one in seen
            )
            # an experimenter knows the error of places, and sees the strains'; differences over too
            # long frames stay unknown
            size = math.sqrt(6) * position_noise * frame_rate**2
            errors = Noise(strain=errors.strain, acceleration=size or None)
        measured = dataclasses.replace(
            exact, stress=stress, acceleration=acceleration, angular_acceleration=turning
        )
        return measured, errors

    turns = {level: repetitions if level or position_noise else 1 for level in levels}
    errors: dict[float, list[float]] = {level: [] for level in levels}
    off = []
    with progress_bar(progress, total=sum(turns.values()), desc="measurements", leave=False) as bar:
        for level, repetition in (
            (level, n) for level, n_turns in turns.items() for n in range(n_turns)
        ):
            measured, spread = measure(level)
            if repetition == 0:
                kept = measured
                known = spread
            one = infer(measured, walls, dataclasses.replace(settings, noise=spread, repetitions=0))
            off.append(_relative(measured.acceleration, exact.acceleration))
            errors[level].append(_relative(one.force, true))
            bar.update()
    found = infer(
        kept,
        walls,
        dataclasses.replace(settings, noise=known, repetitions=repetitions),
        progress=progress,
    )
    means, deviations = ([float(of(errors[level])) for level in levels] for of in (np.mean, np.std))
    instant = float(run.times[number])
    several = len(levels) > 1
    summary = summary_of(name, str(source), state, [found], [instant], notes) | {
        "true_force_error": means if several else means[0],
        "noise": levels if several else levels[0],
        "frame_rate_Hz": frame_rate,
        "position_noise_m": position_noise if frame_rate else None,
        "acceleration_error": float(np.mean(off)),
    }
    return Inferred(
        [found],
        [instant],
        summary,
        measurement=_columns(kept, run, rows),
        case=_case(run, state, found.settings, walls),
        true=true,
        noise=np.array([levels, means, deviations]) if several else None,
    )


def _case(
    run: Snapshots, state: State, settings: Infer, walls: Mapping[str, StraightWall]
) -> dict[str, Any]:
    """Return the tables of a case with which `granwave infer` reads the measurement; materials are
    in its columns.
    """
    same = (
        "friction",
        "wall_friction",
        "contact_tolerance",
        "modulus",
        "repetitions",
        "ridge",
        "weights",
    )
    wanted: dict[str, Any] = {
        "state": state,
        "thickness": run.length,
        **{name: getattr(settings, name) for name in same},
    }
    wanted["walls"] = {
        name: {"point": list(one.point), "normal": list(one.normal)} for name, one in walls.items()
    }
    noise = {name: size for name, size in dataclasses.asdict(settings.deviations).items() if size}
    if noise:
        wanted["noise"] = noise
    names = ("density", "youngs_modulus", "poisson_ratio")
    material = {name: float(getattr(run, name)[0]) for name in names}
    return {
        "material": material,
        "infer": {name: value for name, value in wanted.items() if value is not None},
    }


def _settings(run: Snapshots, case: InferCase | None) -> tuple[State, Infer]:
    """Return state and settings: those of the case, or of the run."""
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
                f"{'space' if run.dimension == 3 else 'plane-stress or plane-strain'} for {run.directory}"
            )
        return "space", settings
    return case.infer.state, settings


def _relative(found: Array, true: Array) -> float:
    known = np.isfinite(true)
    size = float(np.linalg.norm(true[known]))
    return float(np.linalg.norm((found - true)[known])) / size if size > 0 else 0.0


def _columns(grains: MeasuredGrains, run: Snapshots, rows: NDArray[np.bool_]) -> Columns:
    """Return the columns of the measurement of the grains ``rows`` of a run, as `granwave infer`
    reads them.
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
