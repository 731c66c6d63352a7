"""Finite-element contacts to which the law ``elastoplastic-fe`` is fitted, and their table.

    python -m granwave.extensions.continuum.sphere_contact.law_table DIR [--all] [--worker K/N]

runs the contacts that are neither in the table nor in DIR, or with ``--all`` all contacts that are
not in DIR. It leaves a file for each contact in DIR, may be stopped and called again, and at the
end writes ``law_table.csv`` next to this module. The table identifies contacts by their name in
`contacts`; rows of contacts without a file in DIR are unchanged. Lengths are in units of R*, forces
of E* R*^2. Each contact is unloaded from several depths; after each, loading continues from a copy
of the state before.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from granwave.extensions.continuum.sphere_contact.case import SphereContactCase
from granwave.extensions.continuum.sphere_contact.deviations import LOADING, UNLOADING
from granwave.extensions.continuum.sphere_contact.run import ContactRun
from granwave.lammps_inputs.files import replacing

_MODULUS = 1e11  # modulus of the first sphere, Pa; results do not depend on it
_RADIUS = 0.01  # radius of the first sphere, m; results do not depend on it
TABLE = Path(__file__).with_name("law_table.csv")
CONTACTS = Path(__file__).with_name("law_contacts.csv")
_DEEPEST = 0.22  # largest overlap / R*
_ELEMENTS = 2000  # elements of each body
_FIRST_PEAK = 2.0  # overlap of the first unloading / overlap at first yield
_PEAKS = 6  # number of unloadings
_POINTS = 32  # points of loading in the table
_SMOOTHED = 0.12  # width of their smoothing, in the logarithm of the overlap
_FEWEST = 20  # smallest number of entries of an unloading


def contacts() -> dict[str, dict[str, float]]:
    """Return the contacts of ``law_contacts.csv`` by name.

    ``nu, ratio, hardening`` of the first sphere (ratio: Young's modulus / yield strength), and
    of the second its ``radius, modulus, strength`` divided by the values of the first, and ``nu2``;
    values equal to the first sphere's are omitted. A radius of 100 means a flat. Names that begin
    with ``held`` are excluded from the fit. Two equal spheres to a depth of 0.88 R* are equivalent
    to one sphere on a rigid flat to 0.22 R*.
    """
    table = pd.read_csv(CONTACTS, index_col="name", float_precision="round_trip")
    return {name: row.dropna().to_dict() for name, row in table.iterrows()}


def case_of(name: str, values: dict[str, float]) -> SphereContactCase:
    """Return the case of a contact of `contacts`."""
    nu = values["nu"]
    ratio = values["ratio"]
    radius = values.get("radius", 1.0)
    first = {
        "youngs_modulus": _MODULUS, "poisson_ratio": nu, "density": 1e4, "yield_strength": _MODULUS / ratio,
        "hardening": values["hardening"],
    }  # fmt: skip
    second = first | {
        "youngs_modulus": _MODULUS * values.get("modulus", 1.0),
        "poisson_ratio": values.get("nu2", nu),
    }
    strength = values.get("strength", 1.0)
    second["yield_strength"] *= strength
    if np.isinf(strength):
        del second["yield_strength"], second["hardening"]
    tables: dict[str, Any] = {
        "name": "contact", "material": first, "sphere": {"radius": _RADIUS},
        "partner": {"radius": _RADIUS * radius, "material": second},
    }  # fmt: skip
    bodies = 1 if first == second and radius == 1 else 2
    tables["run"] = {
        "max_overlap": values.get("deepest", _DEEPEST),
        "unloadings": _PEAKS,
        "elements": bodies * _ELEMENTS,
    }
    return SphereContactCase.from_dict(tables)


class TableRun(ContactRun):
    """Run that unloads from several depths and continues from each without reloading."""

    def _cycle(self, cycle: int, *, last: bool) -> None:
        solver = self.solver
        rate = self._unloading_rate()
        parts = [
            solver.motion,
            solver.state,
            solver.tally,
            solver.mass,
            *(surface.gaps for surface in solver._surfaces),
        ]
        before = [part.copy() for part in parts]
        every = max(1, round(self._way / 100))
        while solver.rate > 0:
            solver.advance(max(1, every // 5), -rate)
            self._enter(UNLOADING, cycle)
        while solver.force > 0:
            solver.advance(every, -rate)
            self._enter(UNLOADING, cycle)
        for part, old in zip(parts, before, strict=True):
            part[:] = old


def run(name: str, values: dict[str, float], path: Path) -> None:
    """Run a contact and write its history: branch, cycle, overlap, force, contact radius."""
    case = case_of(name, values)
    table_run = TableRun(case)
    table_run.integrate()
    history = table_run.history
    radius = case.law.effective_radius
    modulus = case.law.effective_modulus
    table = pd.DataFrame({
        "branch": history["branch"], "cycle": history["cycle"], "overlap": history["overlap"] / radius,
        "force": history["force"] / (modulus * radius**2), "contact_radius": history["contact_radius"] / radius,
        "kinetic": history["kinetic"] / (history["elastic"] + history["plastic"]),
    })  # fmt: skip
    if table_run.end_reason != "done":
        table = table.iloc[:0]
    with replacing(path) as scratch:
        table.to_csv(scratch, index=False, float_format="%.6g")


def stored() -> pd.DataFrame:
    """Return the table of the file."""
    return pd.read_csv(TABLE)


def reduce(directory: Path) -> pd.DataFrame:
    """Return the table of the contacts in a directory: points of loading, and the unloadings.

    Loading is smoothed over the steps by which the contact grows from node to node. A row of an
    unloading has the residual overlap and the exponent of a fitted curve, and the largest deviation
    from this curve divided by the peak force.
    """
    rows: list[tuple[Any, ...]] = []
    for name, values in contacts().items():
        if not (directory / f"{name}.csv").exists():
            continue
        history = pd.read_csv(directory / f"{name}.csv")
        first = case_of(name, values).contact_law("elastoplastic-fe")
        start = first.yield_overlap / first.effective_radius
        for overlap, force in _smoothed_loading(history, start):
            rows.append((name, "loading", overlap, force, "", "", ""))
        for _, cycle in history[history["branch"] == UNLOADING].groupby("cycle"):
            down = cycle.iloc[int(cycle["overlap"].to_numpy().argmax()) :]
            down = down[down["force"] > 0]
            if len(down) >= _FEWEST:
                rows.append((name, "unloading", *_fitted_unloading(down)))
    return pd.DataFrame(
        rows, columns=["contact", "branch", "overlap", "force", "residual", "exponent", "misfit"]
    )


def _smoothed_loading(history: pd.DataFrame, start: float) -> Iterator[tuple[float, float]]:
    """Return overlaps and smoothed forces on loading, given the overlap at first yield divided by
    R*.
    """
    is_loading = history["branch"] == LOADING
    loading = history[is_loading & (history["overlap"] > 0.3 * start) & (history["force"] > 0)]
    x = np.log(loading["overlap"].to_numpy())
    y = np.log((loading["force"] / loading["overlap"]).to_numpy())
    for overlap in np.geomspace(0.7 * start, 0.95 * loading["overlap"].max(), _POINTS):
        distance = x - math.log(overlap)
        weight = np.exp(-0.25 * (distance / _SMOOTHED) ** 2)
        near = weight > 0.03
        level = np.polyfit(distance[near], y[near], 2, w=weight[near])[-1]
        yield overlap, overlap * math.exp(level)


def _fitted_unloading(down: pd.DataFrame) -> tuple[float, float, float, float, float]:
    """Return overlap and force at the peak of an unloading, residual overlap, exponent, and the
    largest deviation from the fitted curve divided by the peak force.
    """
    relative = down["overlap"].to_numpy() / down["overlap"].iloc[0]
    share = down["force"].to_numpy() / down["force"].iloc[0]

    def misfit(constants: np.ndarray) -> np.ndarray:
        residual, exponent = constants
        scaled = (relative - residual) / (1 - residual)
        return np.asarray(np.clip(scaled, 1e-9, None) ** exponent - share)

    fitted = least_squares(misfit, [relative[-1], 1.35])
    residual, exponent = fitted.x
    peak = down["overlap"].iloc[0]
    largest = np.abs(fitted.fun).max()
    return peak, down["force"].iloc[0], residual * peak, exponent, largest


def main() -> None:
    """Run the contacts without a file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("directory", type=Path)
    parser.add_argument("--all", action="store_true", help="run contacts of the table again")
    parser.add_argument("--worker", default="0/1", help="K/N: every Nth contact from the Kth")
    parser.add_argument("--most", type=int, default=10**6, help="how many contacts to run")
    options = parser.parse_args()
    options.directory.mkdir(parents=True, exist_ok=True)
    k, n = map(int, options.worker.split("/"))
    kept = set() if options.all else set(stored()["contact"])
    missing = {name: values for name, values in contacts().items() if name not in kept}
    lacking = [
        name
        for m, name in enumerate(missing)
        if m % n == k and not (options.directory / f"{name}.csv").exists()
    ]
    for name in lacking[: options.most]:
        run(name, missing[name], options.directory / f"{name}.csv")
        print(name, flush=True)
    if all((options.directory / f"{name}.csv").exists() for name in missing):
        write(reduce(options.directory))


def write(fresh: pd.DataFrame) -> None:
    """Write the table with new rows of these contacts, and unchanged rows of the others."""
    text = fresh.map(lambda value: f"{value:.5g}" if isinstance(value, float) else str(value))
    before = pd.read_csv(TABLE, dtype=str, keep_default_na=False)
    table = pd.concat([before[~before["contact"].isin(set(text["contact"]))], text])
    order = {name: n for n, name in enumerate(contacts())}
    table = table[table["contact"].isin(order)]
    table = table.sort_values("contact", key=lambda names: names.map(order), kind="stable")
    with replacing(TABLE) as scratch:
        table.to_csv(scratch, index=False)


if __name__ == "__main__":
    main()
