#include "capture/shoot/talk/json_lines.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/io/text/line_input.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot::json_lines_test {

using nlohmann::json;

TEST(ParseJsonCommand, ReadsAllFields) {
  const Command again = ParseJsonCommand(
      R"({"command": "again", "angle_deg": 45, "ring": 2, "flip": 1, "id": {"n": 7}, "new": 1})");
  EXPECT_EQ(again.kind, Command::Kind::kAgain);
  EXPECT_EQ(again.angle_deg, 45);
  EXPECT_EQ(again.ring, 2);
  EXPECT_EQ(again.flip, 1);
  EXPECT_EQ(again.id, R"({"n":7})");
  for (const char* word : {"shoot", "done", "go-on"})
    EXPECT_EQ(ParseJsonCommand(json{{"command", word}}.dump()).kind, Command::Kind::kGoOn);
  EXPECT_TRUE(ParseJsonCommand(R"({"command": "live", "on": true})").on);
}

TEST(ParseJsonCommand, RefusesWhatIsNoCommand) {
  for (const std::string& line :
       {std::string("{"), std::string("[]"), std::string("{}"), std::string(R"({"command": 5})"),
        std::string(R"({"command": "dance"})"), std::string(R"({"command": "again", "ring": "x"})"),
        std::string(150, '['), std::string("\xff")})
    EXPECT_THROW(ParseJsonCommand(line), InputError) << line.substr(0, 40);
}

TEST(LineInput, GivesLinesAsTheyComeAndTheLastWithoutItsEnd) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  LineInput input(ends[0]);
  EXPECT_FALSE(input.Next(0));
  ASSERT_EQ(write(ends[1], "one\ntw", 6), 6);
  EXPECT_EQ(input.Next(0.1), "one");
  EXPECT_FALSE(input.Next(0));
  ASSERT_EQ(write(ends[1], "o\n\nthree", 8), 8);
  EXPECT_EQ(input.Next(0.1), "two");
  EXPECT_EQ(input.Next(0.1), "");
  close(ends[1]);
  EXPECT_FALSE(input.over());
  EXPECT_EQ(input.Next(0.1), "three");
  EXPECT_FALSE(input.Next(0));
  EXPECT_TRUE(input.over());
  close(ends[0]);
}

TEST(LineInput, DropsALineThatNeverEnds) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  LineInput input(ends[0]);
  const std::string much(4096, 'x');
  for (int i = 0; i < 40; ++i) {
    ASSERT_EQ(write(ends[1], much.data(), much.size()), static_cast<ssize_t>(much.size()));
    EXPECT_FALSE(input.Next(0));
  }
  ASSERT_EQ(write(ends[1], "\nend\n", 5), 5);
  EXPECT_EQ(input.Next(0.1), "end");
  close(ends[0]), close(ends[1]);
}

}  // namespace keypose::capture::shoot::json_lines_test
