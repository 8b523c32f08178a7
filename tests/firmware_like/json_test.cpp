// SPDX-License-Identifier: BSD-3-Clause
// Json beside the library that it stands for: what one writes, finds or refuses, the other must.
#include "firmware_like/scene/json.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

using namespace sortie::firmware;

namespace {

using Twin = nlohmann::ordered_json;
using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t n) { return static_cast<std::size_t>(random() % n); }

constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;

/// One document, made twice.
struct Pair {
  Json ours;
  Twin theirs;
};

template <class T>
Pair both(const T& value) {
  return {Json(value), Twin(value)};
}

std::string random_text(Random& random) {
  static const std::vector<std::string> kPieces{"a",      "Z9",     " ",
                                                "\"",     "\\",     "/",
                                                "\n",     "\t",     "\b",
                                                "\x01",   "\x7f",   std::string(1, '\0'),
                                                "\u00e4", "\u2028", "\xf0\x9f\x98\x80"};
  std::string text;
  for (std::size_t n = below(random, 6); n > 0; --n) text += kPieces[below(random, kPieces.size())];
  return text;
}

double random_real(Random& random) {
  switch (random() % 6) {
    case 0:
      return static_cast<double>(random() % 2000) - 1000.0;
    case 1:
      return static_cast<double>(random()) * 1e-20;
    case 2: {
      const double odd[] = {-0.0, 1e300, 5e-324, 0.1, 1e15, 1e16, 123456789012345680.0, -1e-7, 2.5e-5};
      return odd[random() % std::size(odd)];
    }
    default:
      break;
  }
  // Any bits that are a number.
  for (;;) {
    const double real = std::bit_cast<double>(random());
    if (std::isfinite(real)) return real;
  }
}

Pair random_document(Random& random, int depth) {
  switch (random() % (depth > 0 ? 8 : 6)) {
    case 0:
      return both(nullptr);
    case 1:
      return both(random() % 2 == 0);
    case 2:
      return both(static_cast<std::int64_t>(random()) >> (random() % 64));
    case 3:
      return both(random() >> (random() % 64));
    case 4:
      return both(random_real(random));
    case 5:
      return both(random_text(random));
    case 6: {
      Pair list{Json::array(), Twin::array()};
      for (std::size_t n = below(random, 5); n > 0; --n) {
        const Pair element = random_document(random, depth - 1);
        list.ours.push_back(element.ours);
        list.theirs.push_back(element.theirs);
      }
      return list;
    }
    default:
      break;
  }
  Pair object{Json::object(), Twin::object()};
  for (std::size_t n = below(random, 5); n > 0; --n) {
    const std::string key = random_text(random);
    const Pair value = random_document(random, depth - 1);
    object.ours[key] = value.ours;
    object.theirs[key] = value.theirs;
  }
  return object;
}

/// Both refuse a text, or both read the same.
void check_text(const std::string& text) {
  INFO(text);
  const Twin theirs = Twin::parse(text, nullptr, false);
  const Json ours = Json::parse_or_null(text);
  if (theirs.is_discarded()) {
    CHECK(ours.is_null());
    std::string words;
    try {
      const Twin read = Twin::parse(text);
      FAIL(read);
    } catch (const Twin::exception& error) {
      words = error.what();
    }
    CHECK_THROWS_WITH(Json::parse(text), words);
    return;
  }
  CHECK(ours.dump() == theirs.dump(-1, ' ', false, kReplace));
  CHECK(Json::parse(text) == ours);
  CHECK(ours.is_number_unsigned() == theirs.is_number_unsigned());
  CHECK(ours.is_number_integer() == theirs.is_number_integer());
  CHECK(ours.is_number_float() == theirs.is_number_float());
  CHECK(ours.size() == theirs.size());
}

std::string nested(int depth, const std::string& open, const std::string& close) {
  std::string text;
  for (int i = 0; i < depth; ++i) text += open;
  text += "1";
  for (int i = 0; i < depth; ++i) text += close;
  return text;
}

}  // namespace

TEST_CASE("random documents are written and read as the library does it") {
  const std::uint64_t seed = std::random_device{}();
  std::cout << "json_test: seed " << seed << "\n";
  INFO("seed " << seed);
  Random random(seed);
  for (int i = 0; i < 2000; ++i) {
    const Pair document = random_document(random, 5);
    const std::string text = document.theirs.dump();
    REQUIRE(document.ours.dump() == text);
    REQUIRE(document.ours.dump(2) == document.theirs.dump(2));
    REQUIRE(document.ours.dump(0) == document.theirs.dump(0));
    const Json again = Json::parse(text);
    REQUIRE(again == document.ours);
    REQUIRE(again.dump() == text);
  }
}

TEST_CASE("random documents are equal where the library says so") {
  const std::uint64_t seed = std::random_device{}();
  std::cout << "json_test: seed " << seed << "\n";
  INFO("seed " << seed);
  Random random(seed);
  std::size_t same = 0;
  for (int i = 0; i < 20000; ++i) {
    const Pair a = random_document(random, 1);
    const Pair b = random_document(random, 1);
    INFO(a.theirs << " beside " << b.theirs);
    // The library takes 2^64 - 1 for -1; no random pair meets that.
    REQUIRE((a.ours == b.ours) == (a.theirs == b.theirs));
    REQUIRE((a.ours != b.ours) == (a.theirs != b.theirs));
    same += a.ours == b.ours ? 1 : 0;
    const Json copy = a.ours;
    REQUIRE(copy == a.ours);
  }
  CHECK(same > 100);
  CHECK(Json(5) == Json(5u));
  CHECK(Json(5) == Json(5.0));
  CHECK(Json(-1) != Json(std::numeric_limits<std::uint64_t>::max()));
  CHECK(Json(std::nan("")) != Json(std::nan("")));
  CHECK(Json{{"a", 1}, {"b", 2}} != Json{{"b", 2}, {"a", 1}});
}

