// SPDX-License-Identifier: GPL-2.0-only
/* Simulation time of a force evaluation, bitwise identical for any division of a simulation into runs. */

#ifndef GRANWAVE_SIMULATED_TIME_H
#define GRANWAVE_SIMULATED_TIME_H

#include "update.h"

#include <cmath>

namespace granwave {

inline double simulated_time(const LAMMPS_NS::Update &update)
{
  const double by_runs = update.atime + (update.ntimestep - update.atimestep) * update.dt;
  const double at_once = update.ntimestep * update.dt;    // exact to rounding if the timestep is never changed
  return std::fabs(at_once - by_runs) < 1e-3 * update.dt ? at_once : by_runs;
}

}    // namespace granwave

#endif
