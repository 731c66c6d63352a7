// SPDX-License-Identifier: GPL-2.0-only
#include "contact_batch.h"

#include "processors.h"

#include <cstddef>
#include <cstring>

using namespace granwave;

namespace {

using Two = TwoDoubles;
using Four = FourDoubles;

/* Return vector i of an array of components. */
template <class Component> inline Component *vector_of(Component *components, int i)
{
  return components + 3 * static_cast<std::ptrdiff_t>(i);
}

/* Add a vector, whose first two components are added at once. */
inline void add(double *to, const Two &xy, double z)
{
  Two sum;
  std::memcpy(&sum, to, sizeof(sum));
  sum += xy;
  std::memcpy(to, &sum, sizeof(sum));
  to[2] += z;
}

constexpr int SPRINGS_AHEAD = 400;    // pairs of the batches after the next, whose springs are fetched meanwhile

/* Read or write springs and motion of pairs, four at a time, and return the number of completed pairs. */
FOR_OTHERS int read_fours(ContactBatch &, const double *, const double *, const TangentialSpring *) { return 0; }

FOR_OTHERS int write_fours(const ContactBatch &, TangentialSpring *) { return 0; }

#ifdef FOR_AVX2

struct FourVectors {
  Four x, y, z;
};

FOR_AVX2 inline Four four(const double *a, const double *b, const double *c, const double *d)
{
  const __m128d ab = _mm_loadh_pd(_mm_load_sd(a), b), cd = _mm_loadh_pd(_mm_load_sd(c), d);
  return _mm256_insertf128_pd(_mm256_castpd128_pd256(ab), cd, 1);
}

FOR_AVX2 inline Four two_pairs(const double *a, const double *c)
{
  return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(a)), _mm_loadu_pd(c), 1);
}

FOR_AVX2 inline FourVectors four_vectors(const double *of, const int *at)
{
  const double *const a = vector_of(of, at[0]), *const b = vector_of(of, at[1]);
  const double *const c = vector_of(of, at[2]), *const d = vector_of(of, at[3]);
  const Four ac = two_pairs(a, c), bd = two_pairs(b, d);
  return {_mm256_unpacklo_pd(ac, bd), _mm256_unpackhi_pd(ac, bd), four(a + 2, b + 2, c + 2, d + 2)};
}

// the compliance is read and written together with the third component of the force
static_assert(offsetof(TangentialSpring, compliance) == 3 * sizeof(double));

FOR_AVX2 int read_fours(ContactBatch &to, const double *v, const double *omega, const TangentialSpring *springs)
{
  int m = 0;
  for (; m + 4 <= to.size; m += 4) {
    const FourVectors vi = four_vectors(v, to.i + m), vj = four_vectors(v, to.j + m);
    _mm256_storeu_pd(to.velocity[0] + m, vi.x - vj.x);
    _mm256_storeu_pd(to.velocity[1] + m, vi.y - vj.y);
    _mm256_storeu_pd(to.velocity[2] + m, vi.z - vj.z);
    const FourVectors oi = four_vectors(omega, to.i + m), oj = four_vectors(omega, to.j + m);
    const Four li = _mm256_loadu_pd(to.lever_i + m), lj = _mm256_loadu_pd(to.lever_j + m);
    _mm256_storeu_pd(to.spin[0] + m, li * oi.x + lj * oj.x);
    _mm256_storeu_pd(to.spin[1] + m, li * oi.y + lj * oj.y);
    _mm256_storeu_pd(to.spin[2] + m, li * oi.z + lj * oj.z);
    const TangentialSpring &a = springs[to.k[m]], &b = springs[to.k[m + 1]], &c = springs[to.k[m + 2]],
                           &d = springs[to.k[m + 3]];
    const Four ac = two_pairs(a.force, c.force), bd = two_pairs(b.force, d.force);
    const Four ac_rest = two_pairs(a.force + 2, c.force + 2), bd_rest = two_pairs(b.force + 2, d.force + 2);
    _mm256_storeu_pd(to.tangential[0] + m, _mm256_unpacklo_pd(ac, bd));
    _mm256_storeu_pd(to.tangential[1] + m, _mm256_unpackhi_pd(ac, bd));
    _mm256_storeu_pd(to.tangential[2] + m, _mm256_unpacklo_pd(ac_rest, bd_rest));
    _mm256_storeu_pd(to.compliance + m, _mm256_unpackhi_pd(ac_rest, bd_rest));
    _mm256_storeu_pd(to.loss + m, four(&a.loss, &b.loss, &c.loss, &d.loss));
  }
  return m;
}

