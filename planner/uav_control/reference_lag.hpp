// SPDX-License-Identifier: BSD-3-Clause
// What rotors that lag can follow exactly: a reference behind the same lag.
#pragma once

#include "planner/uav_control/flat_reference.hpp"
#include "rt/archive.hpp"
#include "rt/math.hpp"

namespace sortie::planner {

/// A smooth motion, passed through the first-order lag of the rotors. Its derivatives then belong to
/// accelerations that rotors can make, and the command that makes them is the snap of the motion before the
/// lag: the chain of integrators behind the lag is fed forward without a derivative of the snap. The result
/// comes `tau_s` later. 60 bytes, no heap, 20 operations.
class ReferenceLag {
 public:
  ReferenceLag(double tau_s, double period_s) : tau_s_(tau_s), keep_(rt::exp(-period_s / tau_s)) {}

  void reset() { snap_ = lead_ = {}; }

  /// The motion at the start of a period and its snap, constant over the period, to the reference there.
  FlatReference step(const FlatReference& start, const rt::Vector3& snap_m_s4) {
    FlatReference r = start;
    r.s_m_s4 = snap_;
    r.j_m_s3 = start.j_m_s3 - tau_s_ * r.s_m_s4;  // y = x - tau y' is what a lag does to each derivative
    r.a_m_s2 = start.a_m_s2 - tau_s_ * r.j_m_s3;
    r.v_m_s = start.v_m_s - tau_s_ * r.a_m_s2;
    r.p_m = start.p_m - tau_s_ * r.v_m_s;
    lead_ = snap_m_s4 - snap_;
    snap_ = snap_m_s4 + keep_ * (snap_ - snap_m_s4);
    return r;
  }

  /// The motion whose lagged reference `r` is, for one that begins within a motion.
  FlatReference ahead(const FlatReference& r) const {
    FlatReference x = r;
    x.p_m = r.p_m + tau_s_ * r.v_m_s;
    x.v_m_s = r.v_m_s + tau_s_ * r.a_m_s2;
    x.a_m_s2 = r.a_m_s2 + tau_s_ * r.j_m_s3;
    return x;
  }

  /// What the snap of the command has more than that of the reference, over the period that step() began.
  const rt::Vector3& lead_m_s4() const { return lead_; }

  /// State to bytes and back.
  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "reference lag").fixed(tau_s_, keep_).state(snap_, lead_);
  }

 private:
  double tau_s_;
  double keep_;
  rt::Vector3 snap_;
  rt::Vector3 lead_;
};

}  // namespace sortie::planner
