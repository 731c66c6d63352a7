"""Values that a version of granwave defined anew, so that earlier and later results differ."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from granwave.analysis.reports.comparison.subjects import ComparedRun, names_in_words

_PROGRAM = "granwave"
_NUMBERS = 2  # of a version, its major and minor number, that decide


@dataclass(frozen=True)
class Redefinition:
    """New definition of a value.

    Attributes
    ----------
    name
        Key of the value in summary.json.
    of_spheres
        True if it concerns runs of spheres, False if it concerns blocks.
    since
        First version with the new definition: major and minor number.
    words
        Subject of a sentence, and what the value refers to before and since this version.
    """

    name: str
    of_spheres: bool
    since: tuple[int, ...]
    words: tuple[str, str, str]

    def is_mixed(self, runs: Sequence[ComparedRun]) -> bool:
        """Return True if runs with the value have both definitions."""
        earlier = self.earlier(runs)
        return bool(earlier) and len(earlier) < len(self._runs_with_value(runs))

    def earlier(self, runs: Sequence[ComparedRun]) -> list[ComparedRun]:
        """Return the runs whose value has the earlier definition."""
        return [run for run in self._runs_with_value(runs) if _version(run) < self.since]

    def note(self, runs: Sequence[ComparedRun]) -> str:
        """Return a sentence on both definitions, with the runs of the earlier one."""
        subject, before, now = self.words
        number = ".".join(map(str, self.since))
        listed = names_in_words([run.name for run in self.earlier(runs)])
        return (
            f"{subject} in results before version {number} ({listed}) refers to {before}, and in "
            f"later results to {now}, so that it is not compared. Run the earlier cases again."
        )

    def _runs_with_value(self, runs: Sequence[ComparedRun]) -> list[ComparedRun]:
        """Return the runs that have the value and state the version that computed it."""
        return [
            run
            for run in runs
            if run.has_spheres is self.of_spheres
            and run.run.number(self.name) is not None
            and _version(run)
        ]


REDEFINITIONS = (
    Redefinition(
        "wave_speed_m_s",
        of_spheres=True,
        since=(1, 1),
        words=("The wave speed", "first contact", "10 % of the force of the wave"),
    ),
    Redefinition(
        "peak_force_N",
        of_spheres=False,
        since=(1, 1),
        words=(
            "The peak force on a block",
            "single steps",
            "means between records, which depend less on the mesh",
        ),
    ),
)


def redefined_names(runs: Sequence[ComparedRun]) -> set[str]:
    """Return the names of values of which these runs have both definitions."""
    return {one.name for one in REDEFINITIONS if one.is_mixed(runs)}


def redefinition_notes(runs: Sequence[ComparedRun], names: Collection[str] = ()) -> list[str]:
    """Return a sentence on each value of which these runs have both definitions.

    Parameters
    ----------
    names
        Values that are compared, which limit the sentences; empty for all.
    """
    concerned = [one for one in REDEFINITIONS if not names or one.name in names]
    return [one.note(runs) for one in concerned if one.is_mixed(runs)]


def _version(run: ComparedRun) -> tuple[int, ...]:
    """Return the major and minor number of the version of a run; empty if they are not known."""
    numbers = run.run.versions.get(_PROGRAM, "").split(".")[:_NUMBERS]
    return tuple(map(int, numbers)) if all(map(str.isdecimal, numbers)) else ()
