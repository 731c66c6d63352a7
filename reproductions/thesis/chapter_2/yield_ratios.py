"""Master curves of yielding spheres.

Two equal spheres with the modulus of brass and eight yield strengths are pressed together by finite
elements. gamma is the yield strength divided by E*. Overlaps are in units of the overlap at first
yield, pressures in units of the yield strength. The source fits one curve to all eight: mean
pressure (2.8), contact area (2.10) and residual overlap (2.13).
"""

import dataclasses
import tomllib

import h5py
import numpy as np
from matplotlib.figure import Figure

import granwave as gw

RATIOS = 8
PRESSURE = (2.48, 1.07, 0.098)  # c1, at first yield, c2 of 2.8
AREA_POWER = 1.14  # c3 of 2.10
AREA_LINE = (2.37, 59.96)  # c4, c5
AREA_SWITCH = 177.6
RESIDUAL = (0.95, 25.94, 0.015)  # c6, c7, c8 of 2.13
EXPONENTS = {"Smallest": 1.30, "Largest": 1.42}
#: Overlaps at which curves are compared: all eight reach the first, six and three the others.
PLACES = (50.0, 150.0, 300.0)
SAMPLES = 1000  # points of a drawn formula
NEAR = 0.02  # half-width of the mean about a place, in the logarithm of the overlap
BEYOND = 1.2  # end of a drawn profile / contact radius


def pressure(overlap):
    """Mean pressure divided by the yield strength, by 2.8."""
    limit, start, rate = PRESSURE
    return limit - (limit - start) * np.exp(-rate * (overlap - 1))


def area(overlap):
    """Area of the contact divided by the area at first yield, by 2.10."""
    slope, offset = AREA_LINE
    return np.where(overlap < AREA_SWITCH, overlap**AREA_POWER, slope * overlap - offset)


def residual(overlap):
    """Residual overlap by 2.13."""
    slope, offset, rate = RESIDUAL
    return slope * overlap - offset + (offset - slope) * np.exp(-rate * (overlap - 1))


@dataclasses.dataclass(frozen=True)
class Profile:
    """Pressure divided by the yield strength, and radius divided by R*, at an overlap in units of
    R*.
    """

    overlap: float
    radius: np.ndarray
    pressure: np.ndarray


class Contact:
    """Two spheres with the same yield strength."""

    def __init__(self, run):
        self.run = run
        text = (run.directory / "case.toml").read_text(encoding="utf-8")
        material = tomllib.loads(text)["material"]
        strength = material["yield_strength"]
        unit = run["yield_overlap_m"]
        effective_radius = run["effective_radius_m"]
        with h5py.File(run.directory / "result.h5") as file:
            loading = {name: file[f"loading/{name}"][()] for name in file["loading"]}
            self.peak = file["cycles/peak_overlap"][()] / unit
            self.residual = file["cycles/residual_overlap"][()] / unit
            profiles = [file["pressure"][name] for name in sorted(file["pressure"], key=int)]
            self.profiles = [
                Profile(
                    one.attrs["overlap"] / effective_radius,
                    one["radius"][()] / effective_radius,
                    one["pressure"][()] / strength,
                )
                for one in profiles
            ]
        effective_modulus = material["youngs_modulus"] / (2 * (1 - material["poisson_ratio"] ** 2))
        self.gamma = strength / effective_modulus
        self.overlap = loading["overlap"] / unit
        self.pressure = loading["mean_pressure"] / strength
        self.area = loading["contact_radius"] ** 2 / (effective_radius * unit)

    def at(self, place, values):
        """Mean of values about an overlap."""
        return values[np.abs(np.log(self.overlap / place)) < NEAR].mean()


def select(runs):
    """The contacts in order of rising yield strength; empty unless there are all eight."""
    contacts = sorted(map(Contact, runs), key=lambda one: one.gamma)
    return [contacts] if len(contacts) == RATIOS else []


