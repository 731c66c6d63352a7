// SPDX-License-Identifier: GPL-2.0-only
/* Batch of contacts beyond their elastic limit as plain arrays: forces and contact circles of several at a time, with the
   functions of the laws and the same results as for one (ScaledLaw). No LAMMPS types. */

#ifndef GRANWAVE_PLASTIC_BATCH_H
#define GRANWAVE_PLASTIC_BATCH_H

#include "../laws/contact_law.h"
#include "contact_batch.h"

namespace granwave {

/* Common data of contacts on their loading curves and below their peaks. Contacts are computed in groups, the last of
   which may hold numbers of earlier batches. */
struct PlasticBatch {
  static constexpr int GROUP = 8;
  static constexpr int CAPACITY = ContactBatch::CAPACITY + GROUP;

  int size = 0;           // at most that of a ContactBatch
  int place[CAPACITY];    // index in the batch of touching pairs
  const ScaledLaw *law[CAPACITY];
  alignas(64) double overlap[CAPACITY];    // present one

  double force[CAPACITY], circle[CAPACITY];    // output: normal force, squared radius of the contact circle

  /* Add a contact, and return its index. */
  int add(int m, const ScaledLaw &scaled, double present)
  {
    place[size] = m;
    law[size] = &scaled;
    overlap[size] = present;
    yield_overlap[size] = scaled.yield_overlap();
    yield_force[size] = scaled.yield_force();
    effective_radius[size] = scaled.effective_radius();
    return size++;
  }

 protected:
  double yield_overlap[CAPACITY], yield_force[CAPACITY], effective_radius[CAPACITY];
};

struct LoadingBatch : PlasticBatch {
  Site site[CAPACITY];

  void compute();

 private:
  void compute(const AnyLaw &, int begin, int end);
};

struct UnloadingBatch : PlasticBatch {
  double peak[CAPACITY], peak_force[CAPACITY], residual[CAPACITY], exponent[CAPACITY], peak_area[CAPACITY];

  /* Set the branch of a contact; the area is the normalized area at the peak. */
  void set(int n, const Turning &t, double area)
  {
    peak[n] = t.peak;
    peak_force[n] = t.force;
    residual[n] = t.residual;
    exponent[n] = t.exponent;
    peak_area[n] = area;
  }
  void compute();
};

}    // namespace granwave

#endif
