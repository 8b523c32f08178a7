// SPDX-License-Identifier: BSD-3-Clause
// What the report shows of recognised places: each line joins a segment with its target, each answer is in
// the table once, and a place that was refused is shown with its reason.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "tests/firmware_like/recognise_rig.hpp"
#include "tests/firmware_like/xml_check.hpp"
#include "toolchain/report/html.hpp"
#include "toolchain/report/recognised_places.hpp"

namespace sortie::testing {
namespace {

using rt::RecognisedPlace;
using toolchain::Mark;
using toolchain::Plot;
using toolchain::Series;

const Series* series_with(const Plot& plot, const std::string& part) {
  for (const Series& series : plot.series)
    if (series.name.find(part) != std::string::npos) return &series;
  return nullptr;
}

/// Four segments, three of them matched, on a known map that is turned by 90 degrees and moved by (10, 2).
toolchain::RecognisedLook three_of_four(std::uint8_t verdict) {
  toolchain::RecognisedLook look;
  look.answer.time_s = 12.34;
  RecognisedPlace& place = look.answer.place;
  place.verdict = verdict;
  place.stamp_ns = 3;
  place.p_known_odom_m[0] = 10;
  place.p_known_odom_m[1] = 2;
  place.q_known_odom[0] = place.q_known_odom[3] = std::sqrt(0.5);
  place.agree = 3;
  place.rival = 1;
  place.share = 0.97;
  place.crossed = 0.012;
  for (std::uint16_t i = 0; i < 3; ++i) {
    const mapping::PlaceCm segment{100 * i, 150 * i * i, 50};
    look.matched.push_back(
        {{i, i}, segment, {1000 - segment.y, 200 + segment.x, segment.z}});  // exactly where it belongs
  }
  look.others.push_back({400, 100, 30});
  look.others.push_back({400, -5000, 30});  // beyond what is shown
  for (int i = 0; i < 60; ++i) look.seen.push_back({0.1 * i, 3.0, i % 2 == 0 ? 0.0 : 1.0});
  return look;
}

toolchain::KnownPlaces known_places() {
  toolchain::KnownPlaces known;
  for (int i = 0; i < 5; ++i) {
    known.targets.push_back({900 + 20 * i, 300, 40});
    known.voxels.push_back(100u << i);
  }
  known.targets.push_back({9000, 300, 40});  // beyond the walls
  known.voxels.push_back(400);
  known.surfaces_m.push_back({8.0, 0.0, 8.0, 6.0});
  return known;
}

std::vector<firmware::TimedPose> way() {
  std::vector<firmware::TimedPose> poses(5);
  for (int i = 0; i < 5; ++i) {
    poses[static_cast<std::size_t>(i)].stamp_ns = i;
    poses[static_cast<std::size_t>(i)].p[0] = i;
  }
  return poses;
}

/// Rows of the table: verdict's words, and answers.
std::vector<std::pair<std::string, std::uint64_t>> rows_of(const std::string& section) {
  std::vector<std::pair<std::string, std::uint64_t>> rows;
  const std::string first = "<tr><td class=\"n\">";
  for (std::size_t at = section.find(first); at != std::string::npos; at = section.find(first, at + 1)) {
    const std::size_t count = section.find("<td class=\"n\">", at + first.size()) + 14;
    const std::size_t words = section.find("</svg> ", count) + 7;
    rows.emplace_back(section.substr(words, section.find("</td>", words) - words),
                      std::stoull(section.substr(count)));
  }
  return rows;
}

/// What the log's own fields say of each answer, without the vehicle: verdict and segments that agree.
struct AnswerFields {
  double stamp_ns{};
  std::uint8_t verdict{};
  std::size_t agree{};
};

/// The newest answer in a job's output, as `export csv` reads it.
bool read_answer(const rt::JobRecord& record, firmware::Runtime& runtime, AnswerFields& answer) {
  std::uint32_t offset = 0;
  for (const rt::TaskBase* task : runtime.executive().group(record.group).tasks) {
    if (std::string("recognise") == task->name() && offset + task->output_bytes() <= record.field_bytes) {
      task->describe(record.fields + offset, {&answer, [](void* self, const char* name, int, double value,
                                                          std::uint64_t, std::uint32_t) {
                                                auto& into = *static_cast<AnswerFields*>(self);
                                                if (std::string(name) == "stamp_ns") into.stamp_ns = value;
                                                if (std::string(name) == "verdict")
                                                  into.verdict = static_cast<std::uint8_t>(value);
                                                if (std::string(name) == "agree")
                                                  into.agree = static_cast<std::size_t>(value);
                                              }});
      return true;
    }
    offset += task->output_bytes();
  }
  return false;
}

/// A replay that is followed as the report does it, and what its fields say.
struct Followed {
  toolchain::RecognisedPlaces places;
  std::vector<AnswerFields> fields;  ///< of each job whose output is another one than before
  firmware::ReplayOutcome outcome;
  Followed(const std::string& log, firmware::ReplayOptions options) {
    options.on_job = [this](const rt::JobRecord& record, firmware::Runtime& runtime) {
      places.job(record, runtime);
      AnswerFields answer;
      if (!read_answer(record, runtime, answer) || answer.verdict == RecognisedPlace::kNone) return;
      if (fields.empty() || fields.back().stamp_ns != answer.stamp_ns ||
          fields.back().verdict != answer.verdict || fields.back().agree != answer.agree)
        fields.push_back(answer);
    };
    outcome = replay_log(log, options);
  }
};

std::size_t lines_in(const Plot& plot) {
  const Series* lines = series_with(plot, "segments that agree");
  return lines == nullptr ? 0 : lines->x.size() / 3;
}

}  // namespace

TEST_CASE("A picture of a place joins each segment with its target, and lays the way where the answer says") {
  const toolchain::RecognisedLook look = three_of_four(RecognisedPlace::kRecognised);
  const Plot plot = plot_recognised(look, known_places(), way());
  const Series* lines = series_with(plot, "3 segments that agree");
  REQUIRE(lines != nullptr);
  REQUIRE(lines->x.size() == 9);
  CHECK(lines->colour == toolchain::kGreen);
  // Segments are all moved by the same, targets not at all.
  for (std::size_t i = 0; i < 3; ++i) {
    const mapping::SweptPair& pair = look.matched[i];
    CHECK(std::fabs(lines->x[3 * i + 1] - 0.01 * pair.target.x) < 1e-9);
    CHECK(std::fabs(lines->y[3 * i + 1] - 0.01 * pair.target.y) < 1e-9);
    CHECK(std::fabs(lines->x[3 * i] - lines->x[0] - 0.01 * pair.segment.x) < 1e-9);
    CHECK(std::fabs(lines->y[3 * i] - lines->y[0] - 0.01 * pair.segment.y) < 1e-9);
    CHECK(std::isnan(lines->x[3 * i + 2]));
  }
  const Series* targets = series_with(plot, "targets");
  REQUIRE(targets != nullptr);
  REQUIRE(targets->sizes.size() == 5);
  for (std::size_t i = 1; i < 5; ++i) CHECK(targets->sizes[i] > targets->sizes[i - 1]);
  REQUIRE(series_with(plot, "match none") != nullptr);
  CHECK(series_with(plot, "match none")->x.size() == 1);
  // The two maps do not lie on each other.
  const double moved_x = lines->x[0];
  for (const double x : series_with(plot, "match none")->x) CHECK(x < 8.0);
  CHECK(moved_x + 5.9 < 8.0);
  // The way ends with the answer: four of five poses, from where the robot began on the known map.
  const Series* laid = nullptr;
  for (const Series& series : plot.series)
    if (series.name.empty() && series.mark == Mark::line && series.labels.empty()) laid = &series;
  REQUIRE(laid != nullptr);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(std::fabs(laid->x[i] - 10.0) < 1e-9);
    CHECK(std::fabs(laid->y[i] - 2.0 - static_cast<double>(i)) < 1e-9);
  }
  CHECK(std::isnan(laid->x[4]));
  CHECK_FALSE(laid->dashed);
  const std::string svg = toolchain::render(plot);
  CHECK(xml_fault(svg).empty());
  CHECK(svg.find("After 12.3 s recognised") != std::string::npos);
  CHECK(svg.find("97 % on surfaces") != std::string::npos);
  CHECK(svg.find("> m</text>") == std::string::npos);
  CHECK(svg.find(" m</text>") != std::string::npos);  // the scale bar

