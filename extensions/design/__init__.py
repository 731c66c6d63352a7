"""Search for the best packing."""

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="design",
    title="search for the best packing",
    packages={"sklearn": "scikit-learn"},
    extra="design",
    result_kinds="granwave.extensions.design.files:RESULT_KINDS",
    report="granwave.extensions.design.report:REPORT_KINDS",
)
