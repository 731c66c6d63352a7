"""Functions of ``import granwave as gw`` that take arrays take lists as well."""

from __future__ import annotations

import dataclasses
import inspect
from types import ModuleType

import numpy as np
import pytest

import granwave as gw
from granwave.analysis import write_result
from granwave.analysis.result.reader import Result
from tests.helpers.made_up import synthetic

TIME = np.linspace(0.0, 1e-3, 41)
PULSE = np.exp(-(((TIME - 4e-4) / 1e-4) ** 2))
BEADS = np.stack([np.exp(-(((TIME - 2e-5 * n - 2e-4) / 6e-5) ** 2)) for n in range(12)], axis=1)
PLACES = np.linspace(0.01, 0.08, 8)
DECAY = 30.0 * np.exp(-40.0 * PLACES)
SIZE = 0.01
#: Arguments of the functions of ``gw.measures`` and ``gw.theory`` that need no run.
ARGUMENTS = {
    "arrival": (TIME, PULSE, 0.1),
    "at_time": (4e-4, TIME, BEADS),
    "crest_force": (np.arange(2, 6),),
    "crest_times": (np.arange(2, 6),),
    "decay_rate": (PLACES, DECAY),
    "estimate": (np.array([1.0, 1.1, 0.9]),),
    "exponential_decay": (PLACES, DECAY),
    "first_peak": (TIME, PULSE),
    "largest_of_pulses": (TIME, PULSE, 1e-4),
    "lattice_speed": (np.array([1.5, 2.0]),),
    "maxima": (PULSE, 0.1),
    "parted_at": (PLACES, DECAY, np.linspace(1e-4, 2e-4, 8), 0.5),
    "power_law": (PLACES, DECAY),
    "pulse_lengths": (TIME, BEADS, SIZE),
    "pulse_peaks": (TIME, BEADS, SIZE),
    "quadratic_law": (np.array([1.0, 2.0, 3.0, 4.0]), np.array([0.1, 0.5, 1.2, 2.0])),
    "reflection": (TIME, BEADS, 4, 3),
    "space_time_transform": (
        TIME, SIZE * np.arange(12), BEADS, np.linspace(10, 200, 5), np.linspace(0.0, 5e3, 6),
    ),
    "two_region_decay": (PLACES, DECAY),
    "width": (TIME, PULSE),
}  # fmt: skip
#: Functions of a run that take arrays.
OF_A_RUN = {"directional_spread", "energy_by_region", "line_velocity"}
#: Functions that take arrays together with a line of beads.
OF_A_LINE = {"crest_speed", "long_wave_speed"}
ARRAYS = ("ArrayLike", "NDArray", "Array")


def functions_of_arrays(module: ModuleType) -> set[str]:
    """Names of the public functions of a module whose parameters include an array."""
    names = set()
    for name in module.__all__:
        function = getattr(module, name)
        if not inspect.isfunction(function):
            continue
        annotations = [
            str(parameter.annotation)
            for parameter in inspect.signature(function).parameters.values()
        ]
        text = " ".join(annotations)
        if any(array in text for array in ARRAYS):
            names.add(name)
    return names


def as_lists(arguments: tuple[object, ...]) -> list[object]:
    """The arguments with lists in place of arrays."""
    return [part.tolist() if isinstance(part, np.ndarray) else part for part in arguments]


def plain(answer: object) -> object:
    """A result as nested lists of numbers, for comparison."""
    if dataclasses.is_dataclass(answer):
        return [plain(getattr(answer, field.name)) for field in dataclasses.fields(answer)]
    if isinstance(answer, dict):
        return [plain(part) for part in answer.values()]
    if isinstance(answer, tuple | list):
        return [plain(part) for part in answer]
    return np.asarray(answer).tolist()


@pytest.mark.parametrize("name", ARGUMENTS)
def test_lists_give_what_arrays_give(name):
    module = gw.measures if name in gw.measures.__all__ else gw.theory
    function = getattr(module, name)
    arguments = ARGUMENTS[name]
    expected = str(plain(function(*arguments)))
    assert str(plain(function(*as_lists(arguments)))) == expected


def test_functions_of_a_run(tmp_path):
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(size=(5, 5, 4))))
    with Result(tmp_path) as result:
        energy = result["spheres/dissipated_energy"]
        spreads = [
            gw.measures.directional_spread(result, values).along
            for values in (energy, energy.tolist())
        ]
        assert spreads[0] == spreads[1] > 0
        regions = gw.measures.energy_by_region(result, {"first": [1, 2], "next": [3]})
        assert set(regions) >= {"first", "next", "other spheres"}
        assert gw.measures.line_velocity(result, [1, 2, 3]).shape[1] == 3


def test_functions_of_a_line():
    line = gw.theory.precompressed_line(gw.case("precompressed-chain"))
    numbers = np.arange(3, 8)
    speeds = gw.theory.crest_speed(line, numbers)
    assert np.array_equal(gw.theory.crest_speed(line, numbers.tolist()), speeds)
    times = gw.theory.crest_times(numbers)
    speed = gw.measures.long_wave_speed(line, numbers, times)
    assert gw.measures.long_wave_speed(line, numbers.tolist(), times.tolist()) == speed


@pytest.mark.parametrize(
    "name", ["contact_force", "contact_energy", "contact_stiffness", "contact_overlap"]
)
def test_functions_of_a_contact(name):
    bodies = [{"shape": "sphere", "diameter": SIZE, "material": "brass"}] * 2
    values = np.array([1e-6, 2e-6])
    function = getattr(gw, name)
    expected = function("hertz", bodies, values)
    assert np.array_equal(function("hertz", bodies, values.tolist()), expected)


def test_every_function_with_arrays_is_tried():
    names = functions_of_arrays(gw.measures) | functions_of_arrays(gw.theory)
    assert names == {*ARGUMENTS, *OF_A_RUN, *OF_A_LINE}
