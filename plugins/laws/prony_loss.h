// SPDX-License-Identifier: GPL-2.0-only
/* Damping of viscoelastic grains, whose modulus relaxes by a Prony series. No LAMMPS types.

       E(t) = E [1 - sum_i g_i (1 - exp(-t/tau_i))]            g_i weights, tau_i times

   E is the instantaneous modulus. With the force P(overlap) of an elastic law, the force of the contact is the hereditary
   integral over P (E. H. Lee and J. R. M. Radok, J. Appl. Mech. 27, 438, 1960), exact while the contact grows:

       F = (1 - sum_i g_i) P + sum_i g_i s_i,        ds_i/dt = dP/dt - s_i/tau_i

   Nothing pulls. Where F would be negative, the surfaces part and recover by themselves: P is replaced by the P* at which F
   is zero, and the branches continue from P*. The overlap of the recovering surface is that with this P*.

   The energy stored is (1 - sum_i g_i) U + sum_i g_i e_i with the energy U of the law, and

       de_i/dt = s_i d(overlap)/dt - 2 e_i/tau_i

   which is the energy of a foundation of springs, each with this relaxation, whose forces add up to F (all springs within the
   contact circle yield to the same overlap, counted from where the circle reached them). 2 g_i e_i/tau_i is lost.

   A timestep takes P as linear in time: the branches are exact for it, whatever the timestep divided by the time constant. */

#ifndef GRANWAVE_PRONY_LOSS_H
#define GRANWAVE_PRONY_LOSS_H

#include <algorithm>
#include <array>
#include <cmath>

namespace granwave {

struct PronySeries {
  static constexpr int MOST = 4;    // branches

  int n = 0;
  std::array<double, MOST> weight{}, time{};

  bool operator==(const PronySeries &other) const { return n == other.n && weight == other.weight && time == other.time; }

  /* Long-time modulus / instantaneous modulus. */
  double remains() const
  {
    double rest = 1.0;
    for (int i = 0; i < n; i++) rest -= weight[i];
    return rest;
  }
};

/* A branch over a timestep of y times its time constant, with P linear in time. */
struct PronyStep {
  double stress_left, stress_gain;    // s = stress_left s_before + stress_gain dP
  double energy_left, work_before,
      work_after;    // e = energy_left e_before + (work_before s_before + work_after s) d(overlap)

  PronyStep() = default;
  explicit PronyStep(double y)
  {
    const double relaxed = -std::expm1(-y), relaxed_twice = -std::expm1(-2.0 * y);
    stress_left = 1.0 - relaxed;
    stress_gain = relaxed / y;
    energy_left = 1.0 - relaxed_twice;
    const double mean = 0.5 * relaxed_twice / y;
    work_after = of_end(2.0 * y, mean);
    work_before = mean - work_after;
  }

 private:
  /* Integral of u exp(-z (1 - u)) from 0 to 1; `mean` is the integral without the factor u. */
  static double of_end(double z, double mean)
  {
    if (z > 0.05) return (1.0 - mean) / z;
    return 0.5 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0 - z * (1.0 / 720.0 - z / 5040.0))));
  }
};

/* State of the branches of a contact; all members are doubles, for communication. */
struct PronyHistory {
  // overlap of the surface, in addition to the overlap of the spheres while it recovers; 0: no contact yet
  double surface = 0.0;
  double law_force = 0.0;                                                   // P there
  double force = 0.0;                                                       // F
  double stored = 0.0;                                                      // energy
  double parted = 0.0;                                                      // time at which the spheres separated
  double stress[PronySeries::MOST] = {}, energy[PronySeries::MOST] = {};    // s_i and e_i

  static constexpr int SIZE = 5 + 2 * PronySeries::MOST;

  /* Start from a contact that was loaded instantaneously to this overlap. */
  template <class Law> void start(const PronySeries &series, const Law &law, double overlap, double of_law)
  {
    surface = overlap;
    law_force = force = of_law;
    stored = law.elastic_energy(overlap);
    std::fill_n(stress, series.n, of_law);
    std::fill_n(energy, series.n, stored);
  }

  /* Advance by a timestep to this overlap, with the force of the law there: 0 for surfaces that have separated. Returns
     the energy lost. */
  template <class Law> double advance(const PronySeries &series, const Law &law, double overlap, double of_law, double dt)
  {
    const double rest = series.remains();
    double constant = 0.0, slope = rest;    // F = constant + slope P
    std::array<PronyStep, PronySeries::MOST> steps;
    for (int i = 0; i < series.n; i++) {
      const PronyStep &step = steps[i] = PronyStep(dt / series.time[i]);
      constant += series.weight[i] * (step.stress_left * stress[i] - step.stress_gain * law_force);
      slope += series.weight[i] * step.stress_gain;
    }
    const bool was_open = !(force > 0.0), open = !(constant + slope * of_law > 0.0);
    const double now = open ? std::max(-constant / slope, 0.0) : of_law;
    const double there = open ? law.elastic_overlap(now) : overlap;
    const double change = now - law_force, moved = there - surface, before = stored;
    double lost = 0.0;
    force = open ? 0.0 : rest * now;
    stored = rest * law.elastic_energy(there);
    for (int i = 0; i < series.n; i++) {
      const PronyStep &step = steps[i];
      const double s = step.stress_left * stress[i] + step.stress_gain * change;
      const double e = step.energy_left * energy[i] + (step.work_before * stress[i] + step.work_after * s) * moved;
      lost += series.weight[i] * (0.5 * (stress[i] + s) * moved - (e - energy[i]));
      stored += series.weight[i] * e;
      if (!open) force += series.weight[i] * s;
      stress[i] = s;
      energy[i] = e;
    }
    surface = there;
    law_force = now;
    return open && was_open ? before - stored : lost;
  }

  /* Recover without force for this time, in steps that grow from dt. */
  template <class Law> void recover(const PronySeries &series, const Law &law, double duration, double dt)
  {
    constexpr double GROWTH = 1.02, NONE = 1e-14;    // tolerance relative to the initial force
    const double least = NONE * law_force;
    double done = 0.0;
    for (double step = dt; done < duration; step *= GROWTH) {
      const double next = std::min(step, duration - done);
      advance(series, law, 0.0, 0.0, next);
      done += step;
      if (law_force > least) continue;
      *this = {};
      return;
    }
  }
};

static_assert(sizeof(PronyHistory) == PronyHistory::SIZE * sizeof(double));

}    // namespace granwave

#endif
