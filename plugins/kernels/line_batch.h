// SPDX-License-Identifier: GPL-2.0-only
/* Batch of elastic contacts along lines (elastic_contact.h). No LAMMPS types. */

#ifndef GRANWAVE_LINE_BATCH_H
#define GRANWAVE_LINE_BATCH_H

#include "../laws/elastic_contact.h"

namespace granwave {

/* Batch of contacts along lines as plain arrays: forces and stiffnesses of several at a time, with the same bits as one by one.
   Contacts are computed in groups, the last of which may hold numbers of earlier batches. */
struct LineBatch {
  static constexpr int GROUP = 8;
  static constexpr int CAPACITY = 64;    // a multiple of it

  int size = 0;
  int place[CAPACITY];                            // index of the contact, as set by the caller
  double overlap[CAPACITY] = {};                  // input
  double force[CAPACITY], stiffness[CAPACITY];    // output

  bool full() const { return size == CAPACITY; }
  void add(int index, const LineContact &contact, double present)
  {
    place[size] = index;
    overlap[size] = present;
    overlap_scale[size] = contact.overlap_scale();
    force_scale[size] = contact.force_scale();
    size++;
  }
  void compute();

 private:
  double overlap_scale[CAPACITY] = {}, force_scale[CAPACITY] = {};
};

}    // namespace granwave

#endif
