// SPDX-License-Identifier: BSD-3-Clause
// A scene profile: one TOML file that names what a scene needs. Every key is declared, with unit, range,
// default and meaning: by the config struct that it belongs to (rt/keys.hpp), or where it is read. What
// nobody declares is an error with its line.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "rt/keys.hpp"

namespace sortie::firmware {

struct LaidScene;
class TomlTree;

/// A profile that cannot be used. what() is one line: file, line, fault, cure. Commands end with exit code 2.
class ProfileError : public std::runtime_error {
 public:
  /// What a profile or a caller wrote may stand in `words`: control characters in it become spaces, so that
  /// it stays one line and cannot command a terminal.
  explicit ProfileError(std::string words) : std::runtime_error(one_line(std::move(words))) {}

 private:
  static std::string one_line(std::string words);
};

/// One declared key, for help texts and docs. Of what is no number low and high are 0.
struct ProfileKey : rt::KeyRange {
  std::string path;
  std::string value;  ///< in force
  std::string range;  ///< or choices, as text
  bool is_default{};
  bool is_changeable{};  ///< a run-time parameter: may be set while a run goes on
  bool is_knob{};        ///< trades error for run time or memory: of interest to a sweep
  double number{};       ///< of a number: its value
};

/// One row of [[script]]: a change of a run-time parameter, made by the run itself.
struct ScriptLine {
  double at_s{};  ///< on the run's clock
  std::string name;
  double value{};
  std::size_t row{};  ///< in the file's order
};

/// A number that the profile may leave out: its range, and what holds then.
struct NumberSpec : rt::KeyRange {
  constexpr NumberSpec() = default;
  constexpr NumberSpec(double otherwise, const KeyRange& range) : KeyRange(range), fallback(otherwise) {}
  constexpr NumberSpec(double otherwise, double least, double most, rt::KeyUnit written_in = "",
                       const char* what = "")
      : KeyRange{least, most, written_in, what}, fallback(otherwise) {}
  double fallback{};
};

/// One column of a list of tables.
struct ColumnSpec {
  enum class Kind : std::uint8_t { number, text, flag };
  const char* name = "";
  Kind kind{Kind::number};
  NumberSpec number{};  ///< of a number: fallback, range and unit
  bool needed{};        ///< every row has it
};

/// One row of a list of tables; a flag is 0 or 1 among the numbers.
struct ProfileRow {
  std::string path;
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> texts;  ///< only those that stand there
};

/// Where a struct's key stands: in `table`, unless its name has a dot.
std::string key_path(const std::string& table, const std::string& name);

/// A parsed profile. Set-up only: reading throws ProfileError.
class Profile {
 public:
  /// Parses `toml`. `source` names it in messages. `overrides`: "path.to.key=value" each, applied before
  /// anything is read.
  Profile(const std::string& toml, const std::string& source, const std::vector<std::string>& overrides = {});
  ~Profile();
  Profile(Profile&&) noexcept;
  Profile& operator=(Profile&&) noexcept;

  /// Reads the keys that `config` lists into it, those of `table` and those that say where they stand, in the
  /// list's order. What the profile does not say stays as it is in `config`, which may be no struct's
  /// default, but must lie in its range, too. Errors as below.
  template <rt::Keyed Config>
  void read(const std::string& table, Config& config) {
    Config::keys(config, [&](const char* name, auto& member, const rt::KeySpec& spec, auto&&...) {
      using Member = std::remove_reference_t<decltype(member)>;
      const std::string path = key_path(table, name);
      if constexpr (std::is_same_v<Member, rt::Vector3>) {
        read_point(path, spec, member);
      } else {
        double written = rt::as_written(member, spec);
        if (read_key(path, spec, rt::kind_of<Member>(spec), written))
          member = rt::from_written<Member>(written, spec);
      }
    });
  }

