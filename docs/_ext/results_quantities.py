"""Names of stored quantities in parts: what is compared, and the conditions with their numbers.

"V, N2 = 3, elastic" is the quantity "V" under the conditions "N2 = 3" and "elastic"; the number 3
belongs to the condition "N2 = {}". The figures of values group rows by these parts.
"""

from __future__ import annotations

import dataclasses
import re
import textwrap

from results_symbols import readable_numbers

_NUMBER = re.compile(r"(?<![\w.^*])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.]*[a-zA-Z_]\d|\w)")
_BREAK = re.compile(r", |; |(?<=[^:]{4}): ")
_AT = re.compile(r" at (?=(?:[a-z]+ )?-?\d)(?!.* / )")
_BOUND = re.compile(r", at (?:most|least)(?=$|[:,])")
#: Quantities whose numbered conditions are categories, with the template of the condition.
_CATEGORIES = {"Effective modulus": "contact {}"}
#: Names whose order of words hides the conditions; each pattern with the name used here.
_REWORDED = tuple(
    (re.compile(pattern), name)
    for pattern, name in (
        (r"; source: ", r", source's "),
        (r"^V(?=, )", r"Speed V"),
        (
            r"^(Test \d), (.*?) of finite elements at (incidence [\d.]+), (.*)$",
            r"\1 \2, \3, finite elements, \4",
        ),
        (r"^(Test [56]), (.*?) at (incidence [\d.]+, \w+)$", r"\1 \2, \3, one spring"),
        (r"^(Test \d), (case \w, )?(.*?) at (incidence .*)$", r"\1 \3, \4, \2"),
        (
            r"^(Tangential restitution|Spin|Rebound angle) measured at ([\d.]+ degrees), (.*)$",
            r"\1, \2, measured, \3",
        ),
        (
            r"^(Tangential restitution|Spin|Rebound angle) at ([\d.]+ degrees, \w+)$",
            r"\1, \2, one spring",
        ),
        (r"^Energy in (.*), (.*)$", r"Energy, \1, \2"),
        (r"^Pulse length, (fit|half maximum) of (\w+), ", r"Pulse length (\1 of \2), "),
        (r"^(Restitution) at (.* m/s) (with / without .*)$", r"\1 \3, \2"),
        (r"^(Dissipated fraction), impact (on \d spheres / on one), ", r"\1, \2, "),
        (r"(small spheres moved inwards) by ", r"\1, "),
        (r"first peak at (sphere \d+) (falls|is later)", r"first peak (\1) \2"),
        (r" (\d+\.\d+) ms$", lambda found: f" {1000 * float(found[1]):.4g} µs"),
    )
)


@dataclasses.dataclass(frozen=True)
class Condition:
    """A condition of a quantity.

    Attributes
    ----------
    text
        The condition as in the name.
    template
        The condition with {} for each number.
    numbers
        The numbers.
    """

    text: str
    template: str
    numbers: tuple[float, ...]


@dataclasses.dataclass(frozen=True)
class Quantity:
    """A name in parts: what is compared, and its conditions in the order of the name."""

    base: str
    conditions: tuple[Condition, ...]


def quantity_of(name: str) -> Quantity:
    """Return the parts of the name of a stored quantity."""
    name = _BOUND.sub("", name)
    for pattern, reworded in _REWORDED:
        name = pattern.sub(reworded, name)
    base, *conditions = _pieces(name)
    base, *places = _AT.split(base, maxsplit=1)
    texts = [text for text in (*places, *conditions) if text]
    conditions_of_base = tuple(_condition(text) for text in texts)
    return Quantity(base, tuple(_categorical(base, one) for one in conditions_of_base))


def _pieces(name: str) -> list[str]:
    """Return a name split at commas, semicolons and colons that are outside brackets."""
    pieces = [""]
    end = 0
    for found in _BREAK.finditer(name):
        before = name[: found.start()]
        if before.count("(") == before.count(")"):
            pieces.append(name[end : found.start()])
            end = found.end()
    return [*pieces[1:], name[end:].removesuffix(",").strip()]


def _condition(text: str) -> Condition:
    return Condition(
        text,
        _NUMBER.sub("{}", text),
        tuple(float(number) for number in _NUMBER.findall(text)),
    )


