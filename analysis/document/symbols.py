"""Symbols in texts of a report, such as ``F_y`` and ``sigma_y^-2.5``: MathML, or HTML for paper.

Texts contain symbols in the notation of plain text, which Markdown shows unchanged.
"""

from __future__ import annotations

import re

from markupsafe import Markup, escape

_GREEK = {"alpha": "\u03b1", "sigma": "\u03c3", "rho": "\u03c1", "pi": "\u03c0"}
_BAR = "\u0304"  # combines with the letter before it
_OVERLINE = "\u00af"
_MINUS = "\u2212"
_LETTER = rf"E\*|R\*|v{_BAR}|alpha|sigma|rho|pi|[A-Zevz]"
_SUBSCRIPT = r"_(?P<low>y|max|in|dis|p|0)(?![A-Za-z_])"  # others are parts of names
_POWER = r"\^(?P<high>-?(?:\d+(?:\.\d+)?|n))"
_EFFECTIVE = ("E*", "R*")
_SYMBOL = re.compile(
    r"(?P<root>sqrt(?:\((?P<inner>rho|\d+)\)| (?P<number>\d+)))"
    rf"|(?P<close>\)){_POWER.replace('high', 'of_bracket')}"
    rf"|(?<![\w.^/*-])(?P<letter>{_LETTER})(?:{_SUBSCRIPT})?(?:{_POWER})?(?![\w(])"
)


def with_symbols(text: str, *, paper: bool = False) -> Markup:
    """Return a text as HTML with its symbols as MathML.

    Parameters
    ----------
    paper
        True for italics, subscripts and superscripts in place of MathML, which the PDF lacks.
    """
    parts = []
    end = 0
    for match in _SYMBOL.finditer(text):
        formula = _formula(match, paper=paper)
        if formula:
            parts += [escape(text[end : match.start()]), Markup(formula)]
            end = match.end()
    return Markup("").join([*parts, escape(text[end:])])


def _formula(match: re.Match[str], *, paper: bool) -> str:
    """Return a symbol; empty for a letter that is a word, such as an article."""
    if match["root"]:
        return _root(match["inner"] or match["number"], paper=paper)
    if match["close"]:
        return _scripts(")", "", match["of_bracket"], paper=paper)
    letter = match["letter"]
    low = match["low"] or ""
    high = match["high"] or ""
    if not (low or high or letter in (*_EFFECTIVE, "rho", "pi")):
        return ""
    return _scripts(letter, low, high, paper=paper)


def _root(inner: str, *, paper: bool) -> str:
    radicand = _GREEK.get(inner, inner)
    if paper:
        return f"√{radicand}"
    if inner.isdigit():
        return f"<math><msqrt><mn>{radicand}</mn></msqrt></math>"
    return f"<math><msup><mi>{radicand}</mi><mn>1/2</mn></msup></math>"  # fits every font


def _scripts(letter: str, low: str, high: str, *, paper: bool) -> str:
    """Return a letter with a subscript and a power, each of which may be empty."""
    power = high.replace("-", _MINUS)
    if letter in _EFFECTIVE:
        power = f"*{power}"
    name = _GREEK.get(letter, letter.removesuffix("*"))
    if paper:
        base = name if name == ")" else f"<i>{name}</i>"
        return (
            base + (f"<sub>{low}</sub>" if low else "") + (f"<sup>{power}</sup>" if power else "")
        )
    return f"<math>{_scripts_of(_base(name), low, power)}</math>"


def _base(name: str) -> str:
    if name == ")":
        return "<mo stretchy='false'>)</mo>"
    if name.endswith(_BAR):
        return f"<mover><mi>{name[0]}</mi><mo>{_OVERLINE}</mo></mover>"
    return f"<mi>{name}</mi>"


def _scripts_of(base: str, low: str, power: str) -> str:
    below = f"<mtext>{low}</mtext>"
    above = f"<mn>{power}</mn>"
    if low and power:
        return f"<msubsup>{base}{below}{above}</msubsup>"
    if low:
        return f"<msub>{base}{below}</msub>"
    return f"<msup>{base}{above}</msup>" if power else base
