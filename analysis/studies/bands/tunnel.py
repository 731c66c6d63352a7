"""The tunable gap of thesis 7.2: a row under an axial force whose middle runs between cylinders and walls.

Its edges are those of the spring network of an endless tunnel, see `tunnel_model`; the row without cylinders is a run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.series import COLOURS, panels
from granwave.analysis.figures.style import Drawing, legend_above
from granwave.analysis.spectra.band_structure import band_structure
from granwave.analysis.studies.bands.tunnel_model import Tunnel
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.material import Material, material

TITLE = "A gap tuned by walls: spheres between cylinders (thesis 7.2)"
TEXT = (
    "Endless row of brass spheres of 9.525 mm under 1 N with a pair of brass cylinders of 4.76 mm in each gap, between "
    "two rigid walls that approach by a times the diameter; cylinders as long as the spheres are wide. The bands are "
    "those of the springs of its static state. Angular frequencies: the source's axes say Hz, but hold rad/s."
)
_WHERE = "thesis 7.2"
_APPROACHES = (-1.8e-5, 0.0, 3e-5)
_RATIOS = (0.3, 0.5, 0.65)
_SPHERE, _TIME = 75, 5e-3  # where and how long the source listens, s
_PRINTED = 5.6e3  # Hz, the source's cut-off of the row
_TOP_OF_AXIS, _THIRD = 7e4, 3e5  # rad/s: of Fig. 7.7a, and the source's third band
_GAPS = {"brass, brass": 9e4, "steel, aluminium": 14e4, "aluminium, steel": 11e4}  # spheres, cylinders: top of Fig. 7.8
_BOTTOM = 2e4  # rad/s: of Fig. 7.8
_DENSITY_AND_MODULUS = {"brass": (8500.0, 115e9), "steel": (7800.0, 210e9), "aluminium": (2700.0, 70e9)}


def select(runs: Sequence[FinishedRun]) -> list[list[FinishedRun]]:
    """The precompressed rows of like spheres of that size."""
    found = [run for run in runs if _is_row(run)]
    return [found] if found else []


def _is_row(run: FinishedRun) -> bool:
    case = run.case
    of_source = case.packing.kind == "chain" and abs(case.packing.diameter - 9.525e-3) < 1e-9
    return of_source and case.precompression is not None and case.precompression.force == 1.0 and not case.replace


def _material(name: str) -> Material:
    density, modulus = _DENSITY_AND_MODULUS[name]
    return Material(name=name, youngs_modulus=modulus, poisson_ratio=0.3, density=density, yield_strength=None)


def brass_tunnel(approach: float, ratio: float = 4.76 / 9.525) -> Tunnel:
    """The source's tunnel at an approach of the walls, over the diameter."""
    brass = material("brass")
    return Tunnel(brass, brass, ratio=ratio, approach=approach)


def rows(runs: Sequence[FinishedRun]) -> Iterator[Row]:
    """Cut-off of the row, edges of the tunnel, and what became of the source's 5.6 kHz."""
    plain = brass_tunnel(0.0)
    top = band_structure(runs[0].case).edges[0, 1]
    cut_off = 2 * plain.row_frequency
    yield Row("Cut-off of the row", "Hz", None, float(top), "2 sqrt(K/m)", "", cut_off / (2 * math.pi), True)
    yield Row(
        "Cut-off of the row", "Hz", _PRINTED, float(top), _WHERE,
        "Why they differ is not certain. One reading: 5.6e4 rad/s, what a run of 5 ms shows at sphere 75 (next row).",
    )  # fmt: skip
    slowest = (_SPHERE - 1) / _TIME / plain.row_frequency  # group velocity in spheres/s over sqrt(K/m)
    heard = 2 * plain.row_frequency * math.sqrt(1 - slowest**2)
    yield Row(
        "Highest frequency whose waves reach sphere 75 within 5 ms", "rad/s", None, heard, _WHERE,
        "Group velocity sqrt(K/m) sqrt(1 - (w/2)^2 m/K) spheres a second. Near the digits of the source's 5.6 kHz.",
    )  # fmt: skip
    for approach in _APPROACHES:
        edges = brass_tunnel(approach).edges
        for name, value in (
            ("Top of the acoustic band", edges[0, 1]), ("Bottom of the optical band", edges[1, 0]),
            ("Top of the optical band", edges[1, 1]), ("Top of the third band", edges[2, 1]),
        ):  # fmt: skip
            source, remark = None, ""
            if name == "Top of the third band" and approach == 0:
                source, remark = _THIRD, "The source: in the range of 0.3 MHz, which is 0.3e6 rad/s, 58 kHz."
            elif name == "Top of the optical band" and approach <= 0:
                source, remark = _TOP_OF_AXIS, "The source: at most, by the axis of Fig. 7.7a."
            bound = source == _TOP_OF_AXIS
            yield Row(f"{name}, a = {approach:g}", "rad/s", source, float(value), _WHERE, remark, bound=bound)
    yield from _gaps()
    for ratio in _RATIOS:
        low, high = (brass_tunnel(a, ratio).edges for a in (-2e-5, 3e-5))
        quantity = f"Shift of the acoustic top from a = -2e-5 to 3e-5, cylinders of {ratio:g} diameters"
        yield Row(quantity, "rad/s", None, float(high[0, 1] - low[0, 1]), _WHERE, digits=3)


