// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: viscous losses (viscous_loss.h), and the end of contacts that have parted. */

#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "comm.h"
#include "motion.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using granwave::TouchingPairs;

granwave::ViscousHistory *PairGranHysteretic::viscous(int k)
{
  return &granwave::viscous_history(contacts.extra.data() + std::size_t(k + 1) * contacts.n_extra -
                                    granwave::ViscousHistory::SIZE);
}

/* Return true if something ends when the pair parts. */

bool PairGranHysteretic::has_spring(int k)
{
  return (has_friction && contacts.spring[k].compliance > 0.0) || (has_loss && viscous(k)->step > 0.0);
}

/* End the spring of a pair that has parted, and its viscous force. */

void PairGranHysteretic::release_contact(int k)
{
  Contacts &c = contacts;
  if (has_loss && viscous(k)->step > 0.0) {
    const auto row = std::upper_bound(c.begin.begin(), c.begin.end(), k) - c.begin.begin() - 1;
    const int i = c.row[row], j = c.partner[k];
    viscous(k)->release(atom->radius[i] + atom->radius[j] - distance(i, j));
  }
  if (has_friction) release(c.spring[k]);
}

/* Set the masses that spheres and ghosts move with, where there are rigid bodies. */

void PairGranHysteretic::set_masses()
{
  if (!rigid || neighbor->ago != 0) return;
  moved_mass.resize(atom->nmax);
  granwave::set_moved_masses(lmp, rigid, moved_mass);
  comm->forward_comm(this);
}

int PairGranHysteretic::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  for (int k = 0; k < n; k++) buf[k] = moved_mass[list[k]];
  return n;
}

void PairGranHysteretic::unpack_forward_comm(int n, int first, double *buf)
{
  std::copy_n(buf, n, moved_mass.begin() + first);
}

/* Add the viscous forces of touching pairs to the normal forces. Where a run is continued they are those of its last step, so
   that it is identical to an uninterrupted one; there are none in a minimization. */

void PairGranHysteretic::compute_viscous(Batch &batch)
{
  Contacts &c = contacts;
  const double *const v = atom->v[0], *const mass = rigid ? moved_mass.data() : atom->rmass;
  const int *const mask = atom->mask;
  const bool moves = update->whichflag == 1;
  for (int m = 0; m < batch.size; m++) {
    const PairParameters &p = *batch.pair[m];
    if (!p.loss) continue;
    const int k = batch.k[m], i = batch.i[m], j = batch.j[m];
    granwave::ViscousHistory &history = *viscous(k);
    const double overlap = batch.overlap[m], force = batch.force[m];
    if (!moves) {
      history.forget_state();
      continue;
    }
    if (!springs_advance && history.continues(overlap, TouchingPairs::ROUNDING * p.radsum)) {
      batch.force[m] = force + history.force;
      continue;
    }
    double stiffness = p.contact.is_hertzian() ? 1.5 * force / overlap : p.contact.hertz_stiffness(overlap);
    if (p.contact.yielded(c.peak[k]))
      stiffness = overlap >= c.peak[k] ? p.contact.tangent_stiffness(overlap, law_history(k))
                                       : p.contact.tangent_stiffness(overlap, c.turnings[cached_turning(k, p.contact)]);
    // the body of a flat face is much heavier than the sphere, and a frozen one does not move
    const double effective_mass = p.radius_i == 0.0 || (mask[i] & frozen)   ? mass[j]
                                  : p.radius_j == 0.0 || (mask[j] & frozen) ? mass[i]
                                                                            : mass[i] * mass[j] / (mass[i] + mass[j]);
    const double coefficient = p.loss.coefficient(stiffness, effective_mass);
    double approach = 0.0;    // from the velocities
    for (int d = 0; d < 3; d++) approach -= batch.del[d][m] * (v[3 * i + d] - v[3 * j + d]);
    approach /= batch.r[m];
    batch.force[m] = force + (springs_advance ? history.advance(overlap, force, coefficient, approach, update->dt)
                                              : history.start(overlap, force, coefficient, approach, update->dt));
  }
}
