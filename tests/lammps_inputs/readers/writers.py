"""The same three grains as files of many programs; positions, sizes and velocities keep every
bit.
"""

from __future__ import annotations

import base64
import gzip
import io
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

POSITION = np.array([[0.01, 0.1 / 3, 0.005], [0.01, 0.1 / 3, 0.015], [0.01, 0.1 / 3, 0.0275]])
SIZES = [0.01, 0.01, 0.015]
DIAMETER = np.array(SIZES)
VELOCITY = np.array([[0.0, 0.0, 1.0 / 7.0], [0.0, 0.0, 0.0], [0.0, 0.0, -0.5]])
BOX = np.array([[0.0, 0.04], [0.0, 0.04], [0.0, 0.1]])
ORDER = (2, 0, 1)  # rows of files that have ids


def own_table() -> str:
    """Return the grains as a table of granwave."""
    rows = ["x,y,z,diameter,vx,vy,vz"]
    for place, size, speed in zip(POSITION, SIZES, VELOCITY, strict=True):
        rows.append(",".join(map(repr, [*place.tolist(), float(size), *speed.tolist()])))
    return "\n".join(rows) + "\n"


def _numbers(values: object) -> str:
    return " ".join(repr(float(value)) for value in np.ravel(np.asarray(values)))


def dump_step(step: int, *, scale: float = 1.0, moved: float = 0.0) -> str:
    """Return a step of a dump of LAMMPS, with its rows in any order."""
    lines = ["ITEM: TIMESTEP", f"{step}", "ITEM: NUMBER OF ATOMS", "3"]
    lines += ["ITEM: BOX BOUNDS pp pp ff", *map(_numbers, BOX * scale)]
    lines.append("ITEM: ATOMS id type x y z vx vy vz omegax omegay omegaz radius")
    for k in ORDER:
        place = _numbers(scale * (POSITION[k] + moved))
        lines.append(f"{k + 1} 1 {place} {_numbers(VELOCITY[k])} 0 0 0 {SIZES[k] / 2!r}")
    return "\n".join(lines) + "\n"


def yaml_step(step: int, *, moved: float = 0.0) -> str:
    """Return a step of a dump of LAMMPS in YAML, as it writes it with thermodynamic data."""
    lines = ["---", "creator: LAMMPS", f"timestep: {step}", "units: si", "time: 0.5", "natoms: 3"]
    lines += ["boundary: [ p, p, p, p, f, f, ]", "thermo:", "  - keywords: [ Step, Temp, ]"]
    lines += [f"  - data: [ {step}, 0, ]", "box:"]
    lines += [f"  - [ {low!r}, {high!r} ]" for low, high in BOX.tolist()]
    lines += ["keywords: [ id, type, x, y, z, vx, vy, vz, radius,  ]", "data:"]
    for k in ORDER:
        values = _numbers([*(POSITION[k] + moved), *VELOCITY[k], SIZES[k] / 2]).split()
        lines.append(f"  - [ {k + 1} , 1 , {' , '.join(values)}, ]")
    return "\n".join([*lines, "..."]) + "\n"


def molecule() -> str:
    """Return a molecule template of LAMMPS, without velocities, whose sections have any order."""
    lines = ["# three spheres", "", "3 atoms", "", "Types", ""]
    lines += [f"{k + 1} 1" for k in range(3)]
    lines += ["", "Coords # of the centres", ""]
    lines += [f"{k + 1} {_numbers(POSITION[k])}" for k in ORDER]
    lines += ["", "Diameters", "", *(f"{k + 1} {SIZES[k]!r}" for k in reversed(range(3)))]
    return "\n".join(lines) + "\n"


