"""Inner loops of the quasi-static explicit solver with updated geometry, compiled by numba.

Time is counted in steps: a velocity is a displacement per step (m), a mass has the unit
N/(m/step^2). As the problem is static, the masses can be chosen freely (`masses`).

Each element has one quadrature point, its centre. With b = grad N there, from current coordinates,

    D = sym(b v), W = skew(b v)      at the middle of the step (no strain under any finite rotation)
    sigma <- Q sigma Q^T, + C : D    Q: rotation by Hughes and Winget (1980); then radial return
    f = V b^T sigma                  at the end of the step, V = 2 pi r A

Hourglass control follows Flanagan and Belytschko (1981) in stiffness form; the hourglass
displacement rotates with the element and is reduced by plastic flow like the deviator. The state of
an element has the layout of `granwave.extensions.continuum.material`, but ``PLASTIC`` is in J,
as volumes change.
"""

from __future__ import annotations

import math

from granwave.extensions.continuum.material import (
    BULK,
    HOUR_R,
    HOUR_Z,
    PLASTIC,
    RR,
    RZ,
    STRAIN,
    TT,
    ZZ,
    compiled,
)  # fmt: skip

#: overlap (m), change of overlap in a step, change before smoothing (m), force (N); sums of work
#: and losses (J)
OVERLAP, RATE, TARGET_RATE, FORCE, WORK, VISCOUS, HOURGLASS, DAMPING, KINETIC, PENALTY = range(10)
N_TALLY = 10
STABLE = 0.9  # timestep over the stability limit of central differences
#: positions of the two Gauss points on a segment of a surface
NEAR_END = 0.5 - 0.5 / math.sqrt(3)
FAR_END = 0.5 + 0.5 / math.sqrt(3)


@compiled
def plastic_increment(mises, limit, hardening, shear, sensitivity, least):
    """Return the increment m of the equivalent plastic strain, and the factor by which its rate
    raises the yield strength.

    With Johnson and Cook's factor, m solves ``(limit + hardening m)(1 + C ln(m/least)) + 3 mu m =
    mises``, where least is the increment at the reference rate, below which the factor is 1. The
    left side is concave in m, so that Newton's method from ``least`` converges from below.
    """
    more = (mises - limit) / (3 * shear + hardening)
    if sensitivity == 0.0 or more <= least:
        return more, 1.0
    m = least
    factor = 1.0
    for _ in range(50):
        yielding = limit + hardening * m
        missing = mises - yielding * factor - 3 * shear * m
        m += missing / (hardening * factor + yielding * sensitivity / m + 3 * shear)
        factor = 1.0 + sensitivity * math.log(m / least)
        if missing <= 1e-9 * mises:
            break
    return m, factor


