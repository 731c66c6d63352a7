"""Symbols in the texts of a report: MathML on screens, italics and subscripts on paper, and nothing
in names.
"""

from __future__ import annotations

import pytest

from granwave.analysis.document.symbols import with_symbols


@pytest.mark.parametrize(
    ("text", "mathml", "paper"),
    [
        ("F_y", "<msub><mi>F</mi><mtext>y</mtext></msub>", "<i>F</i><sub>y</sub>"),
        (
            "sigma_y^-2.5",
            "<msubsup><mi>\u03c3</mi><mtext>y</mtext><mn>\u22122.5</mn></msubsup>",
            "<i>\u03c3</i><sub>y</sub><sup>\u22122.5</sup>",
        ),
        ("E*^2", "<msup><mi>E</mi><mn>*2</mn></msup>", "<i>E</i><sup>*2</sup>"),
        ("sqrt(rho)", "<msup><mi>\u03c1</mi><mn>1/2</mn></msup>", "\u221a\u03c1"),
        ("sqrt 3", "<msqrt><mn>3</mn></msqrt>", "\u221a3"),
    ],
)
def test_symbols(text, mathml, paper):
    assert with_symbols(text) == f"<math>{mathml}</math>"
    assert with_symbols(text, paper=True) == paper


@pytest.mark.parametrize(
    "text", ["peak_force_N", "run_a", "e_small_x", "material.density", "3e-5", "I and A", "F_yield"]
)
def test_names_and_words_stay(text):
    assert with_symbols(text) == text


def test_other_markup_is_escaped():
    assert with_symbols("<b> & (2/sqrt 3)").startswith("&lt;b&gt; &amp; (2/<math>")
    assert with_symbols("<b> & (2/sqrt 3)").endswith("</math>)")
