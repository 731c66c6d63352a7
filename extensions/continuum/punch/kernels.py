"""Inner loops of the explicit solver, compiled by numba.

Per step and element: strain increment from the nodal velocities, radial return, bulk viscosity,
hourglass forces, nodal forces. All elements are rectangles of a tensor-product mesh, so the tables
of the one-point quadrilateral (`granwave.extensions.continuum.punch.solver`) reduce to a few
numbers per column and row: with ``br = 1/(2 hr)``, ``bz = 1/(2 hz)``, ``bt = 1/(4 r)`` and nodes
``(-,-), (+,-), (-,+), (+,+)`` in (r, z)

    e_rr = br sum(sr u_r)   e_zz = bz sum(sz u_z)   e_tt = bt sum(u_r)   g_rz = bz sum(sz u_r) + br sum(sr u_z)
    f_r  = V (sr br s_rr + sz bz s_rz + bt s_tt)     f_z = V (sz bz s_zz + sr br s_rz)

The contact of the rigid flat punch is frictionless, and kinematic, not a penalty: it has no
parameter, no compliance, and no effect on the stable timestep. With lumped masses the positions at
the end of a step depend on a single unknown, the position X of the punch: a node that the punch
would overtake receives the impulse ``m_i (X - X_i)/dt`` that keeps it at the punch, which loses the
sum,

    M (X* - X) = sum_i m_i max(0, X - X_i)        X_i = u_i* + gap_i        * : without contact

which is solved exactly in a few iterations, as the set of touching nodes only shrinks. Impulses are
compressive. A node that comes into contact loses its relative kinetic energy, which a real surface
would radiate as a wave; the total loss, of the order of the mass of half a row of elements divided
by the mass of the punch, is reported.
"""

from __future__ import annotations

import math

import numpy as np

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

#: running sums, in the array ``tally``
(
    PUNCH_Z,
    PUNCH_V,
    VISCOUS,
    HOURGLASS,
    CONTACT,
    KINETIC,
    PUNCH_KINETIC,
    CONTACT_NOW,
    IMPULSE,
    TOUCHED,
) = range(10)
N_TALLY = 10


