// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: ghosts, the data sent to them, and pairs across a periodic boundary (pair_geometry.h). */

#include "pair_gran_hysteretic.h"

#include "comm.h"
#include "domain.h"

using namespace LAMMPS_NS;
using namespace granwave;

/* Shift the ghosts of a triclinic box as in all later steps: after reneighboring LAMMPS has shifted them in units of the edges. */
void PairGranHysteretic::renew_ghosts()
{
  if (domain->triclinic) comm->forward_comm();
}

/* Replace the velocities of a batch if there are pairs across the boundary of a deforming box. */
void PairGranHysteretic::set_relative_velocities(Batch &b) const
{
  for (int m = 0; m < b.size; m++) {
    if (!geometry.crosses(b.i[m], b.j[m])) continue;
    const PairGeometry::Vector velocity = geometry.shifted_velocity(b.i[m], b.j[m]);
    for (int d = 0; d < 3; d++) b.velocity[d][m] = velocity[d];
  }
}

void PairGranHysteretic::send(Message content)
{
  message = content;
  comm->forward_comm(this);
}

int PairGranHysteretic::pack_forward_comm(int n, int *list, double *buf, int pbc_flag, int *pbc)
{
  if (message == Message::VELOCITIES) return ghosts.pack(n, list, buf, pbc_flag != 0, pbc);
  for (int k = 0; k < n; k++) masses.pack(list[k], buf + k * MovedMass::SIZE);
  return n * MovedMass::SIZE;
}

void PairGranHysteretic::unpack_forward_comm(int n, int first, double *buf)
{
  if (message == Message::VELOCITIES) return ghosts.unpack(n, first, buf);
  for (int k = 0; k < n; k++) masses.unpack(first + k, buf + k * MovedMass::SIZE);
}