def _gaps() -> Iterator[Row]:
    """Edges of the gap of three pairs of materials beside the axes of Fig. 7.8, and the gap's width and its shift."""
    for name, top in _GAPS.items():
        sphere, cylinder = map(_material, name.split(", "))
        edges = np.array([[Tunnel(sphere, cylinder, ratio=ratio, approach=a).edges for a in (-2e-5, 0.0, 3e-5)]
                          for ratio in _RATIOS])  # fmt: skip
        low, high = edges[..., 0, 1], edges[..., 1, 0]
        remark = "By the end of the axis."
        for word, source, ours in (("Lowest", _BOTTOM, low.min()), ("Highest", top, high.max())):
            quantity = (
                f"{word} edge of the gap, at {'least' if word == 'Lowest' else 'most'}: spheres of {name} cylinders"
            )
            yield Row(quantity, "rad/s", source, float(ours), "thesis Fig. 7.8", remark, digits=3, bound=True)
        middle, still = _RATIOS.index(0.5), 1
        width = 2 * (high - low) / (high + low)
        said = {"steel, aluminium": "small", "aluminium, steel": "large"}.get(name)
        quantity = f"Width of the gap over its middle, cylinders of 0.5 D, a = 0: spheres of {name} cylinders"
        remark = f"The source: {said}." if said else ""
        yield Row(quantity, "", None, float(width[middle, still]), "thesis Fig. 7.8", remark, digits=3)


def verdict(runs: Sequence[FinishedRun]) -> list[str]:
    """Effect of the walls."""
    low, high = (brass_tunnel(a).edges for a in (_APPROACHES[0], _APPROACHES[-1]))
    way = 1e6 * (_APPROACHES[-1] - _APPROACHES[0]) * brass_tunnel(0.0).diameter
    return [
        f"Walls that approach by {way:.2g} µm move the gap of the tunnel "
        f"from {low[0, 1] / 2e3 / math.pi:.3g}-{low[1, 0] / 2e3 / math.pi:.3g} kHz to "
        f"{high[0, 1] / 2e3 / math.pi:.3g}-{high[1, 0] / 2e3 / math.pi:.3g} kHz."
    ]


def pictures(runs: Sequence[FinishedRun]) -> Iterator[Picture]:
    """Bands at three places of the walls (figure 7.7), and edges against the place (figure 7.8)."""
    figure, axes = panels(2.6)
    columns: dict[str, np.ndarray] = {}
    for approach, colour in zip(_APPROACHES, COLOURS, strict=False):
        tunnel = brass_tunnel(approach)
        phase = tunnel.bands.path.k[:, 2] * tunnel.diameter
        for n in range(2):
            label = f"a = {approach:g}" if not n else None
            axes.plot(phase / np.pi, 1e-3 * tunnel.bands.frequency[:, n], color=colour, label=label)
            columns[f"f{n + 1}_at_{approach:g}_Hz"] = tunnel.bands.frequency[:, n]
        columns.setdefault("phase_rad", phase)
    axes.set(xlabel="Phase per cell (π)", ylabel="Frequency (kHz)", xlim=(0, 1), ylim=(0, None))
    legend_above(axes, 3)
    yield Picture("_bands", "The two lowest bands at three places of the walls", Drawing(figure, columns))
    figure, axes = panels(2.6)
    places = np.linspace(-2e-5, 3e-5, 21)
    columns = {"approach": places}
    for ratio, colour in zip(_RATIOS, COLOURS, strict=False):
        edges = np.array([brass_tunnel(a, ratio).edges for a in places]) / (2 * np.pi)
        axes.fill_between(1e5 * places, 1e-3 * edges[:, 0, 1], 1e-3 * edges[:, 1, 0], color=colour, alpha=0.35, lw=0,
                          label=f"cylinders {ratio:g} D")  # fmt: skip
        columns |= {f"top_{ratio:g}_Hz": edges[:, 0, 1], f"bottom_{ratio:g}_Hz": edges[:, 1, 0]}
    axes.set(xlabel="Approach of the walls (1e-5 diameters)", ylabel="Gap (kHz)", xlim=(-2, 3))
    legend_above(axes, 3, fontsize=7)
    yield Picture("_gaps", "The lowest gap against the place of the walls", Drawing(figure, columns))
