"""Twin sensors in a square packing.

Two sensors are at symmetric positions, and impacts are not ideal: the striker hits the resting
striker off its centre, the resting striker is displaced, or the diameters scatter. On a tilted
floor spheres lean on each other and all contacts are closed; without tilt they stay at the sites of
the lattice, with gaps. Each setting has runs with several seeds. The rows give standard deviations
between runs of the time between the two peaks of acceleration, and of their ratio. The source has
15 impacts for each pair. It states the tolerance of the diameters, ± 0.01 mm, but no misalignment
and no gap; the settings are ours. The ratio of delay to amplitude difference (in per cent) hardly
depends on the size of an imperfection, and identifies its kind.
"""

import math

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import directions, estimate, first_peak, sensor_accelerations

# impacts of the source at each position of sensors; runs for a standard deviation
IMPACTS = 15
FEWEST = 4
PATH = {"where": "square packing, Wave Propagation Path"}
#: Source's mean and standard deviation: delay of the second sensor, µs, and excess acceleration of
#: the first, %.
TWINS = {
    "1A and 1B (central chains, in-plane)": ((-21.0, 68.0), (4.0, 10.0)),
    "2A and 2B (edge chains, in-plane)": ((-0.5, 6.5), (-7.0, 18.0)),
    "3A and 3B (central chains, out-of-plane)": ((25.0, 54.0), (1.0, 42.0)),
}


class Sample:
    """All runs of a setting at two twin sensors: delay, µs, excess, %, and arrival, µs, of the
    peaks.
    """

    def __init__(self, twins, setting, runs):
        self.twins = twins
        self.setting = setting
        self.n = len(runs)
        first, _, second, *_ = twins.split()
        found = [one for one in (differences(run, first, second) for run in runs) if one]
        self.lost = self.n - len(found)
        self.delay, self.excess, self.arrival = map(estimate, zip(*found, strict=True))
        self.scattered = setting != "ideal" and len(found) >= FEWEST
        self.ratio = self.delay.deviation / self.excess.deviation if self.scattered else math.nan

    @property
    def remark(self):
        """Cause of the scatter, and runs that are excluded."""
        parts = []
        if "striker off centre" in self.setting:
            parts.append(
                "The resting striker moves sideways. The source does not state the offset of "
                "the impacts."
            )
        if "resting striker aside" in self.setting:
            parts.append(
                "The resting striker touches one of two spheres first. The source does "
                "not state the gap."
            )
        if "leaning" in self.setting:
            four = (
                "; the resting striker lies on three of its four spheres and has a gap to the "
                "fourth"
            )
            parts.append(f"All contacts are closed{four if 'out-of-plane' in self.twins else ''}.")
        if "at the sites" in self.setting:
            parts.append(f"Gaps delay the wave, which arrives after {short(self.arrival.mean)} µs.")
        if self.lost:
            parts.append(
                f"In {self.lost} of {self.n} runs the wave misses one of the two sensors; such "
                "runs are excluded."
            )
        return " ".join(parts)


def differences(run, first, second):
    """Delay, excess and arrival of two sensors; None if the wave has reached only one of them, or
    neither.
    """
    found = sensor_accelerations(run.result)
    ways = directions(run.result)
    time = run.result["probes/time"]
    ids = {sensor.name: sensor.id for sensor in run.case.sensor}
    along = [found[name] @ ways[ids[name] - 1] for name in (first, second)]
    times, peaks = np.transpose([first_peak(time, one, floor=0.5) for one in along])
    if not (peaks.min() >= 0.1 * peaks.max() and times.max() < time[-2]):
        return None
    return 1e6 * (times[1] - times[0]), 100 * (peaks[0] / peaks[1] - 1), 1e6 * times.mean()


def setting(case):
    """Imperfection of a case."""
    parts = []
    packing = case.packing
    if packing.diameter_scatter:
        place = "leaning to +x, +y" if packing.tilt else "at the sites"
        parts.append(f"diameters ± {5e5 * packing.diameter_scatter:g} µm, {place}")
    for striker in case.striker:
        if size := max(striker.misalignment):
            what = "striker off centre" if any(striker.velocity) else "resting striker aside"
            parts.append(
                f"{what} within " + (f"{1e3 * size:g} mm" if size >= 1e-4 else f"{1e6 * size:g} µm")
            )
    return "; ".join(parts) or "ideal"


