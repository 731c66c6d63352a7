"""Versions of the programs that a result depends on."""

from __future__ import annotations

import platform
from collections.abc import Iterable
from importlib import metadata

from granwave import __version__


def versions_of(packages: Iterable[str], **others: str) -> dict[str, str]:
    """Return the versions of granwave, Python, ``others`` and packages; "not installed" for missing ones."""
    return {
        "granwave": __version__,
        "python": platform.python_version(),
        **others,
        **{name: _version(name) for name in packages},
    }


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
