"""Column numbers of the computes and fixes of the plugin; plugins/doc has a table of each."""

from __future__ import annotations

from enum import IntEnum


class PluginColumn(IntEnum):
    """Column of an array, or component of a vector, that LAMMPS counts from 1."""

    def of(self, source: str) -> str:
        """Return the reference to this column of a compute or fix, such as ``c_sphere[2]``."""
        return f"{source}[{self.value}]"


class DisplacementColumn(PluginColumn):
    """Columns of compute displace/atom, of LAMMPS itself."""

    Z = 3
    MAGNITUDE = 4


class SphereColumn(PluginColumn):
    """Columns of compute gran/hysteretic/atom that are used."""

    FORCE = 1
    PEAK_FORCE = 2
    PEAK_OVERLAP = 3
    DISSIPATED = 4
    COORDINATION = 6
    ELASTIC = 10
    ELASTIC_TANGENTIAL = 11
    FRICTION = 12
    VISCOUS = 13


class EnergyColumn(PluginColumn):
    """Components of compute gran/hysteretic/energy: sums over all contacts."""

    DISSIPATED = 1
    YIELDED = 2
    BEYOND_LAW = 3
    BEYOND_HALF = 4
    LARGEST_FORCE = 5
    ELASTIC_TANGENTIAL = 6
    FRICTION = 7
    VISCOUS = 8
    ELASTIC_ROLLING = 9
    ROLLING = 10
    ELASTIC_TWISTING = 11
    TWISTING = 12
    ADHESION = 13


class PairColumn(PluginColumn):
    """Components of compute gran/hysteretic/contact that are used: a contact of two atoms."""

    FORCE = 2
    ELASTIC = 4
    DISSIPATED = 5
    VISCOUS = 8


class WallColumn(PluginColumn):
    """Components of the vector of fix wall/gran/hysteretic that are used."""

    FORCE_X = 1
    FORCE_Y = 2
    FORCE_Z = 3
    ELASTIC = 4
    DISSIPATED = 5
    ELASTIC_TANGENTIAL = 8
    FRICTION = 9
    DISPLACEMENT = 10
    VELOCITY = 11
    SUPPORT_ENERGY = 12
    SUPPORT_LOSS = 13
    GROUND_FORCE = 14
    WORK = 15
    VISCOUS = 16
    ELASTIC_ROLLING = 17
    ROLLING = 18
    ELASTIC_TWISTING = 19
    TWISTING = 20
    ADHESION = 21


WALL_FORCE = (WallColumn.FORCE_X, WallColumn.FORCE_Y, WallColumn.FORCE_Z)