@compiled
def stress(x, v, elements, kind, constants, hourglass, state, f, pace):
    """Update the elements to the end of a step and set the internal forces ``f``.

    Parameters
    ----------
    x, v
        Positions at the end of the step and displacements in it, (n_nodes, 2), m.
    kind, constants
        Material index of each element; for each material lambda, mu, yield strength (Pa), viscosity
        (Pa step), hardening modulus (Pa), rate sensitivity and reference rate (1/s).
    pace
        Steps in a second, for rates; 0: at rest.

    Returns
    -------
    tuple
        Viscous work and hourglass work, J.
    """
    f[:, :] = 0.0
    viscous = artificial = 0.0
    for e in range(len(elements)):
        lam = constants[kind[e], 0]
        mu = constants[kind[e], 1]
        viscosity = constants[kind[e], 3]
        hardening = constants[kind[e], 4]
        n0 = elements[e, 0]
        n1 = elements[e, 1]
        n2 = elements[e, 2]
        n3 = elements[e, 3]
        s = state[e]
        limit = constants[kind[e], 2] + hardening * s[STRAIN]
        # differences over the diagonals, at the end and at the middle of the step
        u_r = v[n0, 0] - v[n2, 0]
        u_z = v[n0, 1] - v[n2, 1]
        w_r = v[n1, 0] - v[n3, 0]
        w_z = v[n1, 1] - v[n3, 1]
        p_r = x[n0, 0] - x[n2, 0]
        p_z = x[n0, 1] - x[n2, 1]
        q_r = x[n1, 0] - x[n3, 0]
        q_z = x[n1, 1] - x[n3, 1]
        pm_r = p_r - 0.5 * u_r
        pm_z = p_z - 0.5 * u_z
        qm_r = q_r - 0.5 * w_r
        qm_z = q_z - 0.5 * w_z
        sum_v = v[n0, 0] + v[n1, 0] + v[n2, 0] + v[n3, 0]
        sum_r = x[n0, 0] + x[n1, 0] + x[n2, 0] + x[n3, 0]
        # b of nodes 0 and 1; nodes 2 and 3 have the opposite b
        inverse = 1.0 / (pm_r * qm_z - qm_r * pm_z)
        g_rr = inverse * (qm_z * u_r - pm_z * w_r)
        g_rz = inverse * (pm_r * w_r - qm_r * u_r)
        g_zr = inverse * (qm_z * u_z - pm_z * w_z)
        g_zz = inverse * (pm_r * w_z - qm_r * u_z)
        e_tt = sum_v / (sum_r - 0.5 * sum_v)
        shear = g_rz + g_zr
        e_v = g_rr + g_zz + e_tt
        # rotation
        half = 0.25 * (g_rz - g_zr)
        scale = 1.0 / (1.0 + half * half)
        cosine = (1.0 - half * half) * scale
        sine = 2.0 * half * scale
        cc = cosine * cosine
        ss = sine * sine
        cs = cosine * sine
        o_rr = cc * s[RR] + ss * s[ZZ] + 2 * cs * s[RZ]
        o_zz = ss * s[RR] + cc * s[ZZ] - 2 * cs * s[RZ]
        o_rz = (cc - ss) * s[RZ] + cs * (s[ZZ] - s[RR])
        o_tt = s[TT]
        # elastic trial stress
        s_rr = o_rr + lam * e_v + 2 * mu * g_rr
        s_zz = o_zz + lam * e_v + 2 * mu * g_zz
        s_tt = o_tt + lam * e_v + 2 * mu * e_tt
        s_rz = o_rz + mu * shear
        area = 0.5 * (p_r * q_z - q_r * p_z)
        volume = 0.5 * math.pi * sum_r * area
        mean = (s_rr + s_zz + s_tt) / 3
        d_rr = s_rr - mean
        d_zz = s_zz - mean
        d_tt = s_tt - mean
        square = 1.5 * (d_rr * d_rr + d_zz * d_zz + d_tt * d_tt + 2 * s_rz * s_rz)
        back = 1.0
        if square > limit * limit:
            mises = math.sqrt(square)
            sensitivity = constants[kind[e], 5] if pace > 0.0 else 0.0
            least = constants[kind[e], 6] / pace if sensitivity > 0.0 else 0.0
            more, factor = plastic_increment(mises, limit, hardening, mu, sensitivity, least)
            back = (limit + hardening * more) * factor / mises
            # plastic strain increment (1 - back) d/(2 mu), work by the mean of old and new stress
            before = o_rr * d_rr + o_zz * d_zz + o_tt * d_tt + 2 * o_rz * s_rz
            s[PLASTIC] += 0.5 * (1 - back) / (2 * mu) * (before + back * square / 1.5) * volume
            s[STRAIN] += more
            s_rr = mean + back * d_rr
            s_zz = mean + back * d_zz
            s_tt = mean + back * d_tt
            s_rz *= back
        s[RR] = s_rr
        s[ZZ] = s_zz
        s[TT] = s_tt
        s[RZ] = s_rz
        bulk = viscosity * e_v
        viscous += 0.5 * (s[BULK] + bulk) * e_v * volume
        s[BULK] = bulk
        # hourglass force, orthogonal to linear velocity fields
        factor = 0.5 / area
        b0_r = factor * q_z
        b1_r = -factor * p_z
        b0_z = -factor * q_r
        b1_z = factor * p_r
        h_r = x[n0, 0] - x[n1, 0] + x[n2, 0] - x[n3, 0]
        h_z = x[n0, 1] - x[n1, 1] + x[n2, 1] - x[n3, 1]
        c0 = h_r * b0_r + h_z * b0_z
        c1 = h_r * b1_r + h_z * b1_z
        t_r = 0.25 * (v[n0, 0] - v[n1, 0] + v[n2, 0] - v[n3, 0] - c0 * u_r - c1 * w_r)
        t_z = 0.25 * (v[n0, 1] - v[n1, 1] + v[n2, 1] - v[n3, 1] - c0 * u_z - c1 * w_z)
        old_r = cosine * s[HOUR_R] + sine * s[HOUR_Z]
        old_z = cosine * s[HOUR_Z] - sine * s[HOUR_R]
        new_r = back * (old_r + t_r)
        new_z = back * (old_z + t_z)
        artificial += 0.5 * hourglass[e] * ((old_r + new_r) * t_r + (old_z + new_z) * t_z)
        s[HOUR_R] = new_r
        s[HOUR_Z] = new_z
        h_r = 0.25 * hourglass[e] * new_r
        h_z = 0.25 * hourglass[e] * new_z
        # nodal forces
        s_rr += bulk
        s_zz += bulk
        ring = volume * (s_tt + bulk) / sum_r
        f0_r = volume * (b0_r * s_rr + b0_z * s_rz) - c0 * h_r
        f1_r = volume * (b1_r * s_rr + b1_z * s_rz) - c1 * h_r
        f0_z = volume * (b0_r * s_rz + b0_z * s_zz) - c0 * h_z
        f1_z = volume * (b1_r * s_rz + b1_z * s_zz) - c1 * h_z
        f[n0, 0] += ring + f0_r + h_r
        f[n1, 0] += ring + f1_r - h_r
        f[n2, 0] += ring - f0_r + h_r
        f[n3, 0] += ring - f1_r - h_r
        f[n0, 1] += f0_z + h_z
        f[n1, 1] += f1_z - h_z
        f[n2, 1] += h_z - f0_z
        f[n3, 1] += -f1_z - h_z
    return viscous, artificial


