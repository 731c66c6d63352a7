"""Contact laws and other settings of the model that differ between runs of a comparison.

A result that depends on the model of one packing is no property of the packing, so that it does not
rank the runs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from granwave.analysis.document.model import named
from granwave.analysis.reports.comparison.ends import changes_results
from granwave.analysis.reports.comparison.subjects import ComparedRun, joined_texts, value_text
from granwave.analysis.reports.setting import differing
from granwave.lammps_inputs.case.contact.law_parameters import PARAMETERS

_LAW = "contact.law"
_PAIRS = "pair"  # tables of laws between two materials
_CONTACT = "contact."
_NUMERICS = "run."
_FORGET_GAP = "boundary.forget_gap"
#: Keys of the contact that choose a model, with their names in a sentence; other keys, such as the
#: friction, are properties of the packing.
_CHOICES = {
    _LAW: "contact law",
    "contact.variant": "variant of the contact law",
    "contact.line": "law of line contacts",
    "contact.tangential": "tangential model",
    "contact.normals": "direction of the contact forces",
    _PAIRS: "contact law between the materials",
}
_SETTINGS = {
    "contact.yield_factor": "yield factor of the contact law",
    "contact.beta": "constant beta of the contact law",
    "contact.loss": "viscous damping of contacts",
    _FORGET_GAP: "gap beyond which indentations are forgotten",
    "run.timestep": "timestep",
}
_OF_PAIR = ("law", "variant", "line", "tangential", "normals", "loss", *PARAMETERS)
_LEAST_RUNS = 2
_MOST_LISTED = 4  # runs whose values a sentence lists
_MOST_NAMED = 2  # settings that a sentence names


def model_dependence(runs: Sequence[ComparedRun]) -> str:
    """Return the settings of the model in which runs of one packing differ, with their values:
    ``the contact law (hertz in a, elastoplastic in b)``; empty if anything else differs, or
    nothing.
    """
    keys = _differing_keys(runs)
    if not keys or not all(_is_of_model(key, runs) for key in keys):
        return ""
    return _in_words(keys, runs)


def caveat_on_model(runs: Sequence[ComparedRun]) -> str:
    """Return a sentence on the contact laws of different packings that were computed with different
    laws; empty for one law, and if only the model differs.
    """
    keys = [key for key in _differing_keys(runs) if key in _CHOICES and _is_of_model(key, runs)]
    if not keys or model_dependence(runs):
        return ""
    return (
        f"The runs also differ in {_in_words(keys, runs)}, which may change the order: compare the "
        "packings with one model."
    )


def _differing_keys(runs: Sequence[ComparedRun]) -> list[str]:
    """Return the keys that differ and change results; none if a case or a kind is unlike."""
    reports = [run.run for run in runs]
    if len(runs) < _LEAST_RUNS or not all(run.case for run in reports):
        return []
    if len({run.kind for run in reports}) > 1:
        return []
    return [key for key in differing(reports) if changes_results(key)]


def _is_of_model(key: str, runs: Sequence[ComparedRun]) -> bool:
    """Return True for a key of the contact law, of damping, or of the numerical method."""
    if key == _PAIRS:
        pairs = [_without_model(run.run.case.get(key) or ()) for run in runs]
        return all(own == pairs[0] for own in pairs)
    is_parameter = key.startswith(_CONTACT) and key.removeprefix(_CONTACT) in PARAMETERS
    return is_parameter or key in _CHOICES or key in _SETTINGS or key.startswith(_NUMERICS)


def _without_model(pairs: Sequence[Any]) -> list[dict[str, Any]]:
    """Return the tables of laws between two materials without the keys of the laws."""
    tables: list[dict[str, Any]] = []
    for pair in pairs:
        if isinstance(pair, Mapping):
            tables.append({key: value for key, value in pair.items() if key not in _OF_PAIR})
    return tables


def _in_words(keys: Sequence[str], runs: Sequence[ComparedRun]) -> str:
    """Return settings with their values by run; a choice of a law before its constants."""
    first = [key for key in _CHOICES if key in keys]
    ordered = [*first, *(key for key in keys if key not in first)]
    if _LAW in ordered:  # its constants follow from it
        ordered = [key for key in ordered if key.removeprefix(_CONTACT) not in PARAMETERS]
    texts = [_setting_in_words(key, runs) for key in ordered]
    return " and ".join(texts) if len(texts) <= _MOST_NAMED else named(texts, _MOST_NAMED)


def _setting_in_words(key: str, runs: Sequence[ComparedRun]) -> str:
    """Return a setting, with its value in each of a few runs."""
    name = f"the {(_CHOICES | _SETTINGS)[key]}" if key in _CHOICES | _SETTINGS else key
    if len(runs) > _MOST_LISTED or key == _PAIRS:
        return name
    texts = [(run.name, value_text(key, run.run.case)) for run in runs]
    return f"{name} ({joined_texts(texts, 'in')})"
