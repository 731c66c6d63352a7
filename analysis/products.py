"""Product of a run: a file in addition to its figures, such as an animation, requested by
``[figures]`` of its case.

Extensions make them; `granwave.lammps_inputs.case.run.Figures.products` lists the files that a case
requests.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from granwave.lammps_inputs.result_directory import ResultDirectory


def _none(file: str) -> tuple[str, ...]:
    return ()


@dataclasses.dataclass(frozen=True)
class Product:
    """File that a run makes in addition to its figures.

    Attributes
    ----------
    key
        Key of ``[figures]`` that requests it.
    make
        Function of the directory of a run and of the name of the file there that writes it.
    packages
        Function of the name of the file that returns the Python packages that making it needs, by
        their names in ``import``.
    """

    key: str
    make: Callable[[ResultDirectory, str], object]
    packages: Callable[[str], tuple[str, ...]] = _none
