"""Checks of a run: energy balance, static equilibrium, contacts at the start."""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.result.reader import misfit, work_on_packing
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.packing.contact_ways import DAMPED, KEEP, KEY, RELAX, RELAXATION
from granwave.lammps_inputs.case.run import BALANCE_TOLERANCE
from granwave.lammps_inputs.contact.static_load import (
    FORCE_TOLERANCE,
    dead_loads,
    force_in_bed,
    force_of_contact,
)
from granwave.lammps_inputs.deck.damped_run import CALM, HELD, LOOSE
from granwave.lammps_inputs.deck.deck import box_of
from granwave.lammps_inputs.deck.minimisation import LOST_LOAD, may_lose_its_load
from granwave.lammps_inputs.deck.static_stage import largest_move
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.files import regular
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.run_directory import DUMPS, STATIC_STAGE_FILE
from granwave.workflows.run.lammps_engine import Engine

_LOG = logging.getLogger("granwave")
_CLEAR = 1e-2  # diameters between a striker and its sphere that delay the impact
_DEEP = 1e-3  # diameters by which a striker may overlap its sphere before the impact


_MARGIN = (
    # ratio of net forces after the spin is set to zero to net forces at the end of the damped run
    1.5
)
_MOST_NAMED = 10  # ids in a warning
_NET_FORCES = (
    "Net forces are at most %.2g of the weight of a %s, and all together %.1g of the weight of the "
    "bed. "
)
_ONE_ROLLS = (
    "%s: %d of %d grains still rolls after the static stage, because its contacts do not hold "
    f"it: %s. {_NET_FORCES}This grain starts at rest and continues to roll during the run; "
    "contact.rolling (0.01) stops it"
)
_SEVERAL_ROLL = (
    "%s: %d of %d grains still roll after the static stage, because their contacts do not hold "
    f"them: %s. {_NET_FORCES}These grains start at rest and continue to roll during the run; "
    "contact.rolling (0.01) stops them"
)


@dataclasses.dataclass
class Balance:
    """Energy balance of a run up to its last complete line.

    Attributes
    ----------
    accepted
        Largest error that is accepted, see `granwave.lammps_inputs.case.run.RunSettings`.
    error
        Largest error so far / largest input, see `granwave.analysis.result.reader`; NaN if
        any value is NaN.
    moved
        Mass of the grains with a prescribed displacement, kg.
    row
        Last row, by column.
    """

    path: Path
    accepted: float = BALANCE_TOLERANCE
    moved: float = 0.0
    error: float = 0.0
    _missed: float = 0.0
    _input: float = 0.0
    row: dict[str, float] = dataclasses.field(default_factory=dict)
    _offset: int = 0
    _columns: tuple[str, ...] = ()

    def read(self) -> Balance:
        """Read the rows that LAMMPS has written since the last call."""
        try:
            with self.path.open("rb") as stream:
                stream.seek(self._offset)
                block = stream.read()
        except FileNotFoundError:
            if self.row:  # it was removed
                raise
            return self
        whole = block[: block.rfind(b"\n") + 1]
        self._offset += len(whole)
        for line in whole.decode("ascii").splitlines():
            words = line.lstrip("#").split()
            if line.startswith("#"):
                self._columns = tuple(words) if words[:1] == ["step"] else self._columns
                continue
            self.row = dict(zip(self._columns, map(float, words), strict=True))
            missed = misfit(self.row)
            self._missed = missed if math.isnan(missed) else max(self._missed, missed)
            self._input = max(self._input, work_on_packing(self.row, self.moved))
            if self._missed != 0:  # NaN too
                self.error = self._missed / self._input if self._input else math.inf
        return self

    @property
    def closed(self) -> bool:
        """True if the balance has closed so far."""
        return self.error <= self.accepted  # false for NaN


LARGEST_RESIDUAL = 1e-6  # largest net force on a sphere / largest contact force

_NOT_CONFINED = "the packing is not confined: "
_PERIODIC = 'use boundary.sides = "periodic"'
_UNIFORM = ', or precompression.kind = "uniform"'
_GUIDED = (
    'hold the outer grains with [[hold]], or guide a chain that buckles with [[guide]] (free = "z")'
)
_NEAR_BALANCE = (
    f', or use {KEY} = "{RELAX.name}", which starts from an equilibrium found by Newton\'s '
    "method and lets grains move"
)
_HELD_BY_FRICTION = (
    f', or use {KEY} = "{RELAX.name}" with packing.{RELAXATION} = "{DAMPED}", which keeps the '
    "friction of the case"
)
_BORNE = (
    "hold the outer grains with [[hold]], or press on the top with precompression.force and "
    'boundary.bottom = "wall"'
)
_AS_FOUND = f', or use {KEY} = "{KEEP.name}", which skips the static stage'
_PILE = (
    " (without friction a pile spreads, even between walls, and a sphere next to a vacancy "
    "may lose its support)"
)
_MOVING = "some grains still roll or swing: contact.rolling (0.01) stops grains that roll"
_SUPPORT = "; or the bottom moved: use a stiffer boundary.bottom"


