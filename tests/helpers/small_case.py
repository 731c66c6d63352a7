"""A small case as tables and as a file, with changes, and the faults that these have."""

from __future__ import annotations

from typing import Any

import pytest

from granwave.lammps_inputs.case.parse import apply_overrides
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict

MINIMAL: dict[str, Any] = {
    "packing": {"kind": "fcc", "size": [12, 12, 6], "diameter": 0.01},
    "material": "brass",
}
FILE = 'material = "brass"\n[packing]\nkind = "fcc"\nsize = [12, 12, 6]\ndiameter = 0.01\n'


def changed(**changes: Any) -> dict[str, Any]:
    return apply_overrides(MINIMAL, {key.replace("__", "."): value for key, value in changes.items()})


def faults_of(**changes: Any) -> list[str]:
    with pytest.raises(InputError) as caught:
        case_from_dict(changed(**changes), "my.toml")
    return caught.value.errors
