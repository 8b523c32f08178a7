// SPDX-License-Identifier: BSD-3-Clause
// Characters beyond ASCII in a profile: welcome in quotes and comments, refused elsewhere before the TOML
// library sees them.
#include "firmware_like/scene/profile_text.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "firmware_like/scene/profile.hpp"

using namespace sortie::firmware;

TEST_CASE("a character beyond ASCII is found where it stands neither in quotes nor in a comment") {
  CHECK(line_of_bare_non_ascii("") == 0);
  CHECK(line_of_bare_non_ascii("a = 1\nb = 2") == 0);
  CHECK(line_of_bare_non_ascii("\xef\xbb\xbf"
                               "a = 1") == 0);  // byte order mark
  CHECK(line_of_bare_non_ascii("\xef\xbb\xbd`") ==
        1);  // found by fuzzing: behaviour undefined in the library
  CHECK(line_of_bare_non_ascii("a = 'gr\xc3\xbc\xc3\x9f'\nb = \"\xc3\xbc\" # \xc3\xbc") == 0);
  CHECK(line_of_bare_non_ascii("a = \"\"\"\nx \xc3\xbc\n\"\"\"\"\nb = '''\n\xc3\xbc''\n'''") == 0);
  CHECK(line_of_bare_non_ascii("a = \"\\\"\xc3\xbc\"") == 0);  // an escaped quote does not end it
  CHECK(line_of_bare_non_ascii("a = '\\'\xc3\xbc") == 1);      // in single quotes nothing is escaped
  CHECK(line_of_bare_non_ascii("a = \"\"\"\n\n\"\"\" \xc3\xbc") == 3);
  CHECK(line_of_bare_non_ascii("# \xc3\xbc\na = \"x\n\xc3\xbc = 1") ==
        3);  // quotes that do not end with their line
  CHECK(line_of_bare_non_ascii("a = \"x\\") == 0);
  CHECK(line_of_bare_non_ascii("a\n\xc3\xbc = 1") == 2);
}

TEST_CASE(
    "a profile with a bare character beyond ASCII is refused with its line, and an override takes it for a "
    "text") {
  const auto refusal = [](const std::string& toml) {
    try {
      Profile profile(toml, "own.toml");
      return std::string();
    } catch (const ProfileError& error) {
      return std::string(error.what());
    }
  };
  for (const char* header : {"[|", "[[[", "[\2"})  // found by fuzzing: the library assumed that none comes
    CHECK(refusal(std::string("\n") + header).find("own.toml:2: not valid TOML: ") == 0);
  CHECK(refusal("\n\xef\xbb\xbd = 1").find("own.toml:2: not valid TOML: a character beyond ASCII") == 0);
  CHECK(refusal("\n31=+'\xef\xbb\xa8:)':)").find("own.toml:2: not valid TOML: ") ==
        0);  // and that none is like this
  Profile profile("[scene]\nname = \"a\"\nvehicle = \"ugv\"\n", "own.toml",
                  {"scene.about=Gr\xc3\xbc\xc3\x9f"
                   "e"});
  CHECK(profile.about() ==
        "Gr\xc3\xbc\xc3\x9f"
        "e");
}

TEST_CASE("an override whose key no profile could have is refused") {
  const std::string toml = "[scene]\nname = \"a\"\nvehicle = \"ugv\"\n";
  // The first was found by fuzzing: such a key did not come back from the canonical text.
  for (const char* assignment : {"\377l\010=", "a b=1", "a\"b=1", "gr\303\274n=1"}) {
    INFO(assignment);
    CHECK_THROWS_WITH(Profile(toml, "own.toml", {assignment}), Catch::Contains("a key has letters"));
  }
  CHECK_NOTHROW(Profile(toml, "own.toml", {"a.b_c-1=2"}));
}

TEST_CASE("what is UTF-8 is told from what is not, and an override that is not is refused") {
  for (const char* good : {"", "a", "\xc2\x80", "\xdf\xbf", "\xe0\xa0\x80", "\xed\x9f\xbf", "\xee\x80\x80",
                           "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf"}) {
    CHECK(is_utf8(good));
  }
  for (const char* bad : {"\x80", "\xc2", "\xc1\xbf", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xf0\x8f\xbf\xbf",
                          "\xf4\x90\x80\x80", "\xf5", "a\xe2\x82", "\xe2\x28\xa1"}) {
    CHECK_FALSE(is_utf8(bad));
  }
  for (const char* assignment : {"66=\277", "Q=\np6=\t#", "a=\x7f"}) {  // the first two were found by fuzzing
    INFO(assignment);
    CHECK_THROWS_WITH(Profile("[scene]\nname = \"a\"\nvehicle = \"ugv\"\n", "own.toml", {assignment}),
                      Catch::Contains("no line of UTF-8"));
  }
}
