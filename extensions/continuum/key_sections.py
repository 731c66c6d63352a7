"""Tables of the finite-element cases, for ``granwave keys``."""

from __future__ import annotations

from collections.abc import Mapping

from granwave.extensions.continuum.punch.case import ContinuumCase
from granwave.extensions.continuum.sphere_contact.case import Partner, SphereContactCase
from granwave.lammps_inputs.case.case import CaseHead
from granwave.workflows.cli.key_sections import HEAD, Sections


def _with_head(sections: Mapping[str, type]) -> Sections:
    tables: Sections = {f"[{name}]": (section, "") for name, section in sections.items()}
    return {"": (CaseHead, HEAD), **tables}


PUNCH = _with_head(ContinuumCase.SECTIONS)
SPHERE_CONTACT = {**_with_head(SphereContactCase.SECTIONS), "[partner]": (Partner, "")}
