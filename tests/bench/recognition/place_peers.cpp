// SPDX-License-Identifier: BSD-3-Clause
// How well places of different visits are told apart: by segments that agree, beside two published
// descriptors of places, made again, on the same pairs.
#include <algorithm>
#include <functional>

#include "tests/bench/recognition/described_place.hpp"
#include "tests/bench/recognition/owned_sets.hpp"
#include "tests/bench/recognition/recognition_parts.hpp"
#include "tests/bench/recognition/roc_figures.hpp"

namespace sortie::bench {
namespace {

constexpr int kHalls = 16;  ///< those of `descriptors`
constexpr double kSame_m = 5.0, kElsewhere_m = 10.0;

enum class Family { ours, solid, density };

/// A way to say how unlike two places are.
struct PlaceMethod {
  std::string name;
  Family family;
  std::function<double(const DescribedPlace& known, const DescribedPlace& asked)> distance;
};

std::vector<PlaceMethod> all_methods(AgreeingSegments& agreeing) {
  std::vector<PlaceMethod> methods;
  methods.push_back({"segments that agree", Family::ours,
                     [&agreeing](const DescribedPlace& known, const DescribedPlace& asked) {
                       return -static_cast<double>(agreeing.count(known, asked));
                     }});
  for (std::size_t i = 0; i < std::size(kSolids); ++i) {
    methods.push_back(
        {kSolids[i].name, Family::solid, [i](const DescribedPlace& known, const DescribedPlace& asked) {
           return solid_distance(known.solid[i], asked.solid[i]);
         }});
  }
  for (std::size_t i = 0; i < std::size(kPixels_m); ++i) {
    const auto centimetres = static_cast<int>(std::lround(100.0 * kPixels_m[i]));
    methods.push_back(
        {"density image, " + std::to_string(centimetres) + " cm" + (i == 0 ? ", as published" : ""),
         Family::density, [i](const DescribedPlace& known, const DescribedPlace& asked) {
           return -static_cast<double>(agreeing_features(known.features[i], asked.features[i]));
         }});
  }
  return methods;
}

/// Pairs of a place of a first visit and one of a second visit.
struct PlacePairs {
  std::vector<JudgedPair> other_halls;  ///< the same, or of another hall
  std::vector<JudgedPair> same_hall;    ///< the same, or of the same hall, 10 m away or more
  double us_a_pair{};
};

PlacePairs judge(const PlaceMethod& method, const std::vector<DescribedPlace>& known,
                 const std::vector<DescribedPlace>& asked) {
  PlacePairs pairs;
  const double begin = set_cpu_ms();
  for (const DescribedPlace& a : known) {
    for (const DescribedPlace& b : asked) {
      const double apart_m = rt::norm(a.at - b.at);
      const bool same = a.hall == b.hall && apart_m <= kSame_m;
      const bool elsewhere = a.hall == b.hall && apart_m >= kElsewhere_m;
      const JudgedPair pair{method.distance(a, b), same, a.hall};
      if (same || a.hall != b.hall) pairs.other_halls.push_back(pair);
      if (same || elsewhere) pairs.same_hall.push_back(pair);
    }
  }
  pairs.us_a_pair = 1e3 * (set_cpu_ms() - begin) / static_cast<double>(known.size() * asked.size());
  return pairs;
}

/// What a method came to.
struct MethodArea {
  Family family{};
  std::string name;
  RocCurve roc;
  std::vector<double> drawn;  ///< areas
};

void add_figure(const MethodArea& ours, const MethodArea& theirs, std::size_t pairs, Report& report) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < ours.drawn.size(); ++i) ratios.push_back(ours.drawn[i] / theirs.drawn[i]);
  Figure figure;
  figure.group = "places";
  figure.what = "area under the ROC curve, places";
  figure.n = pairs;
  figure.ours = drawn_range(ours.roc.area(), ours.drawn);
  figure.peer = theirs.name;
  figure.theirs = drawn_range(theirs.roc.area(), theirs.drawn);
  figure.ratio = drawn_range(ours.roc.area() / theirs.roc.area(), ratios);
  set_goal(figure, "more", ours.roc.area() > theirs.roc.area());
  report.add(figure);
}

/// The best one of a family on these very pairs, which favours it.
const MethodArea& best_of(Family family, const std::vector<MethodArea>& all) {
  const MethodArea* best = nullptr;
  for (const MethodArea& one : all) {
    if (one.family == family && (best == nullptr || one.roc.area() > best->roc.area())) best = &one;
  }
  return *best;
}

