"""Constants of the law ``elastoplastic-fe`` from ``law_table.csv``, by least squares, and its
errors.

    python -m granwave.workflows.finite_elements.sphere_contact.law_fit [HEADER] [PICTURE]

prints the largest errors. With HEADER (elastoplastic_fe_constants.h of the plugin) it fits first,
from the present constants on, and writes it; with PICTURE it draws the errors of this law and of
the default one. Two equal spheres to great depth stand for one on a rigid flat.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import least_squares

from granwave._contact_laws import ContactLaw
from granwave.workflows.finite_elements.sphere_contact.law_table import TABLE, contacts

Array = NDArray[np.float64]

LAW = "elastoplastic-fe"
_DEEPEST = 0.205  # over R*, of the points that count
_PLACES = np.linspace(0, 1, 40)  # of an unloading, from the residual overlap to the peak
# overlap over that at first yield, below which the first unloading tells what dissipation begins
# with
_FIRST = 6.0
_BETWEEN = np.array([0.1, 0.25, 0.5, 0.75])  # places from yield to the first unloading
_POWERS = (2, 4, 6)  # of the errors whose sum is made small, one after the other
_CONSTANT = re.compile(r"^  double (\w+) = (.*);$", re.MULTILINE)


class Measured:
    """A contact of the table: points of loading and unloadings in units of R* and E* R*^2."""

    def __init__(self, name: str, values: Mapping[str, float], rows: pd.DataFrame) -> None:
        self.name = name
        self.held = name.startswith("held")
        rigid = "deepest" in values
        nu = values["nu"]
        hardening = values["hardening"]
        radius, modulus, strength = (
            math.inf if rigid else values.get(key, 1.0) for key in ("radius", "modulus", "strength")
        )
        self.bodies = {
            "youngs_modulus": (1.0, modulus),
            "poisson_ratio": (nu, 0.0 if rigid else values.get("nu2", nu)),
            "yield_strength": (1 / values["ratio"], strength / values["ratio"]),
            "radius": (1.0, radius),
            "hardening": (hardening, 0.0 if math.isinf(strength) else hardening),
        }
        law = self.law(LAW)
        size = law.effective_radius
        unit = law.effective_modulus * law.effective_radius**2
        length, force = (size / 4, unit / 8) if rigid else (size, unit)
        rows = rows.assign(overlap=rows["overlap"] * length, residual=rows["residual"] * length)
        rows = rows.assign(force=rows["force"] * force)[rows["overlap"] <= _DEEPEST * size]
        self.start = law.yield_overlap
        loading, unloading = (rows[rows["branch"] == name] for name in ("loading", "unloading"))
        loading = loading[loading["overlap"] > self.start]
        self.overlap, self.force = (loading[name].to_numpy() for name in ("overlap", "force"))
        self.peak, self.peak_force, self.residual, self.exponent = (
            unloading[name].to_numpy() for name in ("overlap", "force", "residual", "exponent")
        )

    def law(self, name: str, constants: Mapping[str, float] | None = None) -> ContactLaw:
        """Return a law of this contact; one without hardening leaves that out."""
        return ContactLaw(law=name, constants=dict(constants or {}), **self.bodies)

    def loading_errors(self, law: ContactLaw) -> Array:
        """Return the errors of the force on loading over that of finite elements."""
        return np.asarray(law.loading_force(self.overlap) / self.force - 1)

    def unloading_errors(self, law: ContactLaw) -> Array:
        """Return the errors of the share of the peak force on unloading, at `_PLACES`:
        (n_unloadings, n_places).
        """
        found = []
        for peak, residual, exponent in zip(self.peak, self.residual, self.exponent, strict=True):
            overlap = residual + (peak - residual) * _PLACES
            found.append(law.force(overlap, peak) / law.loading_force(peak) - _PLACES**exponent)
        return np.array(found).reshape(-1, len(_PLACES))

    def near_yield(self, law: ContactLaw) -> Array:
        """Return how far the dissipated share is from a straight line between yield and the first
        unloading.
        """
        peak = self.peak[0]
        first = self.peak[0] / self.start
        if first > _FIRST:
            return np.zeros(0)
        back = law.loading_force(peak) * (peak - self.residual[0]) / (self.exponent[0] + 1)
        at = peak - (1 - _BETWEEN) * (peak - self.start)
        wanted = _BETWEEN * (1 - back / law.loading_work(peak))
        return np.asarray(law.dissipated_energy(at) / law.loading_work(at) - wanted)


def measured() -> list[Measured]:
    """Return the contacts of the table."""
    table = pd.read_csv(TABLE)
    return [
        Measured(name, values, table[table["contact"] == n])
        for n, (name, values) in enumerate(contacts().items())
    ]


def fit(found: list[Measured], start: Mapping[str, float]) -> dict[str, float]:
    """Return the constants of the law: of loading first, then those of unloading, whose names are r
    and n.
    """
    constants = dict(start)
    used = [one for one in found if not one.held]
    groups = [
        [name for name in start if (name[0] in "rn" and name[1:].isdigit()) == back]
        for back in (False, True)
    ]
    for names, powers in zip(groups, (_POWERS, _POWERS[:2]), strict=True):
        for power in powers:

            def errors(x: Array, names: list[str] = names, power: int = power) -> Array:
                trial = constants | dict(zip(names, map(float, x), strict=True))
                laws = [(one, one.law(LAW, trial)) for one in used]
                if names is groups[0]:
                    parts = [one.loading_errors(law) for one, law in laws]
                else:
                    parts = [one.unloading_errors(law)[:, ::3].ravel() for one, law in laws]
                    parts += [4 * one.near_yield(law) for one, law in laws]
                scaled = np.nan_to_num(np.concatenate(parts) / 0.02, nan=1e3)
                return np.asarray(np.sign(scaled) * np.abs(scaled) ** (power / 2))

            x = np.array([constants[name] for name in names])
            solved = least_squares(errors, x, x_scale=np.maximum(np.abs(x), 0.05), max_nfev=40)
            constants.update(zip(names, map(float, solved.x), strict=True))
    return constants


def errors(
    found: list[Measured], name: str = LAW, constants: Mapping[str, float] | None = None
) -> pd.DataFrame:
    """Return for each kind of contact the largest error of loading by range of the overlap, and of
    unloading, per cent.

    ``within_3`` and ``within_5``: percentage of the points of loading within 3 %, of unloadings
    within 5 %.
    """
    rows = []
    for kind in dict.fromkeys(one.name.partition("_")[0] for one in found):
        laws = [(one, one.law(name, constants)) for one in found if one.name.startswith(kind)]
        at = np.concatenate([one.overlap / one.start for one, _ in laws])
        loading = np.concatenate([one.loading_errors(law) for one, law in laws])
        back = np.concatenate([np.abs(one.unloading_errors(law)).max(axis=1) for one, law in laws])
        ranges = {
            f"{low:g}-{high:g}": (at > low) & (at <= high)
            for low, high in ((1, 10), (10, 100), (100, math.inf))
        }
        worst = {label: 100 * np.abs(loading[part]).max() for label, part in ranges.items()}
        rows.append({"contacts": kind, **worst, "within_3": 100 * (np.abs(loading) <= 0.03).mean(),
                     "unloading": 100 * back.max(), "within_5": 100 * (back <= 0.05).mean()})  # fmt: skip
    return pd.DataFrame(rows).set_index("contacts")


def draw(found: list[Measured], constants: Mapping[str, float] | None, path: Path) -> None:
    """Draw the errors of the force on loading of both laws against the overlap."""
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 2, figsize=(6.4, 2.8), sharey=True, layout="constrained")
    for axes, (name, own) in zip(panels, (("elastoplastic", None), (LAW, constants)), strict=True):
        for held, label in ((False, "fitted contacts"), (True, "held-out contacts")):
            chosen = [one for one in found if one.held == held]
            overlap = np.concatenate([one.overlap / one.start for one in chosen])
            error = np.concatenate([one.loading_errors(one.law(name, own)) for one in chosen])
            axes.plot(overlap, 100 * error, ".", markersize=2, label=label)
        axes.axhspan(-3, 3, color="0.85", zorder=0)
        axes.set(
            title=name, xscale="log", ylim=(-80, 80), xlabel="overlap over that at first yield"
        )
    panels[0].set_ylabel("force over finite elements - 1 (%)")
    panels[1].legend()
    figure.savefig(path, dpi=130)
    plt.close(figure)


def main() -> None:
    """Fit if a header is named, and print the errors of this law and of the default one."""
    found = measured()
    constants = None
    headers, pictures = (
        [Path(one) for one in sys.argv[1:] if one.endswith(".h") == header]
        for header in (True, False)
    )
    for path in headers:
        text = path.read_text(encoding="utf-8")
        fitted = fit(found, {name: float(value) for name, value in _CONSTANT.findall(text)})
        constants = {name: float(f"{value:.6g}") for name, value in fitted.items()}
        for name, value in constants.items():
            text = re.sub(
                rf"^  double {name} = .*;$",
                f"  double {name} = {value!r};",
                text,
                flags=re.MULTILINE,
            )
        path.write_text(text, encoding="utf-8")
    for path in pictures:
        draw(found, constants, path)
    for name, of_law in ((LAW, constants), ("elastoplastic", None)):
        print(f"{name}\n{errors(found, name, of_law).round(1).to_string()}")


if __name__ == "__main__":
    main()
