"""Checks of lines of grains, ``[[line]]``."""

from __future__ import annotations

import numpy as np

from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.lines import line_ids


def check_lines(assembly: Assembly, errors: ErrorList) -> None:
    """Check names, ids and grains of the lines of a case."""
    lines, last = assembly.case.line, assembly.last_sphere
    for place, line in enumerate(lines, start=1):
        key = f"line.{place}"
        if line.name in [other.name for other in lines[: place - 1]]:
            errors.add(f"{key}.name", f"found {show(line.name)} twice, expected a name of its own")
        if line.index is not None and line.start is not None:
            errors.add(f"{key}.index", "found beside start; give one of them")
            continue
        index = () if line.index is None or isinstance(line.index, str) else line.index
        named = {"index": index, "start": () if line.start is None else (line.start,)}
        strange = [(name, one) for name, ids in named.items() for one in ids if one > last]
        if strange:
            name, one = strange[0]
            errors.add(f"{key}.{name}", f"found {one}, expected ids from 1 to {last}")
            continue
        vacant = [(name, one) for name, ids in named.items() for one in np.setdiff1d(ids, assembly.ids).tolist()]
        if vacant:
            errors.add(f"{key}.{vacant[0][0]}", f"found {vacant[0][1]}, a vacant site; expected a grain that is there")
            continue
        if len(set(index)) < len(index):
            errors.add(f"{key}.index", f"found {show(list(index))}, expected each id once")
        elif (found := len(line_ids(assembly, line))) < 2:
            errors.add(
                key,
                f"found {found} grain{'' if found == 1 else 's'} along {show(list(line.direction))}, expected two "
                "or more; give another direction or start, or the ids as index",
            )
