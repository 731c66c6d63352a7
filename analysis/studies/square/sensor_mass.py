"""What spheres with a sensor, of another mass, do to the waves: in a chain, and in a square packing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.style import BLUE, GREY, Drawing, new_figure
from granwave.analysis.measures.sensors import sensor_velocities
from granwave.analysis.measures.signals import first_peak
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.square.runs import PackingRun
from granwave.analysis.studies.study import Picture, Row, Study
from granwave.lammps_inputs.packing.assembly import assemble

_WHERE = "square packing, Experimental Setup"
_BEFORE = 4  # contacts between the lighter sphere and the one at which the reflection is measured
_GONE = 1e-3  # of its peak: the incident wave has passed
_BACK = 0.8  # part of the wave's way to the far end and back that is waited for
_SENSOR_MASS, _LIMIT = 26.52 / 28.79, 1.2  # over the others'; per cent of the incident wave
_SAME = 0.005
_FELT = 0.01  # of the largest velocity: the wave passes a sensor


def lighter_sphere(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Chains that a striker hits, with one sphere of another mass and the same diameter."""
    found: dict[float, float] = {}
    for run in runs:
        ratio = _mass_ratio(run)
        share = np.nan if ratio is None else _reflection(run)
        if ratio is not None and np.isfinite(share):
            found.setdefault(round(ratio, 6), 100 * share)
    if not found:
        return
    ratios = np.array(sorted(found))
    reflected = np.array([found[ratio] for ratio in ratios])
    rows = []
    for ratio, ours in zip(ratios, reflected, strict=True):
        of_source = abs(ratio - _SENSOR_MASS) < _SAME
        rows.append(
            Row(
                f"Largest reflection of a sphere of {ratio:.3g} of the others' mass",
                "% of the wave",
                _LIMIT if of_source else None,
                float(ours),
                _WHERE,
                "the source says less than this" if of_source else "",
            )
        )
    pictures = (Picture("sensor_chain", "Reflection of a lighter sphere in a chain", _draw(ratios, reflected)),)
    yield Study(
        "sensor-chain",
        "A lighter sphere in a chain",
        "Largest contact force of what comes back, over that of the incident wave, four contacts before the sphere, "
        "until waves from the far end can arrive. The source does not say which amplitude it took, nor where.",
        tuple(rows),
        pictures if len(ratios) > 1 else (),
    )


def sensors_in_square(runs: Sequence[PackingRun]) -> Iterator[Study]:
    """Square packings with sensors in lighter spheres, beside the same one with like spheres."""
    plain = {_key(run): run for run in runs if run.alike and run.case.sensor}
    pairs = [(run, plain[_key(run)]) for run in runs if not run.alike and run.case.sensor and _key(run) in plain]
    rows = [row for run, other in pairs for row in _changes(run, other)]
    if rows:
        yield Study(
            "sensors-in-square",
            "Sensor spheres in a square packing",
            "What lighter spheres with sensors change at the sensors, beside spheres alike: peak velocity, and its "
            "time. The source found no trend in its experiments with a chain.",
            tuple(rows),
        )


def _changes(run: PackingRun, other: PackingRun) -> Iterator[Row]:
    with Result(run.directory) as with_sensors, Result(other.directory) as without:
        found = sensor_velocities(with_sensors), sensor_velocities(without)
        times = with_sensors["probes/time"], without["probes/time"]
    mass = run.assembly.mass_of(run.case.sensor[0].id) / run.case.sphere_mass
    largest = max(float(np.abs(one).max()) for one in found[1].values())
    for name in found[0]:
        speeds = [np.linalg.norm(one[name], axis=1) for one in found]
        (late, ours), (early, theirs) = (
            first_peak(time, one, floor=0.5) for time, one in zip(times, speeds, strict=True)
        )
        if theirs > _FELT * largest:
            where = f"sensor {name}, {mass:.3g} of the others' mass"
            yield Row(f"Change of peak velocity, {where}", "%", None, 100 * (ours / theirs - 1), _WHERE)
            yield Row(f"Delay of the peak, {where}", "µs", None, 1e6 * (late - early), _WHERE)


def _key(run: PackingRun) -> tuple:
    case = run.case
    return case.packing, case.material, case.striker, case.contact, case.boundary, case.run.end_time, case.sensor


def _mass_ratio(run: ChainRun) -> float | None:
    case = run.case
    if len(assemble(case).materials) != 1 or assemble(case).diameters or not run.recorded:
        return None
    if len(case.striker) != 1 or case.striker[0].touches != (1,) or case.load.kind != "striker" or case.contact.yields:
        return None
    theirs, ours = next(iter(assemble(case).materials.values())), case.material
    if (theirs.youngs_modulus, theirs.poisson_ratio) != (ours.youngs_modulus, ours.poisson_ratio):
        return None
    return theirs.density / ours.density


def _reflection(run: ChainRun) -> float:
    """NaN where the run ends too soon, or the sphere is too near an end."""
    place = next(iter(run.assembly.materials)) - _BEFORE  # the contact of the striker is number 0
    n = run.force.shape[1]
    if place < 2 or place + _BEFORE + 2 > n:
        return np.nan
    (here, peak), (early, _), (far, _) = (first_peak(run.time, run.force[:, k], floor=0.5) for k in (place, 1, n - 1))
    period = (here - early) / (place - 1)  # from contact to contact
    signal = run.force[:, place]
    gone = np.flatnonzero((run.time > here) & (signal < _GONE * peak))
    until = far + _BACK * (n - place) * period
    if not len(gone) or run.time[-1] < until:
        return np.nan
    after = signal[int(gone[0]) :][run.time[int(gone[0]) :] < until]
    return float(after.max(initial=0.0) / peak)


def _draw(ratios: np.ndarray, reflected: np.ndarray) -> Drawing:
    figure = new_figure(2.3)
    axes = figure.subplots()
    axes.plot(100 * ratios, reflected, "o-", color=BLUE, markersize=3, label="ours")
    axes.plot(100 * _SENSOR_MASS, _LIMIT, "v", color=GREY, label="source: less than this")
    axes.set_xlabel("Mass of the sphere (% of the others')")
    axes.set_ylabel("Reflection (% of the wave)")
    axes.set_ylim(0)
    axes.legend()
    return Drawing(figure, {"mass_ratio": ratios, "reflection_percent": reflected})
