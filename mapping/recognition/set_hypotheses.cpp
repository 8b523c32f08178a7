// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/set_hypotheses.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::mapping {
namespace {
/// Of eps, narrow to wide.
constexpr double kGateShare[] = {0.5, 1.0, 2.0};
/// What a pose explains: all that lies within so many eps of where it is laid.
constexpr double kExplained = 2.0;
}  // namespace

SetHypotheses::SetHypotheses(std::uint32_t pairs, rt::Arena& arena)
    : sweep_(pairs, arena),
      set_({pairs, std::min(pairs, 1024u), SetHypothesis::kMostPairs}, arena),
      core_(pairs, arena),
      alive_(arena.make_array<SweptPair>("recognition pairs alive", pairs)),
      core_pairs_(arena.make_array<SweptPair>("recognition pairs of the core", pairs)),
      core_number_(arena.make_array<std::uint16_t>("recognition numbers of the core", pairs)),
      members_(arena.make_array<BitGraph::Word>("recognition all", BitGraph::words_of(pairs))) {}

ConsistencyGate SetHypotheses::gate(double of_eps) const {
  ConsistencyGate gate;
  gate.eps_cm = static_cast<std::int32_t>(100.0 * of_eps * config_.eps_m + 0.5);
  gate.tilt_permille = static_cast<std::int32_t>(config_.tilt_deg * 17.4533 + 0.5);
  gate.gravity = config_.gravity;
  return gate;
}

Status SetHypotheses::begin(const SetConfig& config, std::span<const SweptPair> pairs) {
  config_ = config;
  step_ = Step::done;
  round_ = 0;
  found_count_ = 0;
  bent_ = false;
  proved_ = true;
  verdict_ = SetVerdict::none;
  core_count_ = 0;
  const Status status = sweep_.begin(gate(kGateShare[kGates - 1]), pairs);
  if (status != Status::ok ||
      members_.size() < BitGraph::words_of(static_cast<std::uint32_t>(pairs.size()))) {
    return status != Status::ok ? status : Status::full;
  }
  if (pairs.size() < config.least) {
    verdict_ = SetVerdict::few;
    return Status::ok;
  }
  // The core is picked from this copy once it is known.
  std::copy(pairs.begin(), pairs.end(), alive_.begin());
  step_ = Step::sweep_all;
  return Status::ok;
}

/// A set of `least` lies within the core of least - 1.
void SetHypotheses::keep_core() {
  const auto order = sweep_.order();
  for (std::uint32_t v = 0; v < order.size(); ++v) {
    if (core_.core(v) + 1u < config_.least) continue;
    core_number_[core_count_] = order[v];
    core_pairs_[core_count_++] = alive_[order[v]];
  }
  alive_count_ = core_count_;
  std::copy(core_pairs_.begin(), core_pairs_.begin() + core_count_, alive_.begin());
}

void SetHypotheses::begin_round() {
  gate_ = 0;
  round_count_ = 0;
}

/// The gate's set, where it is larger than those of narrower gates.
void SetHypotheses::take_set() {
  const auto set = set_.found();
  proved_ = proved_ && set_.proved();
  if (set.empty()) return;
  round_count_ = static_cast<std::uint32_t>(set.size());
  for (std::uint32_t i = 0; i < round_count_; ++i) round_set_[i] = sweep_.order()[set[i]];
}

/// Every segment's nearest correspondence within eps of the pose, of each target the nearest one's. Numbers
/// are of core_pairs_.
void SetHypotheses::refine(SetHypothesis& h) const {
  struct Near {
    double miss;
    std::uint16_t pair;
  };
  Near near[SetHypothesis::kMostPairs];
  std::uint32_t count = 0;
  const double most = config_.eps_m * config_.eps_m;
  for (std::uint32_t i = 0; i < core_count_; ++i) {
    const double miss = squared_miss(h.fit.place, core_pairs_[i]);
    if (miss > most) continue;
    const Correspondence& pair = core_pairs_[i].pair;
    bool is_nearest = true;
    for (std::uint32_t k = 0; k < count;) {
      const Correspondence& other = core_pairs_[near[k].pair].pair;
      const bool same = other.segment == pair.segment || other.target == pair.target;
      if (same && near[k].miss <= miss) is_nearest = false;
      if (same && near[k].miss > miss) {
        near[k] = near[--count];
      } else {
        ++k;
      }
    }
    if (is_nearest && count < SetHypothesis::kMostPairs)
      near[count++] = {miss, static_cast<std::uint16_t>(i)};
  }
  std::sort(near, near + count, [&](const Near& a, const Near& b) {
    return core_pairs_[a.pair].pair < core_pairs_[b.pair].pair;
  });
  h.count = count;
  for (std::uint32_t i = 0; i < count; ++i) h.pairs[i] = near[i].pair;
}

