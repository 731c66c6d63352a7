// SPDX-License-Identifier: GPL-2.0-only
/* Constants of law elastoplastic-fe and its error bars, written by `make law`. */

#ifndef GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H
#define GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H

#include <utility>

namespace granwave {

struct FeConstants {
  double p0 = 8.5381;
  double c0 = 0.153697;
  double cn = -1.47305;
  double cq = -0.191401;
  double cw = 1.82201;
  double tc = 1.5461;
  double tch = 1.8496;
  double tcn = -1.70013;
  double t0 = 0.906656;
  double te = -2.95841;
  double tk = 1.7654;
  double tkn = 1.5316;
  double gk = 0.257377;
  double gu = -0.299104;
  double gq = 0.468728;
  double gqe = 0.235162;
  double gqh = 2.04696;
  double fl = 3.56293;
  double fla = 1.04565;
  double ks = 0.678812;
  double rb = 1.40215;
  double q0 = 0.261027;
  double q1 = 2.78423;
  double qr = -0.617593;
  double h1 = 0.133981;
  double h2 = 0.421258;
  double h2a = 0.199377;
  double h3 = 0.865858;
  double hg = 0.74321;
  double hge = 3.92318;
  double hq = 0.151057;
  double hd = -0.317549;
  double e3 = -0.413956;
  double hf = 2.47193;
  double hfa = -0.602535;
  double hfe = -1.61925;
  double hf2 = 1.46189;
  double hc = 2.42522;
  double r0 = 0.117611;
  double r1 = 0.384579;
  double r2 = -0.0177534;
  double r3 = -0.210637;
  double r4 = 0.013322;
  double r5 = 0.833538;
  double r6 = 0.73088;
  double r7 = 0.0697593;
  double r8 = -0.0467717;
  double r9 = -0.203311;
  double n0 = 2.86643;
  double n1 = -0.994421;
  double n2 = -20.4311;
  double n3 = 1.96884;
  double n4 = 0.189493;
  double n5 = -0.902369;
  double n6 = 0.586275;
  double n7 = -0.578094;
  double n8 = -0.56098;
  double n9 = 0.225697;
};

constexpr std::pair<const char *, double FeConstants::*> FE_CONSTANTS[] = {
    {"p0", &FeConstants::p0},
    {"c0", &FeConstants::c0},
    {"cn", &FeConstants::cn},
    {"cq", &FeConstants::cq},
    {"cw", &FeConstants::cw},
    {"tc", &FeConstants::tc},
    {"tch", &FeConstants::tch},
    {"tcn", &FeConstants::tcn},
    {"t0", &FeConstants::t0},
    {"te", &FeConstants::te},
    {"tk", &FeConstants::tk},
    {"tkn", &FeConstants::tkn},
    {"gk", &FeConstants::gk},
    {"gu", &FeConstants::gu},
    {"gq", &FeConstants::gq},
    {"gqe", &FeConstants::gqe},
    {"gqh", &FeConstants::gqh},
    {"fl", &FeConstants::fl},
    {"fla", &FeConstants::fla},
    {"ks", &FeConstants::ks},
    {"rb", &FeConstants::rb},
    {"q0", &FeConstants::q0},
    {"q1", &FeConstants::q1},
    {"qr", &FeConstants::qr},
    {"h1", &FeConstants::h1},
    {"h2", &FeConstants::h2},
    {"h2a", &FeConstants::h2a},
    {"h3", &FeConstants::h3},
    {"hg", &FeConstants::hg},
    {"hge", &FeConstants::hge},
    {"hq", &FeConstants::hq},
    {"hd", &FeConstants::hd},
    {"e3", &FeConstants::e3},
    {"hf", &FeConstants::hf},
    {"hfa", &FeConstants::hfa},
    {"hfe", &FeConstants::hfe},
    {"hf2", &FeConstants::hf2},
    {"hc", &FeConstants::hc},
    {"r0", &FeConstants::r0},
    {"r1", &FeConstants::r1},
    {"r2", &FeConstants::r2},
    {"r3", &FeConstants::r3},
    {"r4", &FeConstants::r4},
    {"r5", &FeConstants::r5},
    {"r6", &FeConstants::r6},
    {"r7", &FeConstants::r7},
    {"r8", &FeConstants::r8},
    {"r9", &FeConstants::r9},
    {"n0", &FeConstants::n0},
    {"n1", &FeConstants::n1},
    {"n2", &FeConstants::n2},
    {"n3", &FeConstants::n3},
    {"n4", &FeConstants::n4},
    {"n5", &FeConstants::n5},
    {"n6", &FeConstants::n6},
    {"n7", &FeConstants::n7},
    {"n8", &FeConstants::n8},
    {"n9", &FeConstants::n9},
};

/* Error bars for peaks from this overlap on, over that at first yield: relative ones of the force on loading and of the
   coefficient of restitution, and that of unloading over the peak force. */
struct FeBar {
  double from, force, unloading, restitution;
};

constexpr FeBar FE_BARS[] = {
    {1.0, 0.04, 0.06, 0.04},
    {10.0, 0.04, 0.06, 0.04},
    {100.0, 0.04, 0.06, 0.04},
};

}    // namespace granwave

#endif
