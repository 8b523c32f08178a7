// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench rt`, `plant`, `mapping`, `registration`, `uav`, `stability`, `campaign`, `rays`: one command
// a benchmark that has a program of its own.
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/result/results.hpp"
#include "toolchain/bench/peer_front.hpp"
#include "toolchain/bench/peer_program.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/export/output_file.hpp"

namespace sortie::toolchain {

namespace {

struct PeerCommand {
  PeerFront front;  // holds the values of its options
  std::string program;
  unsigned passes{1};
  OutputOptions output;
};

firmware::Option* add(firmware::Command& command, PeerOption& option) {
  const auto add_number = [&](auto& value, auto low, auto high) {
    return command.add_option(option.name, value, option.about)->in_range(low, high)->capture_default_str();
  };
  if (auto* whole = std::get_if<int>(&option.value))
    return add_number(*whole, static_cast<int>(option.low), static_cast<int>(option.high));
  if (auto* real = std::get_if<double>(&option.value)) return add_number(*real, option.low, option.high);
  if (auto* count = std::get_if<std::uint64_t>(&option.value))
    return add_number(*count, static_cast<std::uint64_t>(option.low),
                      static_cast<std::uint64_t>(option.high));
  if (auto* flag = std::get_if<bool>(&option.value))
    return command.add_flag(option.name, *flag, option.about);
  firmware::Option* added = nullptr;
  if (auto* given = std::get_if<std::optional<std::uint64_t>>(&option.value)) {
    added = command.add_option(option.name, *given, option.about);
    added->in_range(static_cast<std::uint64_t>(option.low), static_cast<std::uint64_t>(option.high));
  } else {
    added = command.add_option(option.name, std::get<std::string>(option.value), option.about);
    if (!option.choices.empty()) added->one_of(option.choices);
  }
  if (!option.type.empty()) added->type_name(option.type);
  return added;
}

std::string text_of(const PeerOption& option) {
  if (const auto* text = std::get_if<std::string>(&option.value)) return *text;
  if (const auto* flag = std::get_if<bool>(&option.value)) return *flag ? "yes" : "";
  if (const auto* whole = std::get_if<int>(&option.value)) return std::to_string(*whole);
  if (const auto* real = std::get_if<double>(&option.value)) return std::to_string(*real);
  if (const auto* count = std::get_if<std::uint64_t>(&option.value)) return std::to_string(*count);
  const auto& given = std::get<std::optional<std::uint64_t>>(option.value);
  return given ? std::to_string(*given) : "";
}

PeerProgram program_of(const PeerCommand& options) {
  PeerProgram program{"sortie-bench-" + options.front.name,          options.program,        {}, -1,
                      options.front.has_passes ? options.passes : 1, options.front.all_timed};
  for (const PeerOption& option : options.front.options) {
    const std::string text = text_of(option);
    if (text.empty()) continue;
    program.arguments.insert(program.arguments.end(), {option.name, text});
    if (option.name == "--core") program.core = std::stoi(text);  // the doctor looks at it, too
  }
  return program;
}

int run(const CommandContext& context, PeerCommand& options) {
  PeerFront& front = options.front;
  if (front.adapt != nullptr) front.adapt(front);
  firmware::Json result = run_peer_program(program_of(options));
  if (front.finish != nullptr) front.finish(result);
  if (options.output.json) {
    show_json(result);
  } else {
    print_bench(std::cout, front, result, firmware::wants_colour(STDOUT_FILENO));
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    const std::string file = folder + "/" + front.file;
    write_file(file + ".json", result.dump(front.on_one_line ? -1 : 2) + "\n");
    write_file(file + ".md", bench_page(front, result, context.command_line));
    if (front.pictures != nullptr) {
      for (const BenchPicture& picture : front.pictures(result))
        write_file(folder + "/" + picture.file, render(picture.plot) + "\n");
    }
    std::cerr << "report: " << file << ".{md,json}" << (front.pictures != nullptr ? " and pictures" : "")
              << "\n";
  }
  return front.is_good == nullptr || front.is_good(result) ? 0 : 1;
}

void add_bench_peer(firmware::Command& bench, CommandContext& context, const PeerFront& front) {
  auto options = std::make_shared<PeerCommand>();
  options->front = front;
  firmware::Command* command = bench.add_subcommand(front.name, front.about);
  command->footer(front.footer);
  std::vector<firmware::Option*> added;
  for (PeerOption& option : options->front.options) added.push_back(add(*command, option));
  command
      ->add_option("--program", options->program,
                   "sortie-bench-" + front.name + ", where it is not found by itself")
      ->type_name("FILE");
  if (front.has_passes)
    command->add_option("--passes", options->passes, "Runs, a process each; ranges then hold all of them")
        ->in_range(1, 100)
        ->capture_default_str();
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command
      ->add_option("--out", options->output.out,
                   "Folder for " + front.file + ".md, " + front.file +
                       (front.pictures != nullptr ? ".json and pictures" : ".json"))
      ->type_name("DIR");
  command->callback([&context, options, added] {
    for (std::size_t i = 0; i < added.size(); ++i) options->front.options[i].given = added[i]->count() > 0;
    context.chosen = [&context, options] { return run(context, *options); };
  });
}

}  // namespace

void add_bench_peers(firmware::Command& bench, CommandContext& context) {
  for (const PeerFront& front : peer_fronts()) add_bench_peer(bench, context, front);
}

}  // namespace sortie::toolchain