  // Without a map of surfaces, without a way, without a local map.
  toolchain::RecognisedLook bare = look;
  bare.seen.clear();
  toolchain::KnownPlaces targets_alone = known_places();
  targets_alone.surfaces_m.clear();
  CHECK(xml_fault(toolchain::render(plot_recognised(bare, targets_alone, {}))).empty());
}

TEST_CASE("A refused place is shown in another colour with its reason, one that is not verified in a third") {
  for (const auto& [verdict, colour, words] :
       {std::tuple{RecognisedPlace::kRefused, toolchain::kVermilion, "refused: segments agree, but the scan"},
        {RecognisedPlace::kAmbiguous, toolchain::kVermilion, "ambiguous: another place has nearly as many"},
        {RecognisedPlace::kNarrow, toolchain::kVermilion, "narrow"},
        {RecognisedPlace::kUnverified, toolchain::kOrange, "unverified"}}) {
    INFO(words);
    const Plot plot = plot_recognised(three_of_four(verdict), known_places(), way());
    REQUIRE(series_with(plot, "agree") != nullptr);
    CHECK(series_with(plot, "agree")->colour == colour);
    CHECK(plot.title.find(words) != std::string::npos);
    CHECK((plot.title.find("% on surfaces") != std::string::npos) == (verdict == RecognisedPlace::kRefused));
  }
}

