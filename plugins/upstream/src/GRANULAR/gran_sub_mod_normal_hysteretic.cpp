/* ----------------------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   Copyright (2003) Sandia Corporation.  Under the terms of Contract
   DE-AC04-94AL85000 with Sandia Corporation, the U.S. Government retains
   certain rights in this software.  This software is distributed under
   the GNU General Public License.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

/* ----------------------------------------------------------------------
   Elasto-plastic normal force without cohesion: Hertz up to first yield, a fit
   to finite-element solutions of two elastic-perfectly-plastic spheres beyond it,
   and unloading to a residual overlap that depends on the largest overlap (R. K. Pal,
   thesis, University of Illinois at Urbana-Champaign, 2015, chapters 2 and 3). Force
   and contact area are continuous. Just beyond first yield the unloading exponent is
   larger than the published value, which would create energy there.

   The history is the largest overlap. It is kept until the undeformed spheres are
   farther apart than a given gap.
------------------------------------------------------------------------- */

#include "gran_sub_mod_normal_hysteretic.h"

#include "error.h"
#include "gran_sub_mod_damping.h"
#include "granular_model.h"
#include "math_const.h"
#include "math_special.h"
#include "neighbor.h"

#include <cmath>

using namespace LAMMPS_NS;
using namespace Granular_NS;

using MathConst::MY_PI;
using MathSpecial::square;

static constexpr double FOURTHIRDS = 4.0 / 3.0;

// constants of the fit

static constexpr double PRESSURE_LIMIT = 2.48;
static constexpr double PRESSURE_RATE = 0.098;
static constexpr double AREA_SWITCH = 177.6;
static constexpr double AREA_SLOPE = 2.37;
static constexpr double AREA_OFFSET = 59.96;
static constexpr double RESIDUAL_SLOPE = 0.95;
static constexpr double RESIDUAL_OFFSET = 25.94;
static constexpr double RESIDUAL_AMPLITUDE = 24.99;
static constexpr double RESIDUAL_RATE = 0.015;
static constexpr double UNLOADING_EXPONENT = 1.35;

// search for the overlap at which the unloading exponent becomes constant

static constexpr double SEARCH_START = 1e-3;
static constexpr double SEARCH_GROWTH = 1.1;

// Gauss-Legendre quadrature with 10 points: those of one half

static constexpr int NHALF = 5;
static constexpr double GAUSS_POINT[NHALF] = {0.1488743389816312, 0.4333953941292472,
                                              0.6794095682990244, 0.8650633666889845,
                                              0.9739065285171717};
static constexpr double GAUSS_WEIGHT[NHALF] = {0.2955242247147529, 0.2692667193099963,
                                               0.2190863625159820, 0.1494513491505806,
                                               0.0666713443086881};

/* ---------------------------------------------------------------------- */

GranSubModNormalHysteretic::GranSubModNormalHysteretic(GranularModel *gm, LAMMPS *lmp) :
    GranSubModNormal(gm, lmp), Fne(0.0)
{
  material_properties = 1;
  beyond_contact = 1;
  contact_radius_flag = 1;
  num_coeffs = 6;

  // the largest overlap is the same for both atoms

  size_history = 1;
  nondefault_history_transfer = 1;
  transfer_history_factor = new double[size_history];
  transfer_history_factor[0] = 1.0;
}

/* ---------------------------------------------------------------------- */

void GranSubModNormalHysteretic::coeffs_to_local()
{
  Emod = coeffs[0];
  damp = coeffs[1];
  poiss = coeffs[2];
  const double yield_strength = coeffs[3];
  const double yield_factor = coeffs[4];
  gap = coeffs[5];

  if (Emod <= 0.0 || damp < 0.0 || yield_strength <= 0.0 || gap < 0.0)
    error->all(FLERR, "Illegal hysteretic normal model");

  pressure_yield = 2.0 / 3.0 * yield_factor;
  if (yield_factor <= 0.0 || pressure_yield >= PRESSURE_LIMIT)
    error->all(FLERR,
               "Yield factor {} of hysteretic normal model must be positive and below {:.4g}",
               yield_factor, 1.5 * PRESSURE_LIMIT);

  // a wall is of the material of the particles

  Emix = mix_stiffnessE(Emod, Emod, poiss, poiss);
  overlap_yield = square(0.5 * MY_PI * yield_factor * yield_strength / Emix);
  force_yield = FOURTHIRDS * Emix * overlap_yield * sqrt(overlap_yield);
  amplitude = 1.5 / yield_factor;
  area_exponent = log(AREA_SLOPE * AREA_SWITCH - AREA_OFFSET) / log(AREA_SWITCH);

  peak_lossy = 1.0;
  for (double step = SEARCH_START; peak_lossy < AREA_SWITCH; step *= SEARCH_GROWTH) {
    peak_lossy = 1.0 + step;
    if (energy_ratio(peak_lossy) < UNLOADING_EXPONENT) break;
  }
}

/* ----------------------------------------------------------------------
   the mixed modulus is that of two equal materials, so that a restart file holds
   coefficients from which coeffs_to_local() recovers the effective modulus
------------------------------------------------------------------------- */

void GranSubModNormalHysteretic::mix_coeffs(double *icoeffs, double *jcoeffs)
{
  const double *softer = (icoeffs[3] <= jcoeffs[3]) ? icoeffs : jcoeffs;
  const double modulus = mix_stiffnessE(icoeffs[0], jcoeffs[0], icoeffs[2], jcoeffs[2]);

  coeffs[1] = mix_geom(icoeffs[1], jcoeffs[1]);
  coeffs[2] = mix_geom(icoeffs[2], jcoeffs[2]);
  coeffs[0] = 2.0 * modulus * (1.0 - square(coeffs[2]));
  coeffs[3] = softer[3];
  coeffs[4] = softer[4];
  coeffs[5] = MAX(icoeffs[5], jcoeffs[5]);

  coeffs_to_local();
}

