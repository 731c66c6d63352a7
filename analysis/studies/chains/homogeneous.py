"""The homogeneous chain of the composite-chain source: its finite elements and ours against theory (Tables 2 and 3).

15 stainless-steel spheres of 4.76 mm, the first with 0.626 m/s, the last against a steel cylinder. Two theories serve:
Nesterenko's formula, of a continuum with the long-wave limit of the chain's dispersion, which the source takes, and the
travelling wave of the discrete chain itself (`discrete_speed`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, new_figure
from granwave.analysis.measures.signals import first_peak
from granwave.analysis.studies.chains.elastic import IMPULSE_COEFFICIENT
from granwave.analysis.studies.chains.runs import ChainRun, uniform
from granwave.analysis.studies.chains.scales import ChainScales, discrete_speed
from granwave.analysis.studies.study import Picture, Row, Study
from granwave.lammps_inputs.case.material import material

_CONTACTS = (4, 9)  # from 0: of beads 5 and 6, 10 and 11, as the source takes them
_DIAMETER, _VELOCITY = 4.76e-3, 0.626  # m, m/s: of the source
_WHERE = "composite chain, Tables 2 and 3"
_SAME = 1e-6
_EXPONENT = 1.5  # of the Hertz law


@dataclasses.dataclass(frozen=True)
class Model:
    """A finite-element model of the source: force in N, speed in m/s, its printed error of the speed in per cent."""

    name: str
    force: float
    speed: float
    error: float


MODELS = (
    Model("mesh 0.2 to 0.4 mm", 7.92, 590, 20.00),
    Model("mesh 0.1 to 0.2 mm", 21.71, 569, 2.14),
    Model("mesh 0.05 to 0.1 mm", 24.55, 566, 4.63),
    Model("mesh 0.025 to 0.05 mm", 26.62, 586, 2.58),
    Model("mesh 0.01 to 0.02 mm", 27.17, 599, 0.76),
    Model("penalty 1.1", 26.71, 587, 2.47),
    Model("penalty 1.2", 26.77, 590, 2.01),
    Model("penalty 1.3", 26.81, 592, 1.70),
    Model("penalty 1.4", 26.86, 592, 1.57),
    Model("penalty 1.5, constant solver", 27.36, 590, 2.36),
    Model("penalty 1.5, automatic solver", 27.22, 595, 0.40),
)
_FINEST, _CHOSEN = MODELS[4], MODELS[10]
_FIRST_PENALTY = 5  # from where on the mesh is the same


def homogeneous_chain(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Elastic chains of like beads, the first struck, the last against a wall of a material."""
    for run in uniform(runs, "hertz"):
        case = run.case
        if (
            case.load.kind == "impact"
            and case.boundary.bottom_material is not None
            and run.force.shape[1] > max(_CONTACTS)
        ):
            yield _study(run)
            return


def _study(run: ChainRun) -> Study:
    diameter, velocity, scales = run.case.packing.diameter, run.case.load.velocity, ChainScales(run)
    (early, _), (late, force) = (first_peak(run.time, run.force[:, k]) for k in _CONTACTS)
    found = _Found(
        force, (_CONTACTS[1] - _CONTACTS[0]) * diameter / (late - early),
        IMPULSE_COEFFICIENT * scales.impulse_force(run.mass * velocity), scales,
    )  # fmt: skip
    pictures = [Picture("homogeneous_forces", "Force at contacts 5 and 10 (source Fig. 3)", _histories(run))]
    if _is_source(run):
        rows = _rows_of_source(found)
        pictures.append(
            Picture("homogeneous_errors", "Errors of the source's finite elements and ours", _errors(found))
        )
    else:
        rows = [
            Row("Peak force at contact 10", "N", None, found.force, "thesis 4.5", "", found.expected),
            Row("Speed over 5 diameters", "m/s", None, found.speed, "discrete chain", "", found.wave(found.force)),
        ]
    return Study(
        "homogeneous-chain",
        "Homogeneous chain of the composite-chain source",
        f"{run.velocity.shape[1]} elastic spheres of {1e3 * diameter:.3g} mm, the first with {velocity:g} m/s. Speed: "
        "5 diameters over the time between the peaks at contacts 5 and 10; force: the peak at contact 10.",
        tuple(rows),
        tuple(pictures),
    )


@dataclasses.dataclass(frozen=True)
class _Found:
    """Force (N) and speed (m/s) of the wave; the force that is expected of the impact."""

    force: float
    speed: float
    expected: float
    scales: ChainScales

    def wave(self, force: float) -> float:
        """Speed of the discrete chain's wave of this force, m/s."""
        return discrete_speed() * self.scales.nesterenko(force)

    def errors(self, force: float, speed: float) -> tuple[float, float]:
        """Of a force against the expected one, of a speed against that of the wave of this force; magnitudes."""
        return abs(force / self.expected - 1), abs(speed / self.wave(force) - 1)


