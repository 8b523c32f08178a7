// SPDX-License-Identifier: BSD-3-Clause
// The one file that sees CLI11.
#include "firmware_like/scene/command_line.hpp"

#include <CLI/CLI.hpp>
#include <utility>

namespace sortie::firmware {

Option* Option::required() { return ours(option_->required()); }
Option* Option::type_name(const std::string& name) { return ours(option_->type_name(name)); }
Option* Option::capture_default_str() { return ours(option_->capture_default_str()); }
Option* Option::not_negative() { return ours(option_->check(CLI::NonNegativeNumber)); }
Option* Option::take_all() { return ours(option_->take_all()); }
Option* Option::delimiter(char between) { return ours(option_->delimiter(between)); }
Option* Option::excludes(Option* other) { return ours(option_->excludes(other->option_)); }
Option* Option::group(const std::string& title) { return ours(option_->group(title)); }

Option* Option::one_of(const std::vector<std::string>& choices) {
  return ours(option_->check(CLI::IsMember(choices)));
}

Option* Option::expected(int least, int most) {
  return ours(option_->expected(least, most)->allow_extra_args(false));
}

template <class T>
Option* Option::in_range(T low, T high) {
  return ours(option_->check(CLI::Range(low, high)));
}
template Option* Option::in_range(int, int);
template Option* Option::in_range(std::uint64_t, std::uint64_t);
template Option* Option::in_range(double, double);

std::size_t Option::count() const { return option_->count(); }

Command::Command(CLI::App* app) : app_(app) {}
Command::~Command() = default;

Command* Command::add_subcommand(const std::string& name, const std::string& about) {
  commands_.push_back(std::make_unique<Command>(app_->add_subcommand(name, about)));
  return commands_.back().get();
}

void Command::require_subcommand(std::size_t least, std::size_t most) {
  app_->require_subcommand(least, most);
}

bool Command::has_chosen_subcommand() const { return !app_->get_subcommands().empty(); }

Option* Command::keep(CLI::Option* option) {
  options_.push_back(std::make_unique<Option>(option));
  return options_.back().get();
}

template <class T>
Option* Command::add_option(const std::string& name, T& value, const std::string& about) {
  return keep(app_->add_option(name, value, about));
}
template Option* Command::add_option(const std::string&, std::string&, const std::string&);
template Option* Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template Option* Command::add_option(const std::string&, double&, const std::string&);
template Option* Command::add_option(const std::string&, std::vector<double>&, const std::string&);
template Option* Command::add_option(const std::string&, int&, const std::string&);
template Option* Command::add_option(const std::string&, std::uint16_t&, const std::string&);
template Option* Command::add_option(const std::string&, std::uint32_t&, const std::string&);
template Option* Command::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option* Command::add_option(const std::string&, std::optional<std::uint64_t>&, const std::string&);

Option* Command::add_flag(const std::string& name, bool& value, const std::string& about) {
  return keep(app_->add_flag(name, value, about));
}

void Command::footer(const std::string& text) { app_->footer(text); }

void Command::callback(std::function<void()> function) { app_->callback(std::move(function)); }

void Command::lacks(const std::string& what) { throw CLI::RequiredError(what); }

CommandLine::CommandLine(const std::string& about, const std::string& name, const std::string& version)
    : app_(std::make_unique<CLI::App>(about, name)), root_(app_.get()) {
  app_->set_version_flag("--version", version);
  app_->set_help_all_flag("--help-all", "Help of all commands");
  app_->require_subcommand(1);
}

CommandLine::~CommandLine() = default;

std::optional<int> CommandLine::parse(int argc, char** argv, int usage) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app_->exit(error) == 0 ? 0 : usage;
  }
  return {};
}

}  // namespace sortie::firmware
