"""Tables of the finite-element cases, for ``granwave keys``."""

from __future__ import annotations

from collections.abc import Mapping

from granwave.extensions.continuum.punch.case import ContinuumCase
from granwave.extensions.continuum.sphere_contact.case import Partner, SphereContactCase
from granwave.lammps_inputs.case.case import CaseHead
from granwave.workflows.cli.keys.sections import HEAD, Sections


def _with_head(sections: Mapping[str, type]) -> Sections:
    tables: Sections = {f"[{name}]": (section, "") for name, section in sections.items()}
    return {"": (CaseHead, HEAD), **tables}


def punch_sections() -> Sections:
    """Return the tables of a case of a punch on a block."""
    return _with_head(ContinuumCase.SECTIONS)


def sphere_contact_sections() -> Sections:
    """Return the tables of a case of two spheres."""
    return {**_with_head(SphereContactCase.SECTIONS), "[partner]": (Partner, "")}
