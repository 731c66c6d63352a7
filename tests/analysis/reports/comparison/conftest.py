"""Runs that the tests of comparisons share."""

from __future__ import annotations

import pytest

from granwave.workflows import load_case, run_case
from tests.analysis.reports.comparison.runs import CASES


@pytest.fixture(scope="session")
def place(tmp_path_factory):
    """Small runs of packings and chains, without figures."""
    folder = tmp_path_factory.mktemp("compared")
    for name, (case, changes) in CASES.items():
        run_case(load_case(case, changes), folder / name, figures=False)
    return folder
