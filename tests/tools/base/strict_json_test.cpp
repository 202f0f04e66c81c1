// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/strict_json.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <ctime>
#include <filesystem>
#include <string>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

std::string nested(int depth, const std::string& open, const std::string& close) {
  std::string text;
  for (int i = 0; i < depth; ++i) text += open;
  text += "1";
  for (int i = 0; i < depth; ++i) text += close;
  return text;
}

TEST_CASE("JSON is read to a depth of a hundred and refused beyond, by every reader") {
  const TemporaryFolder folder;
  CHECK_NOTHROW(parse_json(nested(kDeepestJson, "[", "]"), "a.json"));
  CHECK_NOTHROW(parse_json(nested(kDeepestJson, "{\"a\":", "}"), "a.json"));
  for (const int depth : {kDeepestJson + 1, 100000}) {
    CAPTURE(depth);
    for (const std::string& text : {nested(depth, "[", "]"), nested(depth, "{\"a\":", "}")}) {
      const std::filesystem::path file = folder.with_file("a.json", text);
      const std::string sentence = file.string() + ": has arrays or objects more than 100 deep";
      CHECK_THROWS_WITH(parse_json(text, file.string()), sentence);
      CHECK_THROWS_WITH(read_json(file), sentence);
      CHECK_THROWS_WITH(read_json_with_comments(file), sentence);
    }
  }
}

TEST_CASE("a JSON file that is none is named, in one line") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(read_json(folder.with_file("a.json", "{\"a\":\n1e999}")),
                    Catch::StartsWith((folder / "a.json").string() + ": is not JSON: ") && !Catch::Contains("\n"));
  CHECK_THROWS_WITH(read_json(folder.with_file("a.json", "[1] // one")), Catch::Contains("is not JSON"));
  CHECK(read_json_with_comments(folder.with_file("a.json", "[1] // one")) == nlohmann::json{1});
  CHECK_THROWS_WITH(read_json(folder / "b.json"), (folder / "b.json").string() + ": no such file");
}

TEST_CASE("what stands for no number in JSON becomes a text, and nothing else does") {
  const auto read = [](const std::string& text) { return parse_json_with_nan(text, "a.json"); };
  CHECK(read("[nan, -nan(ind), Infinity, +inf, -INF, nan(0x7_f)]") ==
        nlohmann::json{"nan", "-nan(ind)", "Infinity", "+inf", "-INF", "nan(0x7_f)"});
  CHECK(read(R"(["nan", "a \" nan", "\\", 1, -2.5, true, null])") ==
        nlohmann::json{"nan", "a \" nan", "\\", 1, -2.5, true, nullptr});
  for (const char* const text :
       {"[nano]", "[xnan]", "[1nan]", "[nan(]", "[nan(a b)]", "[\"nan", "[\"\\", "--inf", "nan1"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH(read(text), Catch::StartsWith("a.json: is not JSON: "));
  }
}

TEST_CASE("time to read JSON with nan grows with its length, whatever it holds") {
  constexpr std::size_t kLength = 1 << 19;
  for (const char* const part : {"a", "nan(", "nan(a", "-", "\"", "\\", "in", "nan ", "nan()"}) {
    CAPTURE(part);
    std::string text = "[";
    while (text.size() < kLength) text += part;
    const std::clock_t start = std::clock();
    CHECK_THROWS_AS(parse_json_with_nan(text, "a.json"), InputError);
    CHECK(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC < 1.0);  // a minute where the square is taken
  }
}

// The library quotes what it read last, such as a comment that does not end.
TEST_CASE("the sentence about a file that is no JSON does not quote all of the file") {
  const TemporaryFolder folder;
  std::string text = "/* ";
  for (int i = 0; i < 1000; ++i) text += "\u00e9";
  const std::filesystem::path file = folder.with_file("a.json", text);
  for (const bool comments : {false, true}) {
    try {
      (void)(comments ? read_json_with_comments(file) : read_json(file));
      FAIL("accepted");
    } catch (const InputError& error) {
      const std::string sentence = error.what();
      CHECK(sentence.size() < file.string().size() + 250);
      CHECK_THAT(sentence, Catch::StartsWith(file.string() + ": is not JSON: "));
      CHECK_NOTHROW(nlohmann::json(sentence).dump());  // whole characters
    }
  }
}

TEST_CASE("a pipe in a JSON file's place is refused, and not waited for") {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "a.json";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  CHECK_THROWS_WITH(read_json(pipe), pipe.string() + ": is not a file");
  CHECK_THROWS_WITH(read_json_with_comments(pipe), pipe.string() + ": is not a file");
}

}  // namespace
}  // namespace lumatlas