  /// Reads a value, or gives the fallback when the key is absent. Out of range or of another type:
  /// ProfileError. Units and meanings are static texts.
  double number(const std::string& path, const NumberSpec& spec);
  std::int64_t integer(const std::string& path, const NumberSpec& spec);
  /// A whole number, or nothing where "auto" stands.
  std::optional<std::int64_t> integer_or_auto(const std::string& path, const NumberSpec& spec);
  bool flag(const std::string& path, bool fallback, const char* meaning);
  std::string text(const std::string& path, const std::string& fallback, const char* meaning,
                   const std::vector<std::string>& choices = {});
  /// A list of texts.
  std::vector<std::string> texts(const std::string& path, const std::vector<std::string>& fallback,
                                 const char* meaning);
  /// A list of points of two numbers each; at most `most` of them.
  std::vector<std::array<double, 2>> points(const std::string& path, std::size_t most, const char* meaning);
  /// A list of as many numbers as `fallback` has, each in the range of `spec`.
  std::vector<double> numbers(const std::string& path, const std::vector<double>& fallback,
                              const NumberSpec& spec);
  /// The rows of [[path]], in the file's order; at most `most`. A column that is not among `columns` is an
  /// error.
  std::vector<ProfileRow> rows(const std::string& path, const std::vector<ColumnSpec>& columns,
                               std::size_t most, const char* meaning);
  /// The rows of [[script]], in order of time. ProfileError for a row with other keys than at_s, set, value.
  std::vector<ScriptLine> script();
  /// Marks a number that was read as changeable while a run goes on. ProfileError when no number was read
  /// there.
  const ProfileKey& changeable(const std::string& path);
  /// Marks a key as a knob that no struct lists, before or after it is read.
  void knob(const std::string& path);
  bool has(const std::string& path) const;
  /// Names of the tables directly below `path`, in the file's order; those of a base come first.
  std::vector<std::string> tables(const std::string& path) const;

  /// After all reading: ProfileError for the first key that nobody declared, with its line and the nearest
  /// known key. Only keys below the table `below` ("" = all) and not below `except` ("" = none) are looked
  /// at.
  void refuse_unknown_keys(const std::string& below = "", const std::string& except = "") const;
  /// ProfileError at a key's line, for checks that span several keys.
  [[noreturn]] void fail(const std::string& path, const std::string& why) const;
  /// fail() with the nearest two unless `value`, which `path` was read into, is one.
  void check_power_of_two(const std::string& path, std::uint32_t value) const;

  const std::string& name() const { return name_; }
  const std::string& vehicle() const { return vehicle_; }
  /// One sentence for lists.
  const std::string& about() const { return about_; }
  /// What robots do in such a scene; empty: it is there for tests or as an example.
  const std::string& use() const { return use_; }
  /// One line: what the scene does without, and why. Empty where nobody has said it.
  const std::string& leaves_out() const { return leaves_out_; }
  /// The scene that this one only changes, or nothing.
  const std::string& base() const { return base_; }
  /// The whole profile with overrides applied, as canonical TOML: what a log's header stores.
  std::string canonical() const;
  /// xxhash64 of canonical().
  std::uint64_t hash() const;
  /// Every key that was declared so far, in order of declaration.
  const std::vector<ProfileKey>& keys() const { return keys_; }

 private:
  static constexpr const char* kTooManyDigits =
      "has more digits than a number here can hold: whole ones reach to 2^53 = 9007199254740992";
  friend Profile load_scene(const std::string& scene, const std::vector<std::string>& overrides);
  Profile(LaidScene scene, const std::vector<std::string>& overrides);
  ProfileKey* declare(const std::string& path, const std::string& value, const rt::KeyRange& key,
                      const std::string& range, bool is_default);
  // True: the profile has it, and `written` is what stands there; a flag or a choice as the member's value.
  bool read_key(const std::string& path, const rt::KeySpec& spec, rt::KeyKind kind, double& written);
  void read_point(const std::string& path, const rt::KeySpec& spec, rt::Vector3& point);
  std::string place(const std::string& path) const;
  void apply_override(const std::string& assignment);

  std::unique_ptr<TomlTree> tree_;  // overrides applied
  std::string source_;
  std::string name_;
  std::string vehicle_;
  std::string about_;
  std::string use_;
  std::string leaves_out_;
  std::string base_;
  std::vector<ProfileKey> keys_;
  std::set<std::string> knobs_;
};

/// A scene that is built into the program.
struct BuiltInScene {
  const char* name;
  const char* toml;
};

/// Scenes of firmware_like/scenes/, sorted by name.
const std::vector<BuiltInScene>& built_in_scenes();

/// Loads a built-in scene by name, or a file if `scene` ends in .toml. ProfileError lists the known names
/// otherwise. A scene with `scene.base` begins with all that its base says, a scene by name or a file beside
/// it: its own tables are laid over the base's key by key, its own values and lists take the place of the
/// base's. The profile that results has no base: it, as a log carries it, stands for itself.
Profile load_scene(const std::string& scene, const std::vector<std::string>& overrides = {});

}  // namespace sortie::firmware