/* ---------------------------------------------------------------------- */

void GranSubModNormalHysteretic::init()
{
  const std::string &damping = gm->damping_model->name;
  if (damp > 0.0 && (damping == "velocity" || damping == "mass_velocity"))
    error->all(FLERR, "Damping model {} acts across the gap of the hysteretic normal model",
               damping);
}

/* ----------------------------------------------------------------------
   history is not yet available: a contact stays up to the gap once it has formed
------------------------------------------------------------------------- */

bool GranSubModNormalHysteretic::touch()
{
  const double reach = gm->radsum + (gm->touch ? gap : 0.0);
  return gm->rsq < reach * reach;
}

/* ----------------------------------------------------------------------
   called outside of compute(), do not assume geometry defined in contact
------------------------------------------------------------------------- */

double GranSubModNormalHysteretic::pulloff_distance(double /*radi*/, double /*radj*/)
{
  // neighbor lists of styles nsq and bin contain pairs up to a gap of the skin

  if (gap > neighbor->skin)
    error->all(FLERR, "Gap {} of hysteretic normal model exceeds the neighbor skin {}", gap,
               neighbor->skin);
  return gap;
}

/* ----------------------------------------------------------------------
   called before calculate_forces(): computes the force as well
------------------------------------------------------------------------- */

double GranSubModNormalHysteretic::calculate_contact_radius()
{
  double &largest = gm->history[history_index];
  const double delta = gm->delta;
  const double peak = MAX(largest, delta);
  if (gm->history_update) largest = peak;
  if (delta <= 0.0) return separate();

  const double scale = overlap_yield * gm->Reff;
  if (peak <= scale) {
    const double radius = sqrt(gm->dR);
    Fne = FOURTHIRDS * Emix * radius * delta;
    return radius;
  }

  const double a = delta / scale;
  const double a_peak = peak / scale;
  double radius_squared = scale * gm->Reff * area(a_peak);
  Fne = force_yield * square(gm->Reff) * force_loading(a_peak);

  if (delta < peak) {
    const double a_residual = residual(a_peak);
    if (a <= a_residual) return separate();
    const double fraction = (a - a_residual) / (a_peak - a_residual);
    radius_squared *= fraction;
    Fne *= pow(fraction, exponent(a_peak));
  }
  return sqrt(radius_squared);
}

/* ---------------------------------------------------------------------- */

double GranSubModNormalHysteretic::calculate_forces() { return Fne; }

/* ----------------------------------------------------------------------
   surfaces are apart: no force, and the other sub-models have no springs
------------------------------------------------------------------------- */

double GranSubModNormalHysteretic::separate()
{
  Fne = 0.0;
  if (gm->history_update) {
    for (int i = 0; i < NSUBMODELS; i++) {
      const GranSubMod *model = gm->sub_models[i];
      if (model == this) continue;
      for (int k = 0; k < model->size_history; k++) gm->history[model->history_index + k] = 0.0;
    }
  }
  return 0.0;
}

/* ----------------------------------------------------------------------
   mean pressure / yield strength
------------------------------------------------------------------------- */

double GranSubModNormalHysteretic::pressure(double a) const
{
  return PRESSURE_LIMIT - (PRESSURE_LIMIT - pressure_yield) * exp(-PRESSURE_RATE * (a - 1.0));
}

/* ----------------------------------------------------------------------
   contact area / contact area at first yield
------------------------------------------------------------------------- */

double GranSubModNormalHysteretic::area(double a) const
{
  return (a < AREA_SWITCH) ? pow(a, area_exponent) : AREA_SLOPE * a - AREA_OFFSET;
}

/* ---------------------------------------------------------------------- */

double GranSubModNormalHysteretic::force_loading(double a) const
{
  return amplitude * pressure(a) * area(a);
}

/* ----------------------------------------------------------------------
   work of loading up to an overlap below AREA_SWITCH, on intervals of doubling width
------------------------------------------------------------------------- */

double GranSubModNormalHysteretic::work_loading(double a) const
{
  double work = 0.4;
  for (double low = 1.0; low < a; low *= 2.0) {
    const double half = 0.5 * (MIN(2.0 * low, a) - low);
    const double middle = low + half;
    for (int n = 0; n < NHALF; n++) {
      const double offset = half * GAUSS_POINT[n];
      work += half * GAUSS_WEIGHT[n] *
              (force_loading(middle - offset) + force_loading(middle + offset));
    }
  }
  return work;
}

/* ----------------------------------------------------------------------
   residual overlap of a largest overlap
------------------------------------------------------------------------- */

double GranSubModNormalHysteretic::residual(double a) const
{
  return RESIDUAL_SLOPE * a - RESIDUAL_OFFSET +
         RESIDUAL_AMPLITUDE * exp(-RESIDUAL_RATE * (a - 1.0));
}

/* ----------------------------------------------------------------------
   unloading exponent that returns all energy
------------------------------------------------------------------------- */

double GranSubModNormalHysteretic::energy_ratio(double a) const
{
  return force_loading(a) * (a - residual(a)) / work_loading(a) - 1.0;
}

/* ---------------------------------------------------------------------- */

double GranSubModNormalHysteretic::exponent(double a) const
{
  if (a >= peak_lossy) return UNLOADING_EXPONENT;
  return MAX(UNLOADING_EXPONENT, energy_ratio(a));
}
