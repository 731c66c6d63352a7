// SPDX-License-Identifier: GPL-2.0-only
#include "plastic_batch.h"

#include "processors.h"

#include <type_traits>

using namespace granwave;

namespace {

/* The elastoplastic law, which needs powers, is compiled for each instruction set; the other laws are simple. */
FOR_EACH_PROCESSOR void load(const Elastoplastic &of, int n, const double *overlap, double *force, double *area)
{
  const Elastoplastic law = of;    // a copy, which stores do not change
  for (int first = 0; first < n; first += PlasticBatch::GROUP)
    for (int m = first; m < first + PlasticBatch::GROUP; m++) {
      force[m] = law.loading_beyond_yield(overlap[m]);
      area[m] = law.area_beyond_yield(overlap[m]);
    }
}

}    // namespace

void LoadingBatch::compute(const AnyLaw &any, int begin, int end)
{
  std::visit(
      [&](const auto &law) {
        if constexpr (std::is_same_v<std::decay_t<decltype(law)>, Elastoplastic>) {
          load(law, end - begin, overlap + begin, force + begin, circle + begin);
        } else {
          for (int m = begin; m < end; m++) {
            force[m] = law.loading(overlap[m], site[m]);
            circle[m] = law.area(overlap[m], site[m]);
          }
        }
      },
      any);
}

void LoadingBatch::compute()
{
  for (int m = 0; m < size; m++) overlap[m] = overlap[m] / yield_overlap[m];
  for (int begin = 0, end; begin < size; begin = end) {    // contacts of one law at a time
    for (end = begin + 1; end < size && &law[end]->law() == &law[begin]->law();) end++;
    compute(law[begin]->law().normal(), begin, end);
  }
  for (int m = 0; m < size; m++) {
    force[m] = yield_force[m] * force[m];
    circle[m] = effective_radius[m] * yield_overlap[m] * circle[m];
  }
}

FOR_EACH_PROCESSOR void UnloadingBatch::compute()
{
  for (int first = 0; first < size; first += GROUP)
    for (int m = first; m < first + GROUP; m++) {
      const Turning t{peak[m], peak_force[m], residual[m], exponent[m]};
      const double a = overlap[m] / yield_overlap[m];
      force[m] = yield_force[m] * t.unloading(a);
      circle[m] = effective_radius[m] * yield_overlap[m] * t.area(a, peak_area[m]);
    }
}
