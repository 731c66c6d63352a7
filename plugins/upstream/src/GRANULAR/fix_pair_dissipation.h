/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   Copyright (2003) Sandia Corporation.  Under the terms of Contract
   DE-AC04-94AL85000 with Sandia Corporation, the U.S. Government retains
   certain rights in this software.  This software is distributed under
   the GNU General Public License.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef FIX_CLASS
// clang-format off
FixStyle(PAIR_DISSIPATION,FixPairDissipation);
// clang-format on
#else

#ifndef LMP_FIX_PAIR_DISSIPATION_H
#define LMP_FIX_PAIR_DISSIPATION_H

#include "fix.h"

#include <vector>

namespace LAMMPS_NS {

class FixPairDissipation : public Fix {
 public:
  // parts of a contact force that take energy from the two particles

  enum Channel { NORMAL, TANGENTIAL, ROLLING, TWISTING, NCHANNEL };

  struct Contact {
    tagint partner;
    bigint step;    // at which they last touched
    int owner;      // 1 for one of the records of a contact, 0 for copies
    double rate[NCHANNEL];
    double energy[NCHANNEL];
  };

  FixPairDissipation(class LAMMPS *, int, char **);
  ~FixPairDissipation() override;

  int setmask() override;
  void init() override;
  void setup(int) override;
  void pre_exchange() override;
  void post_force(int) override;
  void end_of_step() override;
  void post_run() override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  int pack_reverse_comm_size(int, int) override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;
  double memory_usage() override;

  double total[NCHANNEL];    // energy of all contacts so far that this processor owned

  const std::vector<Contact> &contacts_of(int i) const { return contacts[i]; }

 private:
  // force of a touching pair at this step, until the velocities at its end are known

  struct Touch {
    int i, j, owner;
    double normal[3];               // from j to i
    double fnormal;                 // on i, positive if repulsive
    double ftangential[3];          // on i
    double leveri, leverj;          // of the tangential force
    double rolling[3], twisting;    // torques on i
  };

  class Pair *pair;
  int granular;    // 1 for pair style granular, 0 for the gran/ styles
  std::vector<Touch> touches;
  std::vector<std::vector<Contact>> contacts;    // of each owned atom, and of ghosts to send
  double last_total_rate[NCHANNEL];
  int nghost_velocity;
  double **ghost_velocity;    // v and omega at the end of the step

  int owns(int, int) const;
  bool evaluate(int, int, double, double, Touch &);
  void communicate_velocities();
  void advance(double);
  void rates_of(const Touch &, double *) const;
  void integrate(Contact &, const double *, double) const;
  Contact &record_of(int, tagint);
  int pack_contacts(int, double *) const;
  int unpack_contacts(int, const double *);
};

}    // namespace LAMMPS_NS

#endif
#endif
