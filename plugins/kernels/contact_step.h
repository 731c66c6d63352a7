// SPDX-License-Identifier: GPL-2.0-only
/* One timestep of a contact of two spheres, or of a sphere and a wall, with the normal force of its law: viscous losses, friction with
   damping along the surface, and resistances to rolling and twisting. Used by the pair style and by the walls. No LAMMPS types.

   Vectors and torques are those of the first body; at a wall that is the sphere. */

#ifndef GRANWAVE_CONTACT_STEP_H
#define GRANWAVE_CONTACT_STEP_H

#include "contact_memory.h"

#include <algorithm>

namespace granwave {

/* Contact at the end of a timestep. */
struct PresentContact {
  const ScaledLaw &law;
  double *block;    // what it remembers (contact_memory.h)
  double peak;      // largest overlap so far
  double overlap;
  double rounding;    // smaller overlaps are none
  double velocity;    // of approach
  double force;       // normal force of the law, with cohesion
  double pressing;    // with cohesion: normal force that limits friction
  double circle;      // with cohesion: radius of the contact circle
};

struct ViscousForce {
  double normal = 0.0;      // to be added to the force of the law
  double damping = -1.0;    // coefficient of damping along the surface; below 0: a run is continued, or there is none
};

/* Advance the viscous loss of a contact, in a run.

   now           time
   stiffness     function that returns the tangent stiffness of the law without cohesion
   mass          function that returns the effective mass of the two bodies, from the tangent stiffness of their contact */
template <class Stiffness, class Mass>
ViscousForce advance_viscous(const ViscousLoss &loss, const ContactMemory &has, const PresentContact &contact,
                             const Step &step, double now, const Stiffness &stiffness, const Mass &mass)
{
  const ScaledLaw &law = contact.law;
  const double overlap = contact.overlap;
  Stored<ViscousHistory> history = has.loss_of(contact.block);
  ViscousForce viscous;
  if (loss.relaxes()) {
    viscous.normal = advance_prony(loss.prony, *history, *has.prony_of(contact.block), law, overlap, contact.rounding,
                                   contact.force, step, now);
    return viscous;
  }
  if (law.cohesive() && !(contact.pressing > 0.0)) {
    history->release(overlap);
    return viscous;
  }
  const double cut_off = contact.force + law.pull_off();
  viscous.normal = advance_loss(*history, overlap, contact.rounding, cut_off, contact.velocity, step, [&] {
    const bool elastic_neck = law.cohesive() && !law.yielded(contact.peak);
    const double slope = elastic_neck ? 2.0 * law.law().modulus() * contact.circle : stiffness();
    const double coefficient = loss.coefficient(slope, loss.kind == LossKind::DASHPOT ? mass(slope) : 0.0);
    viscous.damping = loss.tangential * coefficient;
    return coefficient;
  });
  return viscous;
}

/* End the viscous force of surfaces that have parted, with this overlap below 0. */
inline void part_viscous(const ViscousLoss &loss, const ContactMemory &has, const ScaledLaw &law, double *block,
                         double overlap, const Step &step, double now)
{
  Stored<ViscousHistory> history = has.loss_of(block);
  if (!loss.relaxes()) return history->release(overlap);
  part_prony(loss.prony, *history, *has.prony_of(block), law, step, now);
}

/* Slip of a contact in a timestep, from the velocities that slip_of_step() takes.

   circle    radius of the contact circle
   limit     Coulomb's, of the force along the surface */
inline SlipContact slip_contact(const ScaledLaw &law, double circle, double limit, const double (&normal)[3],
                                const double (&velocity)[3], const double (&spin)[3], double dt)
{
  SlipContact contact{{normal[0], normal[1], normal[2]},      {},    circle,
                      law.law().tangential_stiffness(circle), limit, law.effective_radius()};
  slip_of_step(velocity, spin, normal, dt, contact.slip);
  return contact;
}

/* Advance spring and damping along the surface, with a positive limit. Where a run begins, the damping is that of the present
   velocities.

   damping    its coefficient, as in ViscousForce; null without */
inline void step_friction(const ContactMemory &has, TangentialSpring &spring, double *block, const SlipContact &contact,
                          TangentialModel model, const double *damping, const Step &step)
{
  if (step.advances) return has.advance_friction(spring, block, contact, model, damping, step.dt);
  if (damping && *damping >= 0.0)
    has.damping_of(block).start(contact.normal, contact.slip, spring.force, *damping, contact.limit, step.dt);
}

/* Advance the resistances to rolling and twisting, and compute their torque. There is none without a pressing force. */
inline void step_resistance(const ResistanceModel &model, ResistanceHistory &history, const RollingContact &contact,
                            const Step &step, double (&torque)[3])
{
  std::fill_n(torque, 3, 0.0);
  if (!(contact.force > 0.0)) return history.release();
  if (step.advances) history.advance(model, contact, step.dt);
  history.torque(contact.normal, contact.arm, torque);
}

}    // namespace granwave

#endif
