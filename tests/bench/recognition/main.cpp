// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-recognition: sets of correspondences that agree, beside PCL's grouping, CLIPPER and ROBIN;
// descriptors beside seven features; places beside SOLiD and density images; places that are told where there
// is none, and those that are, on recorded ways, too. Prints one JSON object; `sortie bench recognition` runs
// it and shows the tables.
#include "tests/bench/recognition/recognition_parts.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/parts.hpp"

namespace sortie::bench {
namespace {

constexpr BenchPart<RecognitionSettings> kRecognitionParts[] = {
    {"streets", measure_recognition_streets},   {"outliers", measure_recognition_outliers},
    {"graphs", measure_recognition_graphs},     {"descriptors", measure_recognition_descriptors},
    {"deceive", measure_recognition_deceive},   {"revisits", measure_recognition_revisits},
    {"places", measure_recognition_places},     {"sweep", measure_recognition_sweep},
    {"evidence", measure_recognition_evidence}, {"rest", measure_recognition_rest},
    {"visits", measure_recognition_visits},     {"loops", measure_recognition_loops},
    {"images", measure_recognition_images}};

int run(int argc, char** argv) {
  RecognitionSettings settings;
  settings.data = SORTIE_DATA_DIR;
  std::string only;
  read_arguments(argc, argv,
                 {{"--cases", settings.cases, 1, 1e6},
                  {"--seed", settings.seed, 0, 1e9},
                  {"--data", settings.data},
                  {"--only", only}});
  print_parts<RecognitionSettings>(kRecognitionParts, settings, only,
                                   {{"cases", settings.cases}, {"seed", settings.seed}});
  return 0;
}

}  // namespace
}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-recognition",
                                     [argc, argv] { return sortie::bench::run(argc, argv); });
}
