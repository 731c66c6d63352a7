"""Bands, modes and transmission of a case or of a finished run: computed, and written to a
directory.
"""

from __future__ import annotations

import dataclasses
import json
import logging
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from granwave.analysis.figures.style import Columns, FigureFolder, style, write_csv
from granwave.analysis.result.reader import Result
from granwave.extensions.waves.files import SPECTRA, SPECTRA_FILE
from granwave.extensions.waves.spectra import files
from granwave.extensions.waves.spectra.band_structure import band_structure
from granwave.extensions.waves.spectra.bands import ALL_UP_TO, growing, solve_modes
from granwave.extensions.waves.spectra.files import Table, case_in, write_spectra
from granwave.extensions.waves.spectra.states import State, packing_state
from granwave.extensions.waves.spectra.stiffness import stiffness_of
from granwave.extensions.waves.spectra.transmission import dampers_of, losses_of, transmission
from granwave.lammps_inputs.case.boundary import Damper
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import plain, replace_text, replacing
from granwave.lammps_inputs.own_files import figure_files
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.statics.bodies import Array
from granwave.workflows.run.directory import held

_HIGHEST = 1e12  # Hz, far above all contacts; squares of much larger numbers overflow
_LOWEST_MODES = 2  # lowest modes of a large packing: whether it buckles
_LOG = logging.getLogger("granwave")

#: Functions of `granwave.extensions.waves.figures` by the name of the figure, for each command.
FIGURES = {
    "bands": {
        "bands": "band_diagram",
        "group_velocity": "group_velocities",
        "slowness": "slowness_curves",
        "equal_frequency": "equal_frequency_curves",
        "mode_shapes": "mode_shapes",
    },
    "modes": {"density_of_states": "density_of_states", "participation": "participation"},
    "transmission": {"transmission": "transmission_curve"},
}


def check_place(
    directory: Path | None, name: str, source: Assembly | Path, *, force: bool
) -> ResultDirectory | None:
    """Return the directory for results of this name; None without a directory.

    Raises
    ------
    InputError
        It already contains such results, results of another case or kind, or files that granwave
        did not write.
    """
    if directory is None:
        return None
    if isinstance(source, Assembly):
        case = source.case.to_toml()
    else:
        with Result(source) as result:
            case = result.case.to_toml()
    results = ResultDirectory(results_directory(directory))
    results.check(force=force)
    results.refuse_other_kind(SPECTRA)
    names = [f"{name}.csv", f"{name}.json"]
    there = [one for one in results.result_names() if one.endswith((".csv", ".json"))]
    others = [one for one in there if one not in names]
    again = [one for one in there if one in names]
    if not force and others and case_in(results / SPECTRA_FILE) not in ("", case):
        raise InputError(
            f"{results}: holds results of another case ({others[0]}); {results.by_force}"
        )
    if not force and again:
        raise InputError(f"{results}: already holds results ({min(again)}); {results.by_force}")
    results.refuse_foreign([*names, SPECTRA_FILE])
    return results


@dataclasses.dataclass(frozen=True, eq=False)
class SmallWaves:
    """Bands, modes or transmission with all that is written of them.

    Attributes
    ----------
    name
        Name of the files: bands, modes or transmission.
    state
        Static state.
    found
        The bands, the modes or the transmission.
    summary
        Values of NAME.json.
    columns
        Columns of NAME.csv.
    tables
        Groups of spectra.h5.
    """

    name: str
    state: State
    found: Any
    summary: Mapping[str, Any]
    columns: Columns
    tables: Mapping[str, Table]

    def write(self, results: ResultDirectory | None, *, force: bool, figures: bool) -> list[Path]:
        """Write NAME.csv, NAME.json, the groups of spectra.h5 and the figures; return the paths of
        the files.

        With ``force`` earlier results of the command are first moved to NAME.old; all results if
        they are of another case.
        """
        if results is None:
            return []
        directory = results.path
        with held(results):
            names = [f"{self.name}.csv", f"{self.name}.json"]
            if case_in(directory / SPECTRA_FILE) not in ("", self.state.case.to_toml()):
                results.make_room(force=force)
            elif force:
                drawn = chain.from_iterable(map(figure_files, FIGURES[self.name]))
                results.make_room(force=True, names=[*names, *drawn])
            results.claim([*names, SPECTRA_FILE], kind=SPECTRA)
            write_spectra(directory / SPECTRA_FILE, self.state, self.tables)
            with replacing(directory / names[0]) as scratch:
                write_csv(self.columns, scratch)
            replace_text(
                directory / names[1],
                json.dumps(plain(dict(self.summary)), indent=1, allow_nan=False) + "\n",
            )
            folder = FigureFolder(results)
            if figures:
                # imported on demand: matplotlib takes a second to load
                from granwave.extensions.waves import figures as drawing

                with style():
                    for figure, draw in FIGURES[self.name].items():
                        folder.draw(partial(getattr(drawing, draw), self.found), figure)
        return [directory / one for one in (*names, SPECTRA_FILE)] + folder.written


