// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: special pairs, which are pairs of cylinders, pairs with cohesion, pairs whose force is a
   power of the overlap, those across a periodic boundary, and all with initial normals.

   They have rows of their own behind those of all other pairs, and are found one by one; forces, history and friction are
   those of any batch, with the vector between the centers replaced by its part along the normal. */

#include "pair_gran_hysteretic.h"

#include "domain.h"
#include "error.h"
#include "modify.h"

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

constexpr const char *INITIAL_PLACES = "initial";    // custom array, d2_initial in commands
constexpr double MARGIN = 1e-6;                      // of squared distances, far above their rounding

}    // namespace

/* Index of the custom array with the places at which normals are taken, if they are the initial ones; else -1. */
int PairGranHysteretic::find_initial_places()
{
  if (!normals_initial) return -1;
  int is_double = 0, columns = 0;
  const int index = atom->find_custom(INITIAL_PLACES, is_double, columns);
  bool on_ghosts = false;
  for (const auto *fix : modify->get_fix_by_style("^property/atom$")) on_ghosts = on_ghosts || fix->comm_border >= 3;
  if (index < 0 || !is_double || columns != 3 || !on_ghosts)
    error->all(
        FLERR,
        "Pair style gran/hysteretic with initial normals requires the initial positions: use 'fix ID all property/atom "
        "d2_{} 3 ghost yes', and set its columns to x, y and z",
        INITIAL_PLACES);
  if (domain->xperiodic || domain->yperiodic || domain->zperiodic)
    error->all(FLERR, "Pair style gran/hysteretic with initial normals requires boundaries that are not periodic");
  if (has.friction || has.cohesion)
    error->all(FLERR, "Pair style gran/hysteretic with initial normals does not support friction and cohesion");
  if (laws.cylinders())
    error->all(FLERR, "Pair style gran/hysteretic with initial normals requires spheres, found cylinders");
  return index;
}

/* Set whether pairs of these types are special, and how they touch. Returns their cutoff. */
double PairGranHysteretic::init_shape(int i, int j)
{
  const double radsum = largest_radius[i] + largest_radius[j];
  const bool shaped = laws.shaped(i, j);
  const bool sticks = bool(laws.law(i, j).cohesion());
  if (!shaped && !laws.law(i, j).elastic() && !sticks && !normals_initial) return radsum + gap;
  if (sticks && shaped)
    error->all(FLERR, "Pair style gran/hysteretic: types {} and {} have cohesion, which requires spheres, found cylinders",
               i, j);
  if (sticks && radsum > 0.0) {
    const double neck =
        ScaledLaw(laws.law(i, j), PairLaws::effective_radius(largest_radius[i], largest_radius[j])).neck_length();
    if (!(neck < gap))
      error->all(
          FLERR,
          "Pair style gran/hysteretic: surfaces of types {} and {} are held together up to a gap of {:.3g}; expected a "
          "gap of the pair style above it, found {:.3g}",
          i, j, neck, gap);
  }
  laws.make_special(i, j);
  if (!shaped) return radsum + gap;
  const CylinderPair &shapes = *laws.geometry(i, j);
  if (shapes.nearly_parallel())
    error->all(FLERR,
               "Pair style gran/hysteretic: cylinders of types {} and {} are nearly parallel; expected parallel axes, or "
               "axes that cross at 1 degree or more",
               i, j);
  return shapes.center_distance(radsum + gap);
}

/* Overwrite the forces of elastic contacts with a law other than Hertz's. */
void PairGranHysteretic::set_elastic(Batch &batch)
{
  static_assert(LineBatch::CAPACITY >= Batch::CAPACITY);
  lines.size = 0;
  for (int m = 0; m < batch.size; m++) {
    const ScaledLaw &contact = batch.pair[m]->contact;
    if (contact.is_hertzian()) continue;
    if (const LineContact *const line = contact.line()) {
      lines.add(m, *line, batch.overlap[m]);
      continue;
    }
    batch.force[m] = contact.elastic_force(batch.overlap[m]);
    if (has.friction)
      batch.circle[m] = std::sqrt(contact.circle_squared(batch.overlap[m], contacts.law_history(batch.k[m])));
  }
  if (lines.size == 0) return;
  lines.compute();
  for (int n = 0; n < lines.size; n++) {
    const int m = lines.place[n];
    batch.force[m] = lines.force[n];
    batch.circle[m] = std::sqrt(batch.pair[m]->contact.circle_squared(lines.stiffness[n]));
  }
}

