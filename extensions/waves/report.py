"""Texts, tables and figures of bands, modes and transmission in a report."""

from __future__ import annotations

import h5py
import numpy as np

from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.reports.kinds import ReportKind, ReportRun, by_key
from granwave.analysis.reports.sentences import printed, sentences
from granwave.analysis.reports.setting import setting_of
from granwave.analysis.result.not_a_run import no_results
from granwave.extensions.waves.files import SPECTRA, SPECTRA_FILE, spectra_in
from granwave.extensions.waves.spectra.files import recorded
from granwave.extensions.waves.spectra.quantities import OF_BANDS, OF_MODES, OF_TRANSMISSION
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json, regular
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import SCAN_INDEX, SUMMARY_FILE

BANDS = "bands"
MODES = "modes"
TRANSMISSION = "transmission"

_PASSES = 0.5  # fraction of the driven grain's amplitude that counts as transmitted
_MOST_STRETCHES = 3  # most ranges of frequency in a sentence
_KEYS = (
    "highest_frequency_Hz",
    "lowest_frequency_Hz",
    "widest_gap_Hz",
    "widest_gap_relative",
    "attenuation_in_widest_gap",
    "attenuation_spacing_m",
    "speeds_m_s",
    "largest_amplitude_ratio",
    "least_participation_ratio",
    "static_force_N",
    "contact_stiffness_N_per_m",
    "unit_frequency_Hz",
    "n_grains_in_cell",
    "n_grains",
    "n_left_out",
    "n_contacts_in_cell",
    "n_contacts",
    "n_bands",
    "n_modes",
    "n_floppy",
)
_IN_PER_CENT = ("widest_gap_relative",)
_TITLES = {BANDS: "Bands", MODES: "Modes", TRANSMISSION: "Transmission"}
_OF_A_LOAD = ("load.", "striker")  # keys of the case without effect
_SENTENCES = {  # sentences that are shown if all their values are present
    BANDS: (
        "No wave passes at {widest_gap_Hz}, the widest gap ({widest_gap_relative} of its centre).",
        "No wave passes below {lowest_edge_Hz}.",
        "No wave passes above {highest_edge_Hz}.",
        "The speed of long waves is {speeds_m_s}.",
    ),
    MODES: (
        "{n_modes} modes from {lowest_frequency_Hz} on.",
        "The highest frequency is {highest_frequency_Hz}.",
        "The smallest participation ratio is {least_participation_ratio}.",
    ),
}
_NO_GAP = "There is no gap between the bands."
_LABELS = {entry.name: entry.label for entry in (*OF_BANDS, *OF_MODES, *OF_TRANSMISSION)}
_FIGURES = {
    BANDS: ("bands", "group_velocity", "slowness", "equal_frequency", "mode_shapes"),
    MODES: ("density_of_states", "participation"),
    TRANSMISSION: ("transmission",),
}
_CAPTIONS = {
    "bands": "Band diagram: frequency against wave vector",
    "group_velocity": "Group velocity against frequency",
    "slowness": "Slowness of long waves against direction in a plane",
    "equal_frequency": "Lines of equal frequency in a plane of wave vectors",
    "mode_shapes": "Displacements of the modes at the end of the first segment of the path",
    "density_of_states": "Density of states",
    "participation": "Participation ratio against frequency",
}
_LOOKS = {
    "bands": "Grey stretches are gaps, in which no wave passes; the slope at the origin is the "
    "speed of long waves. Right: attenuation from plane to plane, where it is known.",
    "group_velocity": "Speed of energy transport at each frequency; it vanishes at band edges.",
    "slowness": "A larger radius means a slower wave in this direction; a circle is an isotropic "
    "speed.",
    "equal_frequency": "Energy travels perpendicular to the lines: where they are straight, a "
    "wave does not spread.",
    "mode_shapes": "Bars are the grains of one cell; grains without a bar are at rest.",
    "density_of_states": "Empty intervals are gaps.",
    "participation": "Near 1 all grains have similar amplitudes; low values are modes of few "
    "grains.",
}
_TABLES = {BANDS: OF_BANDS, MODES: OF_MODES, TRANSMISSION: OF_TRANSMISSION}


