// SPDX-License-Identifier: GPL-2.0-only
/* Constants of law elastoplastic-fe, written by `make law`. */

#ifndef GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H
#define GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H

#include <utility>

namespace granwave {

struct FeConstants {
  double p0 = 7.75275;
  double pn = -0.0345111;
  double c0 = 0.745212;
  double cn = -2.99235;
  double tc = 0.392257;
  double t0 = 2.19316;
  double tk = 1.14956;
  double tn = -1.6703;
  double gk = 0.129748;
  double gq = 1.15525;
  double ks = 0.443073;
  double rb = 0.657187;
  double q0 = 0.225473;
  double q1 = 2.91233;
  double qs = 0.0189437;
  double cw = 1.27139;
  double h1 = 0.0807475;
  double h2 = 0.275688;
  double h3 = 0.795299;
  double hg = 0.923778;
  double e3 = 1.09003;
  double hc = 0.534235;
  double r0 = 0.141659;
  double r1 = 0.563562;
  double r2 = 0.0302667;
  double r3 = -0.0200098;
  double r4 = -0.0544365;
  double r5 = 0.884935;
  double r6 = -0.0746624;
  double r7 = 0.0262558;
  double n0 = 0.569542;
  double n1 = 0.436487;
  double n2 = -3.18793;
  double n3 = 0.487276;
  double n4 = -0.252776;
  double n5 = 0.815401;
  double n6 = -1.84707;
};

constexpr std::pair<const char *, double FeConstants::*> FE_CONSTANTS[] = {
    {"p0", &FeConstants::p0}, {"pn", &FeConstants::pn}, {"c0", &FeConstants::c0}, {"cn", &FeConstants::cn},
    {"tc", &FeConstants::tc}, {"t0", &FeConstants::t0}, {"tk", &FeConstants::tk}, {"tn", &FeConstants::tn},
    {"gk", &FeConstants::gk}, {"gq", &FeConstants::gq}, {"ks", &FeConstants::ks}, {"rb", &FeConstants::rb},
    {"q0", &FeConstants::q0}, {"q1", &FeConstants::q1}, {"qs", &FeConstants::qs}, {"cw", &FeConstants::cw},
    {"h1", &FeConstants::h1}, {"h2", &FeConstants::h2}, {"h3", &FeConstants::h3}, {"hg", &FeConstants::hg},
    {"e3", &FeConstants::e3}, {"hc", &FeConstants::hc}, {"r0", &FeConstants::r0}, {"r1", &FeConstants::r1},
    {"r2", &FeConstants::r2}, {"r3", &FeConstants::r3}, {"r4", &FeConstants::r4}, {"r5", &FeConstants::r5},
    {"r6", &FeConstants::r6}, {"r7", &FeConstants::r7}, {"n0", &FeConstants::n0}, {"n1", &FeConstants::n1},
    {"n2", &FeConstants::n2}, {"n3", &FeConstants::n3}, {"n4", &FeConstants::n4}, {"n5", &FeConstants::n5},
    {"n6", &FeConstants::n6},
};

}    // namespace granwave

#endif