TEST_CASE("The table has a row for answers of one verdict that follow one another") {
  toolchain::RecognisedReport report;
  const std::uint8_t verdicts[] = {3, 3, 3, 7, 9, 9, 1, 1, 1, 1, 3};
  for (std::size_t i = 0; i < std::size(verdicts); ++i) {
    toolchain::RecognisedAnswer answer;
    answer.time_s = 1.0 * static_cast<double>(i);
    answer.place.verdict = verdicts[i];
    answer.place.agree = verdicts[i] == 3 ? 0 : static_cast<std::uint32_t>(i);
    report.answers.push_back(answer);
  }
  const std::string section = recognised_section(report);
  const auto rows = rows_of(section);
  REQUIRE(rows.size() == 5);
  const std::uint64_t counts[] = {3, 1, 2, 4, 1};
  for (std::size_t i = 0; i < 5; ++i) CHECK(rows[i].second == counts[i]);
  CHECK(rows[1].first == "ambiguous: another place has nearly as many");
  CHECK(section.find(">6 to 9<") != std::string::npos);  // of the four
  CHECK(section.find(">0.0 to 2.0<") != std::string::npos);
  CHECK(toolchain::recognised_section({}).empty());
}

TEST_CASE(
    "A run that enters from the other side has its lines in the report, and its reason where it is refused",
    "[heavy]") {
  const TempFolder folder;
  const std::string log = folder.file("again.lcm");
  const firmware::LiveRunOutcome run = run_entering(45, log, {});
  CHECK(run.failures.empty());
  CHECK(counted(run, "recognise_recognised") >= 3);
  firmware::ReplayOptions options;
  options.maps = seen_hall().kept;
  Followed followed(log, options);
  CHECK(followed.outcome.results.digest == run.results.digest);

  // As many answers as there are outputs, of the same verdicts and sets.
  const auto& answers = followed.places.answers();
  REQUIRE(answers.size() == followed.fields.size());
  std::map<std::uint8_t, std::size_t> newest;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    CHECK(answers[i].place.verdict == followed.fields[i].verdict);
    CHECK(answers[i].place.agree == followed.fields[i].agree);
    newest[followed.fields[i].verdict] = followed.fields[i].agree;
  }
  toolchain::RecognisedReport report = report_of(followed.places, followed.outcome.estimate);
  CHECK(lines_in(report.accepted) == newest.at(RecognisedPlace::kRecognised));
  CHECK(lines_in(report.accepted) >= 6);
  // Where it is: the odometry's world lies turned about, 14 m along; its segments lie on their targets.
  const toolchain::RecognisedLook& look = *followed.places.accepted();
  CHECK(std::fabs(look.answer.place.p_known_odom_m[0] - 14.0) < 0.3);
  CHECK(std::fabs(look.answer.place.p_known_odom_m[1]) < 0.3);
  for (const mapping::SweptPair& pair : look.matched)
    CHECK(std::hypot(1400 - pair.segment.x - pair.target.x, -pair.segment.y - pair.target.y) < 60.0);
  CHECK(followed.places.known().targets.size() > 20);
  CHECK(followed.places.known().surfaces_m.size() > 100);
  CHECK(error_of(run.results, "located_ate_max_m") < 0.15);

  // The page: the section, a row for each span, as many answers as the counters have.
  toolchain::ReportInput input;
  input.results = followed.outcome.results;
  input.recognised = report;
  const std::string page = render_report(input);
  CHECK(xml_fault(page).empty());
  CHECK(page.find("Recognised places") != std::string::npos);
  std::map<std::string, std::uint64_t> told;
  for (const auto& [words, count] : rows_of(recognised_section(report))) told[words] += count;
  const auto words = [](std::uint8_t verdict) {
    return toolchain::escape_xml(toolchain::verdict_words(verdict));
  };
  CHECK(told[words(RecognisedPlace::kRecognised)] == counted(run, "recognise_recognised"));
  CHECK(told[words(RecognisedPlace::kRefused)] == counted(run, "recognise_refused"));
  CHECK(told[words(RecognisedPlace::kFew)] == counted(run, "recognise_searches_few"));
  CHECK(told[words(RecognisedPlace::kInconsistent)] == counted(run, "recognise_searches_inconsistent"));
  CHECK(told[words(RecognisedPlace::kAmbiguous)] == counted(run, "recognise_searches_ambiguous"));

  // What if nothing that a scan says were enough: places are refused, and say so.
  options.overrides = {"recognise.over_unexplained=100"};
  const Followed refused(log, options);
  CHECK_FALSE(refused.places.accepted());
  REQUIRE(refused.places.refused());
  report = report_of(refused.places, refused.outcome.estimate);
  CHECK(report.accepted.series.empty());
  std::size_t agree = 0;
  for (const AnswerFields& answer : refused.fields)
    if (answer.agree > 0) agree = answer.agree;
  CHECK(lines_in(report.refused) == agree);
  CHECK(recognised_section(report).find("refused: segments agree, but the scan does not fit") !=
        std::string::npos);

  // Who knows nothing recognises nothing, and a run without the part has no such section.
  options = {};
  const Followed first(seen_hall().log, options);
  CHECK(first.places.answers().empty());
  input.recognised = report_of(first.places, first.outcome.estimate);
  CHECK(render_report(input).find("Recognised places") == std::string::npos);
}

}  // namespace sortie::testing
