"""Summaries of runs on the disk."""

from __future__ import annotations

import json


def summary(directory):
    return json.loads((directory / "summary.json").read_text())


def without_clock(directory):
    return {
        key: value
        for key, value in summary(directory).items()
        if key not in ("wall_time_s", "sphere_steps_per_s", "n_ranks")
    }
