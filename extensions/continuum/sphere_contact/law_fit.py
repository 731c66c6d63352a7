"""Constants of the law ``elastoplastic-fe`` from ``law_table.csv``, by least squares; errors and
error bars of the law.

    python -m granwave.extensions.continuum.sphere_contact.law_fit [HEADER] [PICTURE] [PAGE ...]

prints the largest errors. With HEADER (elastoplastic_fe_constants.h of the plugin) it first fits
the constants, starting from the present ones, and writes the header with the error bars. With
PICTURE it draws the errors of this law and of the default law. In each PAGE (Markdown) it updates
the tables of errors and error bars. Two equal spheres at large depth are equivalent to one sphere
on a rigid flat, and the law has the same symmetry.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Mapping
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import least_squares

from granwave._contact_laws import ContactLaw
from granwave.extensions.continuum.sphere_contact.law_table import TABLE, contacts

Array = NDArray[np.float64]

LAW = "elastoplastic-fe"
_DEEPEST = 0.2  # largest overlap of the fit over R*; beyond it the law is a straight line
_PLACES = np.linspace(0, 1, 40)  # positions on an unloading from the residual overlap to the peak
_FIRST = 6.0  # first unloading / first yield below which it shows the onset of dissipation
_BETWEEN = np.array([0.1, 0.25, 0.5, 0.75])  # positions from yield to the first unloading
_POWERS = (2, 4, 6, 8)  # powers of the errors whose sums are minimised in turn
_ERROR = 0.02  # relative error that counts as 1 in these sums
_QUADRATURE = 400  # points of the work of loading
_RANGES = ("1-10", "10-100", "100-inf")  # ranges of the overlap relative to first yield
_OTHER = "elastoplastic"
_KINDS = {
    "equal": "equal spheres", "rigid": "sphere on a rigid flat", "radii": "other radii",
    "unlike": "dissimilar materials", "held": "excluded from the fit",
}  # fmt: skip
_MARGIN = 1.5  # error bars divided by the largest error of fitted contacts
_ROUNDED = 0.001  # digits of error bars
_FROM = (1.0, 10.0, 100.0)  # lower ends of the ranges of error bars, overlap over first yield
_BARS = re.compile(r"(constexpr FeBar FE_BARS.*?\{\n).*?(^\};$)", re.MULTILINE | re.DOTALL)
_CONSTANT = re.compile(r"^  double (\w+) = (.*);$", re.MULTILINE)


class Measured:
    """A contact of the table: points of loading and unloadings in units of R* and E* R*^2."""

    def __init__(self, name: str, values: Mapping[str, float], rows: pd.DataFrame) -> None:
        self.name = name
        self.held = name.startswith("held")
        self.mirrored = not values.keys() & {"radius", "modulus", "strength", "nu2"}
        rigid = "deepest" in values
        nu = values["nu"]
        hardening = values["hardening"]
        radius = math.inf
        modulus = math.inf
        strength = math.inf
        if not rigid:
            radius = values.get("radius", 1.0)
            modulus = values.get("modulus", 1.0)
            strength = values.get("strength", 1.0)
        self.bodies = {
            "youngs_modulus": (1.0, modulus),
            "poisson_ratio": (nu, 0.0 if rigid else values.get("nu2", nu)),
            "yield_strength": (1 / values["ratio"], strength / values["ratio"]),
            "radius": (1.0, radius),
            "hardening": (hardening, 0.0 if math.isinf(strength) else hardening),
        }
        law = self.law(LAW)
        size = law.effective_radius
        length = size
        force = law.effective_modulus * size**2
        if rigid:
            length = size / 4
            force = force / 8
        rows = rows.assign(
            overlap=rows["overlap"] * length,
            residual=rows["residual"] * length,
            force=rows["force"] * force,
        )
        rows = rows[rows["overlap"] <= _DEEPEST * size]
        self.start = law.yield_overlap
        loading = rows[(rows["branch"] == "loading") & (rows["overlap"] > self.start)]
        self.overlap = loading["overlap"].to_numpy()
        self.force = loading["force"].to_numpy()
        unloading = rows[rows["branch"] == "unloading"]
        self.peak = unloading["overlap"].to_numpy()
        self.peak_force = unloading["force"].to_numpy()
        self.residual = unloading["residual"].to_numpy()
        self.exponent = unloading["exponent"].to_numpy()

    def law(self, name: str, constants: Mapping[str, float] | None = None) -> ContactLaw:
        """Return a law for this contact; a law without hardening ignores it."""
        return ContactLaw(law=name, fit=dict(constants or {}), **self.bodies)

    def loading_errors(self, law: ContactLaw) -> Array:
        """Return the errors of the force on loading relative to finite elements."""
        return np.asarray(law.loading_force(self.overlap) / self.force - 1)

    def unloading_errors(self, law: ContactLaw) -> Array:
        """Return the errors of the force on unloading, divided by the peak force, at `_PLACES`:
        (n_unloadings, n_places).
        """
        overlap = self.residual[:, None] + (self.peak - self.residual)[:, None] * _PLACES
        residual = law.residual_overlap(self.peak)[:, None]
        place = np.clip((overlap - residual) / (self.peak[:, None] - residual), 0, None)
        share = place ** law.unloading_exponent(self.peak)[:, None]
        return np.asarray(share - _PLACES ** self.exponent[:, None])

    def near_yield(self, law: ContactLaw) -> Array:
        """Return the deviation of the dissipated fraction from a straight line between yield and
        the first unloading.
        """
        peak = self.peak[0]
        first = self.peak[0] / self.start
        if first > _FIRST:
            return np.zeros(0)
        back = law.loading_force(peak) * (peak - self.residual[0]) / (self.exponent[0] + 1)
        at = peak - (1 - _BETWEEN) * (peak - self.start)
        straight = _BETWEEN * (1 - back / law.loading_work(peak))
        return np.asarray(law.dissipated_energy(at) / law.loading_work(at) - straight)

    @cached_property
    def restitution(self) -> Array:
        """Coefficients of restitution from finite elements, for each peak: (n_unloadings,)."""
        law = self.law("hertz")
        at = np.geomspace(self.start, self.peak.max(initial=self.start), _QUADRATURE)
        hertz = law.loading_force(at)
        places = np.log(np.concatenate([[self.start], self.overlap]))
        ratio = np.concatenate([[1.0], self.force / law.loading_force(self.overlap)])
        force = hertz * np.exp(np.interp(np.log(at), places, np.log(ratio)))
        work = law.loading_work(self.start) + cumulative_trapezoid(force, at, initial=0)
        recovered = self.peak_force * (self.peak - self.residual) / (self.exponent + 1)
        return np.asarray(np.sqrt(recovered / np.interp(self.peak, at, work)))

    def restitution_errors(self, law: ContactLaw) -> Array:
        """Return the errors of the coefficient of restitution relative to finite elements."""
        lost = law.dissipated_energy(self.peak) / law.loading_work(self.peak)
        return np.asarray(np.sqrt(np.clip(1 - lost, 0, 1)) / self.restitution - 1)


def measured() -> list[Measured]:
    """Return the contacts of the table."""
    table = pd.read_csv(TABLE)
    return [
        Measured(name, values, table[table["contact"] == name])
        for name, values in contacts().items()
    ]


def fit(contacts: list[Measured], start: Mapping[str, float]) -> dict[str, float]:
    """Return the constants of the law by names such as r1 and n1: loading is fitted first, then
    unloading.
    """
    used = [contact for contact in contacts if not contact.held]
    of_unloading = [name for name in start if name[0] in "rn" and name[1:].isdigit()]
    of_loading = [name for name in start if name not in of_unloading]
    constants = dict(start)
    for power in _POWERS:
        _improve(constants, of_loading, used, _errors_on_loading, power)
    for power in _POWERS[:3]:
        _improve(constants, of_unloading, used, _errors_on_unloading, power)
    return constants


def _improve(
    constants: dict[str, float],
    names: list[str],
    contacts: list[Measured],
    errors_of: Callable[[Measured, ContactLaw], list[Array]],
    power: int,
) -> None:
    """Fit some of the constants in place; minimise the sum of this power of the errors."""

    def errors(x: Array) -> Array:
        trial = constants | dict(zip(names, map(float, x), strict=True))
        parts: list[Array] = []
        for contact in contacts:
            parts += errors_of(contact, contact.law(LAW, trial))
        scaled = np.nan_to_num(np.concatenate(parts) / _ERROR, nan=1e3)
        return np.asarray(np.sign(scaled) * np.abs(scaled) ** (power / 2))

    x = np.array([constants[name] for name in names])
    solved = least_squares(errors, x, x_scale=np.maximum(np.abs(x), 0.05), max_nfev=40)
    constants.update(zip(names, map(float, solved.x), strict=True))


def _errors_on_loading(contact: Measured, law: ContactLaw) -> list[Array]:
    return [contact.loading_errors(law)]


def _errors_on_unloading(contact: Measured, law: ContactLaw) -> list[Array]:
    return [
        contact.unloading_errors(law)[:, ::3].ravel(),
        2 * contact.near_yield(law),
        2 * contact.restitution_errors(law),
    ]


def errors(
    contacts: list[Measured], name: str = LAW, constants: Mapping[str, float] | None = None
) -> pd.DataFrame:
    """Return the largest errors of loading by range of the overlap, of unloading, and of the
    coefficient of restitution, for each kind of contact, per cent.

    ``within_3`` is the percentage of points of loading with errors up to 3 %, ``within_5`` the
    percentage of unloadings with errors up to 5 %.
    """
    rows = []
    for kind in dict.fromkeys(contact.name.partition("_")[0] for contact in contacts):
        chosen = [contact for contact in contacts if contact.name.startswith(kind)]
        laws = [contact.law(name, constants) for contact in chosen]
        pairs = list(zip(chosen, laws, strict=True))
        scaled = np.concatenate([contact.overlap / contact.start for contact in chosen])
        loading = np.abs(np.concatenate([c.loading_errors(law) for c, law in pairs]))
        unloading = np.concatenate(
            [np.abs(contact.unloading_errors(law)).max(axis=1) for contact, law in pairs]
        )
        restitution = np.abs(np.concatenate([c.restitution_errors(law) for c, law in pairs]))
        row: dict[str, Any] = {"contacts": kind}
        for label, (low, high) in zip(_RANGES, pairwise((*_FROM, math.inf)), strict=True):
            row[label] = 100 * loading[(scaled > low) & (scaled <= high)].max()
        row["within_3"] = 100 * (loading <= 0.03).mean()
        row["unloading"] = 100 * unloading.max()
        row["within_5"] = 100 * (unloading <= 0.05).mean()
        row["restitution"] = 100 * restitution.max()
        rows.append(row)
    return pd.DataFrame(rows).set_index("contacts")


def bars(contacts: list[Measured], constants: Mapping[str, float] | None = None) -> pd.DataFrame:
    """Return the error bars: `_MARGIN` times the largest error of fitted contacts, by kind and
    range of the overlap relative to first yield.

    Held-out contacts test the error bars; the margin is for contacts between the fitted ones.
    """
    rows = []
    for kind, mirrored in (("equal spheres, sphere on a rigid flat", True), ("others", False)):
        chosen = [
            contact for contact in contacts if contact.mirrored == mirrored and not contact.held
        ]
        for low, high in pairwise((*_FROM, math.inf)):
            largest = largest_errors(chosen, low, high, constants)
            row: dict[str, Any] = {"contacts": kind, "from": low}
            for name, value in largest.items():
                row[name] = math.ceil(_MARGIN * value / _ROUNDED) * _ROUNDED
            rows.append(row)
    return pd.DataFrame(rows)


def largest_errors(
    chosen: list[Measured], low: float, high: float, constants: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return the largest relative errors of force, unloading and restitution of contacts, for
    overlaps and peaks in a range relative to first yield.
    """
    parts: dict[str, list[Array]] = {"force": [], "unloading": [], "restitution": []}
    for contact in chosen:
        law = contact.law(LAW, constants)
        at = contact.overlap / contact.start
        peak = contact.peak / contact.start
        loads = (at >= low) & (at < high)
        turns = (peak >= low) & (peak < high)
        parts["force"].append(contact.loading_errors(law)[loads])
        parts["unloading"].append(contact.unloading_errors(law)[turns].ravel())
        parts["restitution"].append(contact.restitution_errors(law)[turns])
    return {
        name: float(np.abs(np.concatenate(values)).max(initial=0.0))
        for name, values in parts.items()
    }


