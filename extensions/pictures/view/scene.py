"""Objects of the page of a run, made with k3d: spheres with their fields, walls, bars, colour bars,
clock and title.

Lengths are in mm from the impacted sphere, and times in µs, as in figures. Fields are values of the
spheres at every instant, as levels of a logarithmic scale.

Instants are the snapshots of a run, or the more frequent records of a complete chain. A
page holds millions of values. They are stored as levels of a scale of `LEVELS` colours, with 0 for
values below the scale: such levels repeat, so that they compress to a twentieth.
"""

from __future__ import annotations

import base64
import html
import io
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, to_rgb
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from granwave.analysis.figures.colouring import DISSIPATION_LIMITS, decades_up_to, force_scale
from granwave.analysis.figures.style import DISSIPATION_MAP, FORCE_MAP, new_figure, style
from granwave.analysis.measures.geometry import own_plane, planes
from granwave.analysis.result.reader import Result
from granwave.extensions.pictures.packing3d import AZIMUTH, ELEVATION, plane_lines, tube_lines
from granwave.extensions.pictures.sphere_renderer import Camera
from granwave.lammps_inputs.case.material import Cylinder
from granwave.lammps_inputs.packing.cylinders import in_grains
from granwave.lammps_inputs.packing.walls import walls

if TYPE_CHECKING:
    import k3d

# iterations for the corner of the grid, because a longer extent may have a longer step
_ROUNDINGS = 3
_MOST_OF_A_CHAIN = 120  # most instants of up to a thousand
BLANK = "#a4a4a4"  # spheres below the scale; the lights of the page make it paler
LEVELS = 100  # colours of a scale; steps of a twentieth of a decade, or finer
_DECADES = 4  # decades of a scale of forces, far below F_y, to include the elastic wave


@dataclass(frozen=True, eq=False)
class Instants:
    """Values of the spheres at rising times.

    Attributes
    ----------
    times
        Times, s: (n_instants,).
    quantities
        Names that `values` knows, as of a snapshot.
    values
        Function of the number of an instant and a quantity: (n_spheres,) or (n_spheres, 3), SI
        units.
    """

    times: NDArray[np.float64]
    quantities: tuple[str, ...]
    values: Callable[[int, str], NDArray[np.float64]]

    def at(self, numbers: Sequence[int]) -> Instants:
        """Return the instants with these numbers."""
        return Instants(
            self.times[list(numbers)],
            self.quantities,
            lambda n, name: self.values(numbers[n], name),
        )


def instants_of(result: Result) -> Instants:
    """Return the instants of a run: its snapshots, with 0 for missing records, or the record of a
    chain.
    """
    if "chain" in result and len(result["chain/time"]) > result.n_frames:
        return _of_chain(result)
    return Instants(
        result.frame_times,
        result.quantities,
        lambda number, name: np.nan_to_num(result.frame(number, name)),
    )


def _of_chain(result: Result) -> Instants:
    """Return velocity and displacement, which point along the chain, and the largest force of each
    bead's contacts.
    """
    time = result["chain/time"]
    n = result.n_spheres
    rows = np.unique(
        np.linspace(0, len(time) - 1, min(_MOST_OF_A_CHAIN, len(time))).round().astype(int)
    )
    beads = result.rows(result["chain/id"])
    force = np.zeros((len(time), n))
    row = dict(zip(result["chain/id"].tolist(), beads.tolist(), strict=True))
    for end in ("chain/contact_i", "chain/contact_j"):
        for contact, sphere in enumerate(result[end].tolist()):
            if sphere in row:  # else the face of a bar
                np.maximum(
                    force[:, row[sphere]],
                    result["chain/contact_force"][:, contact],
                    out=force[:, row[sphere]],
                )
    scalars = {"contact_force": force, "peak_force": np.maximum.accumulate(force, axis=0)}
    along = {name: result[f"chain/{name}"] for name in ("velocity", "displacement")}

    def values(number: int, quantity: str) -> NDArray[np.float64]:
        if quantity in scalars:
            return np.asarray(scalars[quantity][rows[number]])
        found = np.zeros((n, 3))
        found[beads, 2] = along[quantity][rows[number]]
        return found

    return Instants(time[rows], (*along, *scalars), values)


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


