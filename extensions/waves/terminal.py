"""Commands ``granwave bands``, ``granwave modes`` and ``granwave transmission``; each returns the
exit status.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from granwave.analysis.formatting.numbers import counted
from granwave.extensions.waves import small_waves as spectra
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.run_directory import RESULT_FILE
from granwave.workflows import library
from granwave.workflows.cli.commands import chosen
from granwave.workflows.cli.terminal import print_json, warn

_KILO = 1e-3


def bands(options: argparse.Namespace) -> int:
    """Execute ``granwave bands``."""
    waves, written = spectra.bands(_source(options, "bands"), **chosen(options, spectra.bands))
    found = waves.found
    network = waves.state.network
    if found.note:
        warn(f"{waves.state.name}: {found.note}; they are left blank")
    lines = [
        f"{waves.state.name}: {counted(network.n_grains, 'grain')} and {counted(len(network.springs), 'contact')} "
        f"in a cell, {counted(found.bands.square.shape[1], 'band')} up to "
        f"{_KILO * np.nanmax(found.bands.frequency):.5g} kHz",
    ]
    if len(found.speeds):
        lines.append(
            f"speeds of long waves    {', '.join(f'{one:.5g}' for one in found.speeds)} m/s"
        )
    for gap in found.gaps:
        if gap.below and np.isfinite(gap.high):
            lines.append(
                f"gap above band {gap.below:<8} {_KILO * gap.low:.5g} to {_KILO * gap.high:.5g} "
                f"kHz ({100 * gap.relative_width:.3g} % of its centre)"
            )
    return _print(options, waves, written, lines)


def modes(options: argparse.Namespace) -> int:
    """Execute ``granwave modes``."""
    waves, written = spectra.modes(_source(options, "modes"), **chosen(options, spectra.modes))
    values = waves.summary
    line = (
        f"{values['name']}: {values['n_modes']} of {values['n_freedoms']} modes of {values['n_grains']} grains, "
        f"from {_KILO * (values['lowest_frequency_Hz'] or 0):.5g} kHz"
    )
    if values["highest_frequency_Hz"]:
        line += f" to {_KILO * values['highest_frequency_Hz']:.5g} kHz"
    return _print(options, waves, written, [line])


def transmission(options: argparse.Namespace) -> int:
    """Execute ``granwave transmission``."""
    waves, written = spectra.steady(
        _source(options, "transmission"), **chosen(options, spectra.steady)
    )
    found = waves.found
    lines = []
    for n, sensor in enumerate(found.sensors):
        row = int(np.argmax(found.amplitude[:, n]))
        lines.append(
            f"grain {found.drive} to {sensor}: largest amplitude ratio {found.amplitude[row, n]:.4g} at "
            f"{_KILO * found.frequency[row]:.5g} kHz, end {found.end}"
        )
    return _print(options, waves, written, lines)


def _print(
    options: argparse.Namespace, waves: spectra.SmallWaves, written: list[Path], lines: list[str]
) -> int:
    if len(ids := waves.state.network.left_out):
        some = ", ".join(map(str, ids[:5])) + (", ..." if len(ids) > 5 else "")
        warn(
            f"{waves.state.name}: {len(ids)} grains carry no static load ({some}) and are excluded"
        )
    if options.json:
        print_json(waves.summary)
    else:
        print("\n".join([*lines, "", f"results in {written[0].parent}"]))
    return 0


def _source(options: argparse.Namespace, name: str) -> Assembly | Path:
    """Return the packing of a case or the directory of a run; choose a directory for the results if
    none is given.

    Raises
    ------
    InputError
        There is none, or keys are set for a run, whose case cannot be changed.
    """
    path = Path(options.case)
    source = None
    if not (path.is_dir() and (path / RESULT_FILE).is_file()):
        source = library.load_assembly(options.case, options.overrides)
    elif options.overrides:
        raise InputError(
            f"--set: found {options.overrides[0]} for the run {path}, which is finished; use a "
            "case to change keys"
        )
    own = path.resolve().name if source is None else source.case.name
    options.directory = options.directory or Path(f"{own}-{name}")
    return source or path
