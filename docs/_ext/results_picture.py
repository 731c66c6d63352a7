"""Picture of all comparisons: the deviation of each stored value of ours from its reference, by
suite and kind.

The picture contains a digest of the points that it shows, so that a test detects an outdated
picture.
"""

from __future__ import annotations

import dataclasses
import hashlib
import io
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from PIL import Image
from results_rows import has_both_signs

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, style
from granwave.lammps_inputs.files import replace_bytes

KINDS = {
    "source": ("printed in a source", BLUE),
    "theory": ("theory", ORANGE),
    "verification": ("verification of the code", GREEN),
}
FAR = 0.3  # deviation from which on values are named below the picture
# ends of the axis
_LEAST = 1e-7
_MOST = 10.0
_TICKS = {1e-7: "≤ 10⁻⁵ %", 1e-5: "0.001 %", 1e-3: "0.1 %", 1e-2: "1 %", 1e-1: "10 %", 1.0: "100 %"}
_WIDTH = 7.6  # inches
# ends of the row of panels, as fractions of the width
_LEFT = 0.325
_RIGHT = 0.965
_ABSCISSA = (
    "relative difference from the reference (filled: granwave is larger; open: smaller; grey: "
    "above 10 %)"
)
_LABEL = 38  # characters in a line of the label of a study
_LINE_OF_MARKS = 5  # characters in a line of letters, which stay between two panels
_SPREAD = 0.62  # fraction of a suite's band that its points occupy
_DESCRIPTION = 0x010E  # ImageDescription of EXIF
_LETTERS = "abcdefghijklmnopqrstuvwxyz"


@dataclasses.dataclass(frozen=True)
class Far:
    """Values of a study whose deviation from their reference exceeds `FAR`.

    Attributes
    ----------
    mark
        Letter in the picture.
    deviations
        Their relative deviations; without quantities that have values on both sides of zero.
    differences
        Absolute differences of the other quantities.
    unit
        Unit of these differences; empty for numbers.
    number, total
        Number of these values, and of all values of this kind in the study.
    why
        Remark on the value with the largest deviation; the title of the study if there is no
        remark.
    """

    mark: str
    suite: str
    study: str
    title: str
    kind: str
    deviations: tuple[float, ...]
    differences: tuple[float, ...]
    unit: str
    number: int
    total: int
    why: str


def deviation(row: Mapping[str, Any]) -> float | None:
    """Return the ratio of our value to its reference, minus 1; None without a reference, or if it
    is only a bound.
    """
    against = reference_of(row)
    return (
        row["granwave"] / against - 1
        if against and row["granwave"] is not None and not row["bound"]
        else None
    )


def reference_of(row: Mapping[str, Any]) -> float | None:
    """Return the value of the source, or of theory if the row has no source."""
    against: float | None = row["theory"] if row["source"] is None else row["source"]
    return against


def absolute_difference(row: Mapping[str, Any]) -> float:
    """Return our value minus its reference, of a row that has both."""
    against = reference_of(row)
    assert against is not None
    return float(row["granwave"]) - against


def points(stored: Mapping[str, Any]) -> list[tuple[str, str, str, float]]:
    """Suite, study, kind and deviation of all values with a reference."""
    return [
        (suite, study, row["kind"], off)
        for suite, found in stored["suites"].items()
        for study, one in found["studies"].items()
        for row in one["rows"]
        if (off := deviation(row)) is not None
    ]


def printed_values(stored: Mapping[str, Any]) -> list[list[float]]:
    """Return the magnitudes of the deviations of each value that a source prints.

    Rows with the same place in a source, number and unit compare the same value.
    """
    found: dict[tuple[str, float, str], list[float]] = {}
    for suite in stored["suites"].values():
        for study in suite["studies"].values():
            for row in study["rows"]:
                off = deviation(row)
                if row["kind"] == "source" and off is not None:
                    place = row["where"], float(f"{row['source']:.9g}"), row["unit"]
                    found.setdefault(place, []).append(abs(off))
    return list(found.values())


def far_off(stored: Mapping[str, Any]) -> list[Far]:
    """Return the studies with large deviations, marked in the order of suites and kinds."""
    found = []
    for suite, content in stored["suites"].items():
        for study, one in content["studies"].items():
            for kind in KINDS:
                rows = [
                    (off, row)
                    for row in one["rows"]
                    if row["kind"] == kind and (off := deviation(row)) is not None
                ]
                out = [(off, row) for off, row in rows if abs(off) > FAR]
                if out:
                    offs = [off for off, row in out if not has_both_signs(row["quantity"])]
                    signed = [row for _, row in out if has_both_signs(row["quantity"])]
                    remarks = [
                        row["remark"] for _, row in sorted(out, key=lambda pair: -abs(pair[0]))
                    ]
                    why = next(filter(None, [*remarks, one["text"].partition(". ")[0]]), "")
                    far = (
                        suite,
                        study,
                        one["title"],
                        kind,
                        tuple(offs),
                        tuple(map(absolute_difference, signed)),
                        signed[0]["unit"] if signed else "",
                        len(out),
                        len(rows),
                        why,
                    )
                    found.append(Far(_mark(len(found)), *far))
    return found


def _mark(number: int) -> str:
    """Return a, b, ... z, aa, ab, ..."""
    first, last = divmod(number, len(_LETTERS))
    return (_LETTERS[first - 1] if first else "") + _LETTERS[last]


def digest(stored: Mapping[str, Any], labels: Mapping[str, str]) -> str:
    """Return a digest of the points of the picture."""
    shown = [
        (labels.get(suite, suite), study, kind, f"{off:.3e}")
        for suite, study, kind, off in points(stored)
    ]
    return hashlib.sha256(repr(shown).encode()).hexdigest()[:16]


