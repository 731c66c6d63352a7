"""Small waves as ``granwave check`` tells them, against the closed forms of a loaded Hertzian chain."""

from __future__ import annotations

import math
import re

import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.workflows.cli.check import wave_rows
from granwave.workflows.cli.plan_values import small_waves
from granwave.workflows.library import find_for, load_case

FORCE, DIAMETER = 20.0, 0.010


def chain(**changes):
    tables = {
        "packing.diameter": DIAMETER, "packing.size": 40, "precompression.force": FORCE, "material": "steel",
        "contact.law": "hertz", **changes,
    }  # fmt: skip
    return load_case("precompressed-chain", tables)


def closed_forms():
    """Cut-off, Hz, and speed of long waves, m/s: stiffness k = 3/2 F/overlap of Hertz's law."""
    case = chain()
    modulus = case.material.youngs_modulus / (1 - case.material.poisson_ratio**2) / 2
    radius = DIAMETER / 4
    overlap = (3 * FORCE / (4 * modulus * math.sqrt(radius))) ** (2 / 3)
    stiffness, mass = 1.5 * FORCE / overlap, case.material.density * math.pi * DIAMETER**3 / 6
    return math.sqrt(stiffness / mass) / math.pi, DIAMETER * math.sqrt(stiffness / mass)


def numbers(text):
    return [float(one) for one in re.findall(r"\d+(?:\.\d+)?(?:e[-+]\d+)?", text)]


def test_cut_off_and_speed():
    cut_off, speed = closed_forms()
    rows = list(wave_rows(small_waves(chain())))
    assert numbers(rows[0][1])[0] == pytest.approx(cut_off * 1e-3, rel=1e-3)
    assert numbers(rows[1][1])[0] == pytest.approx(speed, rel=2e-3)


@pytest.mark.parametrize(("share", "fate"), [(0.5, "passes"), (1.1, "is stopped")])
def test_frequency_of_the_load(share, fate):
    cut_off, _ = closed_forms()
    load = {"load": {"kind": "force", "shape": "harmonic", "amplitude": 0.01, "frequency": share * cut_off}}
    rows = list(wave_rows(small_waves(chain(**load))))
    assert rows[-1][0] == "load's frequency" and rows[-1][1].endswith(fate)


def test_nothing_without_a_static_force():
    assert small_waves(load_case("elastic-impact")) is None


def test_a_case_of_inference_is_named_as_such(tmp_path):
    file = tmp_path / "crystal.toml"
    file.write_text("[infer]\nfriction = 0.3\n")
    with pytest.raises(InputError, match=r"granwave infer GRAINS\.csv --case"):
        find_for(str(file), "run", "continuum")
