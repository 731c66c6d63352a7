// Columns of spheres of two sizes that are pressed, released and pressed again, each contact to another depth: both programs of test_kernels.py compute them, one with the laws of the plain pair style, one with the kernels of Kokkos.
#include "kernels/touching_pairs.h"
#include "laws/law_arguments.h"
#include "laws/tangential.h"

#include <cstdio>
#include <utility>
#include <vector>

using namespace granwave;

constexpr int COLUMNS = 60, HEIGHT = 40, SPHERES = COLUMNS * HEIGHT, STEPS = 200;
constexpr double GAP = 1e-3, DT = 2e-8;

/* Laws of the columns, one after the other. */
inline const std::vector<ContactLaw> &laws()
{
  static const std::vector<ContactLaw> all = [] {
    std::vector<ContactLaw> made;
    for (const std::vector<std::string> &words : {std::vector<std::string>{"elastoplastic", "115e9", "0.3", "550e6"},
                                                  {"hertz", "210e9", "0.3"},
                                                  {"elastoplastic", "115e9", "0.3", "550e6", "yield_factor", "1.1"},
                                                  {"elastoplastic", "115e9", "0.3", "550e6", "variant", "published"}}) {
      const LawArguments args = parse_law(words);
      made.push_back(args.contact(args.first, args.first));
    }
    return made;
  }();
  return all;
}

inline double radius(int i) { return i % 3 == 0 ? 0.007 : 0.005; }
inline const ContactLaw &law_of(int i) { return laws()[i / HEIGHT % laws().size()]; }
inline bool has_next(int i) { return i % HEIGHT != HEIGHT - 1; }
inline ScaledLaw contact_of(int i)    // of spheres i and i + 1
{
  const double ri = radius(i), rj = radius(i + 1);
  return ScaledLaw(law_of(i), ri * rj / (ri + rj), ri, rj);
}

/* Overlap of spheres i and i + 1: loading, unloading to a gap, reloading, beyond the peak, and a last release. */
inline double overlap(int i, int step)
{
  constexpr double AT[] = {-0.2, 0.5, 1.0, 0.7, 0.3, 0.6, 0.2, -0.5, 0.4, 0.9, 1.3, 1.8, 1.2, 0.9, 0.4, -0.1, 0.2};
  constexpr int PIECES = sizeof(AT) / sizeof(*AT) - 1;
  const int piece = step * PIECES / STEPS;
  const double part = static_cast<double>(step * PIECES % STEPS) / STEPS;
  const double depth = 2e-9 * (1.0 + i % 7) * static_cast<double>(1 << (i * 5 % 15));    // up to 0.4 mm
  return depth * (AT[piece] + part * (AT[piece + 1] - AT[piece]));
}

/* Positions of all spheres, three a sphere. */
inline std::vector<double> positions(int step)
{
  std::vector<double> x(3 * SPHERES);
  for (int i = 0; i < SPHERES; i++) {
    double *const at = x.data() + 3 * static_cast<std::ptrdiff_t>(i);
    at[0] = 0.02 * (i / HEIGHT) + 1e-5 * (i % 5);
    at[1] = 2e-5 * (i % 3);
    at[2] = i % HEIGHT == 0 ? 0.0 : at[-1] + radius(i - 1) + radius(i) - overlap(i - 1, step);
  }
  return x;
}

/* Velocities of all spheres, or with a scale angular velocities: any numbers that change with time. */
inline std::vector<double> velocities(int step, double scale)
{
  std::vector<double> v(3 * SPHERES);
  for (int n = 0; n < 3 * SPHERES; n++) v[n] = scale * ((n * 7 + step * 3) % 23 - 11);
  return v;
}
constexpr double SPEED = 0.05, SPIN = 8.0;

/* Friction of spheres i and i + 1, without which every seventh pair is. */
inline double coefficient(int i) { return i % 7 == 0 ? 0.0 : 0.3; }
inline TangentialModel model(int i) { return i % 2 == 0 ? TangentialModel::MINDLIN : TangentialModel::MINDLIN_RESCALE; }

/* Print the bits of numbers. */
inline void print(const char *name, int step, int i, std::initializer_list<double> numbers)
{
  std::printf("%s %d %d", name, step, i);
  for (const double number : numbers) {
    std::uint64_t bits;
    std::memcpy(&bits, &number, sizeof(bits));
    std::printf(" %016llx", static_cast<unsigned long long>(bits));
  }
  std::printf("\n");
}
