"""Choice of the cases of a test that every run of the tests has."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def with_every_test(cases: Iterable[Any], chosen: Collection[Any]) -> list[Any]:
    """Return the parameters of a test: the chosen cases are part of `make test`, the others of
    `make validate`.
    """
    return [
        case if case in chosen else pytest.param(case, marks=pytest.mark.validation)
        for case in cases
    ]
