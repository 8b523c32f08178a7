// SPDX-License-Identifier: BSD-3-Clause
// Places with few things or none: what height images say of them, beside segments.
#include <algorithm>
#include <cmath>
#include <string>

#include "tests/bench/recognition/bare_worlds.hpp"
#include "tests/bench/recognition/recognition_parts.hpp"
#include "tests/bench/recognition/recognition_trials.hpp"

namespace sortie::bench {
namespace {

constexpr int kWorlds = 6;  ///< of a row

/// Worlds in which a place was told, and in which any that was told is wrong.
struct ToldWorlds {
  int right{}, wrong{};
  void add(bool any_right, bool any_wrong) {
    right += any_right && !any_wrong ? 1 : 0;
    wrong += any_wrong ? 1 : 0;
  }
  ToldWorlds& operator+=(const ToldWorlds& other) {
    right += other.right;
    wrong += other.wrong;
    return *this;
  }
};

struct BareTally {
  int worlds{};
  ToldWorlds found, placed, confirmed,
      segments;                  ///< by images; by a scan, too; by two looks; by segments and a scan
  std::size_t looks{}, by[7]{};  ///< verdicts
  Rounds ms, off_m, off_deg, way_m;
  std::string wrong_seeds;

  void add(const RecognitionTrial& trial, std::uint64_t seed) {
    ++worlds;
    bool right[4]{}, wrong[4]{};
    for (const RecognitionLook& look : trial.looks) {
      const auto note = [&](int i, const std::optional<PoseError>& told) {
        if (told) (trial.is_kept && told->is_right() ? right[i] : wrong[i]) = true;
      };
      const ImageLook& image = look.image;
      ++looks;
      ++by[static_cast<std::size_t>(image.verdict)];
      if (image.units > 0) ms.add(image.ms);
      if (image.placed && image.placed->is_right() && trial.is_kept && !right[1]) {
        way_m.add(look.way_m);
        off_m.add(image.best->move_m);
        off_deg.add(image.best->turn_deg);
      }
      if (image.verdict == mapping::ImageVerdict::found) note(0, image.best);
      note(1, image.placed);
      if (image.confirmed) note(2, image.placed);
      note(3, look.placed);
    }
    found.add(right[0], wrong[0]);
    placed.add(right[1], wrong[1]);
    confirmed.add(right[2], wrong[2]);
    segments.add(right[3], wrong[3]);
    if (wrong[0]) wrong_seeds += " " + std::to_string(seed) + (wrong[2] ? "!!" : wrong[1] ? "!" : "");
  }
  /// Of the looks, in percent.
  double share(mapping::ImageVerdict verdict) const {
    const double all = static_cast<double>(std::max<std::size_t>(looks, 1));
    return std::round(100.0 * static_cast<double>(by[static_cast<std::size_t>(verdict)]) / all);
  }
};

Json rounded(const Rounds& rounds, double share, double steps) {
  return rounds.empty() ? Json("-") : Json(std::round(steps * rounds.quantile(share)) / steps);
}

}  // namespace

void measure_recognition_images(const RecognitionSettings& settings, Report& report) {
  using mapping::ImageVerdict;
  const int worlds = settings.cases_or(kWorlds);
  Json rows = Json::array(), verdicts = Json::array();
  ToldWorlds found, placed, confirmed, segments;
  for (const BareKind kind : kBareKinds) {
    for (const BareTruth truth : kBareTruths) {
      BareTally tally;
      for (int i = 0; i < worlds; ++i) {
        const std::uint64_t seed = settings.seed + static_cast<std::uint64_t>(i);
        testing::Draws draws(seed);
        const RecognitionWorld world = bare_world(kind, truth, draws);
        TrialConfig config;
        config.images = true;
        config.sparse = false;
        config.most_way_m = 16.0;
        tally.add(try_recognition(world, config, draws), seed);
      }
      rows.push_back({name_of(kind), name_of(truth), tally.worlds, tally.found.right, tally.found.wrong,
                      tally.placed.right, tally.placed.wrong, tally.confirmed.right, tally.confirmed.wrong,
                      tally.segments.right, tally.segments.wrong, rounded(tally.way_m, 0.5, 10),
                      rounded(tally.off_m, 0.5, 100), rounded(tally.off_deg, 0.5, 10)});
      verdicts.push_back({name_of(kind), name_of(truth), tally.looks, tally.share(ImageVerdict::found),
                          tally.share(ImageVerdict::ambiguous), tally.share(ImageVerdict::narrow),
                          tally.share(ImageVerdict::unlike), tally.share(ImageVerdict::few),
                          tally.share(ImageVerdict::undecided), rounded(tally.ms, 0.5, 10),
                          rounded(tally.ms, 1.0, 10)});
      found += tally.found;
      placed += tally.placed;
      confirmed += tally.confirmed;
      segments += tally.segments;
      if (!tally.wrong_seeds.empty())
        report.note("images",
                    std::string(name_of(kind)) + ", " + name_of(truth) +
                        ": images say a wrong place (!: a scan does, too; !!: two looks) in worlds" +
                        tally.wrong_seeds + ".");
    }
  }
  const auto add_figure = [&](const char* what, int value, bool is_goal) {
    Figure figure;
    figure.group = "images";
    figure.what = what;
    figure.n = static_cast<std::uint64_t>(worlds) * std::size(kBareKinds) * std::size(kBareTruths);
    figure.ours = spread(value);
    if (is_goal) set_goal(figure, "none", value == 0);
    report.add(figure);
  };
  add_figure("worlds in which two looks at images place a lost robot wrongly", confirmed.wrong, true);
  add_figure("worlds in which one look and a scan do", placed.wrong, true);
  add_figure("worlds in which images alone do", found.wrong, false);
  add_figure("worlds in which one look and a scan place rightly", placed.right, false);
  add_figure("worlds in which segments and a scan do", segments.right, false);
  report.add_table("images",
                   {"place", "second visit", "n", "found by images", "wrongly", "placed by one look",
                    "wrongly", "by two looks", "wrongly", "by segments and a scan", "wrongly",
                    "way, m (median)", "images off, m", "deg"},
                   rows);
  report.add_table("images: looks, % by verdict",
                   {"place", "second visit", "looks", "found", "ambiguous", "narrow", "unlike", "few",
                    "undecided", "ms (median)", "most"},
                   verdicts);
  report.note("images",
              "Seeds " + std::to_string(settings.seed) + " to " +
                  std::to_string(settings.seed + static_cast<std::uint64_t>(worlds) - 1) +
                  " of each row; local maps of 20 m, 16 m of way, a look a metre. Wrong: more than 1 m "
                  "or 5 degrees off, or any place where nothing was kept; a world counts as wrong "
                  "where any look is.");
}

}  // namespace sortie::bench
