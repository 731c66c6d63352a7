"""Inertia relief in the LAMMPS input script: what takes off the forces that accelerate a packing as a whole.

With the acceleration a of its centre and the angular acceleration I^-1 T, from the total force and torque, a sphere at
r from the centre gets the force -m (a + I^-1 T x r). On a plane only x, y and the turning about z are free.
"""

from __future__ import annotations

_TERMS = {
    "x": ("b*c-f*f", "e*f-d*c", "d*f-b*e"),
    "y": ("e*f-d*c", "a*c-e*e", "d*e-a*f"),
    "z": ("d*f-b*e", "d*e-a*f", "a*b-d*d"),
}  # rows of the adjugate of the inertia tensor, a = xx, b = yy, c = zz, d = xy, e = xz, f = yz
_TENSOR = {"a": "xx", "b": "yy", "c": "zz", "d": "xy", "e": "xz", "f": "yz"}


def relief_commands(name: str, group: str, *, on_plane: bool) -> list[str]:
    """The fix ``name``, and the variables that it takes, which have this name in front.

    Parameters
    ----------
    on_plane
        The group rests on a plane normal to z.
    """
    if on_plane:
        lines = [f"variable        {name}_az equal torque({group},z)/inertia({group},zz)"]
        turned = {"x": f"-v_{name}_az*(y-xcm({group},y))", "y": f"+v_{name}_az*(x-xcm({group},x))"}
    else:
        values = {letter: f"v_{name}_i{component}" for letter, component in _TENSOR.items()}

        def written(formula: str) -> str:
            return "".join(values.get(letter, letter) for letter in formula)

        lines = [
            f"variable        {name}_i{component} equal inertia({group},{component})" for component in _TENSOR.values()
        ]
        lines.append(f"variable        {name}_det equal {written('a*(b*c-f*f)-d*(d*c-e*f)+e*(d*f-b*e)')}")
        for axis, row in _TERMS.items():
            torque = "+".join(
                f"({written(term)})*torque({group},{about})" for about, term in zip("xyz", row, strict=True)
            )
            lines.append(f"variable        {name}_a{axis} equal ({torque})/v_{name}_det")
        turned = {
            one: f"+v_{name}_a{other}*({third}-xcm({group},{third}))-v_{name}_a{third}*({other}-xcm({group},{other}))"
            for one, other, third in ("xyz", "yzx", "zxy")
        }
    for axis, turning in turned.items():
        lines.append(f"variable        {name}_{axis} atom -mass*(fcm({group},{axis})/mass({group}){turning})")
    lines.append(f"variable        {name}_0 atom 0.0")
    words = " ".join(f"v_{name}_{axis}" if axis in turned else "0.0" for axis in "xyz")
    return [*lines, f"fix             {name} {group} addforce {words} energy v_{name}_0"]
