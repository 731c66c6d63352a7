"""Objects of the page of a run, made with k3d: spheres with their fields, walls, bars, colour bars,
clock and title.

Lengths are in mm from the impacted sphere, and times in µs, as in figures.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from granwave.analysis.measures.geometry import own_plane, planes
from granwave.analysis.result.reader import Result
from granwave.extensions.pictures.packing3d import AZIMUTH, ELEVATION, plane_lines, tube_lines
from granwave.extensions.pictures.sphere_renderer import Camera
from granwave.extensions.pictures.view.fields import Field, colour_bar
from granwave.extensions.pictures.view.instants import Instants
from granwave.lammps_inputs.case.material import Cylinder
from granwave.lammps_inputs.packing.cylinders import in_grains
from granwave.lammps_inputs.packing.walls import walls

if TYPE_CHECKING:
    import k3d

# iterations for the corner of the grid, because a longer extent may have a longer step
_ROUNDINGS = 3
_MILLI = 1e3
_MICRO = 1e6
_MOVES = 0.05  # diameters: spheres with smaller displacements are drawn at rest
_STOP = 0.3  # diameters: spheres of the plane of a section stay
_PHONE_WIDTH = 600  # pixels below which the panel is closed at first
_FIELD_OF_VIEW = 40.0  # degrees
_AROUND_GRID = 1.15  # radius of the view / half the diagonal of the grid: numbers around it
_SECONDS = 8.0  # duration of the animation, s
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
    grid = round_grid(place, _MILLI * result.case.packing.diameter / 2)
    camera = _camera(result, place, grid)
    plot = k3d.plot(
        axes=[r"\text{x (mm)}", r"\text{y (mm)}", r"\text{depth (mm)}\qquad\qquad"],
        camera_auto_fit=False,
        camera_fov=_FIELD_OF_VIEW,
        colorbar_object_id=0,
        time_interpolation=False,
        time_speed=max(times[-1] / _SECONDS, 1e-6),
        lighting=2.0,
        axes_helper=0.0,
        grid_auto_fit=False,  # otherwise numbers along the axes start at any millimetre
        grid=grid.tolist(),
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
        plot += text(colour_bar(field), position=[0.0, 1.0], reference_point="lb", **of_field)
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
    remarks = (
        note,
        in_grains("lengths in mm from the impacted sphere", called),
        in_grains("grey spheres are below the scale", called),
    )
    lines += [html.escape(remark) for remark in remarks if remark]
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


def _camera(result: Result, place: NDArray[np.float64], grid: NDArray[np.float64]) -> list[float]:
    """Return position, target and upward direction of the camera: a chain lies across the view, a
    layer faces the viewer, a packing is seen with its grid and the numbers around it.

    Parameters
    ----------
    place
        Centres of the spheres, mm: (n, 3).
    grid
        Corners of the grid, as of `round_grid`, mm: (6,).
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
        middle = (grid[:3] + grid[3:]) / 2
        extent = _AROUND_GRID * float(np.linalg.norm(grid[3:] - grid[:3])) / 2
        distance = extent / math.sin(math.radians(_FIELD_OF_VIEW / 2))
        return [*(middle + distance * towards).tolist(), *middle.tolist(), *up.tolist()]
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
