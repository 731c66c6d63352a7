// SPDX-License-Identifier: GPL-2.0-only
#include "ghost_velocities.h"

#include "atom.h"
#include "domain.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

using namespace LAMMPS_NS;

namespace {

constexpr int BITS = 64;    // bits of a number in the buffer, one for each ghost

bool is_positive_zero(const double *values)
{
  std::uint64_t bits[3];
  std::memcpy(bits, values, sizeof(bits));
  return (bits[0] | bits[1] | bits[2]) == 0;
}

/* Jump of the velocity across a periodic boundary of a deforming box. */
void set_jump(const Domain *domain, const int *images, double (&jump)[3])
{
  const double *const rate = domain->h_rate;
  jump[0] = images[0] * rate[0] + images[5] * rate[5] + images[4] * rate[4];
  jump[1] = images[1] * rate[1] + images[3] * rate[3];
  jump[2] = images[2] * rate[2];
}

}    // namespace

namespace granwave {

void GhostVelocities::start(LAMMPS *lammps, bool turn)
{
  lmp = lammps;
  turns = turn;
  renew();
}

void GhostVelocities::renew()
{
  const Atom *const atom = lmp->atom;
  at_rest.assign(atom->nlocal + atom->nghost, 0);
}

int GhostVelocities::pack(int n, const int *atoms, double *buffer, bool crosses, const int *images) const
{
  const Atom *const atom = lmp->atom;
  const Domain *const domain = lmp->domain;
  const bool jumps = crosses && domain->deform_vremap;
  double jump[3];
  if (jumps) set_jump(domain, images, jump);
  double *next = buffer + (n + BITS - 1) / BITS;
  for (int begin = 0; begin < n; begin += BITS) {
    std::uint64_t moving = 0;
    for (int k = begin; k < std::min(begin + BITS, n); k++) {
      const int i = atoms[k];
      const double *const v = atom->v[i];
      const bool jumps_here = jumps && (atom->mask[i] & domain->deform_groupbit);
      if (!jumps_here && is_positive_zero(v) && !(turns && !is_positive_zero(atom->omega[i]))) continue;
      moving |= std::uint64_t(1) << (k - begin);
      for (int d = 0; d < 3; d++) *next++ = jumps_here ? v[d] + jump[d] : v[d];
      if (turns) next = std::copy_n(atom->omega[i], 3, next);
    }
    std::memcpy(buffer + begin / BITS, &moving, sizeof(moving));
  }
  return static_cast<int>(next - buffer);
}

void GhostVelocities::unpack(int n, int first, const double *buffer)
{
  const Atom *const atom = lmp->atom;
  const double *next = buffer + (n + BITS - 1) / BITS;
  for (int begin = 0; begin < n; begin += BITS) {
    std::uint64_t moving;
    std::memcpy(&moving, buffer + begin / BITS, sizeof(moving));
    for (int k = begin; k < std::min(begin + BITS, n); k++, moving >>= 1) {
      const int i = first + k;
      if (moving & 1) {
        std::copy_n(next, 3, atom->v[i]);
        next += 3;
        if (turns) std::copy_n(next, 3, atom->omega[i]);
        if (turns) next += 3;
        at_rest[i] = 0;
      } else if (!at_rest[i]) {
        std::fill_n(atom->v[i], 3, 0.0);
        if (turns) std::fill_n(atom->omega[i], 3, 0.0);
        at_rest[i] = 1;
      }
    }
  }
}

}    // namespace granwave
