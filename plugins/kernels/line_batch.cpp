// SPDX-License-Identifier: GPL-2.0-only
#include "line_batch.h"

#include "processors.h"

using namespace granwave;

namespace {

constexpr int GROUP = LineBatch::GROUP;

/* Forces and stiffnesses of complete groups, for each instruction set. */
FOR_EACH_PROCESSOR void compute_groups(int n, const double *overlap, const double *overlap_scale, const double *force_scale,
                                       double *force, double *stiffness)
{
  for (int begin = 0; begin < n; begin += GROUP) {
    double s[GROUP], w[GROUP];
    for (int m = 0; m < GROUP; m++) s[m] = overlap[begin + m] / overlap_scale[begin + m];
    LineContact::exponents<GROUP>(s, w);
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
