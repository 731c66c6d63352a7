"""Contact forces from measured grains."""

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="inference",
    title="contact forces from measured grains",
    packages={"clarabel": "clarabel"},
    extra="inference",
    result_kinds="granwave.extensions.inference.files:RESULT_KINDS",
    report="granwave.extensions.inference.report:REPORT_KINDS",
)