def liggghts_step() -> str:
    """Return a step of LIGGGHTS, in which the type occurs twice."""
    lines = ["ITEM: TIMESTEP", "100", "ITEM: NUMBER OF ATOMS", "3"]
    lines += ["ITEM: BOX BOUNDS ff ff ff", *map(_numbers, BOX)]
    names = "id type type x y z ix iy iz vx vy vz fx fy fz omegax omegay omegaz radius"
    lines.append(f"ITEM: ATOMS {names} ")
    for k in ORDER:
        moving = f"{_numbers(VELOCITY[k])} 0 0 0 0 0 0"
        radius = SIZES[k] / 2
        lines.append(f"{k + 1} 1 1 {_numbers(POSITION[k])} 0 0 0 {moving} {radius!r} ")
    return "\n".join(lines) + "\n"


def data_file(style: str = "sphere") -> str:
    """Return a data file of LAMMPS."""
    lines = ["LAMMPS data file via write_data, units = si", "", "3 atoms", "1 atom types", ""]
    lines += [
        f"{_numbers(edges)} {axis}lo {axis}hi" for edges, axis in zip(BOX, "xyz", strict=True)
    ]
    lines += ["", f"Atoms # {style}", ""]
    for k in ORDER:
        place = _numbers(POSITION[k])
        size = f"{SIZES[k]!r} 2500"
        row = f"{size} {place}" if style == "sphere" else f"{place} {size} 0"
        lines.append(f"{k + 1} 1 {row} 0 0 0")
    lines += ["", "Velocities", ""]
    lines += [f"{k + 1} {_numbers(VELOCITY[k])} 0 0 0" for k in reversed(ORDER)]
    return "\n".join(lines) + "\n"


def yade_text() -> str:
    """Return an export of YADE, without velocities."""
    rows = zip(POSITION, SIZES, strict=True)
    lines = [f"{_numbers(place)} {size / 2!r} 0".replace(" ", "\t") for place, size in rows]
    return "\n".join(["#format x_y_z_r_matId", *lines]) + "\n"


def yade_pack() -> str:
    """Return a saved SpherePack of YADE, without velocities."""
    rows = zip(POSITION, SIZES, strict=True)
    lines = [f"{_numbers(place)} {size / 2!r}" for place, size in rows]
    return "\n".join(["##PERIODIC:: 0.04 0.04 0.1", *lines]) + "\n"


def mercury_step(time: float = 0.0) -> str:
    """Return a step of a data file of MercuryDPM."""
    lines = [f"3 {time} 0 0 0 0.04 0.04 0.1"]
    for place, size, speed in zip(POSITION, SIZES, VELOCITY, strict=True):
        lines.append(f"{_numbers(place)}  {_numbers(speed)}  {size / 2!r}  0 0 0  0 0 0  0")
    return "\n".join(lines) + "\n"


def mercury_restart() -> str:
    """Return a restart file of MercuryDPM."""
    lines = [
        "restart_version 1.0 name grains",
        "xMin 0 xMax 0.04 yMin 0 yMax 0.04 zMin 0 zMax 0.1",
        "Particles 3",
    ]
    for k in ORDER:
        motion = f"velocity {_numbers(VELOCITY[k])} angularVelocity 0 0 0"
        place = f"position {_numbers(POSITION[k])} orientation 1 0 0 0"
        lines.append(
            f"SphericalParticle id {k} indSpecies 0 {place} {motion} force 0 0 0 torque 0 0 0 "
            f"radius {SIZES[k] / 2!r} invMass 1"
        )
    return "\n".join([*lines, "Interactions 0"]) + "\n"


def esys() -> str:
    """Return a geometry of ESyS-Particle, without velocities, with a bond."""
    lines = ["LSMGeometry 1.2", "BoundingBox 0 0 0 0.04 0.04 0.1", "PeriodicBoundaries 1 1 0"]
    lines += ["Dimension 3D", "BeginParticles", "Simple", "3"]
    for k in ORDER:
        lines.append(f"{_numbers(POSITION[k])} {SIZES[k] / 2!r} {k} 7")
    lines += ["EndParticles", "BeginConnect", "1", "0 1 0", "EndConnect"]
    return "\n".join(lines) + "\n"