def _advice(case: Case) -> str:
    """Return advice on keys that confine a packing of this kind."""
    rule = case.packing.rule
    if case.settles_damped:
        return f"{_MOVING}{_AS_FOUND}"
    if case.packing.grains is not None and case.packing.cell is None:
        remedy = _GUIDED + _other_way(case)
    elif rule.is_lattice and not rule.has_faces:
        remedy = _PERIODIC
    else:
        remedy = _PERIODIC + _UNIFORM
    support = _SUPPORT if case.boundary.bottom_support is not None else ""
    return f"{_NOT_CONFINED}{remedy}{_PILE}{support}"


def _other_way(case: Case) -> str:
    """Return the value of ``packing.contacts`` to use instead of the value of a case."""
    if case.contact.friction > 0 and case.packing.relaxation != DAMPED:
        return _HELD_BY_FRICTION
    return _AS_FOUND if case.may_rearrange else _NEAR_BALANCE


def check_equilibrium(assembly: Assembly, directory: Path) -> dict[str, float]:
    """Read and check the record of the static stage.

    Returns
    -------
    dict
        Values by column, see `granwave.lammps_inputs.deck.static_stage.RECORD`; SI units.

    Raises
    ------
    RunError
        The packing is not in equilibrium, or has rearranged.
    """
    case = assembly.case
    title, values = (
        regular(directory / DUMPS / STATIC_STAGE_FILE).read_text(encoding="ascii").splitlines()[:2]
    )
    found = dict(zip(title.lstrip("#").split(), map(float, values.split()), strict=True))
    if not case.seeks_balance:
        return found
    advice = _advice(case)
    moved = found["displacement"] / case.packing.diameter
    limit = largest_move(assembly) / case.packing.diameter
    if not moved <= limit:
        raise RunError(
            f"precompression: a sphere moved by {moved:.2g} diameters, expected at most {limit:.2g}; {advice}"
        )
    if _has_lost_load(assembly, found):
        raise RunError(
            f"precompression: the largest contact force is {found['largest_force']:.2g} N after "
            f"the static stage, expected some {force_of_contact(assembly):.2g} N: the load has "
            f"pushed the grains apart; {_BORNE}"
        )
    if not _relative_net_force(assembly, found) <= LARGEST_RESIDUAL and not _is_calm(found):
        raise RunError(
            f"precompression: no equilibrium after {found['iterations']:.0f} iterations: a net "
            f"force of {found['residual']:.1e} of the largest contact force remains, expected at "
            f"most {LARGEST_RESIDUAL:.0e}; {advice}"
        )
    for name, asked in (case.precompression.presses if case.precompression else {}).items():
        force = found[f"force_{name}"]
        if not abs(force / asked - 1) <= FORCE_TOLERANCE:
            raise RunError(
                f"precompression: the {name} walls carry {force:.6g} N after the static stage, "
                f"expected {asked:.6g} N: their distance is computed with elastic contacts, but "
                "some contacts yield under this force, or the walls touch nothing; use a smaller "
                f"{name}_force, or set the distance {name}"
            )
    return found


def _has_lost_load(assembly: Assembly, found: dict[str, float]) -> bool:
    """Return True if grains of a file carry almost no force after the static stage, although they
    should.
    """
    way = assembly.case.packing.contact_way
    if way is None or may_lose_its_load(assembly):
        return False
    return found["largest_force"] < LOST_LOAD * force_in_bed(assembly)


def _is_calm(found: Mapping[str, float]) -> bool:
    """Return True for a bed in which only single grains still roll. The sum of the net forces is
    then a negligible fraction of its weight, and no net force exceeds the weight of its grain.
    """
    if "unbalanced" not in found:
        return False
    return found["unbalanced"] <= _MARGIN * CALM and found["worst"] <= _MARGIN * HELD


def rolls_on(found: Mapping[str, float]) -> bool:
    """Return True if some grains of a bed still roll after the static stage."""
    return found["residual"] > LARGEST_RESIDUAL and found.get("rolling", 0.0) > 0


def warn_of_rolling(
    assembly: Assembly, found: Mapping[str, float], forces: Mapping[int, NDArray[np.float64]]
) -> None:
    """Log a warning of the grains that still roll after the static stage.

    Parameters
    ----------
    found
        Values of the record, see `check_equilibrium`.
    forces
        Net forces on the bodies by id: (3,), N.
    """
    ratio = _net_forces_over_weights(assembly, forces)
    rolling = sorted(sphere for sphere, part in ratio.items() if part > LOOSE)
    if not rolling:
        return
    message = _ONE_ROLLS if len(rolling) == 1 else _SEVERAL_ROLL
    _LOG.warning(
        message,
        assembly.case.name,
        len(rolling),
        len(ratio),
        _listed(rolling),
        max(ratio.values()),
        "clump" if assembly.clumps else "grain",
        found["unbalanced"],
    )