def short(value):
    return f"{float(f'{value:.3g}'):g}"


def select(runs):
    """One group of all samples."""
    found = {}
    for run in runs:
        names = {sensor.name for sensor in run.case.sensor}
        for twins in TWINS:
            if twins[:2] in names:
                found.setdefault((twins, setting(run.case)), []).append(run)
    return [[Sample(*key, members) for key, members in found.items()]]


def by_twins(samples):
    """Values of the source, and samples with scatter, of each pair of sensors."""
    for twins, source in TWINS.items():
        own = [one for one in samples if one.twins == twins and one.scattered]
        if own:
            yield twins, source, own


def rows(samples):
    for one in samples:
        if one.scattered:
            scatters = (
                ("delay", "µs", one.delay.deviation),
                ("peak acceleration", "%", one.excess.deviation),
            )
            for (name, unit, ours), (_, theirs) in zip(scatters, TWINS[one.twins], strict=True):
                remark = (
                    f"The source reports a scatter of {theirs:g} {unit}. It attributes the scatter "
                    f"to imperfect impacts, which it did not measure. {one.remark}"
                )
                quantity = f"Scatter of the {name}, {one.twins}: {one.setting}"
                yield gw.Row(quantity, unit, ours=ours, remark=remark, **PATH)
    for twins, source, _ in by_twins(samples):
        names = (
            (f"Mean delay, {twins}", "µs"),
            (f"Mean difference of the peak acceleration, {twins}", "%"),
        )
        for (name, unit), (mean, scatter) in zip(names, source, strict=True):
            errors = abs(mean) / (scatter / math.sqrt(IMPACTS))
            remark = (
                f"the source value differs by {errors:.1f} standard errors of its {IMPACTS} "
                "impacts, which is not significant."
            )
            yield gw.Row(
                name,
                unit,
                mean,
                theory=0.0,
                remark=f"Because of symmetry the expected value is 0; {remark}",
                **PATH,
            )


def verdict(samples):
    """Ratio of the delay to the scatter of the amplitude, which is almost independent of the size
    of an imperfection.
    """
    for twins, ((_, delay), (_, excess)), own in by_twins(samples):
        found = "; ".join(f"{one.setting}: {short(one.ratio)}" for one in own)
        yield (
            f"{twins.partition(' (')[0]}: the source has scatters of {delay:g} µs and {excess:g} "
            f"%, or {short(delay / excess)} µs for each per cent of amplitude scatter. Our "
            f"values are: {found}."
        )


def pictures(samples):
    axes = Figure((5.2, 4.2), layout="constrained").subplots()
    settings = list(dict.fromkeys(one.setting for one in samples if one.scattered))
    marks = dict(zip(TWINS, "os^", strict=True))
    for n, name in enumerate(settings):
        for k, one in enumerate(one for one in samples if one.setting == name):
            scatter = one.excess.deviation, one.delay.deviation
            axes.loglog(
                *scatter, marks[one.twins], color=f"C{n}", markersize=4, label="" if k else name
            )
    for twins, ((_, delay), (_, excess)), _ in by_twins(samples):
        name = f"source, {twins.partition(' (')[0]}"
        axes.loglog(excess, delay, f"{marks[twins]}k", markersize=8, fillstyle="none", label=name)
    axes.set(xlabel="Scatter of the peak acceleration (%)", ylabel="Scatter of the delay (µs)")
    axes.figure.legend(loc="outside upper center", ncols=2, fontsize=6)
    data = {
        name: [getattr(one, name) for one in samples] for name in ("twins", "setting", "n", "lost")
    }
    for name, unit in (("delay", "us"), ("excess", "percent"), ("arrival", "us")):
        values = [getattr(one, name) for one in samples]
        data |= {f"{name}_{unit}": [one.mean for one in values]}
        data |= {f"{name}_scatter_{unit}": [one.deviation for one in values]}
        data |= {f"{name}_95_percent_{unit}": [one.half_width for one in values]}
    caption = (
        "Scatter of the delay between twin sensors against the scatter of their ratio of peaks; "
        "each pair has a symbol. One kind of imperfection gives a line of slope 1: a kind whose "
        "line passes through the open mark of the source may be its cause"
    )
    yield gw.Picture("", caption, axes.figure, data)
