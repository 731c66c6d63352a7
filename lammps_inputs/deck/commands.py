"""Elements of the input script, and contacts in it: laws of all pairs of types, walls, and initial
dents.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain, combinations_with_replacement

import numpy as np

from granwave.lammps_inputs.case.contact.contact import INITIAL, Contact
from granwave.lammps_inputs.case.contact.law_parameters import OF_LOSS, is_set, keywords, value_of
from granwave.lammps_inputs.case.contact.tables import MARSHALL, Resistance
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import (
    HERTZ,
    ContactLoss,
    elastic_contact,
    loss_at_bar,
    viscous_loss,
)
from granwave.lammps_inputs.packing.assembly import Assembly, Species
from granwave.lammps_inputs.packing.motion import held_ids
from granwave.lammps_inputs.packing.walls import (
    Wall,
    backing_of,
    plane_fixes,
    touched_by,
    touched_groups,
    wall_friction,
    walls,
)
from granwave.lammps_inputs.run_directory import DUMPS
from granwave.lammps_inputs.script_words import joined, num

_WIDTH = 110
#: Variable of the number of files of a dump in parts: `granwave run` sets it to the number of
#: nodes, and a script that is run by hand to `MOST_PARTS`. LAMMPS takes at most one a rank.
PARTS = "parts"
_IN_PARTS = f"nfile ${{{PARTS}}}"


def id_ranges(ids: Iterable[int]) -> str:
    """Join rising ids in the form of LAMMPS, with consecutive ids as ``first:last``."""
    every = np.fromiter(ids, dtype=np.int64)
    ranges = np.split(every, 1 + np.flatnonzero(np.diff(every) != 1)) if every.size else []
    return joined(f"{one[0]}:{one[-1]}" if len(one) > 1 else one[0] for one in ranges)


def command(*words: str) -> list[str]:
    """Join the words of a command, with LAMMPS continuation lines if it is long."""
    lines = [words[0]]
    for word in words[1:]:
        if len(lines[-1]) + len(word) + 3 > _WIDTH:
            lines[-1] += " &"
            lines.append("                " + word)
        else:
            lines[-1] += " " + word
    return lines


def time_series(
    name: str, every: int, file: str, title: str, columns: dict[str, str], resumed: bool
) -> list[str]:
    """Return the command of a time series: one row every ``every`` steps, the step first."""
    return command(
        f"fix             {name} all ave/time {every} 1 {every}",
        *columns.values(),
        f'{"append" if resumed else "file"} {DUMPS}/{file} format " %.17g" title1 "# {title}"',
        f'title2 "# {joined(["step", *columns])}"',
    )


def dump(
    name: str,
    style: str,
    every: int,
    file: str,
    columns: dict[str, str],
    resumed: bool,
    *,
    form: str = "",
    group: str = "all",
    one_line: bool = False,
    parts: bool = False,
) -> list[str]:
    """Return the commands of a dump, to which a resumed run appends.

    Particles are sorted by id, except in parts, where LAMMPS sorts nothing if several ranks share a
    file.

    Parameters
    ----------
    style
        ``custom``: of particles, or ``local``: of contacts.
    columns
        Sources by name.
    form
        Format of a line.
    one_line
        True for one command with all names.
    parts
        True for several files, see `PARTS`.
    """
    start = f"dump            {name} {group} {style} {every} {DUMPS}/{file}"
    custom = style == "custom"
    first = "append yes first no" if resumed else "first yes"
    modify = f"dump_modify     {name}"
    names = _column_names(columns)
    order = " sort id" if custom else ""
    if parts:
        order = f" {_IN_PARTS}"
    return [
        *(command(start, *columns.values()) if custom else [f"{start} {joined(columns.values())}"]),
        f"{modify} {first}{order}" + (f' format line "{form}"' if form else ""),
        *(command(modify, *names) if one_line else (f"{modify} {one}" for one in names)),
    ]


def write_dump(
    style: str, file: str, columns: dict[str, str], above: str = "", *, parts: bool = False
) -> list[str]:
    """Return the command that writes the present state; ``above``: only of particles for which this
    source is positive; ``parts``: to several files, see `PARTS`.
    """
    of_id, select = ([], "") if style == "local" else (["%d"], f" sort id thresh {above} > 0.0")
    if parts:
        select += f" {_IN_PARTS}"
    return command(
        f"write_dump      all {style} {DUMPS}/{file}{' id' if of_id else ''}",
        *columns.values(),
        f"modify{select} format line",
        f'"{joined([*of_id, *["%.17g"] * len(columns)])}"',
        *_column_names(columns),
    )


def _column_names(columns: dict[str, str]) -> list[str]:
    """Return the arguments of dump_modify that name the columns, given their sources by name."""
    return [f"colname {source} {name}" for name, source in columns.items() if name != source]


def law_coefficients(
    contact: Contact,
    first: Material,
    second: Material | None = None,
    friction: float = 0.0,
    loss: ContactLoss | None = None,
    *,
    resists: bool = False,
) -> str:
    """Return the coefficients of a contact law in the form of pair_coeff and the wall fix.

    Parameters
    ----------
    first
        Material of a sphere.
    second
        Material of its partner; None if it is the same. A partner without a yield strength is
        elastic.
    friction
        Coefficient of friction.
    loss
        Kind and size of a viscous loss.
    resists
        True to give the resistance to rolling and twisting.
    """
    words = [contact.law]
    both = [one for one in (first, second) if one is not None]
    for material in both:
        words += [num(material.youngs_modulus), num(material.poisson_ratio)]
        strength = "INF" if material.yield_strength is None else num(material.yield_strength)
        words += [strength] if contact.yields else []
    words += _law_parameters(contact, both)
    if friction:
        words += ["friction", num(friction)]
        words += (
            [] if contact.tangential == "mindlin_rescale" else ["tangential", contact.tangential]
        )
    if resists:
        words += _slider("rolling", contact.rolling)
        marshall = contact.twisting == MARSHALL
        words += [] if marshall and not friction else _slider("twisting", contact.twisting)
    if loss is not None:
        words += ["loss", *_loss_words(loss)]
        words += _loss_parameters(contact) if friction else []
    if contact.cohesion is not None and contact.coheres:
        words += ["cohesion", contact.cohesion.kind, num(contact.cohesion.energy)]
    return joined(words)


def _law_parameters(contact: Contact, materials: Sequence[Material]) -> list[str]:
    """Return the words of the parameters of a law; parameters with default values are omitted."""
    words: list[str] = []
    for keyword, parameters in keywords(contact.entry.parameters).items():
        of_material = parameters[0].of_material
        if of_material:
            holders: Sequence[Contact | Material] = materials
            is_given = any(is_set(material, parameters[0]) for material in materials)
        else:
            holders = [contact]
            is_given = parameters[0].name in contact.parameters
        if is_given:
            words.append(keyword)
            for holder in holders:
                words += [_word(value_of(holder, parameter)) for parameter in parameters]
    return words


def _loss_words(loss: ContactLoss) -> list[str]:
    """Return the kind of a loss and its numbers."""
    if loss[0] == "prony":
        return [loss[0], *(num(size) for size in chain.from_iterable(loss[1]))]
    return [loss[0], num(loss[1])]


def _loss_parameters(contact: Contact) -> list[str]:
    """Return the words of the damping along the surface, which friction limits."""
    words: list[str] = []
    for parameter in OF_LOSS:
        if is_set(contact.loss, parameter):
            words += [parameter.keyword, _word(value_of(contact.loss, parameter))]
    return words


def _word(value: float | str) -> str:
    """Return the value of a parameter in the form of an input script."""
    return value if isinstance(value, str) else num(value)


def _slider(key: str, resistance: Resistance | str | None) -> list[str]:
    """Return the arguments of a resistance to rolling or twisting; empty without a resistance."""
    if not isinstance(resistance, Resistance):
        return [key, resistance] if resistance else []
    if not resistance.coefficient:
        return []
    stiffness = "mindlin" if resistance.stiffness is None else num(resistance.stiffness)
    return [key, "sds", stiffness, num(resistance.damping), num(resistance.coefficient)]


def contacts(assembly: Assembly) -> list[str]:
    """Return the pair style with the laws of all pairs of types."""
    case = assembly.case
    gap = case.boundary.forget_gap * case.packing.diameter
    normals = f" normals {INITIAL}" if case.contact.normals == INITIAL else ""
    return [
        *(["# Cylinders: type, length and axis of each kind."] if assembly.has_cylinders else []),
        *cylinder_commands(assembly),
        f"# Contact law: {case.contact.law}. Beyond the gap below (m), a contact forgets its "
        "indentation, which stays on record.",
        f"pair_style      gran/hysteretic {num(gap)} forgotten list{normals}",
        *pair_coefficients(assembly),
    ]


def pair_coefficients(assembly: Assembly, *, elastic: bool = False) -> list[str]:
    """Return the laws of all pairs of types; ``elastic``: Hertz's law without friction, regardless
    of the case.
    """
    case = assembly.case
    lines = []
    for (i, first), (j, second) in combinations_with_replacement(
        enumerate(assembly.species, start=1), 2
    ):
        contact = HERTZ
        partner = None if i == j else second.material
        loss = None
        if first.role == "sphere":  # nodes of bars do not touch each other
            own = case.contact_between(first.material, second.material)
            contact = elastic_contact(own) if elastic else own
            loss = None if elastic else _pair_loss(assembly, own, first, second)
        rough = second.role == "sphere" and not elastic  # the face of a bar does
        friction = contact.friction if rough else 0.0
        words = law_coefficients(contact, first.material, partner, friction, loss, resists=rough)
        lines.append(f"pair_coeff      {i} {j} {words}")
    return lines


def _pair_loss(
    assembly: Assembly, contact: Contact, first: Species, second: Species
) -> ContactLoss | None:
    """Return the loss of spheres with spheres, or with the face of a bar."""
    bodies = (first.material, second.material)
    for bar in assembly.bars:
        if second.bar == bar.name:
            return loss_at_bar(assembly, contact, first.material, bar)
    return viscous_loss(assembly, contact, *bodies, shapes=(first.shape, second.shape))


def cylinder_commands(assembly: Assembly, *, again: bool = False) -> list[str]:
    """Return the command for the cylinders of the packing; none if it has only spheres.

    Parameters
    ----------
    again
        True after the walls, whose torques it projects on the axes of the cylinders: the first one
        is taken back.
    """
    words = [
        f"{number} {num(one.shape.length)} {joined(map(num, one.shape.axis))}"
        for number, one in enumerate(assembly.species, start=1)
        if one.shape is not None
    ]
    if not words:
        return []
    back = ["unfix           cylinders"] if again else []
    line = " line plane-strain" if assembly.plane_strain else ""
    return [*back, f"fix             cylinders all gran/cylinder {joined(words)}{line}"]


def plane_names(assembly: Assembly) -> list[str]:
    """Return the names of the wall fixes, and of the fix that holds the last layer."""
    held = ["held"] if any(wall.held_layer for wall in walls(assembly)) else []
    return [
        *held,
        *plane_fixes(assembly),
        *(name for name, hold in assembly.case.holds.items() if hold.axes),
    ]


def wall_commands(
    assembly: Assembly,
    *,
    elastic: bool = False,
    prefix: str = "",
    only: Sequence[Wall] | None = None,
) -> list[str]:
    """Return the commands for walls, and for a last layer held in place.

    Parameters
    ----------
    elastic
        True for fixed planes with Hertz's law without friction, regardless of the case.
    prefix
        Prefix of the names of the fixes.
    only
        Existing walls that change their positions; their groups, and the held grains, stay.
    """
    case = assembly.case
    lines = [*_groups(assembly), *_regions(assembly)] if only is None else []
    for wall in walls(assembly) if only is None else only:
        if wall.held_layer:
            lines.append(f"group           held id {id_ranges(assembly.lattice.last_layer)}")
            lines.append(f"fix             {prefix}held held setforce 0.0 0.0 0.0")
            continue
        style = _wall_style(assembly, wall)
        line = ["line plane-strain"] if assembly.has_cylinders and assembly.plane_strain else []
        for name, group, material in wall.fixes:
            contact = case.contact_between(material, wall.material)
            words = [law_coefficients(elastic_contact(contact), material, wall.material), *line]
            if not elastic:
                friction = wall_friction(case, wall, material)
                behind = backing_of(assembly, wall, material)
                loss = viscous_loss(
                    assembly, contact, material, wall.material, flat=True, behind=behind
                )
                law = law_coefficients(
                    contact, material, wall.material, friction, loss, resists=True
                )
                words = [law, *_support_arguments(assembly, wall, material), *line]
            lines.append(
                f"fix             {prefix}{name} {group} wall/gran/hysteretic {style} {joined(words)}"
            )
    if only is not None:
        return lines
    if lines:
        lines.insert(
            0, "# Walls: planes that touch the outermost spheres, or the fixed last layer."
        )
    lines += ["# Fixed grains."] if case.holds else []
    for name, hold in case.holds.items():  # after all other forces on these spheres
        lines.append(f"group           {name} id {id_ranges(held_ids(case, hold))}")
        zeros = joined("0.0" if axis in hold.axes else "NULL" for axis in "xyz")
        lines += [f"fix             {prefix}{name} {name} setforce {zeros}"] if hold.axes else []
    return lines


def _regions(assembly: Assembly) -> list[str]:
    """Return the commands that define the regions of walls."""
    faces = [wall.face for wall in walls(assembly) if wall.face is not None]
    definitions = dict.fromkeys(face.definition for face in faces)
    return [definition for definition in definitions if definition]


def _wall_style(assembly: Assembly, wall: Wall) -> str:
    """Return the arguments of the wall fix for the position of a wall."""
    if wall.face is not None:
        return wall.face.style
    place = coordinate(assembly, wall)
    if wall.tube:
        return f"tube {place}"
    low, high = ("NULL", place) if wall.outward > 0 else (place, "NULL")
    return f"{'xyz'[wall.axis]}plane {low} {high}"


def coordinate(assembly: Assembly, wall: Wall) -> str:
    """Return the position of a plane in the input script, or the radius of a tube; for walls that
    move to a force, a formula.
    """
    place = wall.coordinate
    if not wall.tube:
        place -= float(assembly.deck_origin[wall.axis])
    stage = assembly.case.precompression
    if stage is None or wall.key not in stage.presses:
        return num(place)
    return f"$({num(place)}{'-' if wall.outward > 0 else '+'}v_{moved_wall(wall.key)}:%.17g)"


def moved_wall(name: str) -> str:
    """Return the variable of the distance by which walls move in to a force; ``name``: x, y or
    tube.
    """
    return f"wall_{name}"


def _groups(assembly: Assembly) -> list[str]:
    """Return the commands for groups of spheres by material, if walls need them."""
    lines = []
    passing = assembly.passing
    planes = [wall for wall in walls(assembly) if not wall.held_layer]
    selections = [touched_by(assembly, wall) for wall in planes]
    chosen = next((one for one in selections if one is not None), None)
    if chosen is not None:
        lines += [
            f"group           {name} id {id_ranges(ids)}"
            for name, _, ids in touched_groups(assembly, chosen)
        ]
    others = [wall for wall, selected in zip(planes, selections, strict=True) if selected is None]
    fixes = others[-1].fixes if others else ()
    groups = [(group, of) for _, group, of in fixes if group != "all"]
    outside = []
    if groups and passing:
        every = len(passing) == len(assembly.strikers)
        outside = [
            f"group           strikers id {f'{passing[0]}:{passing[-1]}' if every else id_ranges(passing)}"
        ]
    for number, (group, of) in enumerate(groups, start=1):
        species = enumerate(assembly.species, start=1)
        types = joined(n for n, one in species if one.role == "sphere" and one.material == of)
        lines.append(f"group           {f'type{number}' if outside else group} type {types}")
        lines += [f"group           {group} subtract type{number} strikers"] if outside else []
    return outside + lines


def _support_arguments(assembly: Assembly, wall: Wall, material: Material) -> list[str]:
    """Support arguments of the wall fix for spheres of a material; empty for fixed planes."""
    if wall.plate is not None:
        mass, velocity = wall.plate
        held = assembly.case.precompression is not None  # held until the run begins, see `motion`
        return ["support", "free", num(mass), "0.0" if held else num(velocity)]
    behind = backing_of(assembly, wall, material)
    if behind is None:
        return []
    if behind.is_damper:
        return ["support", "damper", num(behind.damping)]
    if not behind.elements:
        return ["support", *map(num, (behind.mass, behind.stiffness, behind.damping))]
    end = behind.end if isinstance(behind.end, str) else num(behind.end)
    return ["support", "bar", str(behind.elements), num(behind.mass), num(behind.stiffness), end]