/// What the pose explains speaks for no other one.
void SetHypotheses::remove(const SetHypothesis& h) {
  const double explained = kExplained * config_.eps_m, most = explained * explained;
  std::uint32_t left = 0;
  for (std::uint32_t i = 0; i < alive_count_; ++i) {
    if (squared_miss(h.fit.place, alive_[i]) <= most) continue;
    alive_[left++] = alive_[i];
  }
  alive_count_ = left;
}

/// The round's set becomes a pose, or goes.
void SetHypotheses::fit_round() {
  ++round_;
  SetHypothesis h;
  const std::span<const std::uint16_t> set{round_set_, round_count_};
  bool rigid = fit_level(alive_, set, h.fit) && h.fit.rms_m <= config_.eps_m;
  for (int again = 0; rigid && again < 2; ++again) {
    refine(h);
    rigid = h.count >= config_.least && fit_level(core_pairs_, {h.pairs, h.count}, h.fit);
  }
  if (rigid) {
    remove(h);
    for (std::uint32_t i = 0; i < h.count; ++i) h.pairs[i] = core_number_[h.pairs[i]];
    found_[found_count_++] = h;
    return;
  }
  bent_ = true;
  std::uint32_t left = 0;
  for (std::uint32_t i = 0; i < alive_count_; ++i) {
    if (std::find(set.begin(), set.end(), i) != set.end()) continue;
    alive_[left++] = alive_[i];
  }
  alive_count_ = left;
}

void SetHypotheses::judge() {
  step_ = Step::done;
  std::stable_sort(found_, found_ + found_count_,
                   [](const SetHypothesis& a, const SetHypothesis& b) { return a.count > b.count; });
  if (found_count_ == 0) {
    verdict_ = bent_ ? SetVerdict::bent : SetVerdict::inconsistent;
    if (!proved_) verdict_ = SetVerdict::undecided;
  } else if (found_count_ > 1 && found_[1].count > config_.of_rival * found_[0].count) {
    verdict_ = SetVerdict::ambiguous;
  } else if (found_[0].fit.spread_m < config_.spread_m) {
    verdict_ = SetVerdict::narrow;
  } else {
    verdict_ = proved_ ? SetVerdict::found : SetVerdict::undecided;
  }
}

void SetHypotheses::stop() {
  if (step_ != Step::done) verdict_ = SetVerdict::undecided;
  step_ = Step::done;
}

bool SetHypotheses::run(std::uint64_t& units) {
  while (step_ != Step::done) {
    switch (step_) {
      case Step::sweep_all:
        if (!sweep_.run(units)) return false;
        BitGraph::fill(members_, sweep_.graph().vertices());
        core_.begin(sweep_.graph(), members_);
        step_ = Step::peel;
        break;
      case Step::peel:
        if (!core_.run(units)) return false;
        keep_core();
        begin_round();
        step_ = Step::next;
        break;
      case Step::next: {
        const bool over = found_count_ == kMost || round_ == kMostRounds || alive_count_ < config_.least;
        const auto gate_of_round = gate(kGateShare[gate_]);
        if (over || sweep_.begin(gate_of_round, alive_.first(alive_count_)) != Status::ok) {
          judge();
        } else {
          step_ = Step::sweep;
        }
        break;
      }
      case Step::sweep:
        if (!sweep_.run(units)) return false;
        BitGraph::fill(members_, sweep_.graph().vertices());
        set_.begin(sweep_.graph(), members_, std::max(config_.least, round_count_ + 1));
        step_ = Step::search;
        break;
      case Step::search:
        if (!set_.run(units)) return false;
        take_set();
        step_ = Step::next;
        if (++gate_ < kGates) break;
        if (round_count_ == 0) {
          judge();
          break;
        }
        fit_round();
        begin_round();
        break;
      case Step::done:
        break;
    }
  }
  return true;
}

}  // namespace sortie::mapping
