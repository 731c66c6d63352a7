"""Packings in three dimensions: figures, films, a page to turn and cut, files for ParaView and OVITO."""

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="pictures",
    title="cut packings, films, views, files for ParaView and OVITO",
    packages={"imageio_ffmpeg": "imageio-ffmpeg", "k3d": "k3d", "vtk": "vtk", "vtkmodules": "vtk"},
    extra="pictures",
    commands="granwave.extensions.pictures.commands:COMMANDS",
)
