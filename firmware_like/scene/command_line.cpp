// SPDX-License-Identifier: BSD-3-Clause
// The one file that sees CLI11.
#include "firmware_like/scene/command_line.hpp"

#include <CLI/CLI.hpp>
#include <utility>

namespace sortie::firmware {

Option* Option::required() {
  option_->required();
  return this;
}

Option* Option::type_name(const std::string& name) {
  option_->type_name(name);
  return this;
}

Option* Option::capture_default_str() {
  option_->capture_default_str();
  return this;
}

template <class T>
Option* Option::in_range(T low, T high) {
  option_->check(CLI::Range(low, high));
  return this;
}
template Option* Option::in_range(int, int);
template Option* Option::in_range(std::uint64_t, std::uint64_t);
template Option* Option::in_range(double, double);

Option* Option::not_negative() {
  option_->check(CLI::NonNegativeNumber);
  return this;
}

Option* Option::one_of(const std::vector<std::string>& choices) {
  option_->check(CLI::IsMember(choices));
  return this;
}

Option* Option::take_all() {
  option_->take_all();
  return this;
}

Option* Option::delimiter(char between) {
  option_->delimiter(between);
  return this;
}

Option* Option::expected(int least, int most) {
  option_->expected(least, most)->allow_extra_args(false);
  return this;
}

Option* Option::excludes(Option* other) {
  option_->excludes(other->option_);
  return this;
}

Option* Option::group(const std::string& title) {
  option_->group(title);
  return this;
}

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
