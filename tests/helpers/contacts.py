"""Tables of contacts of two runs, side by side."""

from __future__ import annotations

import numpy as np


def assert_same_contacts(one, other, *, bits: bool = True):
    """The same pairs with the same bits: forces are added up in an order-independent way; or, momentary forces, to 1e-8 of the largest."""
    orders = [np.lexsort((c["j"], c["i"])) for c in (one, other)]
    assert len(orders[0]) == len(orders[1])
    for name in one.columns:
        a, b = one[name][orders[0]], other[name][orders[1]]
        if bits:
            assert np.array_equal(a, b), name
        elif not name.startswith("time"):
            assert np.abs(a - b).max() <= 1e-8 * np.abs(a).max(), name
