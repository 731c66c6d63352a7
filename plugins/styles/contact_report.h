// SPDX-License-Identifier: GPL-2.0-only
/* Forces, energies and times of one contact for output, from its law and its complete state. */

#ifndef GRANWAVE_CONTACT_REPORT_H
#define GRANWAVE_CONTACT_REPORT_H

#include "../kernels/contact_history.h"
#include "../kernels/contact_memory.h"

#include "lmptype.h"

namespace granwave {

/* State of one contact for output, in physical units. */
struct ContactReport {
  int i, j;    // local index; j may be a ghost; -1: the record of a forgotten dent
  LAMMPS_NS::tagint tag_i, tag_j;
  double overlap, force;    // present values; overlap < 0 is a gap
  double on_first[3];       // present force on i: normal and tangential; of for_each_dent, for live contacts
  double peak_force, elastic, dissipated, share_i;
  double time_first;    // arrival of the force
  double tangential_force, tangential_elastic, frictional_loss;
  double rolling_loss, twisting_loss;    // part of the frictional loss
  double viscous_loss, adhesive_loss;
  double tangential[3];    // tangential force on sphere i
  double effective_radius;
  double initial;    // initial dent
  bool live, yielded;
  bool touches;    // or is held by a neck
  Dent dent;
};

/* Compute forces and energies of a contact with this overlap, from the dent of its report. */
void fill_report(ContactReport &, const ContactMemory &, const ScaledLaw &, const BlockView &, double overlap);

/* Largest force of this run: at the peak, where it is `at_peak` without cohesion, or below the initial dent. */
double largest_force_of_run(const ContactMemory &, const ScaledLaw &, const LawHistory &, const BlockView &, double overlap,
                            double at_peak);

/* Return 1 if the peak of a contact is beyond half of the range of its law, 2 if beyond all of it, else 0. */
int beyond_range(const ScaledLaw &, double peak);

}    // namespace granwave

#endif