_MILLI = 1e3
_MICRO = 1e6
_MOVES = 0.05  # diameters: spheres with smaller displacements are drawn at rest
_STOP = 0.3  # diameters: spheres of the plane of a section stay
_PHONE_WIDTH = 600  # pixels below which the panel is closed at first
_FIELD_OF_VIEW = 40.0  # degrees
_SECONDS = 8.0  # duration of the animation, s
_DOTS = 2  # pixels of a colour bar over those on the screen
_SIDES = 32  # sides of a cylinder
_MOST_DEPTHS = 6  # intervals of the numbers along a chain
_BAR_COLOUR = 0x8C9AA8
_WALL_COLOUR = 0x9AA5B1
_INK = 0x222222


def plot_of(
    result: Result, instants: Instants, rows: NDArray[np.int64], found: Sequence[Field], note: str
) -> k3d.Plot:
    """Return the plot of a run.

    Parameters
    ----------
    instants
        Instants that are on the page.
    rows
        Rows of the spheres that are, rising: (n,).
    found
        Fields; the first is shown at the start.
    note
        A sentence on omitted data; empty if nothing is omitted.
    """
    import k3d  # imports the notebook widgets

    place = _MILLI * (result["spheres/position"][rows] - result.origin)
    times = (_MICRO * instants.times).tolist()
    camera = _camera(result, place)
    plot = k3d.plot(
        axes=[r"\text{x}", r"\text{y}", r"\text{depth}\qquad\quad"],
        camera_auto_fit=False,
        camera_fov=_FIELD_OF_VIEW,
        colorbar_object_id=0,
        time_interpolation=False,
        time_speed=max(times[-1] / _SECONDS, 1e-6),
        lighting=2.0,
        axes_helper=0.0,
        grid_auto_fit=False,  # otherwise numbers along the axes start at any millimetre
        grid=round_grid(place, _MILLI * result.case.packing.diameter / 2).tolist(),
        grid_visible=not result.case.packing.rule.is_chain,
        name=result.case.name,
        antialias=1,
    )
    for one in (*_spheres(result, instants, rows, found, place), *_walls(result), *_bars(result)):
        plot += one
    if result.case.packing.rule.is_chain:
        for label in _depths_of_chain(result, place):
            plot += label
    text = partial(k3d.text2d, is_html=True, label_box=False)
    for field in found:
        of_field = {
            "name": f"colour bar of {field.name}",
            "group": field.name,
            "visible": field is found[0],
        }
        plot += text(_colour_bar(field), position=[0.0, 1.0], reference_point="lb", **of_field)
    clock = {_key(time): f"{time:.1f} µs" for time in times}
    plot += text(
        clock, position=[0.5, 0.01], reference_point="ct", size=1.5, color=_INK, name="clock"
    )
    called = result.assembly.grains_called
    number = f"{len(rows):,}".replace(",", " ")
    lines = [
        f"<b>{html.escape(result.case.name)}</b>",
        f"{number} {called}, {len(times)} snapshots",
    ]
    lines += [
        html.escape(line)
        for line in (note, in_grains("lengths in mm from the impacted sphere", called))
        if line
    ]
    corner = {"position": [0.005, 0.01], "reference_point": "lt", "size": 1.0}
    plot += text("<br>".join(lines), **corner, color=_INK, name="title")
    cuts, cut = _cuts(result, place, camera)
    plot.time = times[min(max(1, len(times) // 4), len(times) - 1)]
    plot.camera = camera
    names = [field.name for field in found]
    plot.custom_data = {
        "fields": names,
        "cuts": cuts,
        "cut": cut,
        "times": times,
        "camera": camera,
        "phone_width": _PHONE_WIDTH,
    }
    return plot


def _key(time: float) -> str:
    return f"{time:.9g}"


def _spheres(
    result: Result,
    instants: Instants,
    rows: NDArray[np.int64],
    found: Sequence[Field],
    place: NDArray[np.float64],
) -> Iterator[Any]:
    """Make the grains of every field: cylinders, spheres at fixed positions, and moving spheres."""
    import k3d

    times = (_MICRO * instants.times).tolist()
    moved = [_MILLI * instants.values(number, "displacement")[rows] for number in range(len(times))]
    steps = {_key(time): one for time, one in zip(times, moved, strict=True)}
    radius = _MILLI * result["spheres/radius"][rows]
    away = np.max([np.abs(one).max(axis=1) for one in moved], axis=0) > _MOVES * 2 * radius
    grain_shapes = result.assembly.grain_shapes()
    shapes = [grain_shapes[row] for row in rows]
    is_round = np.array([one is None for one in shapes])

    def look(field: Field, rows: NDArray[np.int64], what: str, corners: int = 1) -> dict[str, Any]:
        """Return the colour and name of each grain, repeated once per point."""
        levels = {
            _key(time): np.repeat(field.levels[n, rows], corners) for n, time in enumerate(times)
        }
        scale = {"attribute": levels, "color_range": [0.0, 1.0], "color_map": field.colours.ravel()}
        return scale | {
            "name": f"{field.name}{what}",
            "group": field.name,
            "visible": field is found[0],
        }

    if len(own := np.flatnonzero(~is_round)):  # cylinders of every field, as one mesh
        outlines = np.stack([_outline(one, radius[row]) for row in own if (one := shapes[row])])
        n_corners = outlines.shape[1]
        faces = (
            (np.arange(len(own))[:, None, None] * n_corners + _faces())
            .reshape(-1, 3)
            .astype(np.uint32)
        )
        corners = {
            key: ((place + one)[own][:, None] + outlines).reshape(-1, 3).astype(np.float32)
            for key, one in steps.items()
        }
        for field in found:
            of_field = look(field, own, ", cylinders", n_corners)
            yield k3d.mesh(corners, faces, flat_shading=False, side="double", **of_field)
    for own, what in (
        (np.flatnonzero(~away & is_round), ""),
        (np.flatnonzero(away & is_round), ", moving"),
    ):
        if not len(own):
            continue
        positions: Any = place[own].astype(np.float32)
        if what:
            positions = {
                key: (place[own] + one[own]).astype(np.float32) for key, one in steps.items()
            }
        sizes = (2 * radius[own]).astype(np.float32)
        for field in found:
            yield k3d.points(positions, point_sizes=sizes, shader="3d", **look(field, own, what))


def _outline(shape: Cylinder, radius: float) -> NDArray[np.float64]:
    """Return the corners of a cylinder around its centre: rims of the side, rims and middles of the
    ends, mm.
    """
    axis = shape.vector
    one = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    one /= np.linalg.norm(one)
    angle = 2 * np.pi * np.arange(_SIDES)[:, None] / _SIDES
    rim = radius * (np.cos(angle) * one + np.sin(angle) * np.cross(axis, one))
    half = _MILLI * shape.length / 2 * axis
    return np.concatenate([rim - half, rim + half, rim - half, rim + half, [-half, half]])


def _faces() -> NDArray[np.int64]:
    """Return the triangles between the corners of `_outline`: (n, 3)."""
    n = np.arange(_SIDES)
    after = (n + 1) % _SIDES
    low = 2 * _SIDES
    high = 3 * _SIDES
    middle = 4 * _SIDES
    side = [
        np.stack([n, after, _SIDES + n], axis=1),
        np.stack([after, _SIDES + after, _SIDES + n], axis=1),
    ]
    ends = [
        np.stack([low + after, low + n, np.full(_SIDES, middle)], axis=1),
        np.stack([high + n, high + after, np.full(_SIDES, middle + 1)], axis=1),
    ]
    return np.concatenate([*side, *ends])


def _walls(result: Result) -> Iterator[Any]:
    """Make the walls around the packing: the bottom as a surface, the sides as edges."""
    import k3d

    low, high = _MILLI * (result.assembly.lattice_bounds() - result.origin)
    margin = _MILLI * result.case.packing.diameter / 2
    low = low - margin
    high = high + margin
    for wall in walls(result.assembly):
        if wall.held_layer or wall.face is not None:
            continue
        if wall.tube:
            ends = low[2] / _MILLI + result.origin[2], high[2] / _MILLI + result.origin[2]
            for number, points in enumerate(tube_lines(wall.coordinate, *ends), start=1):
                line = (_MILLI * (points - result.origin)).astype(np.float32)
                yield k3d.line(line, color=_WALL_COLOUR, width=0.1 * margin, name=f"tube {number}")
            continue
        level = _MILLI * (wall.coordinate - result.origin[wall.axis])
        edges = plane_lines(wall.axis, level, low, high).astype(np.float32)
        if wall.name == "bottom":
            faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
            yield k3d.mesh(
                edges[:4], faces, color=_WALL_COLOUR, opacity=0.35, side="double", name="bottom"
            )
        else:
            yield k3d.line(edges, color=_WALL_COLOUR, width=0.1 * margin, name=f"wall {wall.name}")


def _bars(result: Result) -> Iterator[Any]:
    """Make the bars at the ends of a chain, as cylinders with the area of the bars."""
    import k3d

    axis = _MILLI * (result["spheres/position"][0] - result.origin)
    for bar in result.assembly.bars:
        ends = np.array([axis, axis], dtype=np.float32)
        ends[:, 2] = _MILLI * (bar.position[[0, -1]] - result.origin[2])
        width = 2 * _MILLI * math.sqrt(bar.section.area / math.pi)
        yield k3d.line(
            ends,
            color=_BAR_COLOUR,
            width=width,
            shader="mesh",
            radial_segments=32,
            name=bar.name.replace("_", " "),
        )


def _colour_bar(field: Field) -> str:
    """Draw the colour bar of a field; return it as HTML."""
    with style():
        figure = new_figure(0.62, 3.2)
        axes = figure.subplots()
        mappable = ScalarMappable(LogNorm(field.low, field.high), colormaps[field.map])
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
    width = round(96 * figure.get_figwidth() * 1.15)
    return f'<img alt="{html.escape(field.label)}" width="{width}" src="data:image/png;base64,{encoded}">'


def _depths_of_chain(result: Result, place: NDArray[np.float64]) -> list[k3d.objects.Text]:
    """Return numbers below a chain, and the name of the axis above its end: the labels of k3d
    around packings that are so thin cover each other.
    """
    import k3d  # imports the notebook widgets

    text = partial(k3d.text, is_html=True, label_box=False, size=1.0, color=_INK, on_top=True)
    radius = _MILLI * result.case.packing.diameter / 2
    low = place.min(axis=0) - 2 * radius
    high = place.max(axis=0) + 2 * radius
    numbers = MaxNLocator(_MOST_DEPTHS, steps=[1, 2, 5, 10])
    depths = numbers.tick_values(float(place[:, 2].min()), float(place[:, 2].max()))
    labels = [
        text(f"{depth:g}", position=[low[0], 0.0, depth], reference_point="ct")
        for depth in depths
        if low[2] <= depth <= high[2]
    ]
    end = [high[0], 0.0, high[2] - radius]
    return [*labels, text("depth (mm)", position=end, reference_point="rb")]


def round_grid(place: NDArray[np.float64], margin: float) -> NDArray[np.float64]:
    """Return the lower and upper corner of a grid on which the numbers of k3d are round.

    k3d puts a number at every tenth of the power of ten above the largest extent, counted from the
    lower corner, or at every fifth of this step along axes of up to two steps.

    Parameters
    ----------
    place
        Centres of the spheres, mm: (n, 3).
    margin
        Distance from the outermost centres, mm.

    Returns
    -------
    ndarray
        x, y and depth of the lower corner, and of the upper corner, mm: (6,).
    """
    lowest = place.min(axis=0) - margin
    high = place.max(axis=0) + margin
    low = lowest
    for _ in range(_ROUNDINGS):
        extent = high - low
        step = 10 ** math.ceil(math.log10(extent.max())) / 10
        steps = np.where(extent > 2 * step, step, step / 5)
        low = np.floor(lowest / steps) * steps
    return np.concatenate([low, high])


def _camera(result: Result, place: NDArray[np.float64]) -> list[float]:
    """Return position, target and upward direction of the camera: a chain lies across the view, a
    layer faces the viewer.
    """
    size = np.ptp(place, axis=0)
    middle = (place.min(axis=0) + place.max(axis=0)) / 2
    if result.case.packing.rule.is_chain:
        towards = np.array([0.0, 1.0, 0.0])
        up = np.array([1.0, 0.0, 0.0])
    elif size[2] == 0:
        towards = np.array([0.0, 0.0, -1.0])
        up = np.array([0.0, -1.0, 0.0])
    else:
        up = np.array([0.0, 0.0, -1.0])
        towards = Camera.looking(AZIMUTH, ELEVATION, up).towards
    reach = float(np.linalg.norm(size)) / 2 + _MILLI * result.case.packing.diameter
    distance = reach / math.tan(math.radians(_FIELD_OF_VIEW / 2))
    return [*(middle + distance * towards).tolist(), *middle.tolist(), *up.tolist()]


def _cuts(
    result: Result, place: NDArray[np.float64], camera: Sequence[float]
) -> tuple[Mapping[str, Sequence[float]], str]:
    """Return the planes of cuts by name, and the name of the first one.

    Returns
    -------
    dict
        Normal, away from the viewer; the lowest, the highest and the first place along it, mm.
    str
        Its name at the start; ``none`` for packings that hide nothing.
    """
    packing = result.case.packing
    own = result.figure_options.plane
    normals = {
        "across x": (1.0, 0.0, 0.0),
        "across y": (0.0, 1.0, 0.0),
        "at a depth": (0.0, 0.0, 1.0),
    }
    normals |= {f"{plane.name} plane": tuple(plane.normal) for plane in planes(packing.kind)}
    starts = dict.fromkeys(normals, 0.0)
    if own is not None:
        plane = own_plane(own.normal, own.through)
        normals["section of the case"] = tuple(plane.normal)
        starts["section of the case"] = 0.0
        if plane.through is not None:
            distance = (plane.through - result.origin) @ plane.normal
            starts["section of the case"] = float(_MILLI * distance)
    stop = _STOP * _MILLI * result.case.packing.diameter
    towards = np.array(camera[:3]) - np.array(camera[3:6])
    cuts: dict[str, Sequence[float]] = {}
    for name, normal in normals.items():
        direction = np.array(normal)
        sign = -1.0 if direction @ towards > 0 else 1.0
        along = place @ (sign * direction)
        low = float(along.min()) - stop
        high = float(along.max()) + stop
        if high - low > 4 * stop:  # more than one plane of spheres
            cuts[name] = [*(sign * direction).tolist(), low, high, sign * starts[name] - stop]
    flat = packing.rule.is_chain or np.ptp(place[:, 2]) == 0
    wanted = ("section of the case", "orthogonal plane", "principal plane")
    return cuts, "none" if flat else next((name for name in wanted if name in cuts), "none")
