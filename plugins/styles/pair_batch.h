// SPDX-License-Identifier: GPL-2.0-only
/* Batch of touching pairs with the laws of their contacts. */

#ifndef GRANWAVE_PAIR_BATCH_H
#define GRANWAVE_PAIR_BATCH_H

#include "../kernels/contact_batch.h"
#include "pair_laws.h"

namespace granwave {

struct PairBatch : ContactBatch {
  const PairParameters *pair[CAPACITY];
  PairParameters parameters[CAPACITY];    // of each pair, or only the first if all are equal; unused if known by type
  double pressing[CAPACITY];              // of pairs with cohesion: normal force that limits friction
  double damping[CAPACITY];               // with damping along the surface: its coefficient; below 0: a run is continued

  void set(int m, const PairParameters &p)
  {
    pair[m] = &p;
    radius_i[m] = p.radius_i;
    radius_j[m] = p.radius_j;
    radsum[m] = p.radsum;
    root_radius[m] = p.root_radius;
    hertz[m] = p.contact.hertz();
    shear_stiffness[m] = p.shear_stiffness;
    largest_overlap[m] = p.largest_overlap;
    elastic_limit[m] = p.contact.elastic_limit();
    friction[m] = p.friction;
    keeps[m] = p.tangential_model == TangentialModel::MINDLIN ? 1.0 : 0.0;
  }

  /* Normal force of a touching pair that limits its friction. */
  double pressing_force(int m) const { return pair[m]->contact.cohesive() ? pressing[m] : force[m]; }
};

}    // namespace granwave

#endif
