// SPDX-License-Identifier: GPL-2.0-only
/* State of contacts in memory, of pairs, walls and cylinders alike: the state of a contact in addition to its largest
   overlap, where that stands in its block of doubles, and what one timestep makes of it. No LAMMPS types.

   The block has the doubles of the law in front, and behind them a history of each kind that is in use. They are found from its
   end: the front has room for the law with the most doubles. */

#ifndef GRANWAVE_CONTACT_MEMORY_H
#define GRANWAVE_CONTACT_MEMORY_H

#include "../laws/contact_law.h"
#include "../laws/law_arguments.h"
#include "../laws/partial_slip.h"
#include "../laws/resistance.h"
#include "../laws/tangential_damping.h"
#include "../laws/viscous_loss.h"
#include "stored.h"

#include <algorithm>
#include <vector>

namespace granwave {

/* Contact as stored in a file: its largest overlap, and if `whole` its complete state: the spring, on a wall the place of
   the dent, and the block, which may be empty where it begins anew. */
struct KnownContact {
  double peak = 0.0;
  bool whole = false;
  // force and compliance of the spring; the force is on the first sphere, or on the sphere at a wall
  double force[3] = {}, compliance = 0.0;
  double place[2] = {};
  std::vector<double> block;
};

struct ContactMemory {
  bool friction = false, dents = false;    // a spring, and what initial dents need: no parts of the block
  bool slip = false, cohesion = false, resistance = false, loss = false, prony = false, damping = false;
  bool loss_first = false;    // for walls: the viscous loss precedes the other parts; for pairs it follows them
  int n = 0;                  // doubles of a block

  /* Add the history that contacts of a law need. */
  void extend(const LawArguments &law)
  {
    friction |= law.friction > 0.0 || law.resistance;
    slip |= law.slips_partially();
    cohesion |= bool(law.options.cohesion);
    resistance |= bool(law.resistance);
    loss |= bool(law.loss);
    prony |= law.loss.relaxes();
    damping |= law.loss.tangential > 0.0;
  }

  /* Histories of a block, to be changed. */
  SlipHistory slip_of(double *block) const { return SlipHistory(block + n - to_slip()); }
  Stored<CohesionHistory> cohesion_of(double *block) const { return part<CohesionHistory>(block, to_cohesion()); }
  Stored<ResistanceHistory> resistance_of(double *block) const { return part<ResistanceHistory>(block, to_resistance()); }
  Stored<ViscousHistory> loss_of(double *block) const { return part<ViscousHistory>(block, to_loss()); }
  Stored<PronyHistory> prony_of(double *block) const { return part<PronyHistory>(block, to_prony()); }
  DampingHistory damping_of(double *block) const { return DampingHistory(block + n - size()); }

  /* Copies; without such history they have the values of a new contact. */
  CohesionHistory cohesion_of(const double *block) const { return copy<CohesionHistory>(cohesion, block, to_cohesion()); }
  ResistanceHistory resistance_of(const double *block) const
  {
    return copy<ResistanceHistory>(resistance, block, to_resistance());
  }
  ViscousHistory loss_of(const double *block) const { return copy<ViscousHistory>(loss, block, to_loss()); }
  PronyHistory prony_of(const double *block) const { return copy<PronyHistory>(prony, block, to_prony()); }

  /* Doubles of the damping along the surface; null without. */
  const double *damping_of(const double *block) const { return damping ? block + n - size() : nullptr; }

  /* Energy lost by viscous forces along the normal and along the surface. */
  double viscous_loss(const double *block) const
  {
    return loss_of(block).lost + (damping ? damping_of(block)[DampingHistory::LOST] : 0.0);
  }

  /* Doubles of all these histories. */
  int size() const { return to_prony() + (damping ? DampingHistory::SIZE : 0); }

  /* Energy stored along the normal, also of viscoelastic bodies, whose elastic energy relaxes; `known` as in
     ScaledLaw::stored_energy(). */
  double stored_energy(const ScaledLaw &law, double overlap, const LawHistory &h, const Turning *known = nullptr) const
  {
    if (prony && overlap > 0.0) {
      const PronyHistory history = prony_of(h.extra);
      if (history.surface > 0.0) return history.stored;
    }
    return law.stored_energy(overlap, h, cohesion_of(h.extra).joined > 0.0, known);
  }

  /* Energy stored by friction. */
  double tangential_energy(const TangentialSpring &spring, const double *block) const
  {
    return slip ? SlipHistory::energy(block + n - to_slip(), spring) : granwave::tangential_energy(spring);
  }

  /* Turn the content of a block into the start of a run: springs and necks stay, dissipated energies are set to 0.
     `keeps_law` if the doubles of the law stay, too. */
  void begin(double *block, bool keeps_law) const
  {
    if (!keeps_law) std::fill_n(block, n - size(), 0.0);
    if (resistance) resistance_of(block)->begin();
    if (cohesion) cohesion_of(block)->lost = 0.0;
    if (loss) *loss_of(block) = {};
    if (prony) *prony_of(block) = {};
    if (damping) damping_of(block).begin();
  }

  /* True if this memory can represent the contact of the file. */
  bool takes(const KnownContact &contact) const
  {
    const bool sprung = contact.compliance != 0.0;
    return (friction || !sprung) && (contact.block.empty() || static_cast<int>(contact.block.size()) == n);
  }

  /* Forget the viscous forces of the last step: there are none in a minimization, and none after the end of a contact. */
  void forget_viscous(double *block) const
  {
    loss_of(block)->forget_state();
    if (prony) *prony_of(block) = {};
    if (damping) damping_of(block).release();
  }

