"""Expected size of the plastic zone, and the warning that a packing will cut it."""

from __future__ import annotations

from granwave.analysis.measures.zone_size import bounds_in_words
from granwave.lammps_inputs.planning.cost import ExpectedZone


def plastic_zone(zone: ExpectedZone | None) -> str:
    """Return an estimate of the size of the plastic zone; empty if there is none."""
    if zone is None:
        return ""
    if "sides" not in zone.room and zone.reaches:
        return "the whole chain"
    within = f", within a factor of {zone.spread:g}" if zone.spread > 1 else " or deeper"
    radius = f", radius {zone.radius:.2g} m" if zone.radius else ""
    larger = f"about {zone.depth:.2g} m deep{radius}{within}"
    if not zone.reaches:
        return larger
    names = " and the ".join(_name(zone, bound) for bound in zone.reaches)
    return f"to the {names} of the packing; in a larger one {larger}"


def _name(zone: ExpectedZone, bound: str) -> str:
    """Return the name of a boundary in texts."""
    return bounds_in_words([bound], periodic=zone.periodic)


def expected_cut(zone: ExpectedZone | None) -> str:
    """Return a warning that a packing will cut the plastic zone; empty if the zone has room, and
    for chains. In a chain of any length the pulse travels from end to end.
    """
    if zone is None or "sides" not in zone.room:
        return ""
    parts = []
    for names, verb in ((zone.reaches, "is expected to reach"), (zone.may_reach, "may reach")):
        if names:
            edges = [f"the {_name(zone, name)}, {zone.room[name]:.2g} m away" for name in names]
            parts.append(f"{verb} {' and '.join(edges)}")
    if not parts:
        return ""
    return (
        f"packing.size: the plastic zone {', and '.join(parts)}. The boundary limits the zone, "
        "and zone_cut in summary.json lists it. Use a larger packing to contain the zone"
    )
