// SPDX-License-Identifier: GPL-2.0-only
#include "restart_state.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fmt/format.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

using namespace LAMMPS_NS;
using granwave::AtomState;

namespace {

constexpr int FORMAT = 3;    // of global states
constexpr int HEAD = 3;      // format, number of values, checksum

// Mark of the format of states with atoms; no byte of it can be changed so that it becomes the whole number of earlier ones.
constexpr double ATOM_STATE = 0.8660254037844386;
constexpr int UNCHECKED = 3;                // numbers before those covered by the checksum
constexpr double ROUNDING_OF_BOX = 1e-9;    // tolerance of positions, relative to the length of the box

/* Checksum of numbers, itself a whole number. */
double checksum(const double *values, std::size_t n)
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

/* True if atom i is at this position, up to rounding. */
bool is_at(const LAMMPS *lmp, int i, const double *place)
{
  for (int d = 0; d < 3; d++)
    if (std::fabs(lmp->atom->x[i][d] - place[d]) > ROUNDING_OF_BOX * lmp->domain->prd[d]) return false;
  return true;
}

}    // namespace

void granwave::write_state(FILE *fp, const std::vector<double> &state)
{
  const double head[HEAD] = {FORMAT, static_cast<double>(state.size()), checksum(state.data(), state.size())};
  const int size = static_cast<int>((HEAD + state.size()) * sizeof(double));
  std::fwrite(&size, sizeof(int), 1, fp);
  std::fwrite(head, sizeof(double), HEAD, fp);
  std::fwrite(state.data(), sizeof(double), state.size(), fp);
}

std::vector<double> granwave::read_state(LAMMPS *lmp, const Fix &fix, const char *buffer, std::size_t n, const char *other)
{
  double stored[HEAD];
  std::memcpy(stored, buffer, sizeof(stored));
  if (stored[0] != FORMAT)
    lmp->error->all(FLERR, "Restart file contains format {} of fix {}; this version reads format {}", stored[0], fix.style,
                    FORMAT);
  if (stored[1] != static_cast<double>(n))
    lmp->error->all(FLERR, "Restart file contains fix {} {} with {}: define it again with the arguments of the file",
                    fix.style, fix.id, other);
  std::vector<double> state(n);
  std::memcpy(state.data(), buffer + sizeof(stored), n * sizeof(double));
  if (stored[2] != checksum(state.data(), n))
    lmp->error->all(FLERR, "The restart file is damaged: the state of fix {} {} does not match its checksum", fix.style,
                    fix.id);
  return state;
}

std::vector<double> granwave::read_state(LAMMPS *lmp, FILE *fp, const std::string &what)
{
  std::vector<double> state;
  int n = -1;    // if it is damaged
  if (lmp->comm->me == 0) {
    int size;
    double head[HEAD];
    utils::sfread(FLERR, &size, sizeof(int), 1, fp, nullptr, lmp->error);
    utils::sfread(FLERR, head, sizeof(double), HEAD, fp, nullptr, lmp->error);
    if (head[0] == FORMAT && (HEAD + head[1]) * sizeof(double) == size) {
      state.resize(static_cast<std::size_t>(head[1]));
      utils::sfread(FLERR, state.data(), sizeof(double), state.size(), fp, nullptr, lmp->error);
      if (head[2] == checksum(state.data(), state.size())) n = static_cast<int>(state.size());
    }
  }
  MPI_Bcast(&n, 1, MPI_INT, 0, lmp->world);
  if (n < 0) lmp->error->all(FLERR, "The restart file is damaged: {} are missing or invalid", what);
  state.resize(n);
  MPI_Bcast(state.data(), n, MPI_DOUBLE, 0, lmp->world);
  return state;
}

int granwave::seal_atom_state(const LAMMPS *lmp, int i, double *buffer, int n)
{
  buffer[0] = AtomState::HEAD + n;
  buffer[1] = ATOM_STATE;
  buffer[3] = static_cast<double>(lmp->atom->tag[i]);
  std::copy_n(lmp->atom->x[i], 3, buffer + 4);
  buffer[2] = checksum(buffer + UNCHECKED, AtomState::HEAD + n - UNCHECKED);
  return AtomState::HEAD + n;
}

granwave::AtomState granwave::atom_state(LAMMPS *lmp, const Fix &fix, int i, int nth)
{
  const double *stored = lmp->atom->extra[i];
  int left = lmp->atom->nextra_store, size = 0;
  for (; nth >= 0; nth--) {    // skip the states of other fixes
    left -= size;
    stored += size;
    const bool is_size = left > 1 && stored[0] >= 2 && stored[0] <= left && stored[0] == std::floor(stored[0]);
    size = is_size ? static_cast<int>(stored[0]) : 0;
    if (!is_size) break;
  }
  if (size < AtomState::HEAD || stored[1] != ATOM_STATE || stored[2] != checksum(stored + UNCHECKED, size - UNCHECKED))
    lmp->error->one(FLERR,
                    "The restart file is damaged, or of an earlier version: the state of atom {} in fix {} {} is invalid",
                    lmp->atom->tag[i], fix.style, fix.id);
  if (static_cast<tagint>(stored[3]) != lmp->atom->tag[i] || !is_at(lmp, i, stored + 4))
    lmp->error->one(
        FLERR,
        "Fix {} {}: the state of atom {} in the restart file would be assigned to atom {}, or to another position: "
        "define the fix and use 'run 0' before atoms are deleted, renumbered or moved",
        fix.style, fix.id, stored[3], lmp->atom->tag[i]);
  return {stored + AtomState::HEAD, size - AtomState::HEAD};
}
