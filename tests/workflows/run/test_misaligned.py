"""Misaligned strikers, leaning and scattered spheres of a square packing against an independent solver."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis import Result
from granwave.analysis.measures.lines import sensor_accelerations, sensor_velocities
from granwave.analysis.measures.signals import first_peak
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.packing import build_packing
from granwave.workflows import run_case
from tests.helpers.square_twin import Plane, Spheres

E, NU, RHO = 193e9, 0.3, 8000.0
DELRIN = {"youngs_modulus": 3.1e9, "poisson_ratio": 0.35, "density": 1400.0}
NX, NY, D = 4, 4, 0.01906
SCATTERED = {"diameter_scatter": 2e-5, "seed": 4}
IN_PLANE = [{"touches": [5, 9]}, {"touches": 17, "velocity": [0.29, 0.0, 0.0]}]
FROM_ABOVE = [{"touches": [6, 7, 10, 11]}, {"touches": 17, "velocity": [0.0, 0.0, 0.65]}]


@pytest.mark.parametrize(
    ("strikers", "packing"),
    [
        pytest.param([IN_PLANE[0], IN_PLANE[1] | {"offset": [0.0, 1.5e-3, 0.0]}], {}, id="off centre"),
        pytest.param(
            [IN_PLANE[0] | {"offset": [0.0, 5e-6, 0.0]}, IN_PLANE[1]], {}, id="aside", marks=pytest.mark.validation
        ),
        pytest.param(IN_PLANE, SCATTERED, id="gaps", marks=pytest.mark.validation),
        pytest.param(FROM_ABOVE, SCATTERED | {"tilt": [1, 1]}, id="leaning"),
    ],
)
def test_as_the_independent_solver(strikers: list[dict[str, Any]], packing: dict[str, Any], tmp_path: Path) -> None:
    case = case_from_dict(
        {
            "name": "square",
            "material": {"youngs_modulus": E, "poisson_ratio": NU, "density": RHO},
            "packing": {"kind": "square", "size": [NX, NY], "diameter": D} | packing,
            "contact": {"law": "hertz"},
            "boundary": {"bottom": {"material": DELRIN}, "sides": {"material": DELRIN}},
            "striker": strikers,
            "sensor": [{"name": "A", "id": 6}, {"name": "B", "id": 10}, {"name": "C", "id": 15}],
            "run": {"end_time": 2e-4, "frames": 2},
        }
    )
    run_case(case, tmp_path / "run", figures=False)
    built = build_packing(case)
    with Result(tmp_path / "run") as result:
        time = result["probes/time"]
        ours = [np.stack(list(one(result).values())) for one in (sensor_velocities, sensor_accelerations)]
        (early, first), (late, second) = (
            first_peak(time, sensor_accelerations(result)[name][:, 0], floor=0.5) for name in "AB"
        )
    modulus, soft = E / (1 - NU**2), DELRIN["youngs_modulus"] / (1 - DELRIN["poisson_ratio"] ** 2)
    low, high = -D / 2, (np.array([NX, NY]) - 0.5) * D
    planes = [Plane(axis, edge, side, soft, NX * NY) for axis in (0, 1) for edge, side in ((low, 1), (high[axis], -1))]
    velocity = np.zeros((NX * NY + 2, 3))
    velocity[-1] = strikers[1]["velocity"]
    twin = Spheres(built.positions, built.atoms.get_array("diameters") / 2, velocity, RHO, modulus,
                   (*planes, Plane(2, D / 2, -1, soft, NX * NY)))  # fmt: skip
    times = time[:: max(1, len(time) // 120)]
    rows = [sensor.id - 1 for sensor in case.sensor]
    for found, expected in zip(ours, twin.run(times), strict=True):
        theirs = np.moveaxis(expected[:, rows], 0, 1)
        largest = np.abs(theirs).max()
        assert largest > 0
        np.testing.assert_allclose(found[:, :: max(1, len(time) // 120)], theirs, atol=2e-3 * largest)
    if "offset" in strikers[1]:  # it pushes the one at rest to the other side, on which A is
        assert first > 1.1 * second and early < late
    if "offset" in strikers[0]:  # B is on the side that is touched
        assert first < 0.9 * second and early > late