@compiled
def press(x, f, around, weights, line, stiffness, approach, gaps):
    """Add to ``f`` the contact forces between the Gauss points of a surface and the opposite
    ``line``.

    The gap at the two Gauss points of each segment is g = z + z_line(r) - approach, with each z
    into its own body. If it is negative, the energy ``stiffness g^2/2`` gives equal and opposite
    forces on the nodes of both surfaces, normal to the line.

    Parameters
    ----------
    around, weights
        Four nodes for each segment, the middle two its ends, (n_segments, 4), and their weights in
        z at its Gauss points, (n_segments, 2, 4): the surface is curved between nodes.
    line
        Nodes from the axis outwards, also curved between them; two nodes: straight.
    stiffness
        Penalty stiffness at the Gauss points, (n_segments, 2), N/m.
    gaps
        Output: gaps g, (n_segments, 2), m.

    Returns
    -------
    tuple
        Axial force (N) and energy (J).
    """
    total = energy = 0.0
    j = 0
    last = len(line) - 2
    for k in range(len(around)):
        a = around[k, 1]
        b = around[k, 2]
        for side in range(2):
            to_b = NEAR_END if side == 0 else FAR_END
            to_a = 1.0 - to_b
            r = to_a * x[a, 0] + to_b * x[b, 0]
            z = 0.0
            for m in range(4):
                z += weights[k, side, m] * x[around[k, m], 1]
            while j < last and x[line[j + 1], 0] < r:
                j += 1
            while j > 0 and x[line[j], 0] > r:
                j -= 1
            c = line[j]
            d = line[j + 1]
            c_r = x[c, 0]
            d_r = x[d, 0]
            to_d = (r - c_r) / (d_r - c_r)
            to_c = 1.0 - to_d
            slope = (x[d, 1] - x[c, 1]) / (d_r - c_r)
            height = x[c, 1] + slope * (r - c_r)
            before = c
            after = d
            to_before = 0.0
            to_after = 0.0
            if j < last:  # curved: mean of the two parabolas through three of four nodes
                before = line[j - 1]
                before_r = x[line[j - 1], 0]
                if j == 0:
                    before = d
                    before_r = -d_r
                after = line[j + 2]
                after_r = x[line[j + 2], 0]
                from_before = 0.5 / ((before_r - c_r) * (before_r - d_r))
                from_after = 0.5 / ((after_r - c_r) * (after_r - d_r))
                from_c = 0.5 / (c_r - d_r) * (1.0 / (c_r - before_r) + 1.0 / (c_r - after_r))
                from_d = 0.5 / (d_r - c_r) * (1.0 / (d_r - before_r) + 1.0 / (d_r - after_r))
                bend = (
                    from_before * x[before, 1]
                    + from_after * x[after, 1]
                    + from_c * x[c, 1]
                    + from_d * x[d, 1]
                )
                arm = (r - c_r) * (r - d_r)
                height += arm * bend
                slope += (2 * r - c_r - d_r) * bend
                to_before = arm * from_before
                to_after = arm * from_after
                to_c += arm * from_c
                to_d += arm * from_d
            gap = z + height - approach
            gaps[k, side] = gap
            if gap < 0.0:
                push = -stiffness[k, side] * gap
                total += push
                energy -= 0.5 * push * gap
                for m in range(4):
                    f[around[k, m], 1] -= push * weights[k, side, m]
                f[c, 1] -= push * to_c
                f[d, 1] -= push * to_d
                f[before, 1] -= push * to_before
                f[after, 1] -= push * to_after
                f[a, 0] -= push * to_a * slope
                f[b, 0] -= push * to_b * slope
                f[c, 0] += push * to_c * slope
                f[d, 0] += push * to_d * slope
                f[after, 0] += push * to_after * slope
                f[before, 0] += push * to_before * slope * (-1.0 if j == 0 else 1.0)
    return total, energy


