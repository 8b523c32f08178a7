// SPDX-License-Identifier: BSD-3-Clause
// Json values beside the library that they stand for: what is built, changed and looked up.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "firmware_like/scene/json.hpp"

using namespace sortie::firmware;

namespace {

using Twin = nlohmann::ordered_json;

}  // namespace

TEST_CASE("braces become arrays and objects by the library's rule") {
  const std::vector<double> numbers{1, 2.5};
  const std::map<std::string, std::uint64_t> counts{{"b", 2}, {"a", 1}};
  const std::string text = "t";
  const auto check = [](const Json& ours, const Twin& theirs) {
    CHECK(ours.dump() == theirs.dump());
    CHECK(ours.is_object() == theirs.is_object());
  };
  check({}, {});
  check({{"a", 1}}, {{"a", 1}});
  check({{"a", 1}, {"b", {1, 2}}}, {{"a", 1}, {"b", {1, 2}}});
  check({{"a", 1}, {"b", 2, 3}}, {{"a", 1}, {"b", 2, 3}});
  check({{"a", 1}, {2, "b"}}, {{"a", 1}, {2, "b"}});
  check({"a", 1}, {"a", 1});
  check({"a", "b"}, {"a", "b"});
  check({{{"a", 1}}}, {{{"a", 1}}});
  check({1}, {1});
  check({text, text}, {text, text});
  check({{text, text}}, {{text, text}});
  check({{"a", {}}, {"b", nullptr}}, {{"a", {}}, {"b", nullptr}});
  check({{"a", 1}, {"a", 2}}, {{"a", 1}, {"a", 2}});
  check({{"a", {{"b", {{"c", {1, {}, true}}}}}}}, {{"a", {{"b", {{"c", {1, {}, true}}}}}}});
  check({{"n", numbers}, {"c", counts}, {"t", text}}, {{"n", numbers}, {"c", counts}, {"t", text}});
  check({Json::array(), Json::object()}, {Twin::array(), Twin::object()});
  check(Json::array({{"a", 1}}), Twin::array({{"a", 1}}));
  check(Json::array({1, "x", 2u}), Twin::array({1, "x", 2u}));
  check(numbers, numbers);
  check(counts, counts);
  check(std::array<int, 3>{3, 2, 1}, std::array<int, 3>{3, 2, 1});
  check(std::vector<std::vector<int>>{{1}, {}}, std::vector<std::vector<int>>{{1}, {}});
  check(std::vector<bool>{true, false}, std::vector<bool>{true, false});
  check(std::string_view("view"), std::string_view("view"));

  Json ours;
  Twin theirs;
  ours["list"].push_back({{"a", 1}, {"b", 2}});
  theirs["list"].push_back({{"a", 1}, {"b", 2}});
  ours["list"].push_back({1, 2});
  theirs["list"].push_back({1, 2});
  ours["list"].push_back("x");
  theirs["list"].push_back("x");
  ours["list"].back() = {{"y", ours["list"]}};
  theirs["list"].back() = {{"y", theirs["list"]}};
  ours["object"] = {{"k", 1}};
  theirs["object"] = {{"k", 1}};
  check(ours, theirs);
}

TEST_CASE("members keep their order, also through changes") {
  Json ours{{"z", 1}, {"a", 2}, {"m", 3}};
  Twin theirs{{"z", 1}, {"a", 2}, {"m", 3}};
  ours["a"] = "again";
  theirs["a"] = "again";
  ours["new"]["deep"] = 1;
  theirs["new"]["deep"] = 1;
  ours.erase("z");
  theirs.erase("z");
  ours.erase("absent");
  theirs.erase("absent");
  ours.update({{"m", 4}, {"z", 5}});
  theirs.update({{"m", 4}, {"z", 5}});
  CHECK(ours.dump() == theirs.dump());
  std::string keys;
  for (const auto& [key, value] : ours.items()) keys += key + value.dump() + " ";
  CHECK(keys == R"(a"again" m4 new{"deep":1} z5 )");
  Json empty;
  empty.update(ours);
  CHECK(empty == ours);
  CHECK(Json().items().begin() == Json().items().end());
}

