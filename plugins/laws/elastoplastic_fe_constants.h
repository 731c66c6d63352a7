// SPDX-License-Identifier: GPL-2.0-only
/* Constants of law elastoplastic-fe and its error bars, written by `make law`. */

#ifndef GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H
#define GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H

#include <utility>

namespace granwave {

struct FeConstants {
  double p0 = 8.37818;
  double c0 = 0.14924;
  double cn = -1.61091;
  double cq = -0.184672;
  double cw = 1.69871;
  double tc = 1.70545;
  double tch = 1.77507;
  double tcn = -1.33979;
  double t0 = 0.9165;
  double te = -2.94969;
  double st = 20.2619;
  double stn = 4.06996;
  double tk = 1.94475;
  double tkn = 2.00548;
  double gk = 0.251355;
  double gu = -0.285;
  double gq = 0.503576;
  double gqe = 0.240564;
  double gqh = 2.0268;
  double fl = 3.25736;
  double fla = 0.940853;
  double ks = 0.676824;
  double rb = 1.34459;
  double q0 = 0.258067;
  double q1 = 2.7937;
  double qr = -0.565194;
  double h1 = 0.144478;
  double h2 = 0.430667;
  double h2a = 0.195752;
  double h3 = 0.864923;
  double hg = 0.65652;
  double hge = 3.04837;
  double hq = 0.1453;
  double hd = -0.357411;
  double e3 = -0.346058;
  double hf = 2.55044;
  double hfa = -0.58864;
  double hfe = -2.1981;
  double hf2 = 1.80367;
  double hc = 2.46279;
  double r0 = 0.11249;
  double r1 = 0.31979;
  double r2 = -0.017137;
  double r3 = -0.181626;
  double r4 = 0.0221769;
  double r5 = 0.840615;
  double r6 = 0.90648;
  double r7 = 0.0674353;
  double r8 = -0.05228;
  double r9 = -0.184026;
  double n0 = 0.724231;
  double n1 = -0.313094;
  double n2 = -4.02664;
  double n3 = 1.75905;
  double n4 = 0.372148;
  double n5 = 0.747448;
  double n6 = -0.683465;
  double n7 = -0.571571;
  double n8 = -0.658743;
  double n9 = 0.286804;
};

constexpr std::pair<const char *, double FeConstants::*> FE_CONSTANTS[] = {
    {"p0", &FeConstants::p0},   {"c0", &FeConstants::c0},   {"cn", &FeConstants::cn},   {"cq", &FeConstants::cq},
    {"cw", &FeConstants::cw},   {"tc", &FeConstants::tc},   {"tch", &FeConstants::tch}, {"tcn", &FeConstants::tcn},
    {"t0", &FeConstants::t0},   {"te", &FeConstants::te},   {"st", &FeConstants::st},   {"stn", &FeConstants::stn},
    {"tk", &FeConstants::tk},   {"tkn", &FeConstants::tkn}, {"gk", &FeConstants::gk},   {"gu", &FeConstants::gu},
    {"gq", &FeConstants::gq},   {"gqe", &FeConstants::gqe}, {"gqh", &FeConstants::gqh}, {"fl", &FeConstants::fl},
    {"fla", &FeConstants::fla}, {"ks", &FeConstants::ks},   {"rb", &FeConstants::rb},   {"q0", &FeConstants::q0},
    {"q1", &FeConstants::q1},   {"qr", &FeConstants::qr},   {"h1", &FeConstants::h1},   {"h2", &FeConstants::h2},
    {"h2a", &FeConstants::h2a}, {"h3", &FeConstants::h3},   {"hg", &FeConstants::hg},   {"hge", &FeConstants::hge},
    {"hq", &FeConstants::hq},   {"hd", &FeConstants::hd},   {"e3", &FeConstants::e3},   {"hf", &FeConstants::hf},
    {"hfa", &FeConstants::hfa}, {"hfe", &FeConstants::hfe}, {"hf2", &FeConstants::hf2}, {"hc", &FeConstants::hc},
    {"r0", &FeConstants::r0},   {"r1", &FeConstants::r1},   {"r2", &FeConstants::r2},   {"r3", &FeConstants::r3},
    {"r4", &FeConstants::r4},   {"r5", &FeConstants::r5},   {"r6", &FeConstants::r6},   {"r7", &FeConstants::r7},
    {"r8", &FeConstants::r8},   {"r9", &FeConstants::r9},   {"n0", &FeConstants::n0},   {"n1", &FeConstants::n1},
    {"n2", &FeConstants::n2},   {"n3", &FeConstants::n3},   {"n4", &FeConstants::n4},   {"n5", &FeConstants::n5},
    {"n6", &FeConstants::n6},   {"n7", &FeConstants::n7},   {"n8", &FeConstants::n8},   {"n9", &FeConstants::n9},
};

/* Error bars for peaks from this overlap on, over that at first yield: relative ones of the force on loading and of the
   coefficient of restitution, and that of unloading over the peak force. */
struct FeBar {
  double from, force, unloading, restitution;
};

/* Of equal spheres and of a sphere on a rigid flat; of other contacts. */
constexpr FeBar FE_BARS[][3] = {
    {{1, 0.029, 0.027, 0.024}, {10, 0.047, 0.05, 0.041}, {100, 0.045, 0.073, 0.05}},
    {{1, 0.038, 0.028, 0.022}, {10, 0.04, 0.049, 0.039}, {100, 0.05, 0.068, 0.048}},
};

}    // namespace granwave

#endif