/// The remade peers see a place that is turned as the same one.
std::string turned_places(const HallPlace& place, const DescribedPlace& described) {
  const rt::Quaternion turn = rt::from_yaw_pitch_roll(0.7, 0, 0);
  HallPlace turned = place;
  for (rt::Vector3& p : turned.voxels) p = rt::rotate(turn, p);
  for (rt::Vector3& p : turned.scan) p = rt::rotate(turn, p);
  const DescribedPlace again(turned);
  std::string words = "A place of the first hall and itself, turned by 40 degrees: SOLiD's distance " +
                      std::to_string(solid_distance(described.solid[3], again.solid[3])).substr(0, 6);
  for (std::size_t i = 0; i < std::size(kPixels_m); ++i) {
    words += ", of " + std::to_string(described.features[i].size()) + " features in pixels of " +
             std::to_string(std::lround(100 * kPixels_m[i])) + " cm " +
             std::to_string(agreeing_features(described.features[i], again.features[i])) + " agree";
  }
  return words + ".";
}

}  // namespace

void measure_recognition_places(const RecognitionSettings& settings, Report& report) {
  std::vector<DescribedPlace> known, asked;
  std::vector<double> by_way[3];
  const int halls = settings.cases_or(kHalls);
  for (std::vector<double>& times : by_way) times.assign(static_cast<std::size_t>(halls), 0.0);
  std::string turned;
  for_places(halls, settings.seed, [&](const HallPlace& place) {
    std::vector<DescribedPlace>& list = place.visit == 0 ? known : asked;
    list.emplace_back(place);
    by_way[static_cast<int>(place.way)][place.hall] = 1.0;
    if (place.hall == 0 && place.visit == 0) turned = turned_places(place, list.back());
  });
  AgreeingSegments agreeing;
  std::vector<MethodArea> all;
  Json rows = Json::array();
  const DrawnHalls draws(static_cast<std::size_t>(halls), settings.seed);
  Picture picture{"bench-recognition-places",
                  "places",
                  "Places of two visits",
                  "different places accepted",
                  "same places found",
                  false,
                  false,
                  false,
                  {}};
  std::size_t pair_count = 0, same = 0, elsewhere = 0;
  for (const PlaceMethod& method : all_methods(agreeing)) {
    const PlacePairs pairs = judge(method, known, asked);
    pair_count = pairs.other_halls.size();
    same = static_cast<std::size_t>(std::count_if(pairs.other_halls.begin(), pairs.other_halls.end(),
                                                  [](const JudgedPair& pair) { return pair.same; }));
    elsewhere = pairs.same_hall.size() - same;
    MethodArea area{method.family, method.name, RocCurve(pairs.other_halls), {}};
    area.drawn = draws.areas(area.roc);
    const Json range = drawn_range(area.roc.area(), area.drawn);
    rows.push_back({method.name, range["value"], range["low"], range["high"],
                    percent(area.roc.found_at(0.001)), percent(area.roc.found_at(0.01)),
                    percent(area.roc.found_at(0.1)), thousandths(area.roc.area(by_way[0])),
                    thousandths(area.roc.area(by_way[1])), thousandths(area.roc.area(by_way[2])),
                    thousandths(RocCurve(pairs.same_hall).area()), std::round(10 * pairs.us_a_pair) / 10});
    picture.curves.push_back(roc_line(area.roc, method.name,
                                      method.family == Family::solid  ? "dashed"
                                      : method.family == Family::ours ? ""
                                                                      : "grey"));
    all.push_back(std::move(area));
  }
  add_figure(all[0], best_of(Family::solid, all), pair_count, report);
  add_figure(all[0], best_of(Family::density, all), pair_count, report);
  report.add_table("places",
                   {"by", "area", "5 %", "95 %", "found at 0.1 % false, %", "at 1 %", "at 10 %",
                    "same direction", "opposite", "across", "elsewhere in the hall", "us a pair"},
                   rows);
  add_picture(report, picture);
  report.note("places",
              "The halls of `descriptors`; a place each 3 m of either visit, with a local map of 20 m that "
              "began with the visit, smooth segments. Same: at most 5 m apart, " +
                  std::to_string(same) + " pairs; different: of another hall, " +
                  std::to_string(pair_count - same) + ". The last but one column: of the same hall, 10 m " +
                  "apart or more, " + std::to_string(elsewhere) +
                  ", whose local maps overlap. The figures take the settings of a peer that do best on "
                  "these pairs.");
  report.note("places", turned);
}

}  // namespace sortie::bench
