// SPDX-License-Identifier: BSD-3-Clause
// Failing sequences made small: chunks are left out first, then numbers are made simple, until nothing more
// goes.
#include <algorithm>
#include <bit>
#include <cmath>

#include "tests/bench/campaign/campaign.hpp"

namespace sortie::bench {

namespace {

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

class Shrinker {
 public:
  Shrinker(std::vector<CampaignOp> ops, std::int64_t period_ns, const CampaignRun& run,
           std::uint64_t most_runs)
      : ops_(std::move(ops)),
        period_ns_(period_ns),
        run_(run),
        most_runs_(most_runs),
        fault_(run_(ops_).fault) {}

  std::vector<CampaignOp> shrink() {
    if (fault_.empty()) return ops_;
    bool smaller = true;
    while (smaller && runs_ < most_runs_) {
      smaller = leave_out();
      for (std::size_t i = 0; i < ops_.size(); ++i) smaller = simplify(i) || smaller;
    }
    return ops_;
  }
  std::uint64_t runs() const { return runs_; }

 private:
  bool take(const std::vector<CampaignOp>& candidate) {
    if (runs_ >= most_runs_) return false;
    ++runs_;
    if (run_(candidate).fault != fault_) return false;
    ops_ = candidate;
    return true;
  }
  // Halves, quarters, ... down to single operations, from the end: what comes last was often enough.
  bool leave_out() {
    const std::size_t before = ops_.size();
    for (std::size_t chunk = std::max<std::size_t>(1, ops_.size() / 2);; chunk /= 2) {
      for (std::size_t end = ops_.size(); end > 0 && ops_.size() > 1;) {
        const std::size_t first = end > chunk ? end - chunk : 0;
        std::vector<CampaignOp> less = ops_;
        less.erase(less.begin() + static_cast<std::ptrdiff_t>(first),
                   less.begin() + static_cast<std::ptrdiff_t>(end));
        static_cast<void>(!less.empty() && take(less));
        end = first;
      }
      if (chunk <= 1) break;
    }
    return ops_.size() < before;
  }
  template <class Change>
  bool try_change(std::size_t i, const Change& change) {
    std::vector<CampaignOp> other = ops_;
    change(other[i]);
    return !(other[i] == ops_[i]) && take(other);
  }
  // Each number becomes the first of these that keeps the fault: a later one is never tried over an earlier
  // one, so that this comes to an end.
  bool simplify(std::size_t i) {
    bool smaller = false;
    if (ops_[i].kind != 0) smaller = try_change(i, [](CampaignOp& op) { op.kind = 0; });
    for (const std::int64_t step : {period_ns_, std::int64_t{0}, std::int64_t{1}}) {
      if (ops_[i].step_ns == step) break;
      if (!try_change(i, [step](CampaignOp& op) { op.step_ns = step; })) continue;
      smaller = true;
      break;
    }
    for (std::size_t k = 0; k < kCampaignValues; ++k) smaller = simplify_value(i, k) || smaller;
    return smaller;
  }
  bool simplify_value(std::size_t i, std::size_t k) {
    const double value = ops_[i].value[k];
    for (const double simple :
         {0.0, 1.0, -1.0, std::trunc(value), fewer_digits(value, 8), fewer_digits(value, 24)}) {
      if (same_bits(value, simple) || (std::isnan(value) && std::isnan(simple))) return false;
      if (try_change(i, [k, simple](CampaignOp& op) { op.value[k] = simple; })) return true;
    }
    return false;
  }
  // The leading binary digits; what is not finite stays as it is.
  static double fewer_digits(double value, int digits) {
    if (!std::isfinite(value) || value == 0.0) return value;
    int exponent = 0;
    const double part = std::frexp(value, &exponent);
    return std::ldexp(std::trunc(std::ldexp(part, digits)), exponent - digits);
  }

  std::vector<CampaignOp> ops_;
  std::int64_t period_ns_;
  const CampaignRun& run_;
  std::uint64_t most_runs_;
  std::uint64_t runs_{};
  std::string fault_;
};

}  // namespace

bool operator==(const CampaignOp& a, const CampaignOp& b) {
  return a.kind == b.kind && a.step_ns == b.step_ns &&
         std::equal(std::begin(a.value), std::end(a.value), std::begin(b.value), same_bits);
}

std::vector<CampaignOp> shrink_sequence(std::vector<CampaignOp> ops, std::int64_t period_ns,
                                        const CampaignRun& run, std::uint64_t most_runs,
                                        std::uint64_t& runs) {
  Shrinker shrinker(std::move(ops), period_ns, run, most_runs);
  std::vector<CampaignOp> small = shrinker.shrink();
  runs = shrinker.runs();
  return small;
}

}  // namespace sortie::bench
