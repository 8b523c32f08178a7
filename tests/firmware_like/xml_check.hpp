// SPDX-License-Identifier: BSD-3-Clause
// Is this well-formed XML? A small strict reader: tags nest, attributes are quoted and unique, entities are
// known.
#pragma once

#include <cctype>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace sortie::testing {

/// Empty if `text` is well-formed (one root element, an optional DOCTYPE or declaration before it), else what
/// is wrong. Contents of <style> are text, too, as XML has it.
inline std::string xml_fault(std::string_view text) {
  std::vector<std::string> open;
  std::size_t i = 0;
  bool had_root = false;
  const auto at = [&](const std::string& what) { return what + " at byte " + std::to_string(i); };
  const auto is_name = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || c == ':';
  };
  const auto entity_fault = [](std::string_view piece) {
    for (std::size_t k = piece.find('&'); k != std::string_view::npos; k = piece.find('&', k + 1)) {
      const std::size_t end = piece.find(';', k);
      if (end == std::string_view::npos) return true;
      const std::string_view name = piece.substr(k + 1, end - k - 1);
      if (name != "amp" && name != "lt" && name != "gt" && name != "quot" && name != "apos" &&
          name.substr(0, 1) != "#")
        return true;
    }
    return false;
  };
  while (i < text.size()) {
    if (text[i] != '<') {
      const std::size_t end = std::min(text.find('<', i), text.size());
      const std::string_view piece = text.substr(i, end - i);
      if (open.empty() && piece.find_first_not_of(" \t\r\n") != std::string_view::npos)
        return at("text outside the root");
      if (entity_fault(piece)) return at("unknown or unescaped entity");
      for (const char c : piece) {
        if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' && c != '\r')
          return at("control character");
      }
      i = end;
      continue;
    }
    if (text.substr(i, 2) == "<!" || text.substr(i, 2) == "<?") {
      if (had_root) return at("declaration behind the root's start");
      i = text.find('>', i);
      if (i == std::string_view::npos) return "declaration without end";
      ++i;
      continue;
    }
    const bool closes = i + 1 < text.size() && text[i + 1] == '/';
    std::size_t k = i + (closes ? 2 : 1);
    std::string name;
    while (k < text.size() && is_name(text[k])) name.push_back(text[k++]);
    if (name.empty()) return at("tag without name");
    std::set<std::string> attributes;
    bool empty_element = false;
    while (true) {
      const std::size_t before = k;
      while (k < text.size() && std::isspace(static_cast<unsigned char>(text[k])) != 0) ++k;
      if (k >= text.size()) return at("tag without end");
      if (text[k] == '>') break;
      if (text[k] == '/') {
        if (k + 1 >= text.size() || text[k + 1] != '>') return at("stray slash");
        empty_element = true;
        ++k;
        break;
      }
      if (k == before) return at("attributes without space between");
      std::string attribute;
      while (k < text.size() && is_name(text[k])) attribute.push_back(text[k++]);
      if (attribute.empty() || k + 1 >= text.size() || text[k] != '=' || text[k + 1] != '"')
        return at("bad attribute");
      const std::size_t end = text.find('"', k + 2);
      if (end == std::string_view::npos) return at("attribute without end");
      const std::string_view value = text.substr(k + 2, end - k - 2);
      if (value.find('<') != std::string_view::npos || entity_fault(value)) return at("bad attribute value");
      if (!attributes.insert(attribute).second) return at("attribute twice");
      k = end + 1;
    }
    if (closes) {
      if (open.empty() || open.back() != name) return at("</" + name + "> does not close what is open");
      open.pop_back();
    } else {
      if (open.empty() && had_root) return at("second root");
      had_root = true;
      if (!empty_element) open.push_back(name);
    }
    i = k + 1;
  }
  if (!open.empty()) return "<" + open.back() + "> is never closed";
  return had_root ? "" : "no element at all";
}

}  // namespace sortie::testing
