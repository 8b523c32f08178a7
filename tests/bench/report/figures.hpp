// SPDX-License-Identifier: BSD-3-Clause
// What the benchmark programs report in: figures beside a peer's, tables, skips and notes, as one JSON
// object.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware_like/scene/json.hpp"
#include "rt/histogram.hpp"

namespace sortie::bench {

using Json = firmware::Json;

/// Repetitions of one figure, one a round.
class Rounds {
 public:
  void add(double value) { values_.push_back(value); }
  bool empty() const { return values_.empty(); }
  std::size_t size() const { return values_.size(); }
  const std::vector<double>& values() const { return values_; }
  double median() const;
  double low() const;
  double high() const;
  /// Nearest-rank quantile, 0..1.
  double quantile(double share) const;

 private:
  std::vector<double> values_;
};

/// Round by round, own over theirs.
Rounds ratio(const Rounds& own, const Rounds& theirs);

/// One line of the table: our figure beside a peer's.
struct Figure {       // NOLINT(bugprone-exception-escape): JSON's own move, out of memory at most
  std::string group;  ///< "wake-up", "queue", ...
  std::string what;   ///< e.g. "round trip p50"
  std::string unit;
  std::uint64_t n{};  ///< samples behind it
  Json ours;          ///< {value, low, high}: median and range of the rounds, or the whole run's figure
  std::string peer;   ///< empty: no peer
  Json theirs;
  Json ratio;        ///< {value, low, high}
  std::string goal;  ///< in words, empty: none
  Json met;          ///< true, false, or null where there is no goal
};

/// {value, low, high} of rounds; of one number.
Json spread(const Rounds& rounds);
Json spread(double value);

/// What the parts fill.
class Report {  // NOLINT(bugprone-exception-escape)
 public:
  void add(const Figure& figure);
  /// A peer or a part that could not run: what, why, and the cure.
  void skip(const std::string& what, const std::string& why);
  /// A line below the table of a group.
  void note(const std::string& group, const std::string& words);
  /// A table beside the figures: `rows` are arrays as long as `columns`, of texts and numbers.
  void add_table(const std::string& group, const std::vector<std::string>& columns, const Json& rows);
  /// A whole distribution for the plots; durations in ns.
  void add_distribution(const std::string& name, const rt::LatencyHistogram& histogram);
  /// The same in 1-us bins of another program.
  void add_distribution(const std::string& name, const std::vector<std::uint64_t>& bins_us,
                        std::uint64_t max_us);
  Json& root() { return root_; }

 private:
  Json root_;
};

/// "a at most b" in words and as verdict.
void set_goal(Figure& figure, const std::string& words, bool met);

}  // namespace sortie::bench