FOR_AVX2 inline __m128d low(Four numbers) { return _mm256_castpd256_pd128(numbers); }
FOR_AVX2 inline __m128d high(Four numbers) { return _mm256_extractf128_pd(numbers, 1); }

FOR_AVX2 int write_fours(const ContactBatch &from, TangentialSpring *springs)
{
  int m = 0;
  for (; m + 4 <= from.size; m += 4) {
    const Four x = _mm256_loadu_pd(from.tangential[0] + m), y = _mm256_loadu_pd(from.tangential[1] + m);
    const Four ac = _mm256_unpacklo_pd(x, y), bd = _mm256_unpackhi_pd(x, y);
    const Four z = _mm256_loadu_pd(from.tangential[2] + m), compliance = _mm256_loadu_pd(from.compliance + m);
    const Four ac_rest = _mm256_unpacklo_pd(z, compliance), bd_rest = _mm256_unpackhi_pd(z, compliance);
    const __m128d xy[] = {low(ac), low(bd), high(ac), high(bd)};
    const __m128d rest[] = {low(ac_rest), low(bd_rest), high(ac_rest), high(bd_rest)};
    for (int n = 0; n < 4; n++) {
      if (from.limit[m + n] == 0.0) continue;
      TangentialSpring &spring = springs[from.k[m + n]];
      _mm_storeu_pd(spring.force, xy[n]);
      _mm_storeu_pd(spring.force + 2, rest[n]);
      spring.loss = from.loss[m + n];
    }
  }
  return m;
}

#endif

}    // namespace

FOR_EACH_PROCESSOR void ContactBatch::multiply_normals()
{
  for (int m = 0; m < size; m++) {
    const double apart = std::sqrt(rsq[m]);
    for (int d = 0; d < 3; d++) del[d][m] = del[d][m] / apart * apart;
    rsq[m] = apart * apart;
  }
}

FOR_EACH_PROCESSOR bool ContactBatch::compute_overlap()
{
  int errors = 0;
  for (int m = 0; m < size; m++) {
    r[m] = std::sqrt(rsq[m]);
    overlap[m] = radsum[m] - r[m];
    const double root = std::sqrt(overlap[m]);
    force[m] = hertz[m] * overlap[m] * root;
    circle[m] = root_radius[m] * root;
    errors += overlap[m] <= largest_overlap[m] ? 0 : 1;
  }
  return errors > 0;
}

FOR_FOUR_DOUBLES void ContactBatch::compare_with_peaks(std::uint64_t &raised, std::uint64_t &yielded) const
{
  static_assert(CAPACITY == 64);    // a word of bits
  FourWords bit = {1, 2, 4, 8}, higher = {}, beyond = {};
  for (int m = 0; m < size; m += 4, bit <<= 4) {
    Four now, before, limit;
    std::memcpy(&now, overlap + m, sizeof(now));
    std::memcpy(&before, peak + m, sizeof(before));
    std::memcpy(&limit, elastic_limit + m, sizeof(limit));
    higher |= (now > before) & bit;
    beyond |= ((now > limit) | (before > limit)) & bit;
  }
  const std::uint64_t used = ~std::uint64_t(0) >> (CAPACITY - size);
  raised = used & static_cast<std::uint64_t>((higher[0] | higher[1]) | (higher[2] | higher[3]));
  yielded = used & static_cast<std::uint64_t>((beyond[0] | beyond[1]) | (beyond[2] | beyond[3]));
}

FOR_EACH_PROCESSOR void ContactBatch::compute_normal()
{
  for (int m = 0; m < size; m++) pair_force[m] = force[m] / r[m];
}

FOR_EACH_PROCESSOR bool ContactBatch::prepare_friction()
{
  int without = 0;
  for (int m = 0; m < size; m++) {
    limit[m] = std::max(friction[m] * force[m], 0.0);
    without += limit[m] > 0.0 ? 0 : 1;
    lever_i[m] = radius_i[m] - 0.5 * overlap[m];
    lever_j[m] = radius_j[m] - 0.5 * overlap[m];
    const double inverse = 1.0 / r[m];
    for (int d = 0; d < 3; d++) normal[d][m] = del[d][m] * inverse;
  }
  return without > 0;
}

