"""``[output]``: records of a run in addition to its snapshots."""

from __future__ import annotations

import dataclasses
from typing import Literal

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.hints import INTERVAL
from granwave.lammps_inputs.case.run import AUTO

_PROBE_FORM = "a list such as [{sphere = 12}, {contact = [12, 34]}]"
_PARTS_FORM = 'true, false or "auto"'
_PARTS = schema.or_word(AUTO, schema.ChoiceType((True, False)), form=_PARTS_FORM)
_PROBE_ID = schema.CountType(form="an id from 1 up")


_TWO_IDS = "two ids from 1 up"


@dataclasses.dataclass(frozen=True)
class Probe:
    """Probe of a sphere, or of the contact of two spheres, recorded at its own rate."""

    sphere: int | None = schema.typed("id of the sphere", _PROBE_ID, default=None)
    contact: tuple[int, int] | None = schema.typed(
        "ids of two spheres, whose contact is recorded",
        schema.ListType(
            item=schema.CountType(form=_TWO_IDS), expected=_TWO_IDS, at_least=2, at_most=2
        ),
        default=None,
    )

    def checked(self) -> Probe:
        """Return the probe; raise `ValidationError` unless it is of a sphere or of a contact."""
        schema.refuse_if((self.sphere is None) == (self.contact is None), _PROBE_FORM)
        return self

    @property
    def spheres(self) -> tuple[int, ...]:
        """Ids of its sphere or spheres."""
        return self.contact if self.contact is not None else (self.sphere or 0,)


_PROBES = schema.ListType(
    item=schema.TableType(section=Probe, expected=_PROBE_FORM, finish=Probe.checked),
    expected=_PROBE_FORM,
    at_least=0,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Output:
    """``[output]``: form of the snapshots, and further records."""

    dump_format: str = schema.choice(
        "format of the dump of snapshots: binary is written and read ten times faster, text can "
        "be read by every program",
        ("binary", "text"),
        default="binary",
    )
    probes: tuple[Probe, ...] = schema.typed(
        "spheres and contacts that are recorded every probe_interval", _PROBES, default=()
    )
    probe_interval: float | str = schema.positive_or_auto(
        "time between records of probes and walls; auto: five timesteps", INTERVAL
    )
    history: int | Literal["auto"] = schema.typed(
        "number of instants at which the velocity of every bead of a chain and the force of "
        "every contact are recorded; auto: 1000 (fewer with long bars) for chains of at least "
        "five beads, and 2000 for each [[line]]",
        schema.or_word(
            AUTO,
            schema.CountType(at_least=0, at_most=schema.NO_LIMIT),
            form='a whole number from 0 up or "auto"',
        ),
        default="auto",
    )
    contact_forces: bool = schema.choice(
        "record the forces of all contacts, and the forces and angular velocities of the spheres, "
        "at every snapshot; for granwave infer, and run.contact_forces in Python",
        (False, True),
        default=False,
    )
    parts: bool | Literal["auto"] = schema.typed(
        "write snapshots, contacts and checkpoints to several files, snapshots and contacts to one "
        "file per node; auto: from 10 million spheres on",
        _PARTS,
        default="auto",
    )
