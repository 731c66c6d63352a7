"""Scan files as texts, and a reader of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from granwave.workflows import load_scan
from granwave.workflows.scanning.scan_file import Scan

Load = Callable[..., Scan]

SMALL = """
case = "fcc-small"
[set]
packing.size = [6, 6, 4]
run.end_time = 5e-5
"""
VELOCITIES = "[grid]\nload.velocity = [1, 2]\n"


def reader(directory: Path) -> Load:
    """Read a scan from a text, which is written to ``directory``."""

    def read(text: str, overrides=(), **options: bool) -> Scan:
        path = directory / "my.toml"
        path.write_text(text, encoding="utf-8")
        return load_scan(path, overrides, **options)

    return read