void PairGranHysteretic::compute_special(Tally what)
{
  ContactList &c = contacts;
  const int rows = static_cast<int>(c.row.size());
  if (rows == c.plain) return;
  only_spheres = !has.cohesion && !normals_initial && !laws.cylinders();
  geometry.set_shifts();
  batch.size = 0;
  for (int r = c.plain; r < rows; r++) {
    if (c.rests(r)) continue;
    bool quiet = true;
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      if (!(only_spheres ? add_spheres(k, c.row[r], c.partner[k]) : add_special(r, k))) continue;
      quiet = false;
      if (batch.size < Batch::CAPACITY) continue;
      compute_special_batch(what);
    }
    c.quiet_special[r - c.plain] = quiet;
  }
  if (batch.size > 0) compute_special_batch(what);
}

void PairGranHysteretic::compute_special_batch(Tally what)
{
  if (only_spheres) batch.multiply_normals();
  compute_batch(what, true);
  batch.size = 0;
}

/* Put special pair k of spheres i and j, which touch by the distance of their centers, into the batch, or end its spring and forces
   if it does not touch. Its vector is then that between the centers. Returns true if it is in the batch. */
bool PairGranHysteretic::add_spheres(int k, int i, int j)
{
  ContactList &c = contacts;
  const double radsum = atom->radius[i] + atom->radius[j], reach = radsum + gap;
  const double rounded = geometry.rounded_distance_squared(i, j);
  // most pairs are so far from touching, and from the gap, that the last bits of the distance do not matter
  const bool clearly_apart =
      rounded > radsum * radsum * (1.0 + MARGIN) && (c.peak[k] == 0.0 || rounded < reach * reach * (1.0 - MARGIN));
  bool far = false;
  if (!clearly_apart) {
    const PairGeometry::Vector del = geometry.shifted_vector(i, j);
    const double rsq = del[0] * del[0] + del[1] * del[1] + del[2] * del[2], distance = std::sqrt(rsq);
    if (!(distance * distance >= TouchingPairs::touch_squared(radsum))) {    // also true for NaN
      batch.put(batch.size++, k, i, j, del[0], del[1], del[2], rsq);
      return true;
    }
    far = c.peak[k] > 0.0 && distance > reach;
  }
  if (c.has_spring(k)) release_contact(k);
  if (far) forget(c.row_of(k), k);
  return false;
}

/* Put special pair k of row r into the batch, or end its spring and forces if it does not touch. Returns true if it is in
   the batch. */
bool PairGranHysteretic::add_special(int r, int k)
{
  ContactList &c = contacts;
  const int i = c.row[r], j = c.partner[k];
  const double radsum = atom->radius[i] + atom->radius[j];
  const CylinderPair::Separation found = geometry.separation(i, j);
  const bool touches = !(found.distance * found.distance >= TouchingPairs::touch_squared(radsum));    // also true for NaN
  const bool sticks = has.cohesion && has.cohesion_of(c.block(k))->active();
  if (sticks || (touches && found.beyond <= 0.0)) {
    const double apart = found.distance, *const normal = found.normal;
    batch.put(batch.size++, k, i, j, normal[0] * apart, normal[1] * apart, normal[2] * apart, apart * apart);
    return true;
  }
  if (touches && c.peak[k] > 0.0)
    error->one(FLERR,
               "Particles {} and {} touch beyond the end of a cylinder, beyond the range of the law of their contact: use "
               "longer cylinders",
               atom->tag[i], atom->tag[j]);
  if (c.has_spring(k)) release_contact(k);
  if (c.peak[k] > 0.0 && found.distance > radsum + gap) forget(r, k);
  return false;
}
