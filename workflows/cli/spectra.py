"""Commands ``granwave bands``, ``granwave modes`` and ``granwave transmission``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.workflows.cli.as_json import print_json

if TYPE_CHECKING:
    from granwave.analysis.spectra.band_structure import BandStructure
    from granwave.workflows.spectra import Finite

_KILO = 1e-3


def bands(options: argparse.Namespace, _: Any) -> int:
    """Execute ``granwave bands``."""
    from granwave.workflows import spectra as commands

    source = commands.source_of(options.case, options.overrides)
    found, written = commands.bands(
        source,
        _place(options, source, "bands"),
        options.path,
        points=options.points,
        n_bands=options.bands,
        directions=options.directions,
        plane=options.plane,
        slab=options.slab,
        allow_floppy=options.allow_floppy,
        force=options.force,
        figures=options.figures,
    )
    _note_left_out(found.state.network.left_out, found.state.name)
    if found.note:
        print(f"granwave: warning: {found.state.name}: {found.note}; they are left blank", file=sys.stderr)
    print_json(found.summary()) if options.json else print(f"{_of_bands(found)}\n\nresults in {written[0].parent}")
    return 0


def modes(options: argparse.Namespace, _: Any) -> int:
    """Execute ``granwave modes``."""
    from granwave.workflows import spectra as commands

    source = commands.source_of(options.case, options.overrides)
    found, written = commands.modes(
        source,
        _place(options, source, "modes"),
        n_modes=options.modes,
        directions=options.directions,
        allow_floppy=options.allow_floppy,
        force=options.force,
        figures=options.figures,
    )
    _note_left_out(found.state.network.left_out, found.state.name)
    print_json(found.summary()) if options.json else print(f"{_of_modes(found)}\n\nresults in {written[0].parent}")
    return 0


def transmission(options: argparse.Namespace, _: Any) -> int:
    """Execute ``granwave transmission``."""
    from granwave.workflows import spectra as commands

    source = commands.source_of(options.case, options.overrides)
    found, state, written = commands.steady(
        source,
        _place(options, source, "transmission"),
        drive=options.drive,
        sensors=options.sensor,
        frequency=options.frequencies,
        axis=options.axis,
        end=options.end,
        directions=options.directions,
        force=options.force,
        figures=options.figures,
    )
    _note_left_out(state.network.left_out, state.name)
    if options.json:
        print_json(commands.transmission_summary(state, found))
        return 0
    for n, sensor in enumerate(found.sensors):
        row = int(np.argmax(found.amplitude[:, n]))
        print(
            f"grain {found.drive} to {sensor}: largest amplitude ratio {found.amplitude[row, n]:.4g} at "
            f"{_KILO * found.frequency[row]:.5g} kHz, end {found.end}"
        )
    print(f"\nresults in {written[0].parent}")
    return 0


_MOST_FREQUENCIES = 1_000_000  # of START:END:COUNT


def frequencies(text: str) -> np.ndarray:
    """Read frequencies, Hz: numbers with commas between them, or START:END:COUNT."""
    try:
        if ":" in text:
            start, end, count = text.split(":")
            if not 1 <= int(count) <= _MOST_FREQUENCIES:
                raise ValueError
            values = np.linspace(float(start), float(end), int(count))
        else:
            values = np.array([float(one) for one in text.split(",")])
    except ValueError:
        values = np.empty(0)
    if not len(values) or not np.isfinite(values).all() or (values < 0).any():
        raise argparse.ArgumentTypeError(
            f"found {text or 'nothing'}, expected numbers from 0 up with commas between them (Hz), or START:END:COUNT "
            f"with a COUNT from 1 to {_MOST_FREQUENCIES}"
        )
    return values


def _place(options: argparse.Namespace, source: Case | Path, name: str) -> Path:
    if options.directory is not None:
        return Path(options.directory)
    own = source.name if isinstance(source, Case) else source.resolve().name
    return Path(f"{own}-{name}")


def _note_left_out(ids: np.ndarray, name: str) -> None:
    if len(ids):
        some = ", ".join(map(str, ids[:5])) + (", ..." if len(ids) > 5 else "")
        print(
            f"granwave: warning: {name}: {len(ids)} grains bear no static load ({some}); they are left out",
            file=sys.stderr,
        )


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


def _of_modes(found: Finite) -> str:
    values = found.summary()
    return (
        f"{values['name']}: {values['n_modes']} of {values['n_freedoms']} modes of {values['n_grains']} grains, "
        f"from {_KILO * (values['lowest_frequency_Hz'] or 0):.5g} kHz"
        + (f" to {_KILO * values['highest_frequency_Hz']:.5g} kHz" if values["highest_frequency_Hz"] else "")
    )


def ids(text: str) -> list[int]:
    """Read ids with commas between them."""
    found = text.split(",")
    if not all(one.strip().isdigit() and int(one) > 0 for one in found):
        raise argparse.ArgumentTypeError(f"found {text or 'nothing'}, expected ids from 1 up with commas between them")
    return [int(one) for one in found]
