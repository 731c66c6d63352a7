"""``[output]``: probes, histories and form of the dumps."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal

from granwave.lammps_inputs.case.schema import NO_LIMIT, ValidationError, choice, custom, positive_or_auto, whole
from granwave.lammps_inputs.case.si_values import INTERVAL


def _parse_history(value: Any) -> int | str:
    expected = 'a whole number from 0 up or "auto"'
    return value if value == "auto" else whole(value, expected, at_least=0, at_most=NO_LIMIT)


def _parse_probes(value: Any) -> tuple[Probe, ...]:
    if not isinstance(value, list | tuple):
        raise ValidationError(_PROBE_FORM)
    return tuple(_parse_probe(probe) for probe in value)


def _parse_parts(value: Any) -> bool | str:
    if value == "auto" or isinstance(value, bool):
        return value
    raise ValidationError('true, false or "auto"')


_PROBE_FORM = "a list such as [{sphere = 12}, {contact = [12, 34]}]"


def _parse_probe(value: Any) -> Probe:
    if not isinstance(value, Mapping) or len(value) != 1:
        raise ValidationError(_PROBE_FORM)
    ((what, which),) = value.items()
    expected = f"{_PROBE_FORM} with ids from 1 up"
    if what == "sphere":
        return Probe(sphere=whole(which, expected))
    if what == "contact" and isinstance(which, list | tuple) and len(which) == 2:
        first, second = (whole(sphere, expected) for sphere in which)
        return Probe(contact=(first, second))
    raise ValidationError(_PROBE_FORM)


@dataclasses.dataclass(frozen=True)
class Probe:
    """Probe of one sphere or of the contact of two, recorded at its own rate."""

    sphere: int | None = None
    contact: tuple[int, int] | None = None

    @property
    def spheres(self) -> tuple[int, ...]:
        """Ids of its sphere or spheres."""
        return self.contact if self.contact is not None else (self.sphere or 0,)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Output:
    """``[output]``: form of the snapshots, and records besides snapshots and energies."""

    dump_format: Literal["binary", "text"] = choice(
        "form of the dump of snapshots: binary is written and read ten times as fast, text is read by every program",
        ("binary", "text"),
        default="binary",
    )
    probes: tuple[Probe, ...] = custom("spheres and contacts recorded at their own rate", _parse_probes, default=())
    probe_interval: float | Literal["auto"] = positive_or_auto(
        "time between records of probes and walls; auto: five timesteps",
        unit="s",
        usual=INTERVAL,
    )
    history: int | Literal["auto"] = custom(
        "instants at which the velocity of every bead of a chain and the force of every contact are recorded; "
        "auto: 1000 (fewer with long bars) for chains of five beads and more; the same for each [[line]], auto: 2000",
        _parse_history,
        default="auto",
    )
    contact_forces: bool = choice(
        "forces of all contacts at every snapshot, with forces and spins of the spheres; for granwave infer, and "
        "run.contact_forces in Python",
        (False, True),
        default=False,
    )
    parts: bool | Literal["auto"] = custom(
        "files of snapshots and contacts, one from each rank instead of one from all; auto: from 10 million spheres on",
        _parse_parts,
        default="auto",
    )
