"""Symbols and numbers on the pages of results: names of rows keep plain text such as ``F_y`` and
``1e+06 Pa``; the pages show formulas and prefixes of units.
"""

from __future__ import annotations

import re

from results_rows import escaped

#: Symbols in names, captions and remarks, longest first, and their formulas.
_FORMULAS = {
    "sigma_y^2 D^3 / E": r"$\sigma_y^2 D^3/E$",
    "sigma_y^2 D^3/E": r"$\sigma_y^2 D^3/E$",
    "sigma_y² D³/E": r"$\sigma_y^2 D^3/E$",
    "pi D^3/6": r"$\pi D^3/6$",
    "pi D³/6": r"$\pi D^3/6$",
    "F_y alpha_y": r"$F_y \alpha_y$",
    "(x/R*) F/(E*R*^2 I)": r"$(x/R^*)\,F/(E^* R^{*2} I)$",
    "E*R*^2 tau": r"$E^* R^{*2} \tau$",
    "E*R*^2 I": r"$E^* R^{*2} I$",
    "E* R*^2": "$E^* R^{*2}$",
    "E*R*^2": "$E^* R^{*2}$",
    "0.01 E* R": "$0.01 E^* R$",
    "(m^3 E*^2 R* v^6)^(1/5)": r"$(m^3 E^{*2} R^* v^6)^{1/5}$",
    "(4 E^2 F0/(a^2 rho^3 (1-nu^2)^2))^(1/6)": (r"$[4 E^2 F_0/(a^2 \rho^3 (1 - \nu^2)^2)]^{1/6}$"),
    "T/tau times (A/(E* R*^2))^(1/6)": r"$(T/\tau)\,[A/(E^* R^{*2})]^{1/6}$",
    "v sqrt(pi/2 rho (1 - nu^2)/E)": r"$v \sqrt{\pi \rho (1 - \nu^2)/(2E)}$",
    "sqrt(9/pi) 3^(-1/3) 4^(-1/6)": r"$\sqrt{9/\pi}\,3^{-1/3}\,4^{-1/6}$",
    "sqrt(gamma^2 + 2 gamma) + gamma = 1": r"$\sqrt{\gamma^2 + 2\gamma} + \gamma = 1$",
    "2 sqrt(k/m)": r"$2\sqrt{k/m}$",
    "2 sqrt(K/m)": r"$2\sqrt{K/m}$",
    "sqrt(2 k/M)": r"$\sqrt{2k/M}$",
    "sqrt(2 k/m)": r"$\sqrt{2k/m}$",
    "sqrt(2 k (1/m + 1/M))": r"$\sqrt{2k(1/m + 1/M)}$",
    "sqrt(K/m) sqrt(1 - (w/2)^2 m/K)": r"$\sqrt{K/m}\,\sqrt{1 - (w/2)^2 m/K}$",
    "sqrt(K/m)": r"$\sqrt{K/m}$",
    "(sqrt(k/m) I)": r"($\sqrt{k/m}\,I$)",
    "sqrt(1 - beta)": r"$\sqrt{1 - \beta}$",
    "sqrt(m_b/k_bb)": r"$\sqrt{m_b/k_{bb}}$",
    "sqrt(k_bb/m_b)": r"$\sqrt{k_{bb}/m_b}$",
    "tau* = D sqrt(rho/sigma_y)": r"$\tau^* = D\sqrt{\rho/\sigma_y}$",
    "D sqrt(rho/sigma_y)": r"$D\sqrt{\rho/\sigma_y}$",
    "sqrt(m/sigma_y)": r"$\sqrt{m/\sigma_y}$",
    "e_T/e_0T": "$e_T/e_{0T}$",
    "k ~ sigma_y R*": r"$k \sim \sigma_y R^*$",
    "tau*": r"$\tau^*$",
    "f_r": "$f_r$",
    "sqrt(8/15)": r"$\sqrt{8/15}$",
    "cos^4": r"$\cos^4$",
    "cos^2.5": r"$\cos^{2.5}$",
    "2 delta tan(theta)": r"$2 \delta \tan\theta$",
    "eta_hat": r"$\hat{\eta}$",
    "n eps^3/A^2 (w_1'^2 + u_1'^2)": r"$n \epsilon^3/A^2\,(w_1'^2 + u_1'^2)$",
    "c^2 w''": "$c^2 w''$",
    "k_w": "$k_w$",
    "a = 2 delta/D": r"$a = 2\delta/D$",
    "k_w/k_bb": "$k_w/k_{bb}$",
    "4 (k_t - F/d)/m": "$4(k_t - F/d)/m$",
    "4 k_t l^2/I": "$4 k_t l^2/I$",
    "4 k/m": "$4k/m$",
    "sqrt(3)/2 W": r"$\sqrt{3}\,W/2$",
    "4 e^3/(1 + e^3)^2": "$4e^3/(1 + e^3)^2$",
    "c0 = h sqrt((2 k - f/D)/m)": r"$c_0 = h\sqrt{(2k - f/D)/m}$",
    "h = D sqrt(2/3)": r"$h = D\sqrt{2/3}$",
    "D sqrt(2/3)": r"$D\sqrt{2/3}$",
    "k = 3/2 f/alpha": r"$k = 3f/(2\alpha)$",
    "d0 + d1 F + d2 F^2": "$d_0 + d_1 F + d_2 F^2$",
    "F_peak/I^(6/5)": "$F_{peak}/I^{6/5}$",
    "A/I^(6/5)": "$A/I^{6/5}$",
    "F^(-1/6)": "$F^{-1/6}$",
    "F^(5/3)": "$F^{5/3}$",
    "F_m/F0": "$F_m/F_0$",
    "v_m m/I": "$v_m m/I$",
    "F_p": "$F_p$",
    "F_m": "$F_m$",
    "F_2": "$F_2$",
    "omega^2": r"$\omega^2$",
    "delta_hat": r"$\hat{\delta}$",
    "sigma_y": r"$\sigma_y$",
    "alpha_y": r"$\alpha_y$",
    "F_y": "$F_y$",
    "k_bb": "$k_{bb}$",
    "k_t": "$k_t$",
    "v0^2/2": "$v_0^2/2$",
    "v0²/2": "$v_0^2/2$",
    "c0": "$c_0$",
    "F0": "$F_0$",
    "N2": "$N_2$",
    "R*": "$R^*$",
    "E*": "$E^*$",
    "gamma": r"$\gamma$",
    "beta": r"$\beta$",
    "lambda": r"$\lambda$",
    "alpha": r"$\alpha$",
}
_WORDS = "|".join(re.escape(escaped(word)) for word in sorted(_FORMULAS, key=len, reverse=True))
#: A symbol on a page; code, links' targets and formulas are matched first and stay.
_ON_PAGE = re.compile(
    rf"(?P<kept>`[^`]*`|\]\([^)]*\)|(?<!\\)\$[^$]*(?<!\\)\$)"
    rf"|(?<![\w$\\^_./])(?P<symbol>{_WORDS})(?![\w^*]|\\\*|\\_)"
)
#: A power of one letter or number, and a square root of one letter.
_ON_PAGE_TOO = re.compile(
    r"(?P<kept>`[^`]*`|\]\([^)]*\)|(?<!\\)\$[^$]*(?<!\\)\$)"
    r"|(?<![\w$\\])(?P<base>[A-Za-z]|\d+)\^(?:\((?P<fraction>-?[\d/]+)\)|(?P<number>\d+(?:\.\d+)?))"
    r"|(?<=layers)\^(?P<of_word>\d+(?:\.\d+)?)"
    r"|sqrt\((?P<letter>\w)\)"
)
_OF_ESCAPED = {escaped(word): formula for word, formula in _FORMULAS.items()}
_PLAIN = ("#", "![", ":::", "```")  # starts of lines without formulas

