// SPDX-License-Identifier: GPL-2.0-only
#include "restart_state.h"

#include "atom.h"
#include "error.h"
#include "fmt/format.h"

#include <cmath>
#include <cstdint>
#include <cstring>

using namespace LAMMPS_NS;

namespace {

enum { WITHOUT_CHECKSUM = 1, WITH_CHECKSUM = 2 };
constexpr int HEAD = 3;    // format, number of values, checksum

// Stands where earlier formats have a whole number; no byte of it can be changed so that it becomes one.
constexpr double ATOM_STATE = 0.6180339887498949;

}    // namespace

double granwave::checksum(const double *values, std::size_t n)
{
  std::uint64_t sum = 0x9e3779b97f4a7c15u + n;
  for (std::size_t k = 0; k < n; k++) {
    std::uint64_t bits;
    std::memcpy(&bits, values + k, sizeof(bits));
    sum = (sum ^ bits) * 0xff51afd7ed558ccdu;
    sum ^= sum >> 32;
  }
  return static_cast<double>(sum >> 12);    // all of its bits fit into a double
}

bool granwave::is_whole(double value, double least, double most)
{
  return value >= least && value <= most && value == std::floor(value);
}

void granwave::write_state(FILE *fp, const std::vector<double> &state)
{
  const double head[HEAD] = {WITH_CHECKSUM, static_cast<double>(state.size()), checksum(state.data(), state.size())};
  const int size = static_cast<int>((HEAD + state.size()) * sizeof(double));
  std::fwrite(&size, sizeof(int), 1, fp);
  std::fwrite(head, sizeof(double), HEAD, fp);
  std::fwrite(state.data(), sizeof(double), state.size(), fp);
}

const double *granwave::read_state(LAMMPS *lmp, const Fix &fix, const char *buffer, std::size_t n, const char *other)
{
  const auto *const stored = reinterpret_cast<const double *>(buffer);
  if (stored[0] == WITHOUT_CHECKSUM) return stored + 1;
  if (stored[0] != WITH_CHECKSUM)
    lmp->error->all(FLERR, "Restart file holds format {} of fix {}; this version reads formats {} and {}", stored[0],
                    fix.style, int(WITHOUT_CHECKSUM), int(WITH_CHECKSUM));
  if (stored[1] != static_cast<double>(n))
    lmp->error->all(FLERR, "Restart file holds fix {} {} with {}: give it again as it was", fix.style, fix.id, other);
  if (stored[2] != checksum(stored + HEAD, n))
    lmp->error->all(FLERR, "The restart file is damaged: the state of fix {} {} does not match its checksum", fix.style,
                    fix.id);
  return stored + HEAD;
}

int granwave::seal_atom_state(double *buffer, int n)
{
  buffer[0] = AtomState::HEAD + n;
  buffer[1] = ATOM_STATE;
  buffer[2] = checksum(buffer + AtomState::HEAD, n);
  return AtomState::HEAD + n;
}

granwave::AtomState granwave::atom_state(LAMMPS *lmp, const Fix &fix, int i, int nth)
{
  const double *stored = lmp->atom->extra[i];
  int left = lmp->atom->nextra_store;
  for (;; nth--) {    // past the states of other fixes
    if (!is_whole(stored[0], 2, left)) damaged_atom_state(lmp, fix, i);
    if (nth == 0) break;
    left -= static_cast<int>(stored[0]);
    stored += static_cast<int>(stored[0]);
    if (left < 2) damaged_atom_state(lmp, fix, i);
  }
  const int size = static_cast<int>(stored[0]);
  if (stored[1] != ATOM_STATE) return {stored + 1, size - 1, false};
  if (size < AtomState::HEAD || stored[2] != checksum(stored + AtomState::HEAD, size - AtomState::HEAD))
    damaged_atom_state(lmp, fix, i);
  return {stored + AtomState::HEAD, size - AtomState::HEAD, true};
}

void granwave::damaged_atom_state(LAMMPS *lmp, const Fix &fix, int i)
{
  lmp->error->one(FLERR, "The restart file is damaged: the state of atom {} in fix {} {} is none", lmp->atom->tag[i],
                  fix.style, fix.id);
}
