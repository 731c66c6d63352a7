// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: friction (tangential.h, partial_slip.h), resistance to rolling and twisting (resistance.h). */

#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "motion.h"

#include <algorithm>

using namespace LAMMPS_NS;
using namespace granwave;

/* Advance the tangential springs of touching pairs and compute the forces on the spheres, including friction. */

void PairGranHysteretic::compute_tangential(Batch &batch)
{
  ContactList &c = contacts;
  bool without = batch.prepare_friction();
  if (has.cohesion)
    for (int m = 0; m < batch.size; m++) {
      if (!batch.pair[m]->contact.cohesive()) continue;
      batch.limit[m] = batch.friction[m] * batch.pressing[m];
      without = without || !(batch.limit[m] > 0.0);
    }
  if (without)
    for (int m = 0; m < batch.size; m++) {
      if (batch.limit[m] > 0.0) continue;
      has.release_spring(c.spring[batch.k[m]], c.block(batch.k[m]));
      batch.circle[m] = 1.0;    // any value, for a pair without friction
    }
  batch.read(triples(atom->v), triples(atom->omega), c.spring.data());
  if (!step.advances) {
    batch.compute_forces_and_torques();
    return;
  }
  batch.advance_forces_and_torques(step.dt);
  if (has.slip) advance_slip(batch);
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
    slip_of_step(velocity, spin, contact.normal, step.dt, contact.slip);
    TangentialSpring spring = contacts.spring[batch.k[m]];
    has.slip_of(contacts.block(batch.k[m])).advance(spring, contact);
    for (int d = 0; d < 3; d++) batch.tangential[d][m] = spring.force[d];
    batch.compliance[m] = spring.compliance;
    batch.loss[m] = spring.loss;
  }
  if (any) batch.compute_forces_and_torques();
}

/* Advance the resistances of touching pairs to rolling and twisting, and compute their torques. */

void PairGranHysteretic::compute_resistance(const Batch &batch, const double *circle, double (*moment)[3])
{
  const double (*const omega)[3] = triples(atom->omega);
  for (int m = 0; m < batch.size; m++) {
    std::fill_n(moment[m], 3, 0.0);
    const PairParameters &p = *batch.pair[m];
    if (!p.resistance) continue;
    ResistanceHistory &history = has.resistance_of(contacts.block(batch.k[m]));
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
    if (step.advances) history.advance(*p.resistance, contact, step.dt);
    history.torque(contact.normal, contact.arm, moment[m]);
  }
}