TEST_CASE("what is looked up is found, replaced or refused as in the library") {
  const Json json = Json::parse(R"({"n":7,"r":1.5,"i":-2,"t":"x","b":true,"l":[1,2,3],"o":{"k":null}})");
  CHECK(json.value("n", 0) == 7);
  CHECK(json.value("r", 0.0) == 1.5);
  CHECK(json.value("i", std::int64_t{0}) == -2);
  CHECK(json.value("t", "") == "x");
  CHECK(json.value("none", "?") == "?");
  CHECK(json.value("none", std::uint64_t{3}) == 3);
  CHECK(json.value("l", Json()).size() == 3);
  CHECK(json.value("l", std::vector<double>{}) == std::vector<double>{1, 2, 3});
  CHECK(json.contains("o"));
  CHECK_FALSE(json.contains("none"));
  CHECK(json.find("none") == json.end());
  CHECK(json.find("n")->get<int>() == 7);
  CHECK(json["l"].front() == 1);
  CHECK(json["l"].back() == 3);
  CHECK(json["o"]["k"].is_null());
  CHECK(json["r"].get<int>() == 1);
  CHECK(json["n"].get<double>() == 7.0);
  double read = 0;
  json.at("r").get_to(read);
  CHECK(read == 1.5);
  CHECK_THROWS_AS(json.at("none"), JsonError);
  CHECK_THROWS_AS(json["none"], JsonError);
  CHECK_THROWS_AS(json["l"][3], JsonError);
  CHECK_THROWS_AS(json["l"]["k"], JsonError);
  CHECK_THROWS_AS(json["o"][0], JsonError);
  CHECK_THROWS_AS(json["n"].value("k", 1), JsonError);
  CHECK_THROWS_AS(Json().value("k", 1), JsonError);
  CHECK_THROWS_WITH(json.value("t", 1.0), "JSON: a text is not a number");
  CHECK_THROWS_AS(json.value("n", ""), JsonError);
  CHECK_THROWS_AS(json["b"].get<double>(), JsonError);
  CHECK_THROWS_AS(json["n"].get<bool>(), JsonError);
  CHECK_THROWS_AS(json["n"].get<std::vector<int>>(), JsonError);
  CHECK_THROWS_AS(json["n"].items(), JsonError);
  CHECK_THROWS_AS(json["n"].begin(), JsonError);
  CHECK_THROWS_AS(Json(1e300).get<int>(), JsonError);
  CHECK_THROWS_AS(Json(std::nan("")).get<std::uint64_t>(), JsonError);
  CHECK_THROWS_AS(Json("x").push_back(1), JsonError);
  CHECK_THROWS_AS(Json::array().back(), JsonError);
  CHECK(Json().empty());
  CHECK(Json::array().empty());
  CHECK(Json::object().empty());
  CHECK_FALSE(Json(1).empty());
  CHECK(Json().begin() == Json().end());
  for (const Json& nothing : Json()) FAIL(nothing);
}

TEST_CASE("values are copied, moved and taken out of themselves") {
  Json json{{"a", {1, {{"b", "deep"}}}}};
  const Json copy = json;
  Json moved = std::move(json);
  CHECK(moved == copy);
  moved = moved["a"][1];
  CHECK(moved == Json{{"b", "deep"}});
  moved = std::move(moved["b"]);
  CHECK(moved == "deep");
  Json list = Json::array({1});
  for (int i = 0; i < 10; ++i) list.push_back(list);
  CHECK(list.dump().size() > 1000);
  std::ostringstream out;
  out << copy;
  CHECK(out.str() == R"({"a":[1,{"b":"deep"}]})");
}