def _net_forces_over_weights(
    assembly: Assembly, forces: Mapping[int, NDArray[np.float64]]
) -> dict[int, float]:
    """Return the net force divided by the weight of each loaded grain by id; a grain of a clump has
    the ratio of its clump.
    """
    ids, loads = dead_loads(assembly)
    load_of = dict(zip(ids.tolist(), loads, strict=True))
    in_clumps = set(assembly.in_clumps.tolist())
    single = [(sphere,) for sphere in load_of if sphere not in in_clumps]
    ratio: dict[int, float] = {}
    for grains in (*assembly.clumps.values(), *single):
        loaded = [sphere for sphere in grains if sphere in load_of]
        load = np.sum([load_of[sphere] for sphere in loaded], axis=0)
        force = np.sum([forces[sphere] for sphere in grains], axis=0)
        if loaded:
            part = float(np.linalg.norm(force) / np.linalg.norm(load))
            ratio |= dict.fromkeys(loaded, part)
    return ratio


def _listed(ids: list[int]) -> str:
    """Return ids in words; for many ids the first few."""
    words = ", ".join(map(str, ids[:_MOST_NAMED]))
    noun = "id" if len(ids) == 1 else "ids"
    more = f" and {len(ids) - _MOST_NAMED} more" if len(ids) > _MOST_NAMED else ""
    return f"{noun} {words}{more}"


def _relative_net_force(assembly: Assembly, found: dict[str, float]) -> float:
    """Return the largest net force on a sphere divided by the largest contact force. Overlaps that
    push the grains of a free packing apart leave no forces: the reference is the initial force.
    """
    largest = found["largest_force"]
    if not largest or not may_lose_its_load(assembly):
        return found["residual"]
    return found["residual"] * min(1.0, largest / force_of_contact(assembly))


def expected_neighbours(assembly: Assembly) -> tuple[int, float] | None:
    """Return the number of pairs of spheres that LAMMPS must find at the start, and their largest
    distance (m).

    None if no single distance selects these pairs. Packings of dissimilar spheres need an array of
    all sites for this; one rank computes it for all.
    """
    case = assembly.case
    packing = case.packing
    sites = assembly.sites
    unlike = sites.stacked is not None or packing.grains is not None
    if assembly.strikers or assembly.bars or unlike:
        return None  # one cutoff cannot distinguish contacts of dissimilar bodies
    # The sites are one diameter apart, whatever the diameters of the spheres there.
    forget_gap = case.boundary.forget_gap
    reach = packing.diameter * (1 + min(1e-6, 0.5 * forget_gap))
    if sites.least_reach + forget_gap * packing.diameter < reach:
        return None  # LAMMPS lists no pairs of such small spheres at neighbouring sites
    return assembly.n_neighbours, reach


def check_coordination(kind: str, expected: tuple[int, float] | None, engine: Engine) -> None:
    """Check that LAMMPS sees the `expected_neighbours` of a kind of packing, with none lost by
    rounding of positions.

    Raises
    ------
    RunError
        It finds another number.
    """
    if expected is None:
        return
    pairs, reach = expected
    engine.commands(
        f"compute start_coordination all coord/atom cutoff {reach!r}\n"
        "compute start_contacts all reduce sum c_start_coordination\nrun 0 post no"
    )
    found = engine.lammps.extract_compute("start_contacts", 0, 0) / 2
    engine.commands("uncompute start_contacts\nuncompute start_coordination")
    if round(found) != pairs:
        raise RunError(
            f"{kind}: LAMMPS finds {found:.0f} neighbours at the start, the lattice has {pairs}"
        )


def warn_of_strikers(assembly: Assembly, centres: Mapping[int, NDArray[np.float64]]) -> None:
    """Log a warning of each striker that does not touch its sphere, or overlaps it deeply, after
    the static stage.

    Parameters
    ----------
    centres
        Centres of strikers and of the spheres that they touched, after the static stage, by id:
        (3,), m.
    """
    diameter = assembly.case.packing.diameter
    for touched, striker in assembly.striker_contacts:
        step = _shortest(assembly, centres[striker] - centres[touched])
        reach = (assembly.diameter_of(touched) + assembly.diameter_of(striker)) / 2
        gap = float(np.linalg.norm(step)) - reach
        if -_DEEP * diameter <= gap <= _CLEAR * diameter:
            continue
        where = f"{gap:.3g} m clear of" if gap > 0 else f"{-gap:.3g} m deep in"
        _LOG.warning(
            "%s: striker %d touched sphere %d, which moved in the static stage; the striker now "
            "starts %s it: use a packing in equilibrium, whose grains do not move "
            '(packing.relaxation = "damped" keeps the friction)',
            assembly.case.name,
            striker - assembly.lattice.n_spheres,
            touched,
            where,
        )


def _shortest(assembly: Assembly, step: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the shortest vector between two points and their images: (3,), m."""
    if not assembly.lattice.periodic:
        return step
    low, high = box_of(assembly)[:2].T
    across = high - low
    shortest = step.copy()
    shortest[:2] -= across * np.round(step[:2] / across)
    return shortest