  /* End the spring of surfaces that have separated, or that friction does not hold. */
  void release_spring(TangentialSpring &spring, double *block) const
  {
    if (damping) damping_of(block).release();
    if (slip && slip_of(block).active()) slip_of(block).release(spring);
    else release(spring);
  }

  /* Advance spring and damping of a contact by the slip of a timestep, with a positive normal force. `coefficient`: of the damping
     along the surface; null without. */
  void advance_friction(TangentialSpring &spring, double *block, const SlipContact &contact, TangentialModel model,
                        const double *coefficient, double dt) const
  {
    const bool slips = model == TangentialModel::PARTIAL_SLIP;
    const auto &[normal, moved, circle, stiffness, limit, radius] = contact;
    if (!coefficient && slips) return slip_of(block).advance(spring, contact);
    if (!coefficient) return compute_tangential(spring, normal, moved, stiffness, limit, model);
    DampingHistory history = damping_of(block);
    if (!slips) return compute_damped(spring, history, normal, moved, stiffness, limit, model, *coefficient, dt);
    SlipDamping damped{};
    history.drag_of_step(normal, moved, *coefficient, dt, damped.force);
    std::copy_n(history.force(), 3, damped.before);
    slip_of(block).advance(spring, contact, &damped);
    history.finish_step(damped.force, damped.lost);
  }

 private:
  int size_of_loss() const { return loss ? ViscousHistory::SIZE : 0; }
  // number of doubles from each part to the end
  int to_resistance() const { return (loss_first ? 0 : size_of_loss()) + (resistance ? ResistanceHistory::SIZE : 0); }
  int to_cohesion() const { return to_resistance() + (cohesion ? CohesionHistory::SIZE : 0); }
  int to_slip() const { return to_cohesion() + (slip ? SlipHistory::SIZE : 0); }
  int to_loss_or_slip() const { return to_slip() + (loss_first ? size_of_loss() : 0); }
  int to_prony() const { return to_loss_or_slip() + (prony ? PronyHistory::SIZE : 0); }
  int to_loss() const { return loss_first ? to_loss_or_slip() : size_of_loss(); }

  template <class History> Stored<History> part(double *block, int to_end) const
  {
    static_assert(doubles_of<History>() == History::SIZE);
    return Stored<History>(block + n - to_end);
  }
  template <class History> History copy(bool has, const double *block, int to_end) const
  {
    return has ? from_doubles<History>(block + n - to_end) : History();
  }
};

struct Step {
  double dt;
  bool advances;    // false in setup, so that a resumed run is identical to an uninterrupted one, and in a minimization
};

/* Advance the cohesion of a contact. Returns its state, whose force includes the compensation of a jump.

   turning     that of its peak if it has yielded
   rounding    smaller overlaps are none
   velocity    of approach */
inline CohesiveState advance_cohesion(const ScaledLaw &law, CohesionHistory &history, const LawHistory &h,
                                      const Turning *turning, double overlap, double rounding, double velocity,
                                      const Step &step)
{
  CohesiveState state;
  const bool joined = history.joined > 0.0;
  if (law.joins(overlap, joined, rounding)) state = law.cohesive_state(overlap, h, turning);
  const bool joins = state.circle_squared > 0.0;
  if (!joins) state.circle_squared = state.pressing = 0.0;
  if (!step.advances) {
    state.force += history.start(overlap, joins, rounding);
    return state;
  }
  const bool jumps = joins != joined;
  const CohesiveState last = jumps && joined ? law.cohesive_state(history.overlap, h, turning) : CohesiveState();
  const Jump jump = jumps ? law.jump(joins, overlap, h.peak, turning) : Jump{};
  state.force += history.advance(overlap, joins, state, last, jump, velocity * step.dt, law.has_neck());
  return state;
}

/* Advance the viscous loss of a contact. Returns the viscous force. When a run is resumed it is the force of the last step,
   so that it is identical to an uninterrupted one.

   force          of the law, with the pull-off force of a contact with cohesion: where it would pull harder, it is cut off
   coefficient    function that returns the force over the rate of the overlap */
template <class Coefficient>
double advance_loss(ViscousHistory &history, double overlap, double rounding, double force, double velocity,
                    const Step &step, const Coefficient &coefficient)
{
  if (step.advances) return history.advance(overlap, force, coefficient(), velocity, step.dt);
  if (history.continues(overlap, rounding)) return history.force;
  return history.start(overlap, force, coefficient(), velocity, step.dt);
}

/* Advance the loss of a contact of viscoelastic bodies. Returns F - P. Bodies that touch where a run begins have been pressed together
   just then; those that meet again have recovered since they parted.

   force    of the law
   now      time */
inline double advance_prony(const PronySeries &series, ViscousHistory &history, PronyHistory &branches, const ScaledLaw &law,
                            double overlap, double rounding, double force, const Step &step, double now)
{
  if (!step.advances && history.continues(overlap, rounding)) return history.force;
  if (!step.advances) {
    branches.start(series, law, overlap, force);
  } else {
    if (history.step == 0.0 && branches.surface > 0.0) {
      branches.recover(series, law, now - step.dt - branches.parted, step.dt);
      history.lost -= branches.stored;    // counted as dissipated at separation
    }
    history.lost += branches.advance(series, law, overlap, force, step.dt);
  }
  history.keep(overlap, force, branches.force - force, step.dt);
  return history.force;
}

/* Separate viscoelastic bodies: their stored energy dissipates, unless they touch again before. */
inline void part_prony(const PronySeries &series, ViscousHistory &history, PronyHistory &branches, const ScaledLaw &law,
                       const Step &step, double now)
{
  if (history.step > 0.0) {
    history.lost += branches.advance(series, law, 0.0, 0.0, step.dt) + branches.stored;
    branches.parted = now;
  }
  history.forget_state();
}

}    // namespace granwave

#endif
