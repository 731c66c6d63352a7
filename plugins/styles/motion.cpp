// SPDX-License-Identifier: GPL-2.0-only
#include "motion.h"

#include "../kernels/touching_pairs.h"

#include "comm.h"
#include "error.h"
#include "fmt/format.h"
#include "force.h"
#include "modify.h"

#include <algorithm>
#include <iterator>

using namespace LAMMPS_NS;

namespace {

// 0 times a finite number is 0; 0 times infinity or NaN is NaN
bool finite(const double *vector) { return 0.0 * vector[0] + 0.0 * vector[1] + 0.0 * vector[2] == 0.0; }

std::string printed(double value) { return std::isnan(value) ? "nan" : fmt::format("{:.6g}", value); }

void require_finite(LAMMPS *lmp, int i, const double *vector, const char *name)
{
  if (finite(vector)) return;
  lmp->error->one(
      FLERR,
      "The {} of sphere {} is not finite ({} {} {}): it was set to this value, the force on the sphere is not finite, or "
      "the timestep is far too large",
      name, lmp->atom->tag[i], printed(vector[0]), printed(vector[1]), printed(vector[2]));
}

}    // namespace

void granwave::require_finite_motion(LAMMPS *lmp, int i)
{
  const Atom *atom = lmp->atom;
  require_finite(lmp, i, atom->x[i], "position");
  if (i >= atom->nlocal) return;
  require_finite(lmp, i, atom->v[i], "velocity");
  if (atom->omega_flag) require_finite(lmp, i, atom->omega[i], "angular velocity");
}

void granwave::require_finite_motion(LAMMPS *lmp)
{
  const Atom *atom = lmp->atom;
  for (int begin = 0; begin < atom->nlocal; begin += RestingBlocks::SIZE) {
    const int end = std::min(begin + RestingBlocks::SIZE, atom->nlocal), n = 3 * (end - begin);
    if (all_finite(atom->x[begin], n) && all_finite(atom->v[begin], n) &&
        (!atom->omega_flag || all_finite(atom->omega[begin], n)))
      continue;
    for (int i = begin; i < end; i++) require_finite_motion(lmp, i);
  }
}

std::string granwave::causes_of_overlap(LAMMPS *lmp, double speed, double radius, const std::string &placed)
{
  constexpr double LARGE = 0.02;    // fraction of the radius: a contact would be loaded in fewer than 50 steps
  std::vector<std::string> causes = {"the load is too strong or the impact too fast for these materials", placed,
                                     "the timestep is far too large"};
  const int likely = lmp->update->setupflag ? 1 : speed * lmp->update->dt > LARGE * radius ? 2 : 0;
  std::rotate(causes.begin(), causes.begin() + likely, causes.begin() + likely + 1);    // to the front
  return fmt::format("{}, or {}, or {}", causes[0], causes[1], causes[2]);
}

double granwave::speed_of(LAMMPS *lmp, int i)
{
  if (i >= lmp->atom->nlocal) return 0.0;
  const double *const v = lmp->atom->v[i];
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

bool granwave::is_rerun(const Update &update)
{
  return update.whichflag == 1 && update.setupflag &&
         (update.ntimestep != update.firststep || update.laststep != update.firststep + update.nsteps);
}

void granwave::refuse_respa(LAMMPS *lmp, const std::string &what)
{
  if (utils::strmatch(lmp->update->integrate_style, "^respa"))
    lmp->error->all(FLERR, "{} does not work with run_style respa", what);
}

double granwave::positive_number(LAMMPS *lmp, const std::string &style, const std::string &name, const char *word,
                                 bool may_be_zero)
{
  const double number = utils::numeric(FLERR, word, false, lmp);
  if (!(may_be_zero ? number >= 0.0 : number > 0.0) || !std::isfinite(number))
    lmp->error->all(FLERR, "Illegal fix {}: the {} must be positive{}, found {}", style, name, may_be_zero ? " or 0" : "",
                    word);
  return number;
}

granwave::TextRows::TextRows(LAMMPS *lmp, const std::string &file, const std::string &fault) : lmp_(lmp)
{
  int opened = 0;
  if (lmp->comm->me == 0) {
    stream_.open(file);
    opened = stream_ ? 1 : 0;
  }
  MPI_Bcast(&opened, 1, MPI_INT, 0, lmp->world);
  if (!opened) lmp->error->all(FLERR, fault);
}

/* Read rows up to the size of a piece, a line each, without comments and empty lines. */
void granwave::TextRows::read_piece(std::string &text, std::vector<bigint> &numbers)
{
  constexpr std::size_t PIECE = 8 << 20;    // bytes
  std::string line;
  while (text.size() < PIECE && std::getline(stream_, line)) {
    number_++;
    constexpr const char *BLANKS = " \t\r\f\v";
    line.resize(std::min(line.size(), line.find('#')));
    const std::size_t begin = line.find_first_not_of(BLANKS);
    if (begin == std::string::npos) continue;
    text.append(line, begin, line.find_last_not_of(BLANKS) + 1 - begin);
    text += '\n';
    numbers.push_back(number_);
  }
}

bool granwave::TextRows::next(std::vector<TextRow> &rows)
{
  std::string text;
  std::vector<bigint> numbers;
  if (lmp_->comm->me == 0) read_piece(text, numbers);
  int sizes[2] = {static_cast<int>(text.size()), static_cast<int>(numbers.size())};
  MPI_Bcast(sizes, 2, MPI_INT, 0, lmp_->world);
  text.resize(sizes[0]);
  numbers.resize(sizes[1]);
  MPI_Bcast(text.data(), sizes[0], MPI_CHAR, 0, lmp_->world);
  MPI_Bcast(numbers.data(), sizes[1], MPI_LMP_BIGINT, 0, lmp_->world);
  rows.clear();
  std::size_t begin = 0;
  for (const bigint number : numbers) {
    const std::size_t end = text.find('\n', begin);
    std::string row = text.substr(begin, end - begin);
    std::vector<std::string> words = utils::split_words(row);
    rows.push_back({number, std::move(row), std::move(words)});
    begin = end + 1;
  }
  return !rows.empty();
}

std::vector<granwave::TextRow> granwave::read_rows(LAMMPS *lmp, const std::string &file, const std::string &fault)
{
  TextRows text(lmp, file, fault);
  std::vector<TextRow> all, piece;
  while (text.next(piece)) std::move(piece.begin(), piece.end(), std::back_inserter(all));
  return all;
}

void granwave::require_mechanical_units(LAMMPS *lmp, const std::string &what)
{
  if (lmp->force->ftm2v != 1.0 || lmp->force->mvv2e != 1.0)
    lmp->error->all(FLERR, "{} needs units in which force is mass times acceleration (si, cgs, lj, micro, nano), found {}",
                    what, lmp->update->unit_style);
}

bool granwave::radii_may_change(LAMMPS *lmp)
{
  for (const auto *fix : lmp->modify->get_fix_list())
    if (utils::strmatch(fix->style, "^adapt") || utils::strmatch(fix->style, "^set$")) return true;
  return false;
}

double granwave::simulated_time(const Update &update)
{
  const double by_runs = update.atime + (update.ntimestep - update.atimestep) * update.dt;
  const double at_once = update.ntimestep * update.dt;    // exact to rounding if the timestep is never changed
  return std::fabs(at_once - by_runs) < 1e-3 * update.dt ? at_once : by_runs;
}
