// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_hysteretic_history.h"

#include "atom.h"
#include "error.h"
#include "finite_motion.h"
#include "memory.h"
#include "pair_gran_hysteretic.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <vector>

using namespace LAMMPS_NS;
using granwave::BlockLayout;
using granwave::ContactRecord;

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
  if (pair) pair->release_contacts();
  int most = 0;
  for (int i = 0; i < atom->nlocal; i++) most = std::max(most, history.count(i));
  maxexchange = 2 + record_size() * most;
}

void FixGranHystereticHistory::setup_pre_exchange() { gather(); }
void FixGranHystereticHistory::pre_exchange() { gather(); }
void FixGranHystereticHistory::min_pre_exchange() { gather(); }

void FixGranHystereticHistory::grow_arrays(int nmax) { history.grow(nmax); }

/* The callbacks below may be called by commands that reorder spheres at any time (sort, delete_atoms, fix balance),
   before gather() is called: the first call makes the per-sphere records the valid copy. */

void FixGranHystereticHistory::copy_arrays(int i, int j, int)
{
  if (pair) pair->release_contacts();
  history.copy(i, j);
}

void FixGranHystereticHistory::set_arrays(int i)
{
  if (pair) pair->release_contacts();
  history.forget_sphere(i);
}

int FixGranHystereticHistory::record_size() const { return ContactRecord::SIZE + history.layout().size(); }

/* A negative count denotes extended blocks. */

int FixGranHystereticHistory::pack(int i, double *buf) const
{
  int m = 0;
  const int size = history.layout().size();
  buf[m++] = history.layout().extended ? -history.count(i) : history.count(i);
  buf[m++] = ubuf(static_cast<int64_t>(history.owner(i))).d;
  const ContactRecord *record = history.records(i);
  for (int k = 0; k < history.count(i); k++, record++) {
    buf[m++] = ubuf(static_cast<int64_t>(record->partner)).d;
    buf[m++] = record->partner_radius;
    buf[m++] = record->partner_type;
    buf[m++] = record->live;
    buf[m++] = record->dent.peak;
    buf[m++] = record->dent.time_first;
    buf[m++] = record->dent.time_peak;
    buf[m++] = record->dent.time_yield;
    std::copy_n(history.block(i, k), size, buf + m);
    m += size;
  }
  return m;
}

/* Unpack the records of a sphere; `n_extra` is that of the blocks in the buffer. */

int FixGranHystereticHistory::unpack(int i, const double *buf, int n_extra)
{
  int m = 0;
  history.forget_sphere(i);
  const int count = static_cast<int>(buf[m++]), n = std::abs(count);
  const BlockLayout packed{n_extra, count < 0};
  history.extend(packed);
  history.own(i, static_cast<std::int64_t>(ubuf(buf[m++]).i));
  std::vector<double> block(history.layout().size());
  for (int k = 0; k < n; k++) {
    ContactRecord record;
    record.partner = static_cast<std::int64_t>(ubuf(buf[m]).i);
    record.partner_radius = buf[m + 1];
    record.partner_type = static_cast<int>(buf[m + 2]);
    record.live = static_cast<int>(buf[m + 3]);
    record.dent = {buf[m + 4], buf[m + 5], buf[m + 6], buf[m + 7]};
    m += ContactRecord::SIZE;
    std::fill(block.begin(), block.end(), 0.0);
    granwave::ContactHistory::copy_block(packed, buf + m, history.layout(), block.data());
    m += packed.size();
    history.append(i, record, block.data());
  }
  return m;
}

int FixGranHystereticHistory::pack_exchange(int i, double *buf)
{
  if (pair) pair->release_contacts();
  return pack(i, buf);
}

int FixGranHystereticHistory::unpack_exchange(int nlocal, double *buf)
{
  if (pair) pair->release_contacts();
  return unpack(nlocal, buf, history.layout().n_extra);
}

int FixGranHystereticHistory::pack_restart(int i, double *buf)
{
  if (pair) pair->publish_contacts();
  buf[0] = pack(i, buf + 1) + 1;
  return static_cast<int>(buf[0]);
}

void FixGranHystereticHistory::unpack_restart(int nlocal, int nth)
{
  double **extra = atom->extra;
  int m = 0;
  for (int i = 0; i < nth; i++) m += static_cast<int>(extra[nlocal][m]);
  const double *const stored = &extra[nlocal][m];
  const int count = static_cast<int>(stored[1]), n = std::abs(count);
  int n_extra = 0;    // from the size of a record
  if (n > 0) n_extra = (static_cast<int>(stored[0]) - 3) / n - ContactRecord::SIZE;
  if (count < 0) n_extra = (n_extra - BlockLayout::N_EXTENDED) / 2;
  unpack(nlocal, stored + 1, n_extra);
}

int FixGranHystereticHistory::size_restart(int i)
{
  if (pair) pair->publish_contacts();
  return 3 + record_size() * history.count(i);
}

int FixGranHystereticHistory::maxsize_restart()
{
  if (pair) pair->publish_contacts();
  int most = 0;
  for (int i = 0; i < atom->nlocal; i++) most = std::max(most, history.count(i));
  return 3 + record_size() * most;
}

double FixGranHystereticHistory::memory_usage() { return history.memory_usage(); }
