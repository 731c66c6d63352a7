"""Export of a run to VTK PolyData, for ParaView: open ``spheres.pvd`` and ``contacts.pvd``, with
times in s.

    spheres_NNNN.vtp    a point for each sphere at its position in the snapshot, with id, radius,
                        displacement, velocity, contact_force, peak_force, dissipated_energy,
                        elastic_energy and contacts_yielded at this time, and friction_energy with
                        friction
    contacts_NNNN.vtp   a line between the centres of each pair of ``/contacts``, with i, j, overlap
                        at this time (negative: a gap), loaded and yielded (1: by this time), and,
                        for the whole run, peak_overlap, peak_force, dissipated_energy,
                        friction_energy, initial_overlap, initial_force

SI units. In ParaView, a Glyph filter with spheres, scaled by ``radius`` with a factor of 2, draws
spheres to scale. A contact across a periodic boundary ends at the image of its second sphere.
"""

from __future__ import annotations

import errno
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.exports.selection import ALL, SelectedRows, Selection
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import GROUP
from granwave.lammps_inputs.errors import InputError

if TYPE_CHECKING:
    from vtkmodules.vtkCommonDataModel import vtkPolyData

OUTDATED = r"(spheres|contacts)_\d{4,}\.vtp"
_OF_RUN = (
    "peak_overlap", "peak_force", "dissipated_energy", "friction_energy", "viscous_energy", "initial_overlap",
    "initial_force",
)  # fmt: skip

Arrays = Mapping[str, NDArray]


def export_run(result: Result, path_of: Callable[[str], Path], selected: Selection = ALL) -> None:
    """Write two files for each snapshot, and the two collections that list them; ``selected``:
    the spheres, contacts and snapshots that are written.
    """
    try:
        import vtkmodules.vtkIOXML  # noqa: F401
    except ImportError as error:
        raise InputError(
            f'--to vtp requires VTK ({error}): pip install "granwave[pictures]"'
        ) from None

    rows = SelectedRows(result, selected)
    radius = result[f"{GROUP}/radius"]
    times = {number: float(result.frame_times[number]) for number in rows.frames}
    for number, time in times.items():
        positions = result.frame(number, "position")
        quantities = [name for name in result.quantities if name != "position"]
        values: dict[str, NDArray] = {name: result.frame(number, name) for name in quantities}
        yielded = result["contacts/yielded"].astype(np.int8) & _since(
            result["contacts/time_yield"], time
        )
        ends = result.ends[yielded > 0]
        values["contacts_yielded"] = np.bincount(ends.ravel(), minlength=result.n_spheres)
        spheres = {"id": result["spheres/id"], "radius": radius, **values}
        spheres = {name: array[rows.spheres] for name, array in spheres.items()}
        places = positions[rows.spheres]
        vertices = np.arange(len(places)).reshape(-1, 1)
        _write(path_of(_name("spheres", number)), places, vertices, spheres, time)
        points, lines, overlap = _lines(result, positions, radius)
        contacts = {"i": result["contacts/i"], "j": result["contacts/j"], "overlap": overlap}
        contacts |= {"loaded": _since(result["contacts/time_first"], time), "yielded": yielded}
        contacts |= {
            name: result[f"contacts/{name}"] for name in _OF_RUN if f"contacts/{name}" in result
        }
        contacts = {name: array[rows.contacts] for name, array in contacts.items()}
        if selected.is_of_place:
            used, ends = np.unique(lines[rows.contacts], return_inverse=True)
            points = points[used]
            lines = ends.reshape(-1, 2)
        _write(path_of(_name("contacts", number)), points, lines, contacts, time)
    for what in ("spheres", "contacts"):
        _write_collection(
            path_of(f"{what}.pvd"), {time: _name(what, n) for n, time in times.items()}
        )


def _name(what: str, number: int) -> str:
    return f"{what}_{number:04d}.vtp"


def _since(began: NDArray[np.float64], time: float) -> NDArray[np.int8]:
    """Return 1 for events up to a time (NaN: never), otherwise 0."""
    return (began <= time).astype(np.int8)


def _lines(
    result: Result, positions: NDArray[np.float64], radius: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Return the contacts as lines.

    Returns
    -------
    points
        Centres of the spheres, followed by images at the ends of contacts across periodic
        boundaries: (n, 3), m.
    lines
        Rows of the end points: (n_contacts, 2).
    overlap
        Overlaps: (n_contacts,), m.
    """
    box = result.file[f"{GROUP}/box"]
    lines = result.ends
    step = positions[lines[:, 1]] - positions[lines[:, 0]]
    shift = np.zeros_like(step)
    for axis, (boundary, length) in enumerate(
        zip(box.attrs["boundary"], box["edges"][()], strict=True)
    ):
        if boundary == "periodic":
            shift[:, axis] = -length * np.round(step[:, axis] / length)
    overlap = radius[lines].sum(axis=1) - np.linalg.norm(step + shift, axis=1)
    through = np.flatnonzero(shift.any(axis=1))
    images = positions[lines[through, 1]] + shift[through]
    lines[through, 1] = len(positions) + np.arange(len(through))
    return np.concatenate([positions, images]), lines, overlap


def _write(
    path: Path, points: NDArray[np.float64], cells: NDArray[np.int64], arrays: Arrays, time: float
) -> None:
    """Write vertices (n, 1) with point data, or lines (n, 2) with cell data."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkLogger, vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    data: vtkPolyData = vtkPolyData()
    places = vtkPoints()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    data.SetPoints(places)
    cell_array = vtkCellArray()
    cell_array.SetData(
        cells.shape[1], numpy_to_vtkIdTypeArray(np.ascontiguousarray(cells).ravel(), deep=True)
    )
    is_lines = cells.shape[1] == 2
    (data.SetLines if is_lines else data.SetVerts)(cell_array)
    for name, values in {**arrays, "TimeValue": np.array([time])}.items():
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        if name == "TimeValue":
            data.GetFieldData().AddArray(array)
        elif is_lines:
            data.GetCellData().AddArray(array)
        else:
            data.GetPointData().AddArray(array)
    vtkLogger.SetStderrVerbosity(
        vtkLogger.VERBOSITY_OFF
    )  # errors of the file are told below, with its name
    writer = vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    if not writer.Write() or writer.GetErrorCode():
        raise OSError(errno.EIO, "VTK could not write it; check the disk space")


def _write_collection(path: Path, files: Mapping[float, str]) -> None:
    root = ElementTree.Element(
        "VTKFile", type="Collection", version="0.1", byte_order="LittleEndian"
    )
    collection = ElementTree.SubElement(root, "Collection")
    for time, name in files.items():
        ElementTree.SubElement(collection, "DataSet", timestep=repr(time), part="0", file=name)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
