// SPDX-License-Identifier: GPL-2.0-only
/* Constants of law elastoplastic-fe, written by `make law`. */

#ifndef GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H
#define GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H

#include <utility>

namespace granwave {

struct FeConstants {
  double p0 = 7.89144;
  double pe = 0.0956272;
  double c0 = 0.154425;
  double cn = -1.7077;
  double cq = -0.137711;
  double cw = 0.55354;
  double tc = 1.33839;
  double tch = 2.38889;
  double tcn = -3.14734;
  double t0 = 0.685994;
  double te = 0.311486;
  double tk = 1.09975;
  double tkn = 2.13094;
  double gk = 0.267612;
  double gq = 0.755513;
  double gqh = 3.30727;
  double fl = 2.71471;
  double ks = 0.407021;
  double rb = 0.283155;
  double q0 = 0.219756;
  double q1 = 3.66875;
  double qs = 0.211961;
  double qr = 0.984809;
  double qr2 = -0.951802;
  double qn = -0.32371;
  double h1 = 0.0530333;
  double h2 = 0.355934;
  double h3 = 0.919613;
  double hg = 9.89528;
  double hq = -0.213014;
  double hd = -0.550224;
  double e3 = 1.2704;
  double hf = 2.10494;
  double hf2 = 0.387244;
  double hc = 2.18614;
  double r0 = 0.0871175;
  double r1 = 0.301053;
  double r2 = -0.105348;
  double r3 = 0.0179456;
  double r4 = 0.147045;
  double r5 = 0.814858;
  double r6 = 0.908759;
  double r7 = 0.0414179;
  double r8 = -0.0668758;
  double r9 = -0.923972;
  double n0 = 3.92845;
  double n1 = -1.8246;
  double n2 = -27.963;
  double n3 = 0.892619;
  double n4 = 0.0938089;
  double n5 = -0.808635;
  double n6 = 0.608074;
};

constexpr std::pair<const char *, double FeConstants::*> FE_CONSTANTS[] = {
    {"p0", &FeConstants::p0},   {"pe", &FeConstants::pe},   {"c0", &FeConstants::c0}, {"cn", &FeConstants::cn},
    {"cq", &FeConstants::cq},   {"cw", &FeConstants::cw},   {"tc", &FeConstants::tc}, {"tch", &FeConstants::tch},
    {"tcn", &FeConstants::tcn}, {"t0", &FeConstants::t0},   {"te", &FeConstants::te}, {"tk", &FeConstants::tk},
    {"tkn", &FeConstants::tkn}, {"gk", &FeConstants::gk},   {"gq", &FeConstants::gq}, {"gqh", &FeConstants::gqh},
    {"fl", &FeConstants::fl},   {"ks", &FeConstants::ks},   {"rb", &FeConstants::rb}, {"q0", &FeConstants::q0},
    {"q1", &FeConstants::q1},   {"qs", &FeConstants::qs},   {"qr", &FeConstants::qr}, {"qr2", &FeConstants::qr2},
    {"qn", &FeConstants::qn},   {"h1", &FeConstants::h1},   {"h2", &FeConstants::h2}, {"h3", &FeConstants::h3},
    {"hg", &FeConstants::hg},   {"hq", &FeConstants::hq},   {"hd", &FeConstants::hd}, {"e3", &FeConstants::e3},
    {"hf", &FeConstants::hf},   {"hf2", &FeConstants::hf2}, {"hc", &FeConstants::hc}, {"r0", &FeConstants::r0},
    {"r1", &FeConstants::r1},   {"r2", &FeConstants::r2},   {"r3", &FeConstants::r3}, {"r4", &FeConstants::r4},
    {"r5", &FeConstants::r5},   {"r6", &FeConstants::r6},   {"r7", &FeConstants::r7}, {"r8", &FeConstants::r8},
    {"r9", &FeConstants::r9},   {"n0", &FeConstants::n0},   {"n1", &FeConstants::n1}, {"n2", &FeConstants::n2},
    {"n3", &FeConstants::n3},   {"n4", &FeConstants::n4},   {"n5", &FeConstants::n5}, {"n6", &FeConstants::n6},
};

}    // namespace granwave

#endif