void ContactBatch::read(const double *v, const double *omega, const TangentialSpring *springs)
{
  for (int m = read_fours(*this, v, omega, springs); m < size; m++) {
    const double *const vi = vector_of(v, i[m]), *const vj = vector_of(v, j[m]);
    const double *const oi = vector_of(omega, i[m]), *const oj = vector_of(omega, j[m]);
    const TangentialSpring &spring = springs[k[m]];
    for (int d = 0; d < 3; d++) {
      velocity[d][m] = vi[d] - vj[d];
      spin[d][m] = lever_i[m] * oi[d] + lever_j[m] * oj[d];
      tangential[d][m] = spring.force[d];
    }
    compliance[m] = spring.compliance;
    loss[m] = spring.loss;
  }
}

void ContactBatch::write(TangentialSpring *springs) const
{
  for (int m = write_fours(*this, springs); m < size; m++)
    if (limit[m] > 0.0) springs[k[m]] = {{tangential[0][m], tangential[1][m], tangential[2][m]}, compliance[m], loss[m]};
}

template <bool ADVANCES> ALWAYS_INLINE void ContactBatch::compute_friction(double dt)
{
  for (int m = 0; m < size; m++) {
    double n[3], f[3], per_lever[3];
    for (int d = 0; d < 3; d++) {
      n[d] = normal[d][m];
      f[d] = tangential[d][m];
    }
    if (ADVANCES) {
      const double v[3] = {velocity[0][m], velocity[1][m], velocity[2][m]}, s[3] = {spin[0][m], spin[1][m], spin[2][m]};
      double slip[3];
      slip_of_step(v, s, n, dt, slip);
      TangentialSpring spring{{f[0], f[1], f[2]}, compliance[m], loss[m]};
      granwave::compute_tangential(spring, n, slip, shear_stiffness[m] * circle[m], limit[m],
                                   keeps[m] > 0.0 ? TangentialModel::MINDLIN : TangentialModel::MINDLIN_RESCALE);
      for (int d = 0; d < 3; d++) tangential[d][m] = f[d] = spring.force[d];
      compliance[m] = spring.compliance;
      loss[m] = spring.loss;
    }
    torque_per_lever(n, f, per_lever);
    for (int d = 0; d < 3; d++) {
      force_i[d][m] = n[d] * force[m] + f[d];
      torque[d][m] = per_lever[d];
    }
  }
}

FOR_EACH_PROCESSOR void ContactBatch::compute_forces_and_torques() { compute_friction<false>(0.0); }
FOR_EACH_PROCESSOR void ContactBatch::advance_forces_and_torques(double dt) { compute_friction<true>(dt); }

void ContactBatch::add_normal(double *forces, int owned) const
{
  for (int m = 0; m < size; m++) {
    const Two f = Two{del[0][m], del[1][m]} * pair_force[m];
    const double fz = del[2][m] * pair_force[m];
    if (i[m] < owned) add(vector_of(forces, i[m]), f, fz);
    if (j[m] < owned) add(vector_of(forces, j[m]), -f, -fz);
  }
}

void ContactBatch::add_forces_and_torques(double *forces, double *torques, int owned, const TangentialSpring *springs) const
{
  for (int m = 0; m < size; m++) {
    const Two f = {force_i[0][m], force_i[1][m]}, t = {torque[0][m], torque[1][m]};
    FETCH_AHEAD_TO_WRITE(springs + k[m] + SPRINGS_AHEAD);    // with the next, for about every second pair touches
    FETCH_AHEAD_TO_WRITE(springs + k[m] + SPRINGS_AHEAD + 1);
    if (i[m] < owned) {
      add(vector_of(forces, i[m]), f, force_i[2][m]);
      add(vector_of(torques, i[m]), lever_i[m] * t, lever_i[m] * torque[2][m]);
    }
    if (j[m] < owned) {
      add(vector_of(forces, j[m]), -f, -force_i[2][m]);
      add(vector_of(torques, j[m]), lever_j[m] * t, lever_j[m] * torque[2][m]);
    }
  }
}

void ContactBatch::add_forces_and_moments(double *forces, double *torques, int owned, const double (*moment)[3]) const
{
  for (int m = 0; m < size; m++)
    for (int d = 0; d < 3; d++) {
      if (i[m] < owned) {
        vector_of(forces, i[m])[d] += force_i[d][m];
        vector_of(torques, i[m])[d] += lever_i[m] * torque[d][m] + moment[m][d];
      }
      if (j[m] < owned) {
        vector_of(forces, j[m])[d] -= force_i[d][m];
        vector_of(torques, j[m])[d] += lever_j[m] * torque[d][m] - moment[m][d];
      }
    }
}
