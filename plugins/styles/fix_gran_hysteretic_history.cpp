// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_hysteretic_history.h"

#include "atom.h"
#include "error.h"
#include "finite_motion.h"
#include "memory.h"
#include "restart_state.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

using namespace LAMMPS_NS;
using granwave::AtomState;
using granwave::BlockLayout;
using granwave::ContactRecord;
using granwave::ForgottenContacts;

namespace {

// the state of a sphere: this head, sums over forgotten contacts if there are any, records with their blocks
enum { COUNT, OWNER, EXTRA, EXTENDED, SUMS, N_HEAD };

}    // namespace

FixGranHystereticHistory::FixGranHystereticHistory(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (std::strcmp(id, ID) != 0)
    error->all(FLERR, "Fix {} belongs to pair style gran/hysteretic and cannot be used by itself", STYLE);
  restart_peratom = 1;
  create_attribute = 1;
  maxexchange_dynamic = 1;
  history.grow(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
}

FixGranHystereticHistory::~FixGranHystereticHistory()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
}

int FixGranHystereticHistory::setmask() { return FixConst::PRE_EXCHANGE | FixConst::MIN_PRE_EXCHANGE; }

/* Copy the flat list of the pair style back to the spheres before they migrate. LAMMPS subsequently assigns spheres to
   subdomains and bins, where one whose position is not finite would be lost. */

void FixGranHystereticHistory::gather()
{
  granwave::require_finite_motion(lmp);
  if (release_contacts) release_contacts();
  // a sphere may be passed on by a processor that it did not come from
  const int mine = most_numbers();
  MPI_Allreduce(&mine, &maxexchange, 1, MPI_INT, MPI_MAX, world);
}

void FixGranHystereticHistory::setup_pre_exchange() { gather(); }
void FixGranHystereticHistory::pre_exchange() { gather(); }
void FixGranHystereticHistory::min_pre_exchange() { gather(); }

void FixGranHystereticHistory::grow_arrays(int nmax) { history.grow(nmax); }

/* The callbacks below may be called by commands that reorder spheres at any time (sort, delete_atoms, fix balance),
   before gather() is called: the first call makes the per-sphere records the valid copy. */

void FixGranHystereticHistory::copy_arrays(int i, int j, int)
{
  if (release_contacts) release_contacts();
  history.copy(i, j);
}

void FixGranHystereticHistory::set_arrays(int i)
{
  if (release_contacts) release_contacts();
  history.forget_sphere(i);
}

/* Size of the state of sphere i, and the largest one of this processor. */

int FixGranHystereticHistory::size(int i, int further) const
{
  return N_HEAD + (history.forgotten(i).none() && further == 0 ? 0 : ForgottenContacts::SIZE) +
         (ContactRecord::SIZE + history.layout().size()) * (history.count(i) + further);
}

void FixGranHystereticHistory::expect_records(int i, int n) { maxexchange = std::max(maxexchange, size(i, n)); }

int FixGranHystereticHistory::most_numbers() const
{
  int most = N_HEAD;
  for (int i = 0; i < atom->nlocal; i++) most = std::max(most, size(i));
  return most;
}

int FixGranHystereticHistory::pack(int i, double *buf) const
{
  const BlockLayout &layout = history.layout();
  const ForgottenContacts sums = history.forgotten(i);
  buf[COUNT] = history.count(i);
  buf[OWNER] = ubuf(static_cast<int64_t>(history.owner(i))).d;
  buf[EXTRA] = layout.n_extra;
  buf[EXTENDED] = layout.extended;
  buf[SUMS] = !sums.none();
  double *at = buf + N_HEAD;
  if (!sums.none()) at = std::copy_n(reinterpret_cast<const double *>(&sums), static_cast<int>(ForgottenContacts::SIZE), at);
  const ContactRecord *record = history.records(i);
  for (int k = 0; k < history.count(i); k++, record++) {
    *at++ = ubuf(static_cast<int64_t>(record->partner)).d;
    *at++ = record->partner_radius;
    *at++ = record->partner_type;
    *at++ = record->live;
    *at++ = record->dent.peak;
    *at++ = record->dent.time_first;
    *at++ = record->dent.time_peak;
    *at++ = record->dent.time_yield;
    at = std::copy_n(history.block(i, k), layout.size(), at);
  }
  return static_cast<int>(at - buf);
}

/* Unpack the state of a sphere. */

int FixGranHystereticHistory::unpack(int i, const double *buf)
{
  const BlockLayout packed{static_cast<int>(buf[EXTRA]), buf[EXTENDED] != 0.0};
  const double *at = buf + N_HEAD;
  history.forget_sphere(i);
  history.own(i, static_cast<std::int64_t>(ubuf(buf[OWNER]).i));
  if (buf[SUMS] != 0.0) {
    std::copy_n(at, static_cast<int>(ForgottenContacts::SIZE), reinterpret_cast<double *>(&history.forgotten_to_change(i)));
    at += ForgottenContacts::SIZE;
  }
  return static_cast<int>(unpack_records(i, static_cast<int>(buf[COUNT]), packed, at) - buf);
}

