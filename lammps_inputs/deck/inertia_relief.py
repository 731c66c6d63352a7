"""Inertia relief: forces that prevent rigid motion of an unsupported packing.

A sphere at r from the centre of mass gets the force -m (a + I^-1 T x r), with the acceleration a of
the centre and the angular acceleration I^-1 T from total force and torque. On a plane only
translation along x and y and rotation about z are free. The centre does not move and the inertia
changes little, so `relief_state` evaluates both once.
"""

from __future__ import annotations

_TERMS = {
    "x": ("b*c-f*f", "e*f-d*c", "d*f-b*e"),
    "y": ("e*f-d*c", "a*c-e*e", "d*e-a*f"),
    "z": ("d*f-b*e", "d*e-a*f", "a*b-d*d"),
}  # rows of the adjugate of the inertia tensor, a = xx, b = yy, c = zz, d = xy, e = xz, f = yz
_DETERMINANT = "a*(b*c-f*f)-d*(d*c-e*f)+e*(d*f-b*e)"
_TENSOR = {"a": "xx", "b": "yy", "c": "zz", "d": "xy", "e": "xz", "f": "yz"}


def relief_commands(name: str, group: str, *, on_plane: bool) -> list[str]:
    """Return the commands for the fix ``name`` and its variables, which have this name as a prefix.

    Parameters
    ----------
    on_plane
        True if the group rests on a plane normal to z.
    """
    lines = relief_state(name, group, on_plane=on_plane)
    at = {axis: f"({axis}-v_{name}_c{axis})" for axis in "xyz"}
    if on_plane:
        lines.append(f"variable        {name}_az equal torque({group},z)*v_{name}_zz")
        turned = {"x": f"-v_{name}_az*{at['y']}", "y": f"+v_{name}_az*{at['x']}"}
    else:
        for axis in "xyz":
            torque = "+".join(f"v_{name}_{axis}{about}*torque({group},{about})" for about in "xyz")
            lines.append(f"variable        {name}_a{axis} equal {torque}")
        turned = {
            one: f"+v_{name}_a{other}*{at[third]}-v_{name}_a{third}*{at[other]}"
            for one, other, third in ("xyz", "yzx", "zxy")
        }
    for axis, turning in turned.items():
        lines.append(
            f"variable        {name}_{axis} atom -mass*(fcm({group},{axis})/v_{name}_mass{turning})"
        )
    lines.append(f"variable        {name}_0 atom 0.0")
    words = " ".join(f"v_{name}_{axis}" if axis in turned else "0.0" for axis in "xyz")
    return [*lines, f"fix             {name} {group} addforce {words} energy v_{name}_0"]


def relief_state(name: str, group: str, *, on_plane: bool) -> list[str]:
    """Return the commands that store the present mass, centre and inverse inertia; they may be
    repeated.
    """
    lines = [f"variable        {name}_mass equal $(mass({group}):%.17g)"]
    lines += [
        f"variable        {name}_c{axis} equal $(xcm({group},{axis}):%.17g)" for axis in "xyz"
    ]
    if on_plane:
        return [*lines, f"variable        {name}_zz equal $(1/inertia({group},zz):%.17g)"]
    values = str.maketrans(
        {letter: f"inertia({group},{component})" for letter, component in _TENSOR.items()}
    )
    for axis, row in _TERMS.items():
        for about, term in zip("xyz", row, strict=True):
            ratio = f"({term})/({_DETERMINANT})".translate(values)
            lines.append(f"variable        {name}_{axis}{about} equal $({ratio}:%.17g)")
    return lines
