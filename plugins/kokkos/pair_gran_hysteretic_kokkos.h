// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic/kk: normal forces of spheres with the laws hertz and elastoplastic, and friction, computed by Kokkos
   (contact_kernels.h). It is in plugins that are built with Kokkos, and requires no package KOKKOS of LAMMPS.

   The flat list of pairs is that of the plain style, and is made on the host. Histories are sent to the card whenever it is made,
   and come back before the host reads them: for output, restart files, spheres that go to another processor, and the next list.
   Positions are sent and forces come back in each timestep, with friction also velocities and torques. */

#ifdef PAIR_CLASS
// clang-format off
PairStyle(gran/hysteretic/kk,PairGranHystereticKokkos<Kokkos::DefaultExecutionSpace>);
// clang-format on
#else

#ifndef LMP_PAIR_GRAN_HYSTERETIC_KOKKOS_H
#define LMP_PAIR_GRAN_HYSTERETIC_KOKKOS_H

#include "contact_kernels.h"

#include "../styles/pair_gran_hysteretic.h"

namespace LAMMPS_NS {

template <class DeviceType> class PairGranHystereticKokkos : public PairGranHysteretic {
 public:
  static constexpr const char *STYLE = "gran/hysteretic/kk";

  explicit PairGranHystereticKokkos(LAMMPS *);

  void init_style() override;
  void compute(int, int) override;
  double memory_usage() override;

 private:
  using Vectors = Kokkos::View<double *[3], Kokkos::LayoutRight, DeviceType>;

  granwave::ContactViews<DeviceType> views;
  Vectors x, v, omega;    // of all spheres
  Vectors f, torque;      // of owned spheres
  bool ahead = false;     // true if histories have advanced since they were sent

  void refuse_others();
  void refuse_flow();
  void send_velocities();
  void send_pairs();
  void send_laws();
  void send_contacts_of_spheres();
  void send_histories();
  void bring_back();
  void compute_contacts(bool with_virial);
  void forget_far();
  [[noreturn]] void stop_at_wrong_overlap();
};

}    // namespace LAMMPS_NS

#endif

#endif
