// SPDX-License-Identifier: BSD-3-Clause
// The options of the command line as commands declare them. Only command_line.cpp sees the library that reads
// them (CLI11, which costs seconds a unit).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace sortie::firmware {

/// One option or positional of a command; it belongs to the command. All but count() give the option back, so
/// that they can be chained.
class Option {
 public:
  /// For Command alone.
  explicit Option(CLI::Option* option) : option_(option) {}

  /// Without it the command line is an error.
  Option* required();
  /// What the help calls the value.
  Option* type_name(const std::string& name);
  /// Shows the value that the variable has now as the default.
  Option* capture_default_str();
  /// A value outside is an error; bounds belong to the range. The help shows it. T: int, std::uint64_t,
  /// double.
  template <class T>
  Option* in_range(T low, T high);
  /// A value below zero, or no number, is an error.
  Option* not_negative();
  /// Any other value is an error. The help lists them.
  Option* one_of(const std::vector<std::string>& choices);
  /// May be given several times; each adds to the list.
  Option* take_all();
  /// Values of a list are separated by this, too.
  Option* delimiter(char between);
  /// So many values each time.
  Option* expected(int least, int most);
  /// Not together with `other`.
  Option* excludes(Option* other);
  /// Under which title the help lists it; empty: it does not.
  Option* group(const std::string& title);
  /// How often it was given; after parsing.
  std::size_t count() const;

 private:
  // In the place of the library's option, which its functions give back.
  Option* ours(CLI::Option*) { return this; }

  CLI::Option* option_;
};

/// A command, or the program itself, with its options and commands below. What it hands out lives as long as
/// the CommandLine; variables that options write to must live until the chosen command has ended. Throws
/// where an option's name is taken or is no name.
class Command {
 public:
  /// For CommandLine alone.
  explicit Command(CLI::App* app);
  ~Command();
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  /// A command below this one.
  Command* add_subcommand(const std::string& name, const std::string& about);
  /// How many commands below this one must be chosen; `most` 0: any number.
  void require_subcommand(std::size_t least, std::size_t most);
  /// True where a command below this one was chosen; for callbacks.
  bool has_chosen_subcommand() const;

  /// "--long", "-s,--long", or "name" for a positional. The value goes into the variable, which keeps what it
  /// has where the option is not given. T: std::string or double, or a vector of them, int, std::uint16_t,
  /// std::uint32_t, or std::uint64_t, which may be optional.
  template <class T>
  Option* add_option(const std::string& name, T& value, const std::string& about = "");
  /// "--long" sets the variable; "!--long" clears it.
  Option* add_flag(const std::string& name, bool& value, const std::string& about);

  /// Text below the help.
  void footer(const std::string& text);
  /// Called after parsing where this command was chosen.
  void callback(std::function<void()> function);
  /// From a callback: what the command line lacks, as where an option is missing that is required.
  [[noreturn]] static void lacks(const std::string& what);

 private:
  friend class CommandLine;
  Option* keep(CLI::Option* option);

  CLI::App* app_;
  std::vector<std::unique_ptr<Option>> options_;
  std::vector<std::unique_ptr<Command>> commands_;
};

/// The command line of a program.
class CommandLine {
 public:
  /// --help and --help-all are there by themselves; --version says `version`. One command must be chosen.
  CommandLine(const std::string& about, const std::string& name, const std::string& version);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  Command& root() { return root_; }
  /// Reads what was typed into the variables of the options and calls the chosen commands' callbacks.
  /// Nothing: go on. Otherwise the exit code of a program that is done: help or version was printed (0), or
  /// on stderr what was typed wrong (`usage`). What else a callback throws goes on to the caller.
  std::optional<int> parse(int argc, char** argv, int usage);

 private:
  std::unique_ptr<CLI::App> app_;
  Command root_;
};

}  // namespace sortie::firmware
