// SPDX-License-Identifier: GPL-2.0-only
#include "collision.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace granwave::bindings {

namespace {

/* Collision of viscoelastic bodies, by velocity Verlet. */
Collision collide_relaxing(const ScaledLaw &law, const PronySeries &series, double mass, double speed, double dt,
                           double longest)
{
  PronyHistory branches;
  double peak = 0.0, peak_force = 0.0, t = 0.0, x = 0.0, v = speed;
  while (t < longest) {
    v -= 0.5 * dt * branches.force / mass;
    x += dt * v;
    branches.advance(series, law, x, x > 0.0 ? law.elastic_force(x) : 0.0, dt);
    v -= 0.5 * dt * branches.force / mass;
    t += dt;
    peak = std::max(peak, x);
    peak_force = std::max(peak_force, branches.force);
    if (v < 0.0 && branches.force == 0.0) break;
  }
  return {v < 0.0 ? -v / speed : 0.0, t, peak_force, peak};
}

}    // namespace

Collision collide(const ScaledLaw &law, const ViscousLoss &loss, double mass, double speed, int steps)
{
  constexpr double MOST_OVERLAP = 4.0;    // over the effective radius
  constexpr double LONGEST = 50.0;        // end of a collision without separation, over the duration without loss
  // the time scale: overlap at which first loading has absorbed the kinetic energy, over the speed
  const std::vector<double> zero(std::max(law.law().n_extra(), 1), 0.0);
  const double energy = 0.5 * mass * speed * speed + law.pull_off() * law.balanced_overlap();
  double low = 0.0, high = 1e-9 * law.effective_radius();
  const double most = std::min(law.largest_overlap(), MOST_OVERLAP * law.effective_radius());
  while (high < most && law.loading_work(high, zero.data()) < energy) high *= 2.0;
  if (!(high < most)) return {NAN, NAN, NAN, NAN};
  for (int n = 0; n < 60; n++) {
    const double middle = 0.5 * (low + high);
    (law.loading_work(middle, zero.data()) < energy ? low : high) = middle;
  }
  const double scale = 2.9432 * high / std::sqrt(2.0 * energy / mass);    // duration of a Hertzian collision
  if (loss.relaxes()) return collide_relaxing(law, loss.prony, mass, speed, scale / steps, LONGEST * scale);
  const double least = -law.neck_length();

  std::vector<double> extra(zero);
  double peak = 0.0, peak_force = 0.0, t = 0.0, x = 0.0, v = speed;
  const auto force = [&](double overlap, double rate) {
    if (overlap <= least) return 0.0;
    const LawHistory h{std::max(peak, overlap), extra.data()};
    if (law.cohesive()) {
      const CohesiveState state = law.cohesive_state(overlap, h);
      const double c = loss.coefficient(2.0 * law.law().modulus() * std::sqrt(state.circle_squared), mass);
      return state.force + viscous_force(state.force + law.pull_off(), c, rate);
    }
    const double of_law = law.force(overlap, h);
    return of_law + viscous_force(of_law, loss.coefficient(law.tangent_stiffness(overlap, h), mass), rate);
  };
  const double usual = scale / steps;
  bool parts = !law.cohesive();    // false while bodies may stick
  while (t < LONGEST * scale) {
    // a loss that is large compared with the inertia needs shorter steps
    const LawHistory h{std::max(peak, x), extra.data()};
    const double at_start = x, v_start = v;
    const double c = x > 0.0 ? loss.coefficient(law.tangent_stiffness(x, h), mass) : 0.0;
    const double dt = c > 0.0 ? std::min(usual, 0.5 * mass / c) : usual;
    const auto slope = [&](double at, double rate) { return -force(at, rate) / mass; };
    const double a1 = slope(x, v), v2 = v + 0.5 * dt * a1, a2 = slope(x + 0.5 * dt * v, v2), v3 = v + 0.5 * dt * a2,
                 a3 = slope(x + 0.5 * dt * v2, v3), v4 = v + dt * a3, a4 = slope(x + dt * v3, v4);
    x += dt / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += dt / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    t += dt;
    if (x <= least) {
      if (law.has_neck())    // the force at its end is singular
        v = -std::sqrt(
            std::max(0.0, v_start * v_start -
                              2.0 / mass * (law.cohesive_state(least, h).energy - law.cohesive_state(at_start, h).energy)));
      parts = true;
      break;
    }
    law.update(x, peak, v, extra.data());
    peak = std::max(peak, x);
    const double f = force(x, v);
    peak_force = std::max(peak_force, f);
    if (v < 0.0 && f == 0.0) {    // no force from here on: the separation is not slowed
      parts = true;
      break;
    }
  }
  return {parts && v < 0.0 ? -v / speed : 0.0, t, peak_force, peak};
}

}    // namespace granwave::bindings
