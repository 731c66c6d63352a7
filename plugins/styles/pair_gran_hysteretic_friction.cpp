// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: friction (tangential.h, partial_slip.h), resistance to rolling and twisting (resistance.h). */

#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "motion.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using namespace granwave;

/* Advance the tangential springs of touching pairs and compute the forces on the spheres, including friction. */

void PairGranHysteretic::compute_tangential(Batch &batch)
{
  Contacts &c = contacts;
  bool without = batch.prepare_friction();
  if (has_cohesion)
    for (int m = 0; m < batch.size; m++) {
      if (!batch.pair[m]->contact.cohesive()) continue;
      batch.limit[m] = batch.friction[m] * batch.pressing[m];
      without = without || !(batch.limit[m] > 0.0);
    }
  if (without)
    for (int m = 0; m < batch.size; m++) {
      if (batch.limit[m] > 0.0) continue;
      release_spring(batch.k[m]);
      batch.circle[m] = 1.0;    // any value, for a pair without friction
    }
  batch.read(triples(atom->v), triples(atom->omega), c.spring.data());
  if (!springs_advance) {
    batch.compute_forces_and_torques();
    return;
  }
  batch.advance_forces_and_torques(update->dt);
  if (has_slip) advance_slip(batch);
  batch.write(c.spring.data());
}

/* Replace the tangential forces of the pairs with partial slip by those of their rows of springs. */

void PairGranHysteretic::advance_slip(Batch &batch)
{
  bool any = false;
  for (int m = 0; m < batch.size; m++) {
    const PairParameters &p = *batch.pair[m];
    if (p.tangential_model != TangentialModel::PARTIAL_SLIP || !(batch.limit[m] > 0.0)) continue;
    any = true;
    SlipContact contact{
        {}, {}, batch.circle[m], batch.shear_stiffness[m] * batch.circle[m], batch.limit[m], p.contact.effective_radius()};
    double velocity[3], spin[3];
    for (int d = 0; d < 3; d++) {
      contact.normal[d] = batch.normal[d][m];
      velocity[d] = batch.velocity[d][m];
      spin[d] = batch.spin[d][m];
    }
    slip_of_step(velocity, spin, contact.normal, update->dt, contact.slip);
    TangentialSpring spring = contacts.spring[batch.k[m]];
    slip(batch.k[m])->advance(spring, contact);
    for (int d = 0; d < 3; d++) batch.tangential[d][m] = spring.force[d];
    batch.compliance[m] = spring.compliance;
    batch.loss[m] = spring.loss;
  }
  if (any) batch.compute_forces_and_torques();
}

SlipHistory *PairGranHysteretic::slip(int k)
{
  return &slip_history(contacts.extra.data() + std::size_t(k) * contacts.n_extra + slip_at());
}

/* Advance the resistances of touching pairs to rolling and twisting, and compute their torques. */

void PairGranHysteretic::compute_resistance(const Batch &batch, const double *circle, double (*moment)[3])
{
  const double (*const omega)[3] = triples(atom->omega);
  for (int m = 0; m < batch.size; m++) {
    std::fill_n(moment[m], 3, 0.0);
    const PairParameters &p = *batch.pair[m];
    if (!p.resistance) continue;
    ResistanceHistory &history = *resistance(batch.k[m]);
    const double pressing = p.contact.cohesive() ? batch.pressing[m] : batch.force[m];
    if (!(pressing > 0.0)) {
      history.release();
      continue;
    }
    RollingContact contact{{},        {}, p.contact.effective_radius(), pressing, circle[m], p.shear_stiffness * circle[m],
                           p.friction};
    for (int d = 0; d < 3; d++) {
      contact.normal[d] = batch.normal[d][m];
      contact.spin[d] = omega[batch.i[m]][d] - omega[batch.j[m]][d];
    }
    if (springs_advance) history.advance(*p.resistance, contact, update->dt);
    history.torque(contact.normal, contact.arm, moment[m]);
  }
}

ResistanceHistory *PairGranHysteretic::resistance(int k)
{
  return &resistance_history(contacts.extra.data() + std::size_t(k) * contacts.n_extra + resistance_at());
}
