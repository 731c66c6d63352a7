"""Contact forces from measured grains."""

from pathlib import Path

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="inference",
    title="contact forces from measured grains",
    packages={"clarabel": "clarabel"},
    extra="inference",
    folder=Path(__file__).parent,
    result_kinds="granwave.extensions.inference.files:RESULT_KINDS",
    report="granwave.extensions.inference.report:REPORT_KINDS",
    file_kinds="granwave.extensions.inference.kinds:FILE_KINDS",
    commands="granwave.extensions.inference.commands:COMMANDS",
    python={
        "InferredForces": "granwave.extensions.inference.python:InferredForces",
        "infer": "granwave.extensions.inference.python:infer",
        "stress_history": "granwave.extensions.inference.relaxation:stress_history",
    },
)