def _bars_in_header(text: str, table: pd.DataFrame) -> str:
    """Return the text of the header with these error bars."""
    lines = []
    for _, rows in table.groupby("contacts", sort=False):
        entries = []
        for row in rows[["from", "force", "unloading", "restitution"]].to_numpy():
            entries.append("{" + ", ".join(map("{:g}".format, row)) + "}")
        lines.append(f"    {{{', '.join(entries)}}},\n")
    return _BARS.sub(lambda match: match[1] + "".join(lines) + match[2], text)


def renew(page: Path, contacts: list[Measured], constants: Mapping[str, float] | None) -> None:
    """Write the tables of errors and error bars into a page, between its marks."""
    own = errors(contacts, LAW, constants)
    other = errors(contacts, _OTHER)
    counts = pd.Series([contact.name.partition("_")[0] for contact in contacts]).value_counts()
    heads = ["contacts", *_RANGES, "within 3 %", "unloading", "restitution"]
    heads += [f"`{_OTHER}`: {_RANGES[0]}", *_RANGES[1:], "unloading"]
    rows = []
    for kind, label in _KINDS.items():
        of_law = own.loc[kind]
        of_other = other.loc[kind]
        row = [f"{label} ({counts[kind]})", *(f"{of_law[name]:.1f}" for name in _RANGES)]
        row.append(f"{of_law['within_3']:.0f} %")
        row += [f"{of_law['unloading']:.1f}", f"{of_law['restitution']:.1f}"]
        row += [f"{of_other[name]:.1f}" for name in (*_RANGES, "unloading")]
        rows.append(row)
    text = page.read_text(encoding="utf-8")
    text = _between_marks(text, "law errors", _markdown(heads, rows))
    rows = []
    for _, bar in bars(contacts, constants).iterrows():
        percentages = [f"{100 * bar[name]:.1f} %" for name in ("force", "unloading", "restitution")]
        rows.append([bar["contacts"], f"from {bar['from']:g}", *percentages])
    heads = ["contacts", "peak", "force", "unloading", "restitution"]
    page.write_text(_between_marks(text, "law bars", _markdown(heads, rows)), encoding="utf-8")


