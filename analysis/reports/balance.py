"""Section on the energy balance of all runs, contacts beyond the range of the law, and zones that a boundary cuts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from granwave.analysis.document.cells import named, value_cell, value_column
from granwave.analysis.document.model import Cell, Column, Group, Note, Section, Table, Tone
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.measures.zone_size import NOTED_SHARE, Mark, bounds_in_words, mark_of
from granwave.analysis.reports.inputs import Inputs, Run
from granwave.lammps_inputs.case.contact import ALL_LAWS, LINE

_BEYOND_SMALL = "overlaps of 0.2 R*, which are no longer small against the grains, as the law takes them"
SLUG = "balance"
MOST_OPEN = 12  # runs whose table is not folded
#: Largest accepted error of the balance over the input, by kind of run.
LIMITS = {"run": 1e-5, "continuum": 2e-2}
_PARTS = ("kinetic", "elastic", "dissipated", "punch", "viscous", "hourglass")
#: Parts of these, shown if any run has them.
_SHARES = ("energy_rotational_J", "energy_dissipated_friction_J", "energy_dissipated_rolling_J",
           "energy_dissipated_twisting_J", "energy_dissipated_adhesion_J", "energy_dissipated_viscous_J",
           "energy_dissipated_holder_J", "energy_absorbed_J", "support_energy_J", "support_lost_J")  # fmt: skip


def verdict(run: Run) -> tuple[str, Tone]:
    """Assess the energy balance of a run."""
    error = run.number("energy_balance_error")
    largest = LIMITS[run.kind]
    if error is None:
        return "not known", "note"
    if math.isnan(error) or error > largest:
        return f"poor: above {plain(f'{largest:.0e}')}", "bad"
    return "good", "good"


def balance_section(inputs: Inputs) -> Section:
    """Make the section of the report."""
    runs = [run for run in inputs.results() if run.has_balance]
    if not runs:
        nothing = () if any(inputs.results()) else (Note("There is no finished run."),)
        return Section("Energy balance", SLUG, nothing)
    text = "Error: the largest |kinetic + elastic + dissipated - input| of the ledger, over the input."
    limits = {
        "run": "Kinetic includes rotation; elastic what is stored tangentially and in the support; dissipated "
        "friction, viscous losses, the support's damper and absorbing spheres. A granular run above 1e-5 is refused "
        "(the published variant of the law, which cannot close, excepted).",
        "continuum": "A continuum run above 2 % is stopped.",
    }
    text = " ".join([text, *(limits[kind] for kind in LIMITS if any(run.kind == kind for run in runs))])
    table = _table(runs)
    shown = Group("Energies of all runs", (table,), folded=True) if len(runs) > MOST_OPEN else table
    return Section("Energy balance", SLUG, (Note(text), shown))


def balance_notes(runs: Sequence[Run], section: str = "") -> list[Note]:
    """Return warnings about poor balances and contacts beyond the law, for the top of the report."""
    notes = []
    for kind, largest in LIMITS.items():
        poor = [run for run in runs if run.kind == kind and verdict(run)[1] == "bad"]
        if poor:
            text = f"Poor energy balance, do not trust ({_errors(poor)}, more than {_share(largest)}): {_labels(poor)}."
            notes.append(Note(text, "bad", section))
    unknown = [run for run in runs if verdict(run)[0] == "not known"]
    still = [run for run in unknown if run.number("energy_input_J") == 0]
    for found, text in (
        (still, "No energy came in before the end"),
        ([run for run in unknown if run not in still], "No energy balance is recorded"),
    ):
        if found:
            notes.append(Note(f"{text}: {_labels(found)}.", "note", section))
    beyond = [run for run in runs if (run.number("contacts_beyond_law") or 0) > 0]
    for fitted, text in ((True, "the law, which was fitted up to an overlap of 0.2 R*"), (False, _BEYOND_SMALL)):
        counts = [f"{run.label} ({run.number('contacts_beyond_law'):.0f})" for run in beyond if _fitted(run) == fitted]
        if counts:
            notes.append(Note(f"Contacts beyond {text}: {named(counts)}.", "note", section))
    return notes


def _fitted(run: Run) -> bool:
    """Return True if the law of a run was fitted to finite elements, or is not known."""
    law = run.case.get("contact.law", "elastoplastic")
    return law != LINE and (law not in ALL_LAWS or bool(ALL_LAWS[law].fitted))


def _errors(runs: Sequence[Run]) -> str:
    """Describe the errors of the balances of runs, with a note on those that are not a number."""
    errors = [run.number("energy_balance_error") or 0.0 for run in runs]
    finite = [error for error in errors if math.isfinite(error)]
    if not finite:
        return "the error is not a number"
    up_to = "up to " if len(finite) > 1 else ""
    return f"off by {up_to}{_share(max(finite))} of the input" + (", or not a number" * (len(finite) < len(errors)))


def _share(value: float) -> str:
    """Format a share with two digits, in per cent from 0.1 % on."""
    return f"{100 * value:.2g} %" if value >= 1e-3 else plain(f"{value:.2g}")


def _labels(runs: Sequence[Run]) -> str:
    return named([run.label for run in runs])


def _table(runs: Sequence[Run]) -> Table:
    parts = [f"energy_{part}_J" for part in _PARTS]
    shown = [key for key in ("energy_input_J", *parts) if any(run.summary.get(key) is not None for run in runs)]
    shown += [key for key in _SHARES if any(run.summary.get(key) for run in runs)]
    beyond = any(run.summary.get("contacts_beyond_law") is not None for run in runs)
    columns = [
        Column("Run", key=True),
        *(value_column(key) for key in shown),
        Column("Error over input", numeric=True),
        Column("Balance"),
        Column("Timestep", "s", numeric=True),
        Column("Timesteps dropped", numeric=True),
    ]
    if beyond:
        columns.append(Column("Contacts beyond the law", numeric=True))
    rows = []
    for run in runs:
        text, tone = verdict(run)
        dropped = run.record.get("attempts")
        row = [
            Cell(run.label, run.label),
            *(value_cell(run.summary.get(key)) for key in shown),
            value_cell(run.summary.get("energy_balance_error"), tone=tone if tone == "bad" else ""),
            Cell(text, text, tone),
            value_cell(run.summary.get("timestep_s")),
            value_cell(len(dropped) if isinstance(dropped, list) else None),
        ]
        if beyond:
            count = run.summary.get("contacts_beyond_law")
            row.append(value_cell(count, tone="note" if (run.number("contacts_beyond_law") or 0) > 0 else ""))
        rows.append(tuple(row))
    return Table("Energies at the end, and the error of the balance", tuple(columns), tuple(rows), sortable=True)


def zone_notes(runs: Sequence[Run], section: str = "") -> list[Note]:
    """Return notes on runs whose zone reaches a boundary, and on runs in which a wave returned from one.

    Parameters
    ----------
    section
        Name of the section with details.
    """
    notes = []
    cut = _with_bounds(_marked(runs, Mark.CUT))
    if cut:
        text = "The plastic zone reaches a bound, which cuts its outermost depth or radius, and may change what holds "
        notes.append(Note(f"{text}99 % of its energy: {cut}.", "note", section))
    waves = [f"{run.label} ({100 * run.summary['wave_return_share']:.2g} %)" for run in _marked(runs, Mark.WAVE)]
    if waves:
        text = f"More than {100 * NOTED_SHARE:g} % of the energy of yielding was dissipated after a wave could be back "
        notes.append(Note(f"{text}from a bound: {named(waves)}.", "note", section))
    return notes


def _with_bounds(runs: Sequence[Run]) -> str:
    """Name runs with the bounds that their zones reach; those that all reach only once."""
    labels, bounds = [run.label for run in runs], [bounds_in_words(run.summary["zone_cut"]) for run in runs]
    if len(runs) > 1 and len(set(bounds)) == 1:
        return f"{named(labels)} (all: {bounds[0]})"
    return named([f"{label} ({one})" for label, one in zip(labels, bounds, strict=True)])


def _marked(runs: Sequence[Run], mark: Mark) -> list[Run]:
    return [run for run in runs if mark_of(run.summary) is mark]
