"""Commands ``granwave bands``, ``granwave modes`` and ``granwave transmission``; each returns the exit status."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from granwave.analysis.spectra.band_structure import BandStructure
from granwave.analysis.spectra.states import State
from granwave.lammps_inputs.case.case import Case
from granwave.workflows import spectra
from granwave.workflows.cli.parser import chosen
from granwave.workflows.cli.terminal import print_json, warn

_KILO = 1e-3


def bands(options: argparse.Namespace) -> int:
    """Execute ``granwave bands``."""
    found, written = spectra.bands(_source(options, "bands"), **chosen(options, spectra.bands))
    _note_left_out(found.state)
    if found.note:
        warn(f"{found.state.name}: {found.note}; they are left blank")
    print_json(found.summary()) if options.json else print(f"{_of_bands(found)}\n\nresults in {written[0].parent}")
    return 0


def modes(options: argparse.Namespace) -> int:
    """Execute ``granwave modes``."""
    found, written = spectra.modes(_source(options, "modes"), **chosen(options, spectra.modes))
    _note_left_out(found.state)
    print_json(found.summary()) if options.json else print(f"{_of_modes(found)}\n\nresults in {written[0].parent}")
    return 0


def transmission(options: argparse.Namespace) -> int:
    """Execute ``granwave transmission``."""
    found, state, written = spectra.steady(_source(options, "transmission"), **chosen(options, spectra.steady))
    _note_left_out(state)
    if options.json:
        print_json(spectra.transmission_summary(state, found))
        return 0
    for n, sensor in enumerate(found.sensors):
        row = int(np.argmax(found.amplitude[:, n]))
        print(
            f"grain {found.drive} to {sensor}: largest amplitude ratio {found.amplitude[row, n]:.4g} at "
            f"{_KILO * found.frequency[row]:.5g} kHz, end {found.end}"
        )
    print(f"\nresults in {written[0].parent}")
    return 0


def _source(options: argparse.Namespace, name: str) -> Case | Path:
    """Return the case or the directory of a run; give the results a directory where none is chosen."""
    source = spectra.source_of(options.case, options.overrides)
    own = source.name if isinstance(source, Case) else source.resolve().name
    options.directory = options.directory or Path(f"{own}-{name}")
    return source


def _note_left_out(state: State) -> None:
    if len(ids := state.network.left_out):
        some = ", ".join(map(str, ids[:5])) + (", ..." if len(ids) > 5 else "")
        warn(f"{state.name}: {len(ids)} grains bear no static load ({some}); they are left out")


def _counted(number: int, word: str) -> str:
    return f"{number} {word}{'s' * (number != 1)}"


def _of_bands(found: BandStructure) -> str:
    network = found.state.network
    lines = [
        f"{found.state.name}: {_counted(network.n_grains, 'grain')} and {_counted(len(network.springs), 'contact')} "
        f"in a cell, {_counted(found.bands.square.shape[1], 'band')} up to "
        f"{_KILO * np.nanmax(found.bands.frequency):.5g} kHz",
    ]
    if len(found.speeds):
        lines.append(f"speeds of long waves    {', '.join(f'{one:.5g}' for one in found.speeds)} m/s")
    for gap in found.gaps:
        if gap.below and np.isfinite(gap.high):
            lines.append(
                f"gap above band {gap.below:<8} {_KILO * gap.low:.5g} to {_KILO * gap.high:.5g} kHz "
                f"({100 * gap.relative_width:.3g} % of its middle)"
            )
    return "\n".join(lines)


def _of_modes(found: spectra.Finite) -> str:
    values = found.summary()
    return (
        f"{values['name']}: {values['n_modes']} of {values['n_freedoms']} modes of {values['n_grains']} grains, "
        f"from {_KILO * (values['lowest_frequency_Hz'] or 0):.5g} kHz"
        + (f" to {_KILO * values['highest_frequency_Hz']:.5g} kHz" if values["highest_frequency_Hz"] else "")
    )
