"""Ways to start contacts of grains at user-defined positions that overlap, or that nearly touch:
``packing.contacts``.
"""

from __future__ import annotations

import dataclasses

CONTACTS = "contacts"
TOLERANCE = "touch_tolerance"
RELAXATION = "relaxation"
SPRINGS = "springs"
DAMPED = "damped"
RELAXATIONS = ("minimiser", DAMPED)
KEY = f"packing.{CONTACTS}"


@dataclasses.dataclass(frozen=True)
class ContactWay:
    """Way to start contacts.

    Attributes
    ----------
    name
        Value of ``packing.contacts``.
    summary
        Effect, for the description of this key.
    moves_grains
        True if grains are first moved until contacts within the tolerance just touch.
    presses
        True if grains that overlap press each other from the start.
    balances
        True if the grains reach equilibrium before the run.
    rearranges
        True if grains may move far on the way to balance.
    """

    name: str
    summary: str
    moves_grains: bool = False
    presses: bool = False
    balances: bool = False
    rearranges: bool = False


TOUCH = ContactWay(
    "touch",
    "grains move by least squares until the pairs within the tolerance just touch, for crystals "
    "whose file is rounded",
    moves_grains=True,
)
OVERLAPS = ContactWay(
    "overlaps",
    "overlaps act as contact forces, and the grains reach equilibrium near their positions",
    presses=True,
    balances=True,
)
RELAX = ContactWay(
    "relax",
    "overlaps act as contact forces, and the grains reach equilibrium at any distance from their "
    "positions",
    presses=True,
    balances=True,
    rearranges=True,
)
KEEP = ContactWay(
    "keep",
    "the run starts with the grains, overlaps and forces of the file",
    presses=True,
)
CONTACT_WAYS = {way.name: way for way in (TOUCH, OVERLAPS, RELAX, KEEP)}


def described_ways() -> str:
    """Return the choices with their summaries, in one sentence."""
    return "; ".join(f"{way.name}: {way.summary}" for way in CONTACT_WAYS.values())
