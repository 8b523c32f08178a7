// SPDX-License-Identifier: BSD-3-Clause
// The one file that sees toml++.
#include "firmware_like/toml_file.hpp"

// A header line such as "[|" breaks what the library's parser assumes. Without assertions it tells the
// compiler that this never happens, which makes the rest undefined; with these two lines it assumes nothing,
// goes on, and says what is wrong and where.
#undef NDEBUG
#define TOML_ASSERT(expression) static_cast<void>(0)
#include <toml++/toml.h>

#include <sstream>
#include <utility>

namespace sortie::firmware {

namespace {

const toml::node* node_of(const void* node) { return static_cast<const toml::node*>(node); }

template <class T>
std::optional<T> value_of(const void* node) {
  return node == nullptr ? std::nullopt : node_of(node)->value<T>();
}

const toml::table* table_of(const void* node) {
  return node == nullptr ? nullptr : node_of(node)->as_table();
}

const toml::array* list_of(const void* node) { return node == nullptr ? nullptr : node_of(node)->as_array(); }

// Nodes keep their file and line.
void lay(toml::table& below, toml::table&& above) {
  for (auto&& [key, value] : above) {
    toml::node* there = below.get(key.str());
    if (there != nullptr && there->is_table() && value.is_table())
      lay(*there->as_table(), std::move(*value.as_table()));
    else
      below.insert_or_assign(key, std::move(value));
  }
}

TomlError error_of(const toml::parse_error& error) {
  return TomlError(std::string(error.description()), error.source().begin.line);
}

}  // namespace

struct TomlTree::Table {
  toml::table root;
};

bool TomlNode::is_table() const { return node_ != nullptr && node_of(node_)->is_table(); }
bool TomlNode::is_list() const { return node_ != nullptr && node_of(node_)->is_array(); }
bool TomlNode::is_string() const { return node_ != nullptr && node_of(node_)->is_string(); }
bool TomlNode::is_boolean() const { return node_ != nullptr && node_of(node_)->is_boolean(); }
bool TomlNode::is_number() const { return node_ != nullptr && node_of(node_)->is_number(); }
bool TomlNode::is_integer() const { return node_ != nullptr && node_of(node_)->is_integer(); }

std::optional<double> TomlNode::number() const { return value_of<double>(node_); }
std::optional<bool> TomlNode::flag() const { return value_of<bool>(node_); }
std::optional<std::string> TomlNode::text() const { return value_of<std::string>(node_); }

std::size_t TomlNode::size() const {
  const toml::array* list = list_of(node_);
  return list == nullptr ? 0 : list->size();
}

TomlNode TomlNode::at(std::size_t i) const {
  const toml::array* list = list_of(node_);
  return TomlNode(list == nullptr ? nullptr : list->get(i));
}

TomlNode TomlNode::get(std::string_view key) const {
  const toml::table* table = table_of(node_);
  return TomlNode(table == nullptr ? nullptr : table->get(key));
}

TomlNode TomlNode::at_path(std::string_view path) const {
  return TomlNode(node_ == nullptr ? nullptr : node_of(node_)->at_path(path).node());
}

std::vector<TomlEntry> TomlNode::entries() const {
  std::vector<TomlEntry> result;
  const toml::table* table = table_of(node_);
  if (table == nullptr) return result;
  result.reserve(table->size());
  for (const auto& [key, value] : *table) result.push_back({std::string(key.str()), TomlNode(&value)});
  return result;
}

std::uint32_t TomlNode::line() const { return node_ == nullptr ? 0 : node_of(node_)->source().begin.line; }

const std::string* TomlNode::source() const {
  return node_ == nullptr ? nullptr : node_of(node_)->source().path.get();
}

TomlTree::TomlTree() : table_(std::make_unique<Table>()) {}
TomlTree::TomlTree(std::unique_ptr<Table> table) : table_(std::move(table)) {}
TomlTree::~TomlTree() = default;
TomlTree::TomlTree(TomlTree&&) noexcept = default;
TomlTree& TomlTree::operator=(TomlTree&&) noexcept = default;

TomlTree TomlTree::parse(const std::string& text, const std::string& source) {
  try {
    return TomlTree(std::make_unique<Table>(Table{toml::parse(text, source)}));
  } catch (const toml::parse_error& error) {
    throw error_of(error);
  }
}

TomlTree TomlTree::read(const std::string& path) {
  try {
    return TomlTree(std::make_unique<Table>(Table{toml::parse_file(path)}));
  } catch (const toml::parse_error& error) {
    throw error_of(error);
  }
}

TomlTree TomlTree::of_text(const std::string& key, const std::string& text) {
  TomlTree tree;
  tree.table_->root.insert(key, text);
  return tree;
}

TomlNode TomlTree::root() const { return TomlNode(static_cast<const toml::node*>(&table_->root)); }

std::optional<std::string> TomlTree::put(const std::string& path, TomlTree& from, const std::string& key) {
  toml::table* table = &table_->root;
  std::size_t begin = 0;
  for (std::size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', begin)) {
    const std::string name = path.substr(begin, dot - begin);
    if (table->get(name) == nullptr) table->insert(name, toml::table{});
    table = table->get(name)->as_table();
    if (table == nullptr) return path.substr(0, dot);
    begin = dot + 1;
  }
  // A constant node would keep the base that its numbers were written in; canonical texts have them decimal.
  toml::node& value = *from.table_->root.get(key);
  table->insert_or_assign(path.substr(begin), value);
  return {};
}

void TomlTree::erase(const std::string& table, const std::string& key) {
  if (toml::table* found = table_->root[table].as_table(); found != nullptr) found->erase(key);
}

void TomlTree::lay_over(TomlTree&& above) { lay(table_->root, std::move(above.table_->root)); }

std::string TomlTree::canonical() const {
  std::ostringstream out;
  out << toml::toml_formatter{table_->root};
  return out.str();
}

}  // namespace sortie::firmware
