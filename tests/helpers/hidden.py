"""Extensions hidden from a process, as if their folders did not exist.

The environment variable ``GRANWAVE_WITHOUT`` names them; as a plugin of pytest (``-p
tests.helpers.hidden``) this module skips their tests, and tests with the marker
``needs_extension``.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import itertools
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import pytest

from granwave.lammps_inputs.extensions import ALL, WITHOUT

FOLDER = Path(__file__).parents[2] / "extensions"
TESTS = Path(__file__).parents[1]
#: All extensions of this repository.
NAMES = tuple(sorted(path.parent.name for path in FOLDER.glob("*/__init__.py")))


def hidden_names() -> tuple[str, ...]:
    """Return the names of the extensions that this process must not see."""
    words = [word.strip() for word in os.environ.get(WITHOUT, "").split(",") if word.strip()]
    return NAMES if ALL in words else tuple(word for word in words if word in NAMES)


def importing_file() -> Path:
    """Return the file whose import statement is being executed."""
    frame = sys._getframe(2)
    while frame.f_back is not None and "importlib" in frame.f_code.co_filename:
        frame = frame.f_back
    return Path(frame.f_code.co_filename)


class NoImport(importlib.abc.MetaPathFinder):
    """Finder of modules that rejects modules of the hidden extensions; a test that imports one is
    skipped, a module of the core fails.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.packages = tuple(f"granwave.extensions.{name}" for name in names)

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Raise ImportError for a module of a hidden extension; leave all others to the next finder."""
        if any(fullname == name or fullname.startswith(f"{name}.") for name in self.packages):
            if TESTS in importing_file().parents:
                pytest.skip(f"looks at {fullname}, which is hidden", allow_module_level=True)
            raise ImportError(f"{fullname} is hidden by {WITHOUT}")
        return None


def hide() -> None:
    """Reject imports of the hidden extensions from now on."""
    sys.meta_path.insert(0, NoImport(hidden_names()))


def pytest_configure(config: pytest.Config) -> None:
    """Hide the extensions before any test is collected."""
    hide()


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Skip the tests of hidden extensions."""
    parts = collection_path.parts
    for name in hidden_names():
        if ("extensions", name) in itertools.pairwise(parts):
            return True
    return None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip tests of the core that concern additions of a hidden extension."""
    names = set(hidden_names())
    left_out = [
        item
        for item in items
        if any(names & set(mark.args) for mark in item.iter_markers("needs_extension"))
    ]
    config.hook.pytest_deselected(items=left_out)
    items[:] = [item for item in items if item not in left_out]


if __name__ == "__main__":
    hide()
    from granwave.workflows.cli.main import main

    sys.exit(main())