def mfix() -> str:
    """Return the particles of MFiX, of version 2.0."""
    rule = 40 * "="
    lines = ["Version 2.0", rule, "Instructions:", 'Dimension: Enter "2" for 2D, "3" for 3D', rule]
    lines += ["Dimension:    3  ", "Particles:    3  ", rule, "Variable  Read(T/F)  Default", rule]
    lines += [
        "Coordinates:  T   Must always be T",
        "Phase_ID:     F   1",
        "Diameter:     T   (Ignored)",
    ]
    lines += ["Density:      F   2700.", "Velocity:     T", "Temperature:  T   (Ignored)"]
    lines += [rule, "|  x  |  y  |  z  |  d  |  u  |  v  |  w  |", rule]
    for place, size, speed in zip(POSITION, SIZES, VELOCITY, strict=True):
        lines.append(_numbers([*place, size, *speed]).replace(" ", "\t"))
    return "\n".join(lines) + "\n"


def xyzd() -> bytes:
    """Return a packing of packing-generation, without velocities."""
    return np.column_stack([POSITION, DIAMETER]).astype("<f8").tobytes()


def lethe_table() -> str:
    """Return a table of lethe, with semicolons."""
    rows = ["p_x; p_y; p_z; v_x; v_y; v_z; w_x; w_y; w_z; diameters; fem_force_x; fem_force_y"]
    for place, size, speed in zip(POSITION, SIZES, VELOCITY, strict=True):
        cells = [*place, *speed, 0.0, 0.0, 0.0, size, 0.0, 0.0]
        rows.append("; ".join(repr(float(cell)) for cell in cells))
    return "\n".join(rows) + "\n"


def chrono_table() -> str:
    """Return a table of Chrono."""
    rows = ["X,Y,Z,r,absv,v_x,v_y,v_z"]
    for place, size, speed in zip(POSITION, SIZES, VELOCITY, strict=True):
        cells = [*place, size / 2, 0.0, *speed]
        rows.append(",".join(repr(float(cell)) for cell in cells))
    return "\n".join(rows) + "\n"


def vtk_ascii() -> str:
    """Return a legacy file of VTK as text."""
    lines = ["# vtk DataFile Version 3.0", "grains", "ASCII", "DATASET POLYDATA", "POINTS 3 double"]
    lines += [_numbers(place) for place in POSITION]
    lines += ["VERTICES 3 6", "1 0", "1 1", "1 2", "POINT_DATA 3"]
    lines += ["SCALARS radius double 1", "LOOKUP_TABLE default", _numbers(DIAMETER / 2)]
    lines += ["VECTORS v double", *map(_numbers, VELOCITY)]
    return "\n".join(lines) + "\n"


def vtk_binary() -> bytes:
    """Return a legacy file of VTK in big-endian numbers."""
    parts = [b"# vtk DataFile Version 3.0\ngrains\nBINARY\nDATASET POLYDATA\nPOINTS 3 double\n"]
    parts += [POSITION.astype(">f8").tobytes(), b"\nPOINT_DATA 3\nFIELD FieldData 2\n"]
    parts += [b"radius 1 3 double\n", (DIAMETER / 2).astype(">f8").tobytes(), b"\n"]
    parts += [b"velocity 3 3 double\n", VELOCITY.astype(">f8").tobytes(), b"\n"]
    return b"".join(parts)


def xyz() -> str:
    """Return a file of extended XYZ as OVITO writes it."""
    lines = ["3", 'Lattice="0.04 0 0 0 0.04 0 0 0 0.1" Origin="0 0 0" pbc="T T F" '
             "Properties=id:I:1:species:S:1:pos:R:3:velo:R:3:Radius:R:1"]  # fmt: skip
    for k in ORDER:
        lines.append(
            f"{k + 1} glass {_numbers(POSITION[k])} {_numbers(VELOCITY[k])} {SIZES[k] / 2!r}"
        )
    return "\n".join(lines) + "\n"


