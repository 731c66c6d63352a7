"""Plan of an experiment: measurements made of a finished run, and how far the forces inferred from them are off."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.style import Columns
from granwave.analysis.inference.case import Infer, InferCase
from granwave.analysis.inference.equations import Noise
from granwave.analysis.inference.grains import Array, Grains, State, Wall, find_contacts, stiffness
from granwave.analysis.inference.infer import infer, relative_noise
from granwave.analysis.inference.output import Inferred
from granwave.analysis.inference.table import groups
from granwave.analysis.inference.tables import summary_of
from granwave.analysis.inference.truth import Snapshots, seen_by_camera
from granwave.analysis.progress_bar import progress_bar
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.errors import InputError


@dataclasses.dataclass(frozen=True)
class Camera:
    """A measurement to be made of a run.

    Attributes
    ----------
    noise
        Errors of strains (and of accelerations, where these are not from frames) over their root mean squares.
    frame_rate
        Frames per second from which accelerations are differentiated; None: accelerations are measured.
    position_noise
        Standard deviation of each coordinate in a frame, m.
    time
        Instant, s; None: that with the largest forces.
    repetitions
        Number of measurements with different errors.
    """

    noise: tuple[float, ...] = (0.0,)
    frame_rate: float | None = None
    position_noise: float = 0.0
    time: float | None = None
    repetitions: int = 10
    seed: int = 1


def plan_experiment(source: Path, case: InferCase | None, camera: Camera, *, progress: bool = False) -> Inferred:
    """Make measurements of a run, infer the forces, and compare them with those of the run.

    Parameters
    ----------
    source
        Directory of a run whose snapshots hold contact forces.
    case
        Case of the inference; None: those of the run (friction, material).
    progress
        Show a bar on a terminal.

    Raises
    ------
    InputError
        The run cannot be measured, or its forces are not determined.
    """
    if camera.position_noise and camera.frame_rate is None:
        raise InputError("--position-noise: found it without --frame-rate, which tells the frames that it falls on")
    with Result(source) as result:
        run = Snapshots(result)
        name = result.case.name
    state, settings = _settings(run, case)
    number = _snapshot(run, camera)
    exact, true = run.state(number, settings.contact_tolerance)
    if not true.any():
        raise InputError(f"{source}: bears no force at {run.times[number]:.4g} s; choose another --time")
    poisson = (
        run.poisson_ratio if case is None or case.material is None else np.full(len(exact), case.material.poisson_ratio)
    )
    compliance = np.linalg.inv(stiffness(run.youngs_modulus, poisson, state)).astype(np.float64)
    exact = dataclasses.replace(exact, compliance=compliance, modulus=run.youngs_modulus)
    walls = run.walls(number)
    kept_rows = find_contacts(exact, walls, settings.contact_tolerance).touched(len(exact))
    exact, lonely = exact.take(kept_rows), int(np.count_nonzero(~kept_rows))
    notes = [f"{lonely} of {len(kept_rows)} grains touch nothing and are left out"] if lonely else []
    rng = np.random.default_rng(camera.seed)
    means, deviations, off, kept = [], [], [], None
    levels = sorted(camera.noise)
    turns = sum(camera.repetitions if level or camera.position_noise else 1 for level in levels)
    bar = progress_bar(progress, total=turns, desc="measurements", leave=False)
    for level in levels:
        errors = []
        for repetition in range(camera.repetitions if level or camera.position_noise else 1):
            measured, noise = _measure(run, number, exact, kept_rows, level, camera, rng)
            off.append(_relative(measured.acceleration, exact.acceleration))
            own = dataclasses.replace(settings, noise=noise, repetitions=0)
            one = infer(measured, walls, own)
            if repetition == 0:
                kept = measured, noise
            errors.append(_relative(one.force, true))
            bar.update()
        means.append(float(np.mean(errors)))
        deviations.append(float(np.std(errors)))
    bar.close()
    assert kept is not None
    own = dataclasses.replace(settings, noise=kept[1], repetitions=camera.repetitions)
    found = infer(kept[0], walls, own, progress=progress)
    time = float(run.times[number])
    summary = summary_of(name, str(source), state, [found], [time], notes)
    several = len(levels) > 1
    summary |= {
        "true_force_error": means if several else means[0],
        "noise": levels if several else levels[0],
        "frame_rate_Hz": camera.frame_rate,
        "position_noise_m": camera.position_noise if camera.frame_rate else None,
        "acceleration_error": float(np.mean(off)),
    }
    return Inferred(
        [found],
        [time],
        summary,
        measurement=_columns(kept[0], run, kept_rows),
        case=_case(run, state, found.settings, walls),
        true=true,
        noise=np.array([levels, means, deviations]) if several else None,
    )


def _case(run: Snapshots, state: State, settings: Infer, walls: Mapping[str, Wall]) -> dict[str, Any]:
    """Return the tables of a case with which `granwave infer` reads the measurement; materials are in its columns."""
    wanted: dict[str, Any] = {
        "state": state,
        "friction": settings.friction,
        "wall_friction": settings.wall_friction,
        "thickness": run.length,
        "contact_tolerance": settings.contact_tolerance,
        "modulus": settings.modulus,
        "repetitions": settings.repetitions,
        "ridge": settings.ridge,
        "weights": settings.weights,
        "walls": {name: {"point": list(wall.point), "normal": list(wall.normal)} for name, wall in walls.items()},
    }
    noise = {name: size for name, size in dataclasses.asdict(settings.deviations).items() if size}
    if noise:
        wanted["noise"] = noise
    names = ("density", "youngs_modulus", "poisson_ratio")
    material = {name: float(getattr(run, name)[0]) for name in names}
    return {"material": material, "infer": {name: value for name, value in wanted.items() if value is not None}}


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


def _snapshot(run: Snapshots, camera: Camera) -> int:
    if camera.time is None:
        return run.largest_snapshot(0.0 if camera.frame_rate is None else 1 / camera.frame_rate)
    if not run.times[0] <= camera.time <= run.times[-1]:
        raise InputError(f"--time {camera.time:g}: expected an instant from {run.times[0]:g} to {run.times[-1]:.6g} s")
    return int(np.argmin(np.abs(run.times - camera.time)))


def _measure(
    run: Snapshots,
    number: int,
    exact: Grains,
    rows: NDArray[np.bool_],
    level: float,
    camera: Camera,
    rng: np.random.Generator,
) -> tuple[Grains, Noise]:
    """Return grains with errors, and the standard deviations of these as an experimenter would know them.

    ``exact`` are the grains ``rows`` of the run.
    """
    scale = relative_noise(exact, level) if level else Noise()
    assert exact.compliance is not None
    strain = np.einsum("nij,nj->ni", exact.compliance, exact.stress)
    if scale.strain:
        strain = strain + scale.strain * rng.normal(size=strain.shape)
    stress = np.linalg.solve(exact.compliance, strain[:, :, None])[:, :, 0]
    if camera.frame_rate is None:
        acceleration, turning = exact.acceleration, exact.angular_acceleration
        if scale.acceleration:
            acceleration = acceleration + scale.acceleration * rng.normal(size=acceleration.shape)
        if scale.angular_acceleration:
            turning = turning + scale.angular_acceleration * rng.normal(size=turning.shape)
        return dataclasses.replace(exact, stress=stress, acceleration=acceleration, angular_acceleration=turning), scale
    seen = seen_by_camera(run, number, camera.frame_rate, camera.position_noise, rng)
    acceleration, turning = seen[0][rows], seen[1][rows]
    unseen = ~exact.has_motion
    acceleration[unseen], turning[unseen] = np.nan, np.nan
    # an experimenter knows the error of places, and sees the strains'; differences over too long frames stay unknown
    known = math.sqrt(6) * camera.position_noise * camera.frame_rate**2
    noise = Noise(strain=scale.strain, acceleration=known or None)
    return dataclasses.replace(exact, stress=stress, acceleration=acceleration, angular_acceleration=turning), noise


def _relative(found: Array, true: Array) -> float:
    known = np.isfinite(true)
    size = float(np.linalg.norm(true[known]))
    return float(np.linalg.norm((found - true)[known])) / size if size > 0 else 0.0


def _columns(grains: Grains, run: Snapshots, rows: NDArray[np.bool_]) -> Columns:
    """Return the columns of the measurement of the grains ``rows`` of a run, as `granwave infer` reads them."""
    names = groups(grains.dimension)
    assert grains.compliance is not None
    values = {
        "position": grains.position,
        "acceleration": grains.acceleration,
        "spin": grains.spin,
        "angular_acceleration": grains.angular_acceleration,
        "force": grains.known_force,
        "strain": np.einsum("nij,nj->ni", grains.compliance, grains.stress),
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