def bands(
    source: Assembly | Path,
    directory: Path | None,
    path: str = "",
    *,
    points: int | None = None,
    n_bands: int | None = None,
    directions: str = "",
    plane: str = "",
    allow_floppy: bool = False,
    slab: bool = False,
    force: bool = False,
    figures: bool = True,
) -> tuple[SmallWaves, list[Path]]:
    """Find the bands of an infinite, periodic packing and write them; see `band_structure`.

    Parameters
    ----------
    directory
        Directory of the results; None: nothing is written.

    Returns
    -------
    SmallWaves, list of Path
        The bands, and the files.
    """
    place = check_place(directory, "bands", source, force=force)
    found = band_structure(
        source, path, points=points, n_bands=n_bands, directions=directions, plane=plane, allow_floppy=allow_floppy,
        slab=slab,
    )  # fmt: skip
    way = found.bands.path
    columns: dict[str, Any] = {
        "distance": way.distance,
        **dict(zip(("kx", "ky", "kz"), way.k.T, strict=True)),
    }
    columns |= {f"f{n}_Hz": one for n, one in enumerate(found.bands.frequency.T, start=1)}
    waves = SmallWaves(
        "bands", found.state, found, found.summary(), columns, files.tables_of_bands(found)
    )
    return waves, waves.write(place, force=force, figures=figures)


def modes(
    source: Assembly | Path,
    directory: Path | None,
    *,
    n_modes: int | None = None,
    directions: str = "",
    allow_floppy: bool = False,
    force: bool = False,
    figures: bool = True,
) -> tuple[SmallWaves, list[Path]]:
    """Find the modes of a finite packing and write them.

    Parameters
    ----------
    directory
        As in `bands`.
    n_modes
        Number of modes; None: all for a small packing, 60 for a large packing.
    allow_floppy
        True to continue where motions meet no resistance.

    Raises
    ------
    InputError
        The packing carries no load, or is not rigid.
    """
    place = check_place(directory, "modes", source, force=force)
    state = _finite(source, directions)
    network = state.network
    found = solve_modes(stiffness_of(state.network), n_modes)
    if found.n_floppy and not allow_floppy:
        raise InputError(
            f"{state.name}: the static state is not rigid: {found.describe_floppy()}; add "
            "friction, a load from all sides, --directions or [[hold]], or continue with "
            "--allow-floppy"
        )
    frequency = found.frequency
    above = found.frequency[found.frequency > 0]
    summary = {
        "name": state.name,
        "kind": "modes",
        "source": state.source,
        "n_grains": network.n_grains,
        "n_contacts": len(network.springs),
        "n_wall_contacts": len(network.supports),
        "n_left_out": len(network.left_out),
        "n_freedoms": network.n_freedoms,
        "n_modes": len(frequency),
        "n_floppy": found.n_floppy,
        "lowest_frequency_Hz": float(above.min()) if len(above) else None,
        "highest_frequency_Hz": float(np.nanmax(frequency)) if found.complete else None,
        "least_participation_ratio": float(found.participation.min()),
        "static_residual": state.residual,
    }
    numbers = np.arange(1, len(frequency) + 1)
    columns = {
        "mode": numbers,
        "frequency_Hz": frequency,
        "participation_ratio": found.participation,
    }
    waves = SmallWaves("modes", state, found, summary, columns, files.tables_of_modes(state, found))
    return waves, waves.write(place, force=force, figures=figures)


