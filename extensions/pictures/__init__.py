"""Packings in three dimensions: figures, animations, an interactive page, and files for ParaView
and OVITO.
"""

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="pictures",
    title="cut packings, animations, views, files for ParaView and OVITO",
    packages={"imageio_ffmpeg": "imageio-ffmpeg", "k3d": "k3d", "vtk": "vtk", "vtkmodules": "vtk"},
    extra="pictures",
    figures={
        "packing_3d": "granwave.extensions.pictures.packing3d:PEAK_FORCE",
        "packing_3d_dissipation": "granwave.extensions.pictures.packing3d:DISSIPATION",
    },
    figures_on_request=("packing_3d_dissipation",),
    products="granwave.extensions.pictures.products:PRODUCTS",
    exports={
        "ovito": "granwave.extensions.pictures.exports:OVITO",
        "vtp": "granwave.extensions.pictures.exports:VTP",
    },
    commands="granwave.extensions.pictures.commands:COMMANDS",
)
