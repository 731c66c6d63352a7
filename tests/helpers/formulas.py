"""Displayed equations of pages, as expressions that Python evaluates."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

FUNCTIONS = ("sqrt", "ln", "min", "max", "A", "p")
NAMES = {"sqrt": math.sqrt, "ln": math.log, "min": min, "max": max, "e": math.e, "pi": math.pi}
SIGNS = {"^{*2}": "_star**2", "^*": "_star", r"\le ": "<=", r"\ge ": ">=", r"\times": "*"}
WORDS = "alpha|sigma|nu|pi|sqrt|ln|min|max"
CASES = re.compile(r"\\begin\{cases\}(.*)\\end\{cases\}", re.DOTALL)
BLOCK = re.compile(r"^ *\$\$\n(.*?)^ *\$\$$", re.MULTILINE | re.DOTALL)
TOKEN = re.compile(rf"[\d.]+|(?:{WORDS}|[A-Za-z])(?:_\w+)?|\*\*|[<>]=?|[-+*/(),]")


def equations(text: str) -> dict[str, str]:
    """Right sides of the displayed equations of a text, in TeX, by their left sides."""
    sides = {}
    for block in BLOCK.findall(text):
        block = re.sub(r"\\(?:begin|end)\{split\}", "", block)
        rows = [block] if "{cases}" in block else re.split(r"\\\\|,\s*\\qquad", block)
        for row in rows:
            left, _, right = row.partition("=")
            sides[left.replace("&", "").strip()] = right.strip()
    return sides


def value(formula: str, names: Mapping[str, Any]) -> float:
    """Value of a formula in TeX; a formula of several cases has the first whose condition holds."""
    if cases := CASES.search(formula):
        for row in cases[1].split(r"\\"):
            case, _, condition = row.partition("&")
            if value(condition, names):
                return value(case, names)
        raise ValueError(f"no case of {formula} holds")
    return eval(expression(formula), {**NAMES, **names})


def expression(formula: str) -> str:
    """Formula without cases, as an expression of Python."""
    text = re.sub(r"\\quad.*|\\[,!]|\\(?:left|right|bigl|bigr)\b", " ", formula)
    for sign, written in SIGNS.items():
        text = text.replace(sign, written)
    text = re.sub(r"_\\text\{(\w+)\}|_\{(\w),(?:\\text\{)?(\w+)\}?\}|_(\w)", subscript, text)
    text = re.sub(rf"\\({WORDS})(?![a-z])", r"\1", without_braces(text))
    words = TOKEN.findall(text)
    assert "".join(words) == "".join(text.split()), (
        f"{text} has other commands than those read here"
    )
    return " ".join(with_products(words))


def subscript(found: re.Match[str]) -> str:
    """Subscript as the end of a name."""
    return "_" + "".join(part for part in found.groups() if part)


def without_braces(text: str) -> str:
    """Fractions, roots and powers with brackets, from the innermost."""
    before = ""
    while text != before:
        before = text
        text = re.sub(r"\\[dt]?frac\{([^{}]*)\}\{([^{}]*)\}", r"((\1)/(\2))", text)
        text = re.sub(r"\\sqrt(?:\{([^{}]*)\}| (\w))", r"sqrt(\1\2)", text)
        text = re.sub(r"\^(?:\{([^{}]*)\}|(\w))", r"**(\1\2)", text)
    return text


def with_products(words: list[str]) -> list[str]:
    """Words with the signs of products that a formula does not have."""
    joined: list[str] = []
    for word in words:
        begins = word == "(" or word[0].isalnum()
        if joined and begins and ends_factor(joined[-1]):
            joined.append("*")
        joined.append(word)
    return joined


def ends_factor(word: str) -> bool:
    """Return True for a number, a closing bracket, and a name that is not a function."""
    return word == ")" or (word[0].isalnum() and word not in FUNCTIONS)