def _is_source(run: ChainRun) -> bool:
    ours, theirs = run.case.material, material("stainless-steel")
    same = all(getattr(ours, key) == getattr(theirs, key) for key in ("youngs_modulus", "poisson_ratio", "density"))
    values = ((run.case.packing.diameter, _DIAMETER), (run.case.load.velocity, _VELOCITY))
    return same and all(abs(a / b - 1) < _SAME for a, b in values)


def _rows_of_source(found: _Found) -> list[Row]:
    errors = 100 * np.array([found.errors(model.force, model.speed) for model in MODELS])
    own_force, own_speed = (100 * error for error in found.errors(found.force, found.speed))
    nesterenko = found.scales.nesterenko
    theirs = 100 * abs(_CHOSEN.speed / nesterenko(_CHOSEN.force) - 1)
    slow = "Theirs is below the wave of the discrete chain at their own force."
    rows = [
        Row(f"Peak force; source: {model.name}", "N", model.force, found.force, _WHERE, remark, found.expected)
        for model, remark in (
            (MODELS[0], "The coarsest mesh is too coarse for the contact."),
            (_FINEST, ""),
            (_CHOSEN, ""),
        )
    ]
    rows += [
        Row(f"Wave speed; source: {model.name}", "m/s", model.speed, found.speed, _WHERE, slow, found.wave(found.force))
        for model in (_FINEST, _CHOSEN)
    ]
    return [
        *rows,
        Row(
            "Error of the speed against Nesterenko's formula at the force found, best model",
            "%", _CHOSEN.error, 100 * abs(found.speed / nesterenko(found.force) - 1), _WHERE,
            f"Theirs as printed; from its force and speed it is {theirs:.2f}. Ours is the formula's own: it takes the "
            "chain for a continuum, and the discrete wave is faster.",
            100 * (discrete_speed() - 1),
        ),
        Row(
            "Error of the speed against the discrete chain's wave at the force found", "%", None, own_speed, _WHERE,
            f"The source's 11 models: {errors[:, 1].min():.1f} to {errors[:, 1].max():.0f} %.", 0.0,
        ),
        Row(
            "Error of the force against thesis 4.5", "%", None, own_force, _WHERE,
            f"The source's 11 models: {errors[:, 0].min():.1f} to {errors[:, 0].max():.0f} %.", 0.0,
        ),
        Row(
            "Exponent of force against approach", "", 1.554, _EXPONENT, "composite chain, Fig. 5",
            "Theirs is fitted to finite elements; ours is the law's.", 1.5,
        ),
    ]  # fmt: skip


def _histories(run: ChainRun) -> Drawing:
    figure = new_figure(2.3)
    axes = figure.subplots()
    columns: dict[str, NDArray[np.float64]] = {"time_s": run.time}
    for k, colour in zip(_CONTACTS, (BLUE, ORANGE), strict=True):
        axes.plot(1e6 * run.time, run.force[:, k], color=colour, label=f"beads {k + 1} and {k + 2}")
        columns[f"contact_{k + 1}_N"] = run.force[:, k]
    axes.set_xlim(0, 1e6 * float(run.time[-1]))
    axes.set_ylim(0, 1.4 * float(run.force[:, list(_CONTACTS)].max()))
    axes.set_xlabel("Time (µs)")
    axes.set_ylabel("Contact force (N)")
    axes.legend(loc="upper right")
    return Drawing(figure, columns)


def _errors(found: _Found) -> Drawing:
    """Error of the force against that of the speed, each against its theory."""
    values = [(model.force, model.speed) for model in MODELS] + [(found.force, found.speed)]
    errors = 100 * np.array([found.errors(*pair) for pair in values])
    figure = new_figure(2.7)
    axes = figure.subplots()
    for part, mark, size, colour, label in (
        (slice(0, _FIRST_PENALTY), "s-", 4, ORANGE, "source, mesh made finer"),
        (slice(_FIRST_PENALTY, -1), "^", 4, GREY, "source, penalty and solver"),
        (slice(-1, None), "o", 6, BLUE, "ours"),
    ):
        axes.plot(*errors[part].T, mark, color=colour, markersize=size, linewidth=0.7, label=label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("Error of the peak force (%)")
    axes.set_ylabel("Error of the wave speed (%)")
    axes.legend(loc="upper left", fontsize=7)
    names = [*(model.name for model in MODELS), "ours"]
    return Drawing(figure, {"model": names, "force_error_percent": errors[:, 0], "speed_error_percent": errors[:, 1]})
