"""Check that the further products of ``[figures]``, such as an animation, can be made here."""

from __future__ import annotations

import os
from importlib.util import find_spec

from granwave.lammps_inputs.case.figures import Figures
from granwave.lammps_inputs.extensions import WITHOUT, added_by_key, missing_package


def missing_products(figures: Figures) -> list[str]:
    """Return the reasons why requested files cannot be made, one sentence each."""
    if not figures.products:
        return []
    products = added_by_key("products", "figures")
    sentences = []
    for key, file in figures.products.items():
        if key not in products:
            sentences.append(f"figures.{key}: {file} is not made: {_missing_extension()}")
            continue
        missing = [name for name in products[key].packages(file) if find_spec(name) is None]
        sentences += [
            f"figures.{key}: {file} is not made: {missing_package(ModuleNotFoundError(name=name))}"
            for name in missing
        ]
    return sentences


def _missing_extension() -> str:
    left_out = os.environ.get(WITHOUT)
    text = "the extension that makes it is not installed"
    if left_out:
        return f"{text}, or {WITHOUT}={left_out} hides it"
    return f"{text}; granwave doctor lists what is installed"
