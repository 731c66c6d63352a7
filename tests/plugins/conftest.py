"""Tests that cannot pass with the oldest supported release of LAMMPS (``make compat``), and why."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent
#: First release in which these tests pass.
SINCE = "2025.7.22"
CUT = "its Python module cuts messages after 100 characters"
CLEARED = "its command `clear` removes plugins"
FIRST = "plugins are not loaded if its Python module is imported before mpi4py"
REASONS = {
    "fixes/test_nve_sphere.py::test_the_bits_are_the_same_after_a_restart": CLEARED,
    "laws/test_mdr.py": "it has no normal model mdr",
    "laws/test_prony.py::test_wrong_words": CUT,
    "laws/test_rate.py::test_balance_of_a_collision_and_its_restitution": CLEARED,
    "package/test_loader.py::test_another_release_is_refused": (
        "the test takes it as the other release"
    ),
    "package/test_package.py::test_the_plugin_registers_the_styles_of_the_blocks": (
        "its available_plugins() needs an argument"
    ),
    "package/test_python_module.py::test_lammps_is_imported_first": FIRST,
    "package/test_python_module.py::test_doctor_tries_the_import": FIRST,
    "test_records.py::test_restart_files_of_format_12_continue_as_they_did": (
        "the stored restart files are those of 22 Jul 2025"
    ),
    "test_records.py::test_dents_are_read_in_pieces": CUT,
    "test_refusals.py::test_contacts_are_not_read_while_they_are_not_current": CUT,
    "test_refusals.py::test_overlaps_name_their_likely_cause_first": CUT,
    "test_spheres_that_go.py::test_cylinders_that_come_during_a_run_touch_the_wall": (
        "it has no `fix set`"
    ),
    "test_upstream.py": "the branch uses interfaces of 22 Jul 2025",
    "walls/test_meshes.py::test_wrong_meshes_are_refused": CUT,
    "walls/test_regions.py::test_what_is_refused": CUT,
}


def pytest_collection_modifyitems(items: Iterable[pytest.Item]) -> None:
    if _parts(version("lammps")) >= _parts(SINCE):
        return
    for item in items:
        if FOLDER in item.path.parents:
            name = item.nodeid.partition("tests/plugins/")[2]
            for start, reason in REASONS.items():
                if name.startswith(start):
                    item.add_marker(pytest.mark.skip(reason=f"older LAMMPS: {reason}"))


def _parts(release: str) -> tuple[int, ...]:
    return tuple(int(part) for part in release.split(".")[:3])
