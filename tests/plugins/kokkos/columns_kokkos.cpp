// The columns with the kernels of pair style gran/hysteretic/kk, on the back end given by the first argument, serial or openmp; with friction if there is a second argument.
#include "kokkos/contact_kernels.h"

#include "columns.h"

using Positions = Kokkos::View<double *[3], Kokkos::LayoutRight, Kokkos::HostSpace>;

/* Return an array of a back end with these numbers. */
template <class Array, class T> Array array_of(const std::vector<T> &numbers)
{
  Array array(Kokkos::view_alloc(Kokkos::WithoutInitializing, "columns"), numbers.size());
  Kokkos::deep_copy(array, Kokkos::View<const T *, Kokkos::HostSpace, Kokkos::MemoryTraits<Kokkos::Unmanaged>>(
                               numbers.data(), numbers.size()));
  return array;
}

template <class Device> ContactViews<Device> start(bool friction)
{
  using Views = ContactViews<Device>;
  std::vector<int> first, second, law, begin{0}, contact;
  std::vector<PairLaw> pair_laws;
  std::vector<PairFriction> frictions;
  std::vector<Elastoplastic> curves;
  for (const ContactLaw &of_column : laws()) {
    const auto *const curve = std::get_if<Elastoplastic>(&of_column.normal());
    curves.push_back(curve ? *curve : Elastoplastic({}, {}));
  }
  for (int i = 0; i < SPHERES; i++) {
    if (i % HEIGHT != 0) contact.push_back(-static_cast<int>(first.size()));    // -1 - k of the pair before
    begin.push_back(static_cast<int>(contact.size()));
    if (!has_next(i)) continue;
    const ScaledLaw scaled = contact_of(i);
    const double radsum = radius(i) + radius(i + 1);
    contact.push_back(static_cast<int>(first.size()));
    begin.back()++;
    first.push_back(i);
    second.push_back(i + 1);
    law.push_back(static_cast<int>(pair_laws.size()));
    pair_laws.push_back({radsum, TouchingPairs::touch_squared(radsum), radsum + GAP, radius(i), scaled.hertz(),
                         scaled.elastic_limit(), scaled.yield_overlap(), scaled.yield_force(),
                         static_cast<int>(i / HEIGHT % laws().size())});
    frictions.push_back({radius(i), radius(i + 1), scaled.effective_radius(), std::sqrt(scaled.effective_radius()),
                         coefficient(i), scaled.law().tangential_stiffness(1.0), model(i)});
  }
  const std::size_t pairs = first.size();
  Views views;
  views.pairs = views.plain = static_cast<int>(pairs);
  views.first = array_of<decltype(views.first)>(first);
  views.second = array_of<decltype(views.second)>(second);
  views.law = array_of<decltype(views.law)>(law);
  views.laws = array_of<decltype(views.laws)>(pair_laws);
  views.curves = array_of<decltype(views.curves)>(curves);
  views.begin = array_of<decltype(views.begin)>(begin);
  views.contact = array_of<decltype(views.contact)>(contact);
  views.peak = array_of<decltype(views.peak)>(std::vector<double>(pairs, 0.0));
  views.time_peak = array_of<decltype(views.peak)>(std::vector<double>(pairs, -1.0));
  views.time_yield = array_of<decltype(views.peak)>(std::vector<double>(pairs, -1.0));
  views.front = array_of<decltype(views.front)>(std::vector<Front>(pairs));
  views.turning = array_of<decltype(views.turning)>(std::vector<Turning>(pairs, Turning{Views::UNKNOWN, 0.0, 0.0, 1.0}));
  views.force = array_of<decltype(views.force)>(std::vector<double>(pairs, 0.0));
  views.friction = friction;
  if (!friction) return views;
  views.frictions = array_of<decltype(views.frictions)>(frictions);
  views.spring = array_of<decltype(views.spring)>(std::vector<TangentialSpring>(pairs));
  views.peak_area = array_of<decltype(views.force)>(std::vector<double>(pairs, 0.0));
  views.surface = array_of<decltype(views.surface)>(std::vector<SurfaceForce>(pairs));
  return views;
}

template <class Device> void run(bool friction)
{
  ContactViews<Device> views = start<Device>(friction);
  const Positions x("positions", SPHERES), f("forces", SPHERES);
  const Positions v("velocities", SPHERES), omega("angular velocities", SPHERES), torque("torques", SPHERES);
  for (int step = 0; step < STEPS; step++) {
    const std::vector<double> present = positions(step);
    std::copy(present.begin(), present.end(), x.data());
    const std::vector<double> speeds = velocities(step, SPEED), spins = velocities(step, SPIN);
    std::copy(speeds.begin(), speeds.end(), v.data());
    std::copy(spins.begin(), spins.end(), omega.data());
    Kokkos::deep_copy(f, 0.0);
    Kokkos::deep_copy(torque, 0.0);
    const KernelStep of_step{step * DT, DT, {}};
    PairFindings found;
    Kokkos::parallel_reduce(Kokkos::RangePolicy<Device>(0, views.pairs),
                            AdvancePairs<Device, Positions>{views, x, v, omega, of_step, SPHERES}, found);
    if (found.wrong > 0) std::printf("wrong overlaps: %d\n", found.wrong);
    const Kokkos::RangePolicy<Device> spheres(0, SPHERES);
    if (friction) Kokkos::parallel_for(spheres, SumForcesAndTorques<Device, Positions>{views, f, torque});
    else Kokkos::parallel_for(spheres, SumForces<Device, Positions, Positions>{views, x, f, of_step});
    Device().fence();
    for (int i = 0; i < SPHERES; i++) {
      print("force", step, i, {f(i, 0), f(i, 1), f(i, 2)});
      if (friction) print("torque", step, i, {torque(i, 0), torque(i, 1), torque(i, 2)});
    }
  }
  for (int k = 0; k < views.pairs; k++) {
    print("contact", STEPS, views.first(k),
          {views.peak(k), views.time_peak(k), views.time_yield(k), views.front(k).time[0], views.front(k).time[5]});
    if (!friction) continue;
    const TangentialSpring &s = views.spring(k);
    print("spring", STEPS, views.first(k), {s.force[0], s.force[1], s.force[2], s.compliance, s.loss});
  }
}

int main(int narg, char **arg)
{
  Kokkos::ScopeGuard guard(narg, arg);
  const bool friction = narg > 2;
  if (std::string(arg[1]) == "serial") run<Kokkos::Serial>(friction);
  else run<Kokkos::OpenMP>(friction);
}
