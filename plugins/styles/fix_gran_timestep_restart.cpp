// SPDX-License-Identifier: GPL-2.0-only
/* Fix gran/timestep: state of the choice of the step in restart files. */

#include "fix_gran_timestep.h"

#include "comm.h"
#include "error.h"
#include "restart_state.h"
#include "update.h"

#include <cmath>

using namespace LAMMPS_NS;

namespace {

constexpr std::size_t N_STATE = 18;

}    // namespace

void FixGranTimestep::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const auto &state = controller.state();
  granwave::write_state(fp, {tick, origin, energy, bound, s, double(n_steps), double(shortest_taken), double(longest_taken),
                             double(state.ticks), std::round(reported[0] / tick), double(state.wanted), double(state.steps),
                             double(state.since), state.start, state.left, state.swing, state.swing_before, reported[1]});
}

void FixGranTimestep::restart(char *buffer)
{
  const double *value = granwave::read_state(lmp, *this, buffer, N_STATE);
  const auto next = [&value] { return *value++; };
  const auto whole = [&next] { return static_cast<std::int64_t>(next()); };
  if (const double given = next(); given != tick)
    error->all(FLERR, "Restart file holds fix {} {} with ticks of {:.17g}, found a timestep of {:.17g}", STYLE, id, given,
               tick);
  origin = next();
  energy = next();
  bound = next();
  s = next();
  n_steps = whole();
  shortest_taken = whole();
  longest_taken = whole();
  granwave::StepController::State state;
  state.ticks = whole();
  const std::int64_t reported_ticks = whole();
  state.wanted = whole();
  state.steps = whole();
  state.since = whole();
  state.start = next();
  state.left = next();
  state.swing = next();
  state.swing_before = next();
  const double error = next();
  controller.restore(state);
  taken = reported_ticks;
  report();
  reported[1] = error;
  taken = state.ticks;
  update->dt = static_cast<double>(taken) * tick;
}