def _packed(array: np.ndarray) -> bytes:
    """Return an array in VTK's compressed form: sizes of its blocks, and a block."""
    raw = array.astype("<f8").tobytes()
    block = zlib.compress(raw)
    head = struct.pack("<4I", 1, len(raw), 0, len(block))
    return base64.b64encode(head) + base64.b64encode(block)


def vtp(form: str) -> bytes:
    """Return an XML file of VTK, with its arrays as text (ascii), inline, or appended."""
    arrays = {"Points": POSITION, "diameter": DIAMETER, "velocity": VELOCITY}
    elements = {}
    blob = b""
    for name, array in arrays.items():
        n_parts = array.shape[1] if array.ndim == 2 else 1
        head = f'<DataArray type="Float64" Name="{name}" NumberOfComponents="{n_parts}"'
        if form == "appended":
            elements[name] = f'{head} format="appended" offset="{len(blob)}"/>'
            raw = array.astype("<f8").tobytes()
            blob += struct.pack("<I", len(raw)) + raw
        else:
            text = _numbers(array) if form == "ascii" else _packed(array).decode()
            kind = "ascii" if form == "ascii" else "binary"
            elements[name] = f'{head} format="{kind}">{text}</DataArray>'
    packing = ' compressor="vtkZLibDataCompressor"' if form == "inline" else ""
    text = (
        f'<?xml version="1.0"?>\n<VTKFile type="PolyData" byte_order="LittleEndian"{packing}>'
        '<PolyData><Piece NumberOfPoints="3">'
        f"<Points>{elements['Points']}</Points>"
        f"<PointData>{elements['diameter']}{elements['velocity']}</PointData>"
        "</Piece></PolyData>"
    ).encode()
    if form == "appended":
        text += b'<AppendedData encoding="raw">_' + blob + b"</AppendedData>"
    return text + b"</VTKFile>\n"


def h5md() -> bytes:
    """Return a trajectory in H5MD form of two steps."""
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        group = file.create_group("particles/grains")
        for name, values in (("position", POSITION), ("velocity", VELOCITY)):
            element = group.create_group(name)
            element["value"] = np.stack([0 * values, values])
            element["step"] = [0, 100]
        group["radius"] = DIAMETER / 2
        group["id"] = [1, 2, 3]
        box = group.create_group("box")
        box.attrs["boundary"] = ["periodic", "periodic", "none"]
        box["edges"] = BOX[:, 1]
    return content.getvalue()


#: File by the name of a format; the endings say nothing.
FILES: dict[str, Callable[[], str | bytes]] = {
    "dump": lambda: dump_step(100),
    "dump of several steps": lambda: dump_step(0, moved=1e-3) + dump_step(100),
    "dump.gz": lambda: gzip.compress(dump_step(100).encode(), mtime=0),
    "dump of liggghts": liggghts_step,
    "yaml": lambda: yaml_step(0, moved=1e-3) + yaml_step(100),
    "data": data_file,
    "data of a hybrid": lambda: data_file("hybrid sphere bond"),
    "molecule": molecule,
    "yade.txt": yade_text,
    "yade.spheres": yade_pack,
    "mercury.data": lambda: mercury_step(0.0) + mercury_step(0.1),
    "mercury.restart": mercury_restart,
    "esys.geo": esys,
    "mfix": mfix,
    "packing.xyzd": xyzd,
    "lethe": lethe_table,
    "chrono": chrono_table,
    "vtk": vtk_ascii,
    "binary vtk": vtk_binary,
    "vtp": lambda: vtp("ascii"),
    "vtp inline": lambda: vtp("inline"),
    "vtp appended": lambda: vtp("appended"),
    "h5md": h5md,
    "xyz": xyz,
}
WITHOUT_VELOCITY = ("molecule", "yade.txt", "yade.spheres", "esys.geo", "packing.xyzd")


def write(path: Path, content: str | bytes) -> Path:
    """Write a file of text or bytes; return its path."""
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path