def _categorical(base: str, condition: Condition) -> Condition:
    """Return a condition without its numbers if they are names of categories of the quantity."""
    if condition.template != _CATEGORIES.get(base):
        return condition
    return Condition(condition.text, condition.text, ())


#: Abscissae whose words in the name are not enough: template of the condition, label of the axis.
_ABSCISSAE = {
    "{} MPa": "modulus (MPa)",
    "{} m/s": "speed of the impact (m/s)",
    "{} degrees": "angle of incidence (degrees)",
    "{} of the zone": "wave number / edge of the zone",
    "{} Pa": "pressure (Pa)",
    "{} alpha_y": "overlap / alpha_y",
    "I {} ({} kN, {} µs)": "impulse I (dimensionless)",
    "unloaded from {} alpha_y": "largest overlap / alpha_y",
    "specified as {}": "specified restitution",
    "small beads of {}": "diameter of the small beads / diameter of the others",
    "{} µs": "period (µs)",
    "beads {} to {}": "first bead of the range of the fit",
    "impact at {} m/s": "speed of the impact (m/s)",
    "{} N": "force (N)",
    "{} cylinders": "number of cylinders",
    "radii {} to {} / finite elements of equal radii": "ratio of the radii",
}


def abscissa(template: str) -> str:
    """Return the label of an axis for the first number of a condition, with its unit."""
    if template in _ABSCISSAE:
        return _ABSCISSAE[template]
    words, _, unit = template.partition("{}")
    words = re.sub(r"( =| of| from| at)?\s*$", "", words)
    unit = unit.partition("(")[0].partition(" to {}")[0].strip()
    return f"{words} ({unit})".strip() if unit else words


_SYMBOLS = {
    "alpha_y": r"$\alpha_y$",
    "sigma_y^2 D^3/E": r"$\sigma_y^2 D^3/E$",
    "D^3/6": "$D^3/6$",
    "E*R*^2 tau": r"$E^* R^{*2} \tau$",
    "E*R*^2 I": "$E^* R^{*2} I$",
    "E* R*^2": "$E^* R^{*2}$",
    "E*R*^2": "$E^* R^{*2}$",
    "sqrt(1 - beta)": r"$\sqrt{1 - \beta}$",
    "k_w/k_bb": "$k_w/k_{bb}$",
    "v0²/2": "$v_0^2/2$",
    "N2": "$N_2$",
    "c0": "$c_0$",
    "sigma_y": r"$\sigma_y$",
    "F_y": "$F_y$",
    "delta_hat": r"$\hat{\delta}$",
    "alpha": r"$\alpha$",
    "beta": r"$\beta$",
    "gamma": r"$\gamma$",
    "lambda": r"$\lambda$",
    "F_m/F0": "$F_m/F_0$",
    "F0": "$F_0$",
    "um": "µm",
    "us": "µs",
    "omega^2": r"$\omega^2$",
}


#: Spaces before a number and between a number and its unit, at which no line ends.
_KEPT = re.compile(r" (?=-?\d)|(?<=\d) (?=(?:%|J|N|kN|g|mm|µm|µs|ms|kg|Pa|MPa|GPa|m/s)(?!\w))")
_PRIVATE = 0xE000  # first character of Unicode without a meaning


def typeset(text: str) -> str:
    """Return a text with its symbols as in an equation."""
    return "\n".join(lines_of(text, len(text) + 1))


def lines_of(text: str, characters: int) -> list[str]:
    """Return a text in lines of a number of characters, with its symbols as in an equation."""
    marks = {
        chr(_PRIVATE + number) * max(len(word) // 2, 1): word
        for number, word in enumerate(_SYMBOLS)
    }
    text = readable_numbers(text)
    for mark, word in marks.items():
        text = re.sub(rf"(?<![\w$\\]){re.escape(word)}(?!\w)", mark, text)
    text = _KEPT.sub("\N{NO-BREAK SPACE}", text)
    filled = "\n".join(textwrap.wrap(text, characters, break_on_hyphens=False))
    for mark, word in marks.items():
        filled = filled.replace(mark, _SYMBOLS[word])
    return filled.split("\n")