class SpectraKind(ReportKind):
    """Bands, modes and transmission of small waves, which may all be in one directory."""

    result_kind = SPECTRA
    noun = "small waves"
    has_balance = False
    main_figures = ("bands", "density_of_states", "transmission")
    captions = _CAPTIONS
    looks = _LOOKS
    table_keys = _KEYS
    in_per_cent = _IN_PER_CENT
    tables = _TABLES

    def read(self, results: ResultDirectory, label: str) -> list[ReportRun]:
        """Read the bands, modes and transmission of a directory."""
        path = results.path
        names = spectra_in(path)
        if not names:
            found = sorted(entry.name for entry in path.iterdir())
            expected = f"expected {SUMMARY_FILE} or {SCAN_INDEX} in it"
            raise InputError(no_results(path, found, "neither a run nor a scan", expected))
        several = len(names) > 1
        return [
            self._read_one(results, f"{label} ({name})" if several else label, name)
            for name in names
        ]

    def _read_one(self, results: ResultDirectory, label: str, name: str) -> ReportRun:
        """Read the results of one command; case and versions are read from spectra.h5."""
        path = results.path
        tables, versions = recorded(path)
        values = read_json(path / f"{name}.json")
        if values is None:
            raise InputError(
                f"{path / f'{name}.json'}: cannot be read; recreate it with  "
                f"granwave {name} CASE -o {path} --force"
            )
        summary = {**values, "kind": name, "versions": versions}
        return ReportRun(label, self, results, "done", summary, by_key(tables), {})

    def part(self, run: ReportRun) -> str:
        """Return the command: bands, modes or transmission."""
        return str(run.summary["kind"])

    def setting(self, run: ReportRun) -> str:
        """Return the packing and its static load."""
        case = {key: value for key, value in run.case.items() if not key.startswith(_OF_A_LOAD)}
        return setting_of(case, grains_called_in([run.summary]))

    def title(self, run: ReportRun) -> str:
        """Return the title of a table."""
        return _TITLES[self.part(run)]

    def label(self, run: ReportRun, key: str) -> str:
        """Return the label of a value of the summary."""
        return _LABELS.get(key, "")

    def figures_of_others(self, run: ReportRun) -> set[str]:
        """Return the names of the figures of the other commands."""
        others: set[str] = set()
        for part, names in _FIGURES.items():
            if part != self.part(run):
                others.update(names)
        return others

    def in_words(self, run: ReportRun) -> str:
        """Return the results."""
        if self.part(run) == TRANSMISSION:
            return _transmission_in_words(run)
        if self.part(run) == MODES:
            return sentences(_SENTENCES[MODES], printed(run.summary, _IN_PER_CENT))
        text = sentences(_SENTENCES[BANDS], printed(_with_edges(run), _IN_PER_CENT))
        return text if run.summary.get("widest_gap_Hz") else f"{_NO_GAP} {text}"


def _with_edges(run: ReportRun) -> dict[str, object]:
    """Return the summary of bands with the edges of the pass bands; None if not known."""
    edges = run.summary.get("band_edges_Hz") or []
    lowest = [edge[0] for edge in edges if edge and edge[0] is not None]
    complete = (run.number("n_bands") or 0) >= (run.number("n_freedoms") or 0)
    return {
        **run.summary,
        "lowest_edge_Hz": min(lowest, default=0.0) or None,
        "highest_edge_Hz": run.summary.get("highest_frequency_Hz") if complete else None,
    }


def _transmission_in_words(run: ReportRun) -> str:
    """Return the frequencies at which at least half of the motion of the drive is transmitted."""
    try:
        with h5py.File(regular(run.directory / SPECTRA_FILE), "r") as file:
            names = ("frequency", "amplitude_ratio", "sensor")
            frequency, ratio, sensors = (file[f"{TRANSMISSION}/{name}"][()] for name in names)
    except (OSError, KeyError):
        return ""
    parts = []
    for sensor, amplitude in zip(sensors, ratio.T, strict=True):
        passes = np.concatenate([[False], amplitude >= _PASSES, [False]]).astype(int)
        edges = np.flatnonzero(np.diff(passes)).reshape(-1, 2)
        stretches = [
            f"{1e-3 * frequency[start]:.4g} to {1e-3 * frequency[stop - 1]:.4g}"
            for start, stop in edges
        ]
        more = " and elsewhere" if len(stretches) > _MOST_STRETCHES else ""
        where = f"at {', '.join(stretches[:_MOST_STRETCHES])} kHz{more}" if stretches else "nowhere"
        peak = int(np.argmax(amplitude))
        parts.append(
            f"Grain {sensor} moves at least half as much as grain {run.summary.get('drive')} "
            f"{where}, at most {amplitude[peak]:.4g} times at {1e-3 * frequency[peak]:.4g} kHz."
        )
    return " ".join(parts)


REPORT_KINDS = (SpectraKind(),)
