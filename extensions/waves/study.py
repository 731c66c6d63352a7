"""Bands of precompressed rows and packings compared with the space-time transforms of their runs.

A weak impact on the first bead or layer contains all frequencies. The velocities along the chain,
or of the layers, are transformed in space and time, and the ridges of the transform are compared
with the bands of the same static state.

For a packing with scattered diameters, a part with periodic boundaries in all directions gives the
frequencies of the response to a plane wave along z. Each mode at a wave vector k contains a
fraction of the plane wave, in which the spheres move along z by exp(i k z). The line in a transform
of the motion is at the mode with the largest fraction; the weighted mean of this mode and the modes
near it is used.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Sequence
from functools import cache, cached_property
from typing import Any

import numpy as np

from granwave.analysis.measures.hertz_lattices import line_of
from granwave.analysis.measures.line_waves import SpaceTime, speed_along_layers
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.extensions.waves.dispersion import (
    STRONGEST,
    has_bands,
    structure_along,
    transform_along,
    transform_drawing,
)
from granwave.extensions.waves.spectra.band_structure import BandStructure, long_wave_speeds
from granwave.extensions.waves.spectra.states import cell_state
from granwave.extensions.waves.spectra.stiffness import Stiffness, stiffness_of
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.load_case import assembly_from_dict, stored_case
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing_kind import PackingKind

TITLE = "Bands of precompressed packings compared with transforms of runs"
TEXT = (
    "Bands from the springs of the static state (dynamical matrix) are compared with closed "
    "forms, and with the positions of the ridges in the space-time transform of the velocities of "
    "each run. Wave numbers and speeds refer to positions before the load."
)
NEEDS = "chains or lattices under a static load, with a weak impact along the load"
_SHARES = (0.3, 0.5, 0.7)  # fractions of the zone at which ridges are read
_SMALL = 0.1  # amplitude over omega alpha0 up to which contacts stay linear
_LAYERS = 12  # layers of a repeated piece: a multiple of 2 and of 3
_WIDTH = 0.05  # relative width in frequency: modes around the largest fraction
_SCATTER = 1e-6  # m
_SEED = 1


class SmallWaveRun(FinishedRun):
    """A run of a weak impact on a periodic packing, observed along its line."""

    @cached_property
    def structure(self) -> BandStructure:
        """Bands along the line; with scattered diameters the bands of identical spheres."""
        packing = without_scatter(self.case) if self.scattered else self.assembly
        return structure_along(self.case, packing)

    @property
    def rule(self) -> PackingKind:
        """Properties of the kind of packing."""
        return self.case.packing.rule

    @property
    def scattered(self) -> bool:
        """True if the diameters are scattered."""
        return self.case.packing.diameter_scatter > 0

    @cached_property
    def transform(self) -> SpaceTime:
        """Transform of its velocities, over the Brillouin zone of its line."""
        with Result(self.directory) as result:
            return transform_along(result, self.structure)

    @property
    def label_of_kind(self) -> str:
        """Name of the packing and of its load."""
        stage = self.case.precompression
        kind = self.rule.label
        assert stage is not None
        load = f"{stage.force:g} N" if stage.force is not None else f"{stage.pressure:.3g} Pa"
        other = " of two materials" if self.case.replace else ""
        if self.scattered:
            other += f" of diameters scattered by {1e6 * self.case.packing.diameter_scatter:g} um"
        return f"{kind}{other}, {load}"

    def band_at(self, k: float, frequency: float) -> float:
        """Frequency of the band along the line that is nearest, Hz; for scattered diameters, the
        frequency of the plane wave.
        """
        if self.scattered:
            return scattered_line(self.case, k)
        bands = self.structure.bands
        known = [
            np.interp(k, bands.path.distance, one)
            for one in bands.frequency.T
            if np.isfinite(one).all()
        ]
        return float(min(known, key=lambda one: abs(one - frequency)))


def select(runs: Sequence[FinishedRun]) -> list[list[SmallWaveRun]]:
    """Chains of one or two kinds of beads and lattices under a static load, with a weak impact
    along the load.

    Lattices with layers have periodic sides, and may have scattered diameters; lattices of one
    layer have free sides.
    """
    found = [run.seen_as(SmallWaveRun) for run in runs if _fits(run)]
    return [found] if found else []


def _fits(run: FinishedRun) -> bool:
    if not run.case.load.gives_velocity or not has_bands(run.case, run.assembly):
        return False
    try:
        return run.seen_as(SmallWaveRun).structure is not None
    except GranwaveError:
        return False


def rows(runs: Sequence[SmallWaveRun]) -> Iterator[Row]:
    """Edges against closed forms, speeds, and ridges against bands."""
    for run in runs:
        yield from _closed_forms(run)
        structure = run.structure
        if len(structure.speeds) and run.rule.is_close_packed and not run.scattered:
            quantity = f"Speed of long waves along the stacking, {run.label_of_kind}"
            yield Row(
                quantity,
                "m/s",
                None,
                _speed(run),
                "dynamical matrix",
                "",
                float(structure.speeds[-1]),
            )
        ridge = run.transform.ridge(STRONGEST)
        for share in _SHARES:
            at = int(np.argmin(np.abs(run.transform.k - share * run.transform.k[-1])))
            if np.isfinite(ridge[at]):
                theirs = run.band_at(float(run.transform.k[at]), float(ridge[at]))
                quantity = f"Ridge of the transform at {share:g} of the zone, {run.label_of_kind}"
                yield Row(quantity, "Hz", None, float(ridge[at]), "dynamical matrix", "", theirs)

    lattice = next((run.case for run in runs if run.rule is KINDS["fcc"]), None)
    if lattice is not None:
        yield from rows_of_square(lattice)
        yield from rows_of_scatter(lattice)


def _closed_forms(run: SmallWaveRun) -> Iterator[Row]:
    """Return the band edges of chains with one and with two masses."""
    network = run.structure.state.network
    edges = run.structure.edges
    if not run.rule.is_chain or network.n_grains > 2:
        return
    stiffness = float(network.springs.stiffness[0])
    mass = network.mass
    if network.n_grains == 1:
        known = {"Cut-off, 2 sqrt(k/m)": (edges[0, 1], 2 * math.sqrt(stiffness / mass[0]))}
    elif np.ptp(network.springs.stiffness) < 1e-9 * stiffness:
        known = {
            "Top of the acoustic band, sqrt(2 k/M)": (
                edges[0, 1],
                math.sqrt(2 * stiffness / mass.max()),
            ),
            "Bottom of the optical band, sqrt(2 k/m)": (
                edges[1, 0],
                math.sqrt(2 * stiffness / mass.min()),
            ),
            "Top of the optical band, sqrt(2 k (1/m + 1/M))": (
                edges[1, 1],
                math.sqrt(2 * stiffness * (1 / mass).sum()),
            ),
        }
    else:
        return
    for name, (ours, theory) in known.items():
        yield Row(
            f"{name}, {run.label_of_kind}",
            "Hz",
            None,
            float(ours),
            "",
            "",
            theory / (2 * math.pi),
            True,
        )


def _speed(run: SmallWaveRun) -> float:
    """Speed of long waves by the crests of the layers, m/s."""
    with Result(run.directory) as result:
        return speed_along_layers(result, line_of(run.case, sphere_contact(run.case)))


def pictures(runs: Sequence[SmallWaveRun]) -> Iterator[Picture]:
    """Transforms and the bands on them, a panel for each run."""
    for number, run in enumerate(runs, start=1):
        drawing = transform_drawing(run.transform, run.structure, run.label_of_kind)
        name = f"_transform_{number}"
        caption = (
            "Space-time transform of the layers' motion, dark where a wave has that frequency and wave number, and "
            f"computed bands (dashed), {run.label_of_kind}. Dark ridges on dashed lines confirm the bands"
        )
        yield Picture(name, caption, drawing)


def without_scatter(case: Case) -> Assembly:
    """Return the case with identical spheres."""
    return _changed(case, {"diameter_scatter": 0.0}, {})


def scattered_line(case: Case, k: float) -> float:
    """Return the frequency, Hz, of the plane longitudinal wave with the wave number k, rad/m, along
    z.
    """
    stiffness = _piece(case.to_toml())
    network = stiffness.network
    values, vectors = np.linalg.eigh(stiffness.dense(np.array([[0.0, 0.0, k]]))[0])
    grain, direction = network.freedoms
    # the phase between cells follows from their periods; within a cell, from the positions
    wave = np.where(
        direction == 2, np.sqrt(network.masses) * np.exp(1j * k * network.position[grain, 2]), 0.0
    )
    share: Array = np.abs(wave.conj() @ vectors) ** 2
    frequency = np.sqrt(np.maximum(values, 0.0)) / (2 * math.pi)
    near = np.abs(frequency / frequency[int(np.argmax(share))] - 1) < _WIDTH
    return float(np.average(frequency[near], weights=share[near]))


@cache
def _piece(case: str) -> Stiffness:
    whole = stored_case(tomllib.loads(case), "case")
    nx, ny, _ = whole.packing.size
    return stiffness_of(
        cell_state(
            _changed(
                whole, {"size": [nx, ny, _LAYERS]}, {"sides": "periodic", "bottom": "periodic"}
            )
        ).network
    )


def _changed(case: Case, packing: dict[str, object], boundary: dict[str, object]) -> Assembly:
    data = case.to_dict()
    keep = {
        name: data[name]
        for name in ("name", "material", "contact", "precompression")
        if name in data
    }
    return assembly_from_dict(
        keep
        | {"packing": data["packing"] | packing, "boundary": data.get("boundary", {}) | boundary}
    )


def rows_of_square(like: Case) -> Iterator[Row]:
    """Edges at X of a square packing of such spheres with friction under pressure: equal to closed
    forms up to rounding.
    """
    packing = _packing(
        like, {"kind": "square", "size": [4, 4]}, 1e5, {"bottom": "free"}, friction=0.3
    )
    network = cell_state(packing).network
    springs = network.springs
    mass = float(network.mass[0])
    inertia = float(network.inertia[0])
    k, kt, f, d = (
        float(one[0])
        for one in (springs.stiffness, springs.tangential, springs.force, springs.distance)
    )
    lever = float(springs.lever[0, 0])
    at_edge = np.array([[math.pi / like.packing.diameter, 0.0, 0.0]])
    ours = np.sqrt(np.sort(np.linalg.eigvalsh(stiffness_of(network).dense(at_edge)[0]))) / (
        2 * math.pi
    )
    known = {
        "longitudinal, 4 k/m": 4 * k / mass,
        "transverse, 4 (k_t - F/d)/m": 4 * (kt - f / d) / mass,
        "rotational, 4 k_t l^2/I": 4 * kt * lever**2 / inertia,
    }
    order = np.argsort(list(known.values()))
    for place, number in enumerate(order.tolist()):
        name, square = list(known.items())[number]
        theory = math.sqrt(square) / (2 * math.pi)
        quantity = f"Square with friction, 1e+05 Pa, omega^2 at the edge of the zone: {name}"
        yield Row(quantity, "Hz", None, float(ours[place]), "", "", theory, True)


def rows_of_scatter(like: Case) -> Iterator[Row]:
    """Speeds of long waves along [111] in a cell of FCC with scattered diameters, compared
    with identical spheres.
    """
    boundary = {"sides": "periodic", "bottom": "periodic"}
    direction = np.array([[0.0, 0.0, 1.0]])
    speeds = []
    for scatter in ({}, {"diameter_scatter": _SCATTER, "seed": _SEED}):
        packing = _packing(like, {"kind": "fcc", "size": [6, 6, 6], **scatter}, 1e6, boundary)
        speeds.append(long_wave_speeds(stiffness_of(cell_state(packing).network), direction)[0])
    for name, place in (("transverse", 0), ("longitudinal", -1)):
        yield Row(
            f"Speed of {name} waves along [111] of FCC, 1e+06 Pa from all sides, scatter of 1 um", "m/s", None,
            float(speeds[1][place]), "identical spheres", "", float(speeds[0][place]),
        )  # fmt: skip


def _packing(
    like: Case,
    packing: dict[str, Any],
    pressure: float,
    boundary: dict[str, Any],
    friction: float = 0.0,
) -> Assembly:
    """Replace the spheres of a packing by the spheres of another, under isotropic pressure."""
    material = like.to_dict()["material"]
    return assembly_from_dict(
        {
            "name": packing["kind"],
            "material": material,
            "packing": {"diameter": like.packing.diameter, **packing},
            "contact": {"law": "hertz", "friction": friction},
            "precompression": {"kind": "uniform", "pressure": pressure},
            "boundary": boundary,
        }
    )
