"""Fields of the spheres on the page of a run, with their logarithmic scales and colour bars.

A page holds millions of values. They are stored as levels of a scale of `LEVELS` colours, with 0
for values below the scale: such levels repeat, so that they compress to a twentieth.
"""

from __future__ import annotations

import base64
import html
import io
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, to_rgb
from numpy.typing import NDArray

from granwave.analysis.figures.colouring import DISSIPATION_LIMITS, decades_up_to, force_scale
from granwave.analysis.figures.style import DISSIPATION_MAP, FORCE_MAP, new_figure, style
from granwave.analysis.result.reader import Result
from granwave.extensions.pictures.view.instants import Instants

BLANK = "#a4a4a4"  # spheres below the scale; the lights of the page make it paler
LEVELS = 100  # colours of a scale; steps of a twentieth of a decade, or finer
_ENLARGED = 1.3  # size of a colour bar on the page / size of a printed one
_DECADES = 4  # decades of a scale of forces, far below F_y, to include the elastic wave
_DOTS = 2  # pixels of a colour bar over those on the screen


@dataclass(frozen=True, eq=False)
class Field:
    """A field with its colour scale.

    Attributes
    ----------
    name
        Its name in the panel.
    label
        Label of the colour bar, with the unit.
    map
        Name of the colour map.
    low, high
        Ends of the logarithmic scale, in the unit of the label.
    above
        True if there are values above the scale.
    levels
        Level over `LEVELS` of each sphere at each snapshot, 0 below the scale: (n_frames,
        n_spheres).
    """

    name: str
    label: str
    map: str
    low: float
    high: float
    above: bool
    levels: NDArray[np.float32]

    @property
    def colours(self) -> NDArray[np.float32]:
        """Colour map of k3d: rows of level divided by `LEVELS`, red, green and blue; grey below the
        scale.
        """
        level = np.arange(1, LEVELS + 1) / LEVELS
        scale = colormaps[self.map]((np.arange(LEVELS) + 0.5) / LEVELS)[:, :3]
        edge = 0.5 / LEVELS
        blank = np.array([[0.0, *to_rgb(BLANK)], [edge, *to_rgb(BLANK)], [1.001 * edge, *scale[0]]])
        return np.concatenate([blank, np.column_stack([level, scale])]).astype(np.float32)


def fields(result: Result, instants: Instants, rows: NDArray[np.int64] | slice) -> list[Field]:
    """Return the fields of a run that are not zero everywhere.

    Parameters
    ----------
    instants
        Instants that are shown.
    rows
        Rows of the spheres.
    """
    options = result.figure_options
    forces = options.colour_map or FORCE_MAP
    losses = options.colour_map or DISSIPATION_MAP
    given = result.energy_input
    scale = force_scale(result)[0]
    in_newtons = (
        None if options.force_limits is None else tuple(scale * end for end in options.force_limits)
    )
    in_joules = None
    if given:
        fractions = options.dissipation_limits or DISSIPATION_LIMITS
        in_joules = tuple(given * end for end in fractions)
    wanted: list[tuple[str, str, str, str, tuple[float, ...] | None]] = [
        (
            "contact force",
            "Contact force, largest of the sphere, excluding walls (N)",
            "contact_force",
            forces,
            in_newtons,
        ),
        ("speed", "Speed (m/s)", "velocity", forces, None),
        (
            "peak force",
            "Peak force so far, excluding walls (N)",
            "peak_force",
            forces,
            in_newtons,
        ),
        (
            "dissipated energy",
            "Dissipated energy so far (J)",
            "dissipated_energy",
            losses,
            in_joules,
        ),
        ("elastic energy", "Elastic energy (J)", "elastic_energy", losses, None),
    ]
    found = []
    for name, label, quantity, colours, limits in wanted:
        if quantity not in instants.quantities:
            continue
        frame_values = (instants.values(number, quantity) for number in range(len(instants.times)))
        values = np.stack(
            [(np.linalg.norm(one, axis=1) if one.ndim == 2 else one)[rows] for one in frame_values]
        )
        largest = float(np.max(values, initial=0.0))
        if not largest > 0:
            continue
        high = decades_up_to(largest, None)[1]
        low, high = limits or (high / 10**_DECADES, high)
        with np.errstate(divide="ignore"):
            share = np.log(values / low) / np.log(high / low)
        levels = np.clip(np.floor(share * LEVELS) + 1, 0, LEVELS) / LEVELS
        found.append(
            Field(name, label, colours, low, high, largest > high, levels.astype(np.float32))
        )
    return found


def colour_bar(field: Field) -> str:
    """Draw the colour bar of a field; return it as HTML."""
    with style():
        figure = new_figure(0.62, 3.2)
        axes = figure.subplots()
        colours = colormaps[field.map].with_extremes(under=BLANK)
        mappable = ScalarMappable(LogNorm(field.low, field.high), colours)
        figure.colorbar(
            mappable,
            cax=axes,
            orientation="horizontal",
            label=field.label,
            extend="both" if field.above else "min",
        )
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=96 * _DOTS, transparent=True)
    encoded = base64.b64encode(stream.getvalue()).decode("ascii")
    width = round(96 * figure.get_figwidth() * _ENLARGED)
    label = html.escape(field.label)
    return f'<img alt="{label}" width="{width}" src="data:image/png;base64,{encoded}">'