_POWER = r"(?P<mantissa>-?\d+(?:\.\d+)?)e(?P<power>[+-]?\d+)"
_PREFIXES = {9: "G", 6: "M", 3: "k", 0: ""}
_PRESSURES = re.compile(rf"{_POWER} Pa(?!\w)")
_PRESSURE_RANGE = re.compile(rf"{_POWER}(?= to (?:-?\d+(?:\.\d+)?)e(?:[+-]?\d+) Pa)")
_PLAIN_POWER = re.compile(rf"(?<![\w.^]){_POWER}(?!\w|\.\d)")
_UNITS = (
    (re.compile(r"(?<=\d )u(?=[ms]\b)"), "µ"),
    (re.compile(r"\bkg/m3\b"), "kg/m³"),
    (re.compile(r"\bg/m3\b"), "g/m³"),
    (re.compile(r"\bJ/N\^2"), "J/N²"),
    (re.compile(r"(?<=\d)%"), " %"),
)
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_LARGEST = 5  # power of ten of numbers that are written out
_GROUPED = 10000  # from which on digits are grouped


def readable_numbers(text: str) -> str:
    """Return a text with 1 MPa for ``1e+06 Pa``, 3790 for ``3.79e+03``, and µm for ``um``."""
    text = _PRESSURE_RANGE.sub(_pressure, text)
    text = _PRESSURES.sub(_pressure, text)
    for pattern, unit in _UNITS:
        text = pattern.sub(unit, text)
    return _PLAIN_POWER.sub(_number, text)


def _pressure(found: re.Match[str]) -> str:
    value = float(found["mantissa"]) * 10 ** int(found["power"])
    power = next((power for power in _PREFIXES if abs(value) >= 10**power), 0)
    return f"{value / 10**power:g} {_PREFIXES[power]}Pa"


def _number(found: re.Match[str]) -> str:
    power = int(found["power"])
    if 0 <= power < _LARGEST:
        value = float(found["mantissa"]) * 10**power
        if value >= _GROUPED:
            return f"{value:,.0f}".replace(",", "\N{NO-BREAK SPACE}")
        return f"{value:g}"
    mantissa = "" if found["mantissa"] == "1" else f"{found['mantissa']} × "
    return f"{mantissa}10{str(power).translate(_RAISED)}"


def with_formulas(page: str) -> str:
    """Return a page of Markdown with formulas for symbols, except in headings and figures."""
    lines = page.split("\n")
    return "\n".join(line if line.startswith(_PLAIN) else _typeset(line) for line in lines)


def _formula(found: re.Match[str]) -> str:
    return found["kept"] or _OF_ESCAPED[found["symbol"]]


def _typeset(line: str) -> str:
    """Return a line with formulas for its symbols, powers and roots."""
    return _ON_PAGE_TOO.sub(_power_or_root, _ON_PAGE.sub(_formula, line))


def _power_or_root(found: re.Match[str]) -> str:
    if found["kept"]:
        return found["kept"]
    if found["letter"]:
        return rf"$\sqrt{{{found['letter']}}}$"
    if found["of_word"]:
        return f"$^{{{found['of_word']}}}$"
    return f"${found['base']}^{{{found['fraction'] or found['number']}}}$"
