// SPDX-License-Identifier: GPL-2.0-only
#include "elastic_contact.h"

#include "processors.h"

using namespace granwave;

namespace {

constexpr int GROUP = LineBatch::GROUP;

/* Roots as LineContact::exponent finds them, step by step: one that has been found, or has left the range of the law, stays. */
inline void exponents(const double *s, double *w)
{
  double wanted[GROUP], open[GROUP];
  for (int m = 0; m < GROUP; m++) {
    wanted[m] = 1.0 - logarithm(s[m]);
    const double near_end = 1.0 + std::sqrt(2.0 * (wanted[m] - 1.0)) + (wanted[m] - 1.0) / 1.5;
    const double first = wanted[m] < 2.0 ? near_end : wanted[m] + logarithm(wanted[m]);
    w[m] = s[m] < 1.0 ? first : 1.0;
    open[m] = 1.0;
  }
  // Two steps at a time: rounding ends in a root that stays, or in two that take turns, and the number of steps is even.
  static_assert(LineContact::STEPS % 2 == 0);
  for (int n = 0; n < LineContact::STEPS; n += 2) {
    double before[GROUP];
    int moved = 0;
    for (int m = 0; m < GROUP; m++) before[m] = w[m];
    for (int half = 0; half < 2; half++)
      for (int m = 0; m < GROUP; m++) {
        const double step = (w[m] - logarithm(w[m]) - wanted[m]) * w[m] / (w[m] - 1.0);
        const double next = open[m] > 0.0 ? w[m] - step : w[m];
        open[m] = std::fabs(step) <= LineContact::PRECISION * next ? 0.0 : open[m];
        w[m] = w[m] > 1.0 ? next : 1.0;
      }
    for (int m = 0; m < GROUP; m++) moved += w[m] != before[m];
    if (moved == 0) break;
  }
}

/* Forces and stiffnesses of whole groups, for each set of instructions. */
FOR_EACH_PROCESSOR void compute_groups(int n, const double *overlap, const double *overlap_scale, const double *force_scale,
                                       double *force, double *stiffness)
{
  for (int begin = 0; begin < n; begin += GROUP) {
    double s[GROUP], w[GROUP];
    for (int m = 0; m < GROUP; m++) s[m] = overlap[begin + m] / overlap_scale[begin + m];
    exponents(s, w);
    for (int m = 0; m < GROUP; m++) {
      const bool touches = overlap[begin + m] > LineContact::LEAST;
      const double f = force_scale[begin + m] * s[m] / w[m];
      const double k = force_scale[begin + m] / overlap_scale[begin + m] / (w[m] - 1.0);
      force[begin + m] = touches ? f : 0.0;
      stiffness[begin + m] = touches ? k : 0.0;
    }
  }
}

}    // namespace

void LineBatch::compute() { compute_groups(size, overlap, overlap_scale, force_scale, force, stiffness); }