def _markdown(heads: list[str], rows: list[list[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def _between_marks(text: str, name: str, table: str) -> str:
    """Return the text with a table between the marks of this name."""
    start, end = (f"<!-- {word} {name} -->" for word in ("begin", "end"))
    before, _, rest = text.partition(start)
    _, _, after = rest.partition(end)
    return f"{before}{start}\n\n{table}\n{end}{after}"


def draw(contacts: list[Measured], constants: Mapping[str, float] | None, path: Path) -> None:
    """Draw the errors of the force on loading of both laws against the overlap."""
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 2, figsize=(6.4, 2.8), sharey=True, layout="constrained")
    for axes, (name, own) in zip(panels, (("elastoplastic", None), (LAW, constants)), strict=True):
        for held_out, label in ((False, "fitted contacts"), (True, "held-out contacts")):
            chosen = [contact for contact in contacts if contact.held == held_out]
            overlap = np.concatenate([contact.overlap / contact.start for contact in chosen])
            error = np.concatenate(
                [contact.loading_errors(contact.law(name, own)) for contact in chosen]
            )
            axes.plot(overlap, 100 * error, ".", markersize=2, label=label)
        axes.axhspan(-3, 3, color="0.85", zorder=0)
        axes.set(
            title=name, xscale="log", ylim=(-80, 80), xlabel="overlap / overlap at first yield"
        )
    panels[0].set_ylabel("force / finite elements - 1 (%)")
    panels[1].legend()
    figure.savefig(path, dpi=130)
    plt.close(figure)


def main() -> None:
    """Fit if a header is given, and print the errors of this law and of the default law."""
    contacts = measured()
    constants = None
    paths = [Path(argument) for argument in sys.argv[1:]]
    for path in [path for path in paths if path.suffix == ".h"]:
        text = path.read_text(encoding="utf-8")
        fitted = fit(contacts, {name: float(value) for name, value in _CONSTANT.findall(text)})
        constants = {name: float(f"{value:.6g}") for name, value in fitted.items()}
        for name, value in constants.items():
            text = re.sub(
                rf"^  double {name} = .*;$",
                f"  double {name} = {value!r};",
                text,
                flags=re.MULTILINE,
            )
        text = _bars_in_header(text, bars(contacts, constants))
        path.write_text(text, encoding="utf-8")
    for path in [path for path in paths if path.suffix == ".webp"]:
        draw(contacts, constants, path)
    for path in [path for path in paths if path.suffix == ".md"]:
        renew(path, contacts, constants)
    for name, of_law in ((LAW, constants), ("elastoplastic", None)):
        print(f"{name}\n{errors(contacts, name, of_law).round(1).to_string()}")


if __name__ == "__main__":
    main()
