// SPDX-License-Identifier: GPL-2.0-only
/* Constants of law elastoplastic-fe, written by `make law`. */

#ifndef GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H
#define GRANWAVE_ELASTOPLASTIC_FE_CONSTANTS_H

#include <utility>

namespace granwave {

struct FeConstants {
  double p0 = 8.07545;
  double pe = 0.108089;
  double c0 = 0.179178;
  double cn = -1.23229;
  double cq = -0.111402;
  double cw = 0.492339;
  double tc = 1.45837;
  double tch = 2.26255;
  double tcn = -2.69833;
  double t0 = 0.952578;
  double te = 0.174243;
  double tk = 1.20226;
  double tkn = 1.71968;
  double gk = 0.282224;
  double gq = 0.678979;
  double gqh = 3.85587;
  double fl = 3.37042;
  double ks = 0.452096;
  double rb = 0.314578;
  double q0 = 0.225164;
  double q1 = 3.64405;
  double qs = 0.207532;
  double qr = 0.93823;
  double qr2 = -0.936296;
  double qn = -0.206658;
  double h1 = 0.0451674;
  double h2 = 0.356856;
  double h3 = 0.94692;
  double hg = 11.1285;
  double hq = -0.234171;
  double hd = -0.575159;
  double e3 = 1.34075;
  double hf = 1.97943;
  double hf2 = 0.65161;
  double hc = 2.21894;
  double r0 = 0.115889;
  double r1 = 0.0552929;
  double r2 = -0.0234805;
  double r3 = 0.00961114;
  double r4 = 0.028679;
  double r5 = 0.856615;
  double r6 = 1.05289;
  double r7 = 0.0554384;
  double r8 = -0.0744047;
  double r9 = -1.23036;
  double n0 = -0.696925;
  double n1 = -0.00734045;
  double n2 = 7.79746;
  double n3 = -0.387868;
  double n4 = 0.416551;
  double n5 = 1.84603;
  double n6 = -1.63055;
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
