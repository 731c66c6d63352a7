// Laws and batches of contacts as code of a graphics card: compiled by test_device_code.py, with one contact or batch per thread.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#pragma omp begin declare target    // with the constants that these refer to
#include "laws/elastoplastic_fe.h"
#pragma omp end declare target
#include "kernels/contact_batch.cpp"
#include "laws/contact_law.h"

using namespace granwave;

template <class Law> void normal(const Law &law, int n, const double *overlap, double *peak, double *force)
{
#pragma omp target teams distribute parallel for map(to : law, overlap[ : n]) map(tofrom : peak[ : n])                      \
    map(from : force[ : n])
  for (int m = 0; m < n; m++) {
    const Site site;
    const bool loads = overlap[m] >= peak[m];
    force[m] = loads ? law.loading(overlap[m], site) : law.turning(peak[m], site).unloading(overlap[m]);
    if (loads) peak[m] = overlap[m];
  }
}

template void normal(const Hertz &, int, const double *, double *, double *);
template void normal(const Elastoplastic &, int, const double *, double *, double *);
template void normal(const Bilinear &, int, const double *, double *, double *);
template void normal(const Thornton &, int, const double *, double *, double *);
template void normal(const ElastoplasticFe &, int, const double *, double *, double *);
template void normal(const RateDependent<Elastoplastic> &, int, const double *, double *, double *);
template void normal(const RateDependent<Thornton> &, int, const double *, double *, double *);
template void normal(const RateDependent<ElastoplasticFe> &, int, const double *, double *, double *);

void any_law(const AnyLaw *law, int n, const double *overlap, double *force)
{
#pragma omp target teams distribute parallel for map(to : law[ : 1], overlap[ : n]) map(from : force[ : n])
  for (int m = 0; m < n; m++) force[m] = std::visit([&](const auto &one) { return one.loading(overlap[m], {}); }, *law);
}

void friction(int n, TangentialSpring *springs, const double (*normal)[3], const double (*slip)[3], const double *stiffness,
              const double *limit)
{
#pragma omp target teams distribute parallel for map(tofrom : springs[ : n])                                                \
    map(to : normal[ : n], slip[ : n], stiffness[ : n], limit[ : n])
  for (int m = 0; m < n; m++)
    compute_tangential(springs[m], normal[m], slip[m], stiffness[m], limit[m], TangentialModel::MINDLIN_RESCALE);
}

void batches(int n, ContactBatch *batch, double dt)
{
#pragma omp target teams distribute parallel for map(tofrom : batch[ : n])
  for (int m = 0; m < n; m++) {
    batch[m].compute_overlap();
    batch[m].compute_normal();
    batch[m].prepare_friction();
    batch[m].advance_forces_and_torques(dt);
  }
}