def rows(contacts):
    curves = (
        ("Mean pressure / yield strength", "pressure", pressure, "thesis Fig. 2.4, 2.8"),
        ("Contact area / area at first yield", "area", area, "thesis Fig. 2.5, 2.10"),
    )
    for words, name, formula, where in curves:
        for place in PLACES:
            values = [
                one.at(place, getattr(one, name)) for one in contacts if one.overlap[-1] > place
            ]
            spread = 100 * np.ptp(values) / np.mean(values)
            yield gw.Row(
                f"{words} at {place:g} alpha_y", source=float(formula(place)),
                ours=np.mean(values), where=where,
                remark="The source value is from its fit. Our value is the mean of "
                       f"{len(values)} ratios, with a spread of {spread:.1f} %.",
                digits=3,
            )  # fmt: skip
    for one in contacts:
        largest = one.peak[-1]
        yield gw.Row(
            f"Residual / largest overlap, unloaded from {largest:.0f} alpha_y",
            source=float(residual(largest)) / largest, ours=one.residual[-1] / largest,
            where="thesis Fig. 2.7, 2.13", remark=f"gamma is {one.gamma:.2e}. The source value is "
                                                  "its fit.",
            digits=3,
        )  # fmt: skip
    exponents = {
        "Smallest": min(one.run["unloading_exponent_min"] for one in contacts),
        "Largest": max(one.run["unloading_exponent_max"] for one in contacts),
    }
    for word, source in EXPONENTS.items():
        yield gw.Row(
            f"{word} unloading exponent of the eight ratios", source=source, ours=exponents[word],
            where="thesis 2.1", digits=3,
        )  # fmt: skip
    deepest = contacts[0].profiles[-1]
    yield gw.Row(
        f"Largest pressure / yield strength at {deepest.overlap:.2f} R*", source=2.5,
        ours=np.median(deepest.pressure[deepest.pressure > 0]), where="thesis Fig. 2.3",
        remark="The value is the median over the contact.", digits=3,
    )  # fmt: skip


def pictures(contacts):
    figure = Figure((7, 5.2), layout="constrained")
    (profiles, pressures), (areas, residuals) = figure.subplots(2, 2)
    data = {}
    for one in contacts[0].profiles:
        radius = one.radius
        inside = radius < BEYOND * radius[one.pressure > 0].max()
        profiles.plot(radius[inside], one.pressure[inside], label=f"{one.overlap:.3f}")
        data |= {
            f"profile_{one.overlap:.3f}_r_over_R": radius[inside],
            f"profile_{one.overlap:.3f}_p_over_strength": one.pressure[inside],
        }
    for one in contacts:
        label = f"{one.gamma:.2e}"
        pressures.plot(one.overlap, one.pressure, linewidth=1, label=label)
        areas.plot(one.overlap, one.area, linewidth=1, label=label)
        residuals.plot(one.peak, one.residual, "o", markersize=3, label=label)
        name = f"gamma_{one.gamma:.2e}"
        data |= {
            f"{name}_overlap": one.overlap,
            f"{name}_pressure": one.pressure,
            f"{name}_area": one.area,
            f"{name}_peak_overlap": one.peak,
            f"{name}_residual": one.residual,
        }
    grid = np.linspace(1.0, contacts[0].overlap[-1], SAMPLES)
    formulas = ((pressures, pressure), (areas, area), (residuals, residual))
    for axes, formula in formulas:
        axes.plot(grid, formula(grid), "k--", linewidth=1, label="source")
        axes.set(xlabel=r"Overlap $\alpha/\alpha_\mathrm{y}$")
    pressures.set(ylabel=r"Mean pressure $p/\sigma_\mathrm{y}$", xlim=(0, 350), ylim=(0.8, 2.8))
    areas.set(ylabel=r"Area $A/A_\mathrm{y}$")
    residuals.set(ylabel=r"Residual $\alpha_R/\alpha_\mathrm{y}$")
    profiles.set(
        xlabel="Radius $r/R^*$",
        ylabel=r"Pressure $p/\sigma_\mathrm{y}$",
        xlim=(0, 0.8),
        ylim=(0, 3.2),
    )
    profiles.legend(title=r"$\alpha/R^*$", fontsize=6, ncols=2)
    areas.legend(title=r"$\gamma$", fontsize=6)
    caption = "Pressure along the contact at ten overlaps (smallest ratio), mean pressure, area "
    caption += "and residual overlap for eight ratios of yield strength and modulus: finite "
    caption += "elements and the source's fits (thesis Figs 2.3, 2.4, 2.5, 2.7)"
    yield gw.Picture("yield_ratios", caption, figure, data)
