"""Search for the best packing."""

from pathlib import Path

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="design",
    title="search for the best packing",
    packages={"sklearn": "scikit-learn"},
    extra="design",
    folder=Path(__file__).parent,
    result_kinds="granwave.extensions.design.files:RESULT_KINDS",
    report="granwave.extensions.design.report:REPORT_KINDS",
    file_kinds="granwave.extensions.design.kinds:FILE_KINDS",
    commands="granwave.extensions.design.commands:COMMANDS",
    python={
        "Designs": "granwave.extensions.design.python:Designs",
        "design": "granwave.extensions.design.python:design",
    },
)