@compiled
def _stress(vr, vz, fr, fz, state, br, bz, bt, area, height, length, hourglass, constants, dt):
    """Update the elements to the end of a step and set the internal forces ``fr``, ``fz``.

    Returns the viscous and the hourglass work, J. ``constants``: lambda, mu, yield strength, rho
    c_L b1, rho b2^2.
    """
    lam, mu, limit, linear, quadratic = constants
    n_z = state.shape[0]
    n_r = state.shape[1]
    fr[:, :] = 0.0
    fz[:, :] = 0.0
    viscous = artificial = 0.0
    for j in range(n_z):
        bzj = bz[j]
        for i in range(n_r):
            s = state[j, i]
            r00 = vr[j, i]
            r10 = vr[j, i + 1]
            r01 = vr[j + 1, i]
            r11 = vr[j + 1, i + 1]
            z00 = vz[j, i]
            z10 = vz[j, i + 1]
            z01 = vz[j + 1, i]
            z11 = vz[j + 1, i + 1]
            bri = br[i]
            bti = bt[i]
            volume = area[i] * height[j]
            e_rr = (r10 - r00 + r11 - r01) * bri * dt
            e_zz = (z01 - z00 + z11 - z10) * bzj * dt
            e_tt = (r00 + r10 + r01 + r11) * bti * dt
            g_rz = ((r01 - r00 + r11 - r10) * bzj + (z10 - z00 + z11 - z01) * bri) * dt
            e_v = e_rr + e_zz + e_tt
            # elastic trial stress
            s_rr = s[RR] + lam * e_v + 2 * mu * e_rr
            s_zz = s[ZZ] + lam * e_v + 2 * mu * e_zz
            s_tt = s[TT] + lam * e_v + 2 * mu * e_tt
            s_rz = s[RZ] + mu * g_rz
            mean = (s_rr + s_zz + s_tt) / 3
            d_rr = s_rr - mean
            d_zz = s_zz - mean
            d_tt = s_tt - mean
            square = 1.5 * (d_rr * d_rr + d_zz * d_zz + d_tt * d_tt + 2 * s_rz * s_rz)
            back = 1.0
            if square > limit * limit:
                mises = math.sqrt(square)
                back = limit / mises
                # plastic strain increment (1 - back) d/(2 mu), work by the mean of old and new
                # stress
                before = s[RR] * d_rr + s[ZZ] * d_zz + s[TT] * d_tt + 2 * s[RZ] * s_rz
                s[PLASTIC] += 0.5 * (1 - back) / (2 * mu) * (before + back * square / 1.5)
                s[STRAIN] += (mises - limit) / (3 * mu)
                s_rr = mean + back * d_rr
                s_zz = mean + back * d_zz
                s_tt = mean + back * d_tt
                s_rz *= back
            s[RR] = s_rr
            s[ZZ] = s_zz
            s[TT] = s_tt
            s[RZ] = s_rz
            # bulk viscosity, on the shorter side of the element
            side = length[j, i]
            rate = e_v / dt
            bulk = linear * side * rate
            if rate < 0:
                bulk -= quadratic * side * side * rate * rate
            viscous += 0.5 * (s[BULK] + bulk) * e_v * volume
            s[BULK] = bulk
            # hourglass force: elastic, and reduced by plastic flow like the deviator
            stiffness = hourglass[j, i]
            q_r = 0.25 * (r11 - r10 - r01 + r00) * dt
            q_z = 0.25 * (z11 - z10 - z01 + z00) * dt
            new_r = back * (s[HOUR_R] + q_r)
            new_z = back * (s[HOUR_Z] + q_z)
            artificial += 0.5 * stiffness * ((s[HOUR_R] + new_r) * q_r + (s[HOUR_Z] + new_z) * q_z)
            s[HOUR_R] = new_r
            s[HOUR_Z] = new_z
            h_r = 0.25 * stiffness * new_r
            h_z = 0.25 * stiffness * new_z
            # nodal forces
            p_rr = volume * bri * (s_rr + bulk)
            p_zz = volume * bzj * (s_zz + bulk)
            p_tt = volume * bti * (s_tt + bulk)
            p_rz = volume * bzj * s_rz
            p_zr = volume * bri * s_rz
            fr[j, i] += p_tt - p_rr - p_rz + h_r
            fr[j, i + 1] += p_tt + p_rr - p_rz - h_r
            fr[j + 1, i] += p_tt - p_rr + p_rz - h_r
            fr[j + 1, i + 1] += p_tt + p_rr + p_rz + h_r
            fz[j, i] += -p_zz - p_zr + h_z
            fz[j, i + 1] += -p_zz + p_zr - h_z
            fz[j + 1, i] += p_zz - p_zr - h_z
            fz[j + 1, i + 1] += p_zz + p_zr + h_z
    return viscous, artificial


@compiled
def _touch(u, v, before, mass, gap, tally, punch_mass, dt):
    """Apply the contact impulses between punch and nodes of the top surface."""
    free = tally[PUNCH_Z] + dt * tally[PUNCH_V]
    place = free
    count = -1
    for _ in range(len(gap) + 1):
        total = punch_mass
        moment = punch_mass * free
        n_touching = 0
        for i in range(len(gap)):
            reach = gap[i] + u[i] + dt * v[i]
            if place > reach:
                total += mass[i]
                moment += mass[i] * reach
                n_touching += 1
        if n_touching == count:
            break
        place = moment / total
        count = n_touching
    speed = (place - tally[PUNCH_Z]) / dt
    tally[CONTACT_NOW] = tally[CONTACT]
    for i in range(len(gap)):
        reach = gap[i] + u[i] + dt * v[i]
        if place > reach:
            impulse = mass[i] * (place - reach) / dt
            v[i] += (place - reach) / dt
            slip = tally[PUNCH_V] - before[i]
            left = speed - v[i]
            tally[CONTACT] += impulse * (slip + left) / 2
            # work of the first half of the impulse
            tally[CONTACT_NOW] += impulse * (3 * slip + left) / 8
            tally[IMPULSE] += impulse
    if count > 0:
        tally[TOUCHED] += 1
    tally[PUNCH_KINETIC] = 0.125 * punch_mass * (tally[PUNCH_V] + speed) ** 2
    tally[PUNCH_Z] = place
    tally[PUNCH_V] = speed


