"""Sources of the compared values: names with author and year, and the bibliography.

The rows of studies name four sources by short words, such as "thesis 2.25". The pages show author
and year in place of these words.
"""

from __future__ import annotations

import re

#: Start of the place of a row, and the name that the pages show.
_NAMES = (
    (re.compile(r"^thesis fig(?:ure)?(s?)\.? ?", re.IGNORECASE), r"Pal 2015, Fig\1. "),
    (re.compile(r"^thesis\b,? ?(?=\w)", re.IGNORECASE), "Pal 2015, "),
    (re.compile(r"^thesis\b", re.IGNORECASE), "Pal 2015"),
    (re.compile(r"^composite(?: chain)?\b"), "Wu et al. 2019"),
    (re.compile(r"^square packing\b"), "Leonard et al. 2013"),
    (re.compile(r"^lateral constraints\b"), "J. Appl. Mech. 2020"),
)
_LINKED = re.compile(
    r"Pal 2015|Wu et al\. 2019|Leonard et al\. 2013|J\. Appl\. Mech\. 2020|Chung and Ooi 2011|"
    r"Kharaz et al\. 2001"
)
#: Anchor of the bibliography on the page of results.
ANCHOR = "#sources"
BIBLIOGRAPHY = """\
The tables name the main sources by author and year:

* **Pal 2015**: R. K. Pal, *Wave tailoring in elastic and elastoplastic granular systems*, thesis,
  University of Illinois at Urbana-Champaign, 2015. The numbers after the name are its chapters,
  sections and equations.
* **Wu et al. 2019**: B. Wu, H. Wang, X. Liu, M. Li, Z. Liu and C. He, *Tuning the propagation
  characteristics of the trapped and released strongly nonlinear solitary waves in 1-D composite
  granular chain of spheres*, J. Mech. Mater. Struct. 14 (2019) 343. Our scan begins with the
  abstract, by which we identified the paper.
* **Leonard et al. 2013**: A. Leonard, F. Fraternali and C. Daraio, *Directional wave propagation in
  a highly nonlinear square packing of spheres*, Exp. Mech. 53 (2013) 327.
* **J. Appl. Mech. 2020**: *Influence of lateral constraints on wave propagation in finite granular
  crystals*, J. Appl. Mech. (2020), doi 10.1115/1.4047004. Our scan lacks the authors.
* **Chung and Ooi 2011**: Y. C. Chung and J. Y. Ooi, Granul. Matter 13 (2011) 643.
* **Kharaz et al. 2001**: A. H. Kharaz, D. A. Gorham and A. D. Salman, Powder Technol. 120 (2001)
  281.

The pages by subject name further sources where they are used."""


def named(place: str) -> str:
    """Return the place in a source with author and year."""
    for pattern, name in _NAMES:
        if pattern.search(place):
            return pattern.sub(name, place, count=1)
    return place


def linked(place: str, page: str) -> str:
    """Return a place in a source, whose names are linked to the bibliography of a page."""
    return _LINKED.sub(lambda found: f"[{found[0]}]({page}{ANCHOR})", place)