@compiled
def masses(x, elements, kind, constants, extra, mass):
    """Set the nodal masses so that a step of 1 is `STABLE` times the stability limit of every
    element.

    The square of an element's highest frequency is at most ``V (lambda + 2 mu) sum(b^2)`` divided
    by a nodal mass.
    """
    mass[:] = extra
    for e in range(len(elements)):
        n0 = elements[e, 0]
        n1 = elements[e, 1]
        n2 = elements[e, 2]
        n3 = elements[e, 3]
        p_r = x[n0, 0] - x[n2, 0]
        p_z = x[n0, 1] - x[n2, 1]
        q_r = x[n1, 0] - x[n3, 0]
        q_z = x[n1, 1] - x[n3, 1]
        sum_r = x[n0, 0] + x[n1, 0] + x[n2, 0] + x[n3, 0]
        area = 0.5 * (p_r * q_z - q_r * p_z)
        volume = 0.5 * math.pi * sum_r * area
        squares = 0.5 * (p_r * p_r + p_z * p_z + q_r * q_r + q_z * q_z) / (area * area) + 4.0 / (
            sum_r * sum_r
        )
        modulus = constants[kind[e], 0] + 2 * constants[kind[e], 1]
        share = volume * modulus * squares / (4 * STABLE * STABLE)
        mass[n0] += share
        mass[n1] += share
        mass[n2] += share
        mass[n3] += share