@compiled
def advance(
    n_steps, motion, mass, mobility, gap, punch_mass, tally, state, tables, fields, constants, dt
):
    """Take ``n_steps`` central-difference steps; kinetic energies in ``tally`` are at the first
    instant.

    Parameters
    ----------
    motion
        (6, n_z + 1, n_r + 1): displacement (m), velocity half a step before (m/s), internal force
        (N), each r and z.
    mass, mobility
        Nodal masses, (n_z + 1, n_r + 1), kg, and 1/mass in r and z, (2, n_z + 1, n_r + 1), zero
        where fixed.
    gap
        Initial gaps between the nodes of the top and the punch, m; only nodes that it can touch.
    tables, fields
        ``(br, bz, bt, area, height)`` and ``(length, hourglass)``.
    """
    u_r = motion[0]
    u_z = motion[1]
    v_r = motion[2]
    v_z = motion[3]
    f_r = motion[4]
    f_z = motion[5]
    br, bz, bt, area, height = tables
    length, hourglass = fields
    before = np.empty(len(gap))
    for step in range(n_steps):
        kinetic = 0.0
        for i in range(len(gap)):
            before[i] = v_z[0, i]
            v_z[0, i] -= dt * mobility[1, 0, i] * f_z[0, i]
        _touch(u_z[0], v_z[0], before, mass[0], gap, tally, punch_mass, dt)
        for j in range(v_r.shape[0]):
            for i in range(v_r.shape[1]):
                old_r = v_r[j, i]
                old_z = v_z[j, i]
                new_r = old_r - dt * mobility[0, j, i] * f_r[j, i]
                if j == 0 and i < len(gap):
                    new_z = old_z
                    old_z = before[i]
                else:
                    new_z = old_z - dt * mobility[1, j, i] * f_z[j, i]
                v_r[j, i] = new_r
                v_z[j, i] = new_z
                u_r[j, i] += dt * new_r
                u_z[j, i] += dt * new_z
                if step == 0:
                    kinetic += 0.125 * mass[j, i] * ((old_r + new_r) ** 2 + (old_z + new_z) ** 2)
        if step == 0:
            tally[KINETIC] = kinetic
            punch_kinetic = tally[PUNCH_KINETIC]
            contact = tally[CONTACT_NOW]
        viscous, artificial = _stress(
            v_r, v_z, f_r, f_z, state, br, bz, bt, area, height, length, hourglass, constants, dt
        )
        tally[VISCOUS] += viscous
        tally[HOURGLASS] += artificial
    tally[PUNCH_KINETIC] = punch_kinetic
    tally[CONTACT_NOW] = contact


@compiled
def measure(state, tables, constants, tolerance, ever):
    """Return the present energies of the elements, and the volume at yield.

    Returns
    -------
    tuple
        Elastic and plastic energy (J), volume at yield (m^3), volume that was ever at yield (m^3),
        largest equivalent strain. ``ever`` is updated.
    """
    lam = constants[0]
    mu = constants[1]
    limit = constants[2]
    area = tables[3]
    height = tables[4]
    young = mu * (3 * lam + 2 * mu) / (lam + mu)
    bulk = lam + 2 * mu / 3
    elastic = plastic = now = all_time = strain = 0.0
    for j in range(state.shape[0]):
        for i in range(state.shape[1]):
            s = state[j, i]
            volume = area[i] * height[j]
            mean = (s[RR] + s[ZZ] + s[TT]) / 3
            square = 1.5 * (
                (s[RR] - mean) ** 2 + (s[ZZ] - mean) ** 2 + (s[TT] - mean) ** 2 + 2 * s[RZ] ** 2
            )
            elastic += volume * (square / (6 * mu) + mean * mean / (2 * bulk))
            plastic += volume * s[PLASTIC]
            if square >= (tolerance * limit) ** 2:
                now += volume
                ever[j, i] = True
            elif s[STRAIN] > 0:
                ever[j, i] = True
            if ever[j, i]:
                all_time += volume
            strain = max(strain, math.sqrt(square) / young + s[STRAIN])
    return elastic, plastic, now, all_time, strain