def steady(
    source: Assembly | Path,
    directory: Path | None,
    *,
    drive: int | Sequence[int],
    sensors: Sequence[int],
    frequencies: Array,
    axis: str = "",
    end: str = "",
    directions: str = "",
    force: bool = False,
    figures: bool = True,
) -> tuple[SmallWaves, list[Path]]:
    """Find the steady transmission between grains of a finite packing and write it.

    Parameters
    ----------
    directory
        As in `bands`.
    drive
        Driven grain, or several grains driven in phase.
    frequencies
        (n,), Hz.
    axis
        Direction of drive and sensors; empty for z, or x in a packing of one layer.
    """
    place = check_place(directory, "transmission", source, force=force)
    if not len(frequencies) or not np.isfinite(frequencies).all() or (frequencies < 0).any():
        raise InputError("--frequencies: expected numbers from 0 up (Hz)")
    if frequencies.max() > _HIGHEST:
        raise InputError(
            f"--frequencies: found {frequencies.max():g} Hz, expected at most {_HIGHEST:g} Hz"
        )
    state = _finite(source, directions, damped=True)
    axis = axis or ("z" if state.network.moves[:, 2].any() else "x")
    if axis not in ("x", "y", "z"):
        raise InputError(f'--axis: found "{axis}", expected x, y or z')
    assembly = state.assembly
    support = state.case.boundary.bottom_support
    damping = support.damping if isinstance(support, Damper) else None
    dampers = dampers_of(assembly, state.network) if state.case.absorb else None
    stiffness = stiffness_of(state.network)
    small = state.network.n_freedoms <= ALL_UP_TO
    modes = solve_modes(stiffness, None if small else _LOWEST_MODES)
    if words := growing(
        modes.square, modes.largest
    ):  # a steady motion about such a state is unstable
        _LOG.warning(
            "%s: the static state is not rigid%s; this static state and the steady motion are "
            "unstable; granwave modes lists these modes",
            state.name,
            words.replace(", and ", ": ", 1).replace(
                " of them", " modes" if small else " modes or more"
            ),
        )
    first, *together = [drive] if isinstance(drive, int) else drive
    found = transmission(
        stiffness, first, sensors, frequencies, axis=axis, end=end, dampers=dampers,
        losses=losses_of(assembly, state.network, [first, *together], axis), together=together, bottom=damping,
    )  # fmt: skip
    n = len(found.sensors)
    columns = {
        "frequency_Hz": np.repeat(found.frequency, n),
        "sensor": np.tile(np.array(found.sensors), len(found.frequency)),
        "amplitude_ratio": found.amplitude.ravel(),
        "phase_rad": found.phase.ravel(),
    }
    summary = {
        "name": state.name,
        "kind": "transmission",
        "source": state.source,
        "n_grains": state.network.n_grains,
        "n_contacts": len(state.network.springs),
        "n_left_out": len(state.network.left_out),
        "drive": found.drive,
        "driven_together": list(found.together),
        "sensors": list(found.sensors),
        "axis": found.axis,
        "end": found.end,
        "lowest_frequency_Hz": float(found.frequency.min()),
        "highest_frequency_Hz": float(found.frequency.max()),
        "largest_amplitude_ratio": found.amplitude.max(axis=0).tolist(),
    }
    waves = SmallWaves(
        "transmission", state, found, summary, columns, files.tables_of_transmission(state, found)
    )
    return waves, waves.write(place, force=force, figures=figures)


def _finite(source: Assembly | Path, directions: str, *, damped: bool = False) -> State:
    if set(directions) - set("xyz"):
        raise InputError(
            f'--directions: found "{directions}", expected some of the letters x, y and z'
        )
    state = packing_state(source, damped=damped)
    if not directions:
        return state
    return dataclasses.replace(state, network=state.network.turned_off(directions))