def digest_of(path: Path) -> str:
    """Return the digest that a picture contains; empty if it contains none."""
    return str(Image.open(path).getexif().get(_DESCRIPTION, ""))


def by_study(suite: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the stored results of a suite, with each study as a separate suite, and their
    labels.
    """
    stored = {}
    labels = {}
    for name, study in suite["studies"].items():
        part = {"suites": {name: {"studies": {name: study}}}}
        if points(part):
            stored |= part["suites"]
            labels[name] = textwrap.shorten(study["title"], 2 * _LABEL, placeholder=" ...")
    return {"suites": stored}, {name: textwrap.fill(labels[name], _LABEL) for name in labels}


def draw(
    stored: Mapping[str, Any], labels: Mapping[str, str], path: Path, *, letters: bool = True
) -> None:
    """Draw the picture, as WebP or in the format given by the suffix of its name.

    There is a panel for each kind of reference that has values.

    Parameters
    ----------
    letters
        Mark values with large deviations by the letters of `far_off`.
    """
    shown = points(stored)
    suites = list(dict.fromkeys(suite for suite, *_ in shown))
    with_values = {kind for _, _, kind, _ in shown}
    kinds = [kind for kind in KINDS if kind in with_values]
    single = len(kinds) == 1
    below = 0.45 if single else 0.75  # inches, for the labels of the axes
    with style():
        height = 0.31 * len(suites) + 0.6 + below
        figure, rows = plt.subplots(
            1, len(kinds), figsize=(_WIDTH, height), sharey=True, squeeze=False
        )
        panels = rows[0]
        figure.subplots_adjust(
            left=_LEFT, right=_RIGHT, wspace=0.25, top=1 - 0.6 / height, bottom=below / height
        )
        for axes, kind in zip(panels, kinds, strict=True):
            _panel(axes, kind, suites, shown)
        panels[0].set_yticks(range(len(suites)), [labels.get(suite, suite) for suite in suites])
        if single:
            panels[0].set_xticks(list(_TICKS), list(_TICKS.values()), rotation=0, ha="center")
        if letters:
            _letters(panels, kinds, suites, far_off(stored))
        figure.text(0.5, 0.1 / height, _ABSCISSA, ha="center", fontsize=8)
        save(figure, path, digest(stored, labels))


def save(figure: Figure, path: Path, digest_shown: str) -> None:
    """Save a picture with the digest of the values that it shows, and close it."""
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=200)
    plt.close(figure)
    exif = Image.Exif()
    exif[_DESCRIPTION] = digest_shown
    file = io.BytesIO()
    Image.open(picture).convert("RGB").save(
        file, path.suffix[1:], quality=80, method=6, optimize=True, exif=exif
    )
    replace_bytes(path, file.getvalue())


def _panel(axes: Any, kind: str, suites: Sequence[str], shown: Sequence[Any]) -> None:
    """Draw the deviations of one kind, in a band for each suite."""
    axes.axvspan(0.1, _MOST * 2, color=GREY, alpha=0.10, lw=0)
    axes.axvline(0.01, color=GREY, lw=0.5, ls=":")
    for place, suite in enumerate(suites):
        own = [off for one, _, of, off in shown if (one, of) == (suite, kind)]
        _points(axes, place, own, KINDS[kind][1])
    total = [abs(off) for _, _, of, off in shown if of == kind]
    within_1 = sum(off <= 0.01 for off in total)
    within_10 = sum(off <= 0.1 for off in total)
    axes.set_title(
        f"{kind}, {len(total)} rows:\n{within_1} within 1 %,\n{within_10} within 10 %", loc="left"
    )
    axes.set(xscale="log", xlim=(_LEAST / 2, _MOST * 2), ylim=(len(suites) - 0.5, -0.5))
    axes.set_xticks(
        list(_TICKS), list(_TICKS.values()), rotation=45, ha="right", rotation_mode="anchor"
    )
    axes.minorticks_off()
    axes.tick_params(axis="y", length=0)
    for place in range(1, len(suites)):
        axes.axhline(place - 0.5, color=GREY, lw=0.3, alpha=0.5)


def _at(off: np.ndarray | float) -> Any:
    return np.clip(np.abs(off), _LEAST, _MOST * 1.3)


def _heights(place: int, number: int) -> np.ndarray:
    """Return vertical positions of the points of a suite such that they do not cover each other."""
    return place + (
        _SPREAD * (np.arange(number) / (number - 1) - 0.5) if number > 1 else np.zeros(number)
    )


def _points(axes: Any, place: int, offs: Sequence[float], colour: str) -> None:
    found = np.array(sorted(offs, key=abs))
    height = _heights(place, len(found))
    for above in (True, False):
        some = (found >= 0) == above
        face = colour if above else "white"
        axes.plot(
            _at(found[some]),
            height[some],
            "o",
            ms=2.6,
            mfc=face,
            mec=colour,
            mew=0.6,
            alpha=0.8,
            clip_on=False,
            lw=0,
        )


def _letters(panels: Any, kinds: Sequence[str], suites: Sequence[str], far: Sequence[Far]) -> None:
    """Write the letters of large deviations to the right of the points of each suite."""
    for axes, kind in zip(panels, kinds, strict=True):
        for place, suite in enumerate(suites):
            own = [one.mark for one in far if (one.suite, one.kind) == (suite, kind)]
            marks = textwrap.fill(" ".join(own), _LINE_OF_MARKS)
            axes.annotate(marks, (1, place), xycoords=("axes fraction", "data"), xytext=(3, 0),
                          textcoords="offset points", va="center", fontsize=7, linespacing=1.0,
                          annotation_clip=False)  # fmt: skip
