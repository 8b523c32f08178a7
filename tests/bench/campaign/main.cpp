// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-campaign: hostile random sequences for every module. `sortie bench campaign` runs it and shows
// the table.
#include <chrono>
#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <stdexcept>

#include "tests/bench/campaign/campaign.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

namespace {

struct CampaignArguments {
  std::string only;
  std::string replay;
  std::uint64_t count{1000};
  std::uint64_t seed{};
  bool has_seed{};
};

CampaignArguments read_arguments(int argc, char** argv) {
  CampaignArguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (++i >= argc) throw std::invalid_argument("unknown option, or no value: " + option);
    if (option == "--only") {
      arguments.only = argv[i];
      if (find_campaign_module(arguments.only) == nullptr)
        throw std::invalid_argument("no module " + arguments.only);
    } else if (option == "--replay") {
      arguments.replay = argv[i];
    } else if (option == "--count") {
      arguments.count = static_cast<std::uint64_t>(number("--count", argv[i], 1, 1e9));
    } else if (option == "--seed") {
      arguments.seed = static_cast<std::uint64_t>(number("--seed", argv[i], 0, 9e15));
      arguments.has_seed = true;
    } else {
      throw std::invalid_argument("unknown option " + option);
    }
  }
  return arguments;
}

std::string hex_text(std::uint64_t value) {
  char text[24];
  std::snprintf(text, sizeof text, "%016" PRIx64, value);
  return text;
}

Json row_of(const CampaignModule& module, const CampaignResult& result, double seconds) {
  Json row = {{"group", module.group},
              {"module", module.name},
              {"tries", module.tries},
              {"keeps", module.keeps},
              {"sequences", result.sequences},
              {"operations", result.operations},
              {"given", result.sum.given},
              {"accepted", result.sum.accepted},
              {"refused", result.sum.refused},
              {"checks", result.sum.checks},
              {"digest", hex_text(result.sum.digest)},
              {"seconds", seconds},
              {"met", result.failed == 0}};
  if (result.failed != 0) {
    row["fault"] = result.sum.fault;
    row["number"] = result.failing_number;
    row["shrink_runs"] = result.shrink_runs;
    row["sequence"] = sequence_text(module.name, result.reduced);
  }
  return row;
}

// A sequence from a file, as often as it is asked for.
Json replay_row(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::invalid_argument("cannot read " + path);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::string name;
  const std::vector<CampaignOp> ops = read_sequence(text, name);
  const CampaignModule* module = find_campaign_module(name);
  if (module == nullptr) throw std::invalid_argument(path + ": no module " + name);
  CampaignResult result;
  result.module = module;
  result.sequences = 1;
  result.operations = ops.size();
  result.sum = try_sequence(*module, ops);
  result.failed = result.sum.fault.empty() ? 0 : 1;
  result.reduced = ops;
  return row_of(*module, result, 0.0);
}

// What cannot go on says at least where it was; the signal then does what it would have done.
CampaignPlace at_work;

extern "C" void tell_place(int signal) {
  std::fprintf(stderr, "campaign: died in module %s, sequence %" PRIu64 " of the seed\n", at_work.module,
               at_work.number);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

int run_program(int argc, char** argv) {
  CampaignArguments arguments = read_arguments(argc, argv);
  for (const int signal : {SIGSEGV, SIGFPE, SIGABRT, SIGBUS, SIGILL}) std::signal(signal, tell_place);
  // 53 bits: a seed that any reader of the JSON keeps whole.
  if (!arguments.has_seed) {
    std::random_device device;
    arguments.seed = (std::uint64_t{device()} << 21) ^ device();
  }
  Json root;
  root["settings"] = {{"only", arguments.only}, {"seed", arguments.seed}, {"count", arguments.count}};
  Json rows = Json::array();
  if (!arguments.replay.empty()) {
    rows.push_back(replay_row(arguments.replay));
  } else {
    std::cerr << "campaign: seed " << arguments.seed << "\n";
    for (const CampaignModule& module : campaign_modules()) {
      if (!arguments.only.empty() && arguments.only != module.name) continue;
      std::cerr << "campaign: " << module.name << "\n";
      const auto begin = std::chrono::steady_clock::now();
      const CampaignResult result = run_campaign(module, arguments.seed, arguments.count, &at_work);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
      rows.push_back(row_of(module, result, took.count()));
    }
  }
  root["figures"] = rows;
  std::cout << root.dump() << std::endl;
  return 0;
}

}  // namespace

}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-campaign",
                                     [argc, argv] { return sortie::bench::run_program(argc, argv); });
}