/* Append records with blocks of this layout to sphere i. Returns the end of the records. */

const double *FixGranHystereticHistory::unpack_records(int i, int count, const BlockLayout &packed, const double *buf)
{
  history.extend(packed);
  std::vector<double> block(history.layout().size());
  for (int k = 0; k < count; k++) {
    ContactRecord record;
    record.partner = static_cast<std::int64_t>(ubuf(buf[0]).i);
    record.partner_radius = buf[1];
    record.partner_type = static_cast<int>(buf[2]);
    record.live = static_cast<int>(buf[3]);
    record.dent = {buf[4], buf[5], buf[6], buf[7]};
    buf += ContactRecord::SIZE;
    std::fill(block.begin(), block.end(), 0.0);
    granwave::ContactHistory::copy_block(packed, buf, history.layout(), block.data());
    buf += packed.size();
    history.append(i, record, block.data());
  }
  return buf;
}

/* True if these can be records: what is not would be believed as type, radius or overlap. */

bool FixGranHystereticHistory::is_sound(const double *buf, int count, const BlockLayout &packed) const
{
  for (int k = 0; k < count; k++) {
    const auto partner = static_cast<std::int64_t>(ubuf(buf[0]).i);
    if (partner < 1 || partner > MAXTAGINT || !(buf[1] >= 0.0) || !granwave::is_whole(buf[2], 1, atom->ntypes) ||
        !granwave::is_whole(buf[3], 0, 1) || !(buf[4] >= 0.0))
      return false;
    const int n = ContactRecord::SIZE + packed.size();
    if (!std::all_of(buf + 1, buf + n, [](double value) { return std::isfinite(value); })) return false;
    buf += n;
  }
  return true;
}

int FixGranHystereticHistory::pack_exchange(int i, double *buf)
{
  if (release_contacts) release_contacts();
  return pack(i, buf);
}

int FixGranHystereticHistory::unpack_exchange(int nlocal, double *buf)
{
  if (release_contacts) release_contacts();
  return unpack(nlocal, buf);
}

int FixGranHystereticHistory::pack_restart(int i, double *buf)
{
  if (publish_contacts) publish_contacts();
  return granwave::seal_atom_state(buf, pack(i, buf + AtomState::HEAD));
}

void FixGranHystereticHistory::unpack_restart(int i, int nth)
{
  const AtomState state = granwave::atom_state(lmp, *this, i, nth);
  const double *const values = state.values;
  if (!state.checked) return unpack_unchecked(i, values, state.n);
  constexpr int MOST_EXTRA = 1000;
  const bool has_head =
      state.n >= N_HEAD && granwave::is_whole(values[COUNT], 0, state.n) && granwave::is_whole(values[EXTRA], 0, MOST_EXTRA);
  const BlockLayout packed{has_head ? static_cast<int>(values[EXTRA]) : 0, has_head && values[EXTENDED] != 0.0};
  const int sums = has_head && values[SUMS] != 0.0 ? static_cast<int>(ForgottenContacts::SIZE) : 0;
  if (!has_head || state.n != N_HEAD + sums + values[COUNT] * (ContactRecord::SIZE + packed.size()) ||
      !is_sound(values + N_HEAD + sums, static_cast<int>(values[COUNT]), packed))
    granwave::damaged_atom_state(lmp, *this, i);
  unpack(i, values);
}

/* Unpack a state of the formats without a checksum: count, negative for extended blocks, owner, records. */

void FixGranHystereticHistory::unpack_unchecked(int i, const double *values, int n)
{
  history.forget_sphere(i);
  if (n < 2 || !granwave::is_whole(values[0], -n, n)) granwave::damaged_atom_state(lmp, *this, i);
  const int count = static_cast<int>(std::fabs(values[0]));
  history.own(i, static_cast<std::int64_t>(ubuf(values[1]).i));
  if (count == 0) return;
  BlockLayout packed{(n - 2) / count - ContactRecord::SIZE, values[0] < 0.0};
  if (packed.extended) packed.n_extra = (packed.n_extra - BlockLayout::N_EXTENDED) / 2;
  if (packed.n_extra < 0 || 2 + count * (ContactRecord::SIZE + packed.size()) != n || !is_sound(values + 2, count, packed))
    granwave::damaged_atom_state(lmp, *this, i);
  unpack_records(i, count, packed, values + 2);
}

int FixGranHystereticHistory::size_restart(int i)
{
  if (publish_contacts) publish_contacts();
  return AtomState::HEAD + size(i);
}

int FixGranHystereticHistory::maxsize_restart()
{
  if (publish_contacts) publish_contacts();
  return AtomState::HEAD + most_numbers();
}

double FixGranHystereticHistory::memory_usage() { return history.memory_usage(); }
