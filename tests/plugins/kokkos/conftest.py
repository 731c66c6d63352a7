"""Tests of pair style gran/hysteretic/kk, which exists only in plugins that are built with Kokkos:
`make kokkos KOKKOS=DIR` builds one and runs them.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def kokkos() -> Path:
    """Folder of a build with Kokkos."""
    given = os.environ.get("GRANWAVE_KOKKOS_BUILD")
    if not given:
        pytest.skip("GRANWAVE_KOKKOS_BUILD names no build with Kokkos (make kokkos KOKKOS=DIR)")
    return Path(given).resolve()
