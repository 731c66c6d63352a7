"""Small waves about a static state: bands, modes and transmission."""

from pathlib import Path

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="waves",
    title="bands, modes and transmission of small waves",
    folder=Path(__file__).parent,
    result_kinds="granwave.extensions.waves.files:RESULT_KINDS",
    figures={"dispersion": "granwave.extensions.waves.dispersion:DISPERSION"},
    figures_on_request=("dispersion",),
    studies={"bands": "granwave.extensions.waves.study"},
    report="granwave.extensions.waves.report:REPORT_KINDS",
    commands="granwave.extensions.waves.commands:COMMANDS",
    check="granwave.extensions.waves.check:check",
    python={
        "bands": "granwave.extensions.waves.python:bands",
        "modes": "granwave.extensions.waves.python:modes",
        "transmission": "granwave.extensions.waves.python:transmission",
    },
)