@compiled
def advance(
    n_steps,
    target,
    growth,
    smoothing,
    damping,
    memory,
    halves,
    velocity,
    tally,
    motion,
    mass,
    free,
    mesh,
    contact,
):
    """Take ``n_steps``; energies and force in ``tally`` refer to the end.

    Parameters
    ----------
    target, growth
        Target for the change of the overlap in a step: ``target + growth * overlap``.
    smoothing
        Time constant, in steps, of the two low-pass filters through which the rate follows this
        target.
    damping, memory
        Fraction that a node loses in a step of the difference between its velocity and its mean
        velocity over about ``memory`` steps: oscillations are damped, steady motion is not.
    halves
        Approach / overlap: 1 for two bodies, 1/2 for one on the plane of symmetry.
    velocity
        Rate of the overlap in time, m/s, by which steps become time for materials that depend on
        the rate; 0: at rest.
    motion
        (4, n_nodes, 2): position (m), displacement in the last step (m), force (N), mean
        displacement in a step (m).
    free
        (n_nodes, 2): 1 for free, 0 for fixed degrees of freedom.
    mesh
        ``elements, kind, constants, hourglass, state``.
    contact
        For each surface ``line, around, weights, stiffness, gaps``, as in `press`; a plane has no
        segments.
    """
    x = motion[0]
    v = motion[1]
    f = motion[2]
    elements, kind, constants, hourglass, state = mesh
    first, second = contact
    steady = motion[3]
    keep = (1 - 0.5 * damping) / (1 + 0.5 * damping)
    gain = 1 / (1 + 0.5 * damping)
    drift = 1 / memory
    for step in range(n_steps):
        tally[TARGET_RATE] += (target + growth * tally[OVERLAP] - tally[TARGET_RATE]) / smoothing
        tally[RATE] += (tally[TARGET_RATE] - tally[RATE]) / smoothing
        tally[OVERLAP] += tally[RATE]
        lost = 0.0
        for i in range(len(mass)):
            for axis in range(2):
                if free[i, axis] > 0:
                    old = v[i, axis]
                    mean = steady[i, axis]
                    new = keep * old + gain * (damping * mean - f[i, axis] / mass[i])
                    v[i, axis] = new
                    x[i, axis] += new
                    steady[i, axis] = mean + drift * (new - mean)
                    lost += mass[i] * (old + new) * (0.5 * (old + new) - mean)
        tally[DAMPING] += 0.5 * damping * lost
        pace = velocity / abs(tally[RATE]) if tally[RATE] != 0.0 else 0.0
        viscous, artificial = stress(x, v, elements, kind, constants, hourglass, state, f, pace)
        tally[VISCOUS] += viscous
        tally[HOURGLASS] += artificial
        approach = halves * tally[OVERLAP]
        force, energy = press(x, f, first[1], first[2], second[0], first[3], approach, first[4])
        if len(second[1]) > 0:
            other, more = press(
                x, f, second[1], second[2], first[0], second[3], approach, second[4]
            )
            force += other
            energy += more
        tally[WORK] += 0.5 * (tally[FORCE] + force) * halves * tally[RATE]
        tally[FORCE] = force
        tally[PENALTY] = energy
        if step == n_steps - 1:
            kinetic = 0.0
            for i in range(len(mass)):
                for axis in range(2):
                    if free[i, axis] > 0:
                        kinetic += 0.5 * mass[i] * (v[i, axis] - 0.5 * f[i, axis] / mass[i]) ** 2
            tally[KINETIC] = kinetic


@compiled
def stored(x, elements, kind, constants, state):
    """Return the present elastic and plastic energy, J."""
    elastic = plastic = 0.0
    for e in range(len(elements)):
        lam = constants[kind[e], 0]
        mu = constants[kind[e], 1]
        n0 = elements[e, 0]
        n1 = elements[e, 1]
        n2 = elements[e, 2]
        n3 = elements[e, 3]
        area = 0.5 * (
            (x[n0, 0] - x[n2, 0]) * (x[n1, 1] - x[n3, 1])
            - (x[n1, 0] - x[n3, 0]) * (x[n0, 1] - x[n2, 1])
        )
        volume = 0.5 * math.pi * (x[n0, 0] + x[n1, 0] + x[n2, 0] + x[n3, 0]) * area
        s = state[e]
        mean = (s[RR] + s[ZZ] + s[TT]) / 3
        square = (s[RR] - mean) ** 2 + (s[ZZ] - mean) ** 2 + (s[TT] - mean) ** 2 + 2 * s[RZ] ** 2
        elastic += volume * (square / (4 * mu) + mean * mean / (2 * (lam + 2 * mu / 3)))
        plastic += s[PLASTIC]
    return elastic, plastic