TEST_CASE("damaged texts are refused with the library's words") {
  const std::uint64_t seed = std::random_device{}();
  std::cout << "json_test: seed " << seed << "\n";
  INFO("seed " << seed);
  Random random(seed);
  for (int i = 0; i < 2000; ++i) {
    std::string text = random_document(random, 4).theirs.dump();
    for (std::size_t n = 1 + below(random, 3); n > 0; --n) {
      const std::size_t at = below(random, text.size());
      if (random() % 2 == 0) {
        text[at] = static_cast<char>(random());
      } else if (text.size() > 1) {
        text.erase(at, 1);
      }
    }
    check_text(text);
  }
}

TEST_CASE("odd texts are read as the library reads them") {
  for (const char* text : {"",
                           " ",
                           "null",
                           "true",
                           "tru",
                           "1",
                           "-1",
                           "-0",
                           "-0.0",
                           "01",
                           "1.",
                           ".5",
                           "1e5",
                           "1E+2",
                           "18446744073709551615",
                           "18446744073709551616",
                           "-9223372036854775808",
                           "-9223372036854775809",
                           "1e300",
                           "1e400",
                           "-1e400",
                           "1e-400",
                           "NaN",
                           "Infinity",
                           "[]",
                           "{}",
                           "[ ]",
                           "{ }",
                           "[1,]",
                           "[1 2]",
                           "{\"a\"}",
                           "{\"a\":}",
                           "{1:2}",
                           "{\"a\":1,}",
                           R"({"a":1,"b":2,"a":3})",
                           R"({"a":{"b":1},"a":[]})",
                           R"("A\/\b\f\n\r\t\"\\")",
                           R"("😀")",
                           R"("\ud83d")",
                           R"("\u00")",
                           "\"\x01\"",
                           "\"\xc3\"",
                           "\"\xff\"",
                           "\"\xed\xa0\x80\"",
                           "\xef\xbb\xbf[1]",
                           "[1] [2]",
                           "// x\n1",
                           "[[[[[]]]]]",
                           "\"unended",
                           "{\"a\":[1,{\"b\":null}]}"}) {
    check_text(text);
  }
}

TEST_CASE("odd numbers are written as the library writes them") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double real : {0.0, -0.0, 1e300, -1e300, 5e-324, 0.1, 1.0, 100.0, 1e15, 1e16, 1e17, 1e22,
                            1.0 / 3.0, 3.2176, kInfinity, -kInfinity, std::nan("")}) {
    CHECK(Json(real).dump() == Twin(real).dump());
    CHECK(Json{real, {{"x", real}}}.dump(1) == Twin{real, {{"x", real}}}.dump(1));
  }
  CHECK(Json(0.1f).dump() == Twin(0.1f).dump());
  CHECK(Json(std::nan("")).dump() == "null");
  CHECK(Json(-0.0).dump() == "-0.0");
  CHECK(Json(std::numeric_limits<std::uint64_t>::max()).dump() == "18446744073709551615");
  CHECK(Json(std::numeric_limits<std::int64_t>::min()).dump() == "-9223372036854775808");
  CHECK(Json(std::uint8_t{200}).dump() == Twin(std::uint8_t{200}).dump());
  CHECK(Json('a').dump() == Twin('a').dump());
}

TEST_CASE("bytes that are no UTF-8 are replaced, in keys and values") {
  for (const char* bytes :
       {"\xff", "a\xc3", "\xc3(", "\xed\xa0\x80z", "\xf0\x9f\x98", "\x80\x80", "ok\xe2\x82"}) {
    CHECK(Json(bytes).dump() == Twin(bytes).dump(-1, ' ', false, kReplace));
    const Json ours{{bytes, {bytes, 1}}};
    const Twin theirs{{bytes, {bytes, 1}}};
    CHECK(ours.dump() == theirs.dump(-1, ' ', false, kReplace));
    CHECK(Json::parse(ours.dump()).is_object());
  }
}

TEST_CASE("a text may be as deep as the bound says and no deeper, whatever its length") {
  for (const auto& [open, close] : {std::pair{"[", "]"}, {"{\"a\":", "}"}, {"[{\"a\":", "}]"}}) {
    const int levels = open == std::string("[{\"a\":") ? 2 : 1;
    const std::string deepest = nested(Json::kMostDepth / levels, open, close);
    CHECK(Json::parse(deepest).dump() == deepest);
    CHECK_THROWS_AS(Json::parse(nested(Json::kMostDepth / levels + 1, open, close)), JsonError);
    CHECK_THROWS_WITH(Json::parse(nested(1'000'000, open, close)), Catch::Contains("more than 100"));
    CHECK_THROWS_AS(Json::parse(nested(1'000'000, open, "")), JsonError);
    CHECK(Json::parse_or_null(nested(1'000'000, open, close)).is_null());
  }
  // Side by side there may be any number.
  std::string wide = "[[]";
  for (int i = 0; i < 10'000; ++i) wide += ",[{}]";
  CHECK(Json::parse(wide + "]").size() == 10'001);
}

TEST_CASE("a stream is read to its end, and one that is not there is null") {
  std::istringstream good("{\"a\":\n1}\n");
  CHECK(Json::parse_or_null(good)["a"] == 1);
  std::istringstream damaged("{\"a\":");
  CHECK(Json::parse_or_null(damaged).is_null());
  std::istringstream failed;
  failed.setstate(std::ios::failbit);
  CHECK(Json::parse_or_null(failed).is_null());
}
