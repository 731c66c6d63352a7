// The columns with the laws as the plain pair style has them; no header of Kokkos is in the path.
#include "columns.h"

#include "kernels/front.h"

#ifdef KOKKOS_INLINE_FUNCTION
#error "this program is to be compiled without Kokkos"
#endif

struct Contact {
  double peak = 0.0, time_peak = -1.0, time_yield = -1.0;
  Front front;

  /* Advance by a timestep in which the spheres touch, and return the force. */
  double advance(const ScaledLaw &law, double overlap, double now)
  {
    const double before = peak;
    if (overlap > before) {
      if (Front::crosses(before, overlap)) front.rise(before, overlap, now, DT);
      if (!law.yielded(before) && law.yielded(overlap) && time_yield < 0.0) time_yield = now;
      peak = overlap;
      time_peak = now;
    }
    return law.force(overlap, {peak, nullptr});
  }
};

int main()
{
  std::vector<Contact> contacts(SPHERES);
  for (int step = 0; step < STEPS; step++) {
    const std::vector<double> x = positions(step);
    std::vector<double> f(x.size(), 0.0);
    for (int i = 0; i < SPHERES; i++) {
      if (!has_next(i)) continue;
      const ScaledLaw law = contact_of(i);
      const double *const xi = x.data() + 3 * static_cast<std::ptrdiff_t>(i), *const xj = xi + 3;
      const double radsum = radius(i) + radius(i + 1), del[3] = {xi[0] - xj[0], xi[1] - xj[1], xi[2] - xj[2]};
      const double square = del[0] * del[0] + del[1] * del[1] + del[2] * del[2];
      if (square >= TouchingPairs::touch_squared(radsum)) continue;
      const double r = std::sqrt(square), force = contacts[i].advance(law, radsum - r, step * DT) / r;
      for (int d = 0; d < 3; d++) {
        f[3 * i + d] += del[d] * force;
        f[3 * i + 3 + d] -= del[d] * force;
      }
    }
    for (int i = 0; i < SPHERES; i++) print("force", step, i, {f[3 * i], f[3 * i + 1], f[3 * i + 2]});
  }
  for (int i = 0; i < SPHERES; i++) {
    const Contact &c = contacts[i];
    if (has_next(i)) print("contact", STEPS, i, {c.peak, c.time_peak, c.time_yield, c.front.time[0], c.front.time[5]});
  }
}
