// SPDX-License-Identifier: BSD-3-Clause
// A TOML file as a tree of values that know their line. Only toml_file.cpp sees the library that parses and
// prints it (toml++, which costs seconds a unit).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sortie::firmware {

/// A text that is not valid TOML, or a file that cannot be read. what() is the fault alone.
class TomlError : public std::runtime_error {
 public:
  TomlError(const std::string& fault, std::uint32_t line) : std::runtime_error(fault), line_(line) {}
  /// From 1; 0: the whole file.
  std::uint32_t line() const { return line_; }

 private:
  std::uint32_t line_;
};

/// A value of a TomlTree, or none. A view: valid while its tree lives and nothing takes the value's place.
/// Every question may be put to every value; one of another type answers no, nothing, or zero.
class TomlNode {
 public:
  /// None.
  TomlNode() = default;

  /// False: none.
  explicit operator bool() const { return node_ != nullptr; }
  bool is_table() const;
  bool is_list() const;
  bool is_string() const;
  bool is_boolean() const;
  /// A whole number or one with a point.
  bool is_number() const;
  bool is_integer() const;

  /// A number; a whole one only if a double can hold it exactly.
  std::optional<double> number() const;
  /// True or false.
  std::optional<bool> flag() const;
  /// What stands in quotes.
  std::optional<std::string> text() const;

  /// Length of a list.
  std::size_t size() const;
  /// An entry of a list.
  TomlNode at(std::size_t i) const;
  /// A value of a table.
  TomlNode get(std::string_view key) const;
  /// The value at "table.table.key" or "table.list[2].key" below this table. Cost: a search a table.
  TomlNode at_path(std::string_view path) const;
  /// What stands in a table, by ascending key. Cost: a copy of the keys.
  std::vector<std::pair<std::string, TomlNode>> entries() const;

  /// Where it stands, from 1; 0: in no file.
  std::uint32_t line() const;
  /// The source it was parsed from; null: from none that has a name.
  const std::string* source() const;

 private:
  friend class TomlTree;
  explicit TomlNode(const void* node) : node_(node) {}

  const void* node_{};
};

/// A whole file: a table of values, which it owns.
class TomlTree {
 public:
  /// An empty table.
  TomlTree();
  ~TomlTree();
  TomlTree(TomlTree&&) noexcept;
  TomlTree& operator=(TomlTree&&) noexcept;

  /// Parses a text; `source` is what its values call their file. Throws TomlError. Undefined for characters
  /// that line_of_bare_non_ascii() (profile_text.hpp) finds.
  static TomlTree parse(const std::string& text, const std::string& source = "");
  /// Parses a file. Throws TomlError.
  static TomlTree read(const std::string& path);
  /// A table of one text.
  static TomlTree of_text(const std::string& key, const std::string& text);

  /// The table itself.
  TomlNode root() const;
  /// The same as root().at_path(path).
  TomlNode at_path(std::string_view path) const { return root().at_path(path); }

  /// Puts a copy of what `from` has as `key`, which it must have, at "table.table.key"; tables that are not
  /// there are made, what is there is replaced. The copy stands in no file, and a whole number in it is
  /// decimal. Returns the path of what is there and no table, if that is so.
  std::optional<std::string> put(const std::string& path, TomlTree& from, const std::string& key);
  /// Takes table.key out, if it is there.
  void erase(const std::string& table, const std::string& key);
  /// Lays another tree over this one: tables key by key, everything else takes the other's place. Values
  /// keep their source and line.
  void lay_over(TomlTree&& above);
  /// The tree as TOML, the same text for the same values, without a line end.
  std::string canonical() const;

 private:
  struct Table;
  explicit TomlTree(std::unique_ptr<Table> table);

  std::unique_ptr<Table> table_;  ///< null: moved from
};

}  // namespace sortie::firmware
