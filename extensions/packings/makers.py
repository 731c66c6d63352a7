"""The kinds of packings that this extension makes."""

from __future__ import annotations

from granwave.extensions.packings.compressed import CompressedMaker
from granwave.extensions.packings.poured import PouredMaker
from granwave.extensions.packings.recipe import BedMaker

MAKERS: tuple[BedMaker, ...] = (PouredMaker(), CompressedMaker())
