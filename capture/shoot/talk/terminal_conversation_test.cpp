#include "capture/shoot/talk/terminal_conversation.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/values/errors.h"

namespace keypose::capture::shoot::terminal_conversation_test {

using nlohmann::json;

TEST(ParseWords, UnderstandsWhatTheDocumentationSays) {
  EXPECT_EQ(ParseWords("").kind, Command::Kind::kGoOn);
  EXPECT_EQ(ParseWords("  again   r2_a045 ").photograph, "r2_a045");
  EXPECT_EQ(ParseWords("again 45").photograph, "45");
  EXPECT_EQ(ParseWords("at 22.5").angle_deg, 22.5);
  EXPECT_EQ(ParseWords("next bent").pose, "bent");
  EXPECT_EQ(ParseWords("next bent 6").pose, "bent");
  EXPECT_EQ(ParseWords("next bent 6").angles, 6);
  EXPECT_THROW(ParseWords("next bent six"), InputError);
  EXPECT_EQ(ParseWords("skip").kind, Command::Kind::kSkip);
  EXPECT_EQ(ParseWords("pause").kind, Command::Kind::kPause);
  EXPECT_EQ(ParseWords("go").kind, Command::Kind::kGoOn);
  EXPECT_EQ(ParseWords("end").kind, Command::Kind::kEnd);
}

TEST(ParseWords, SaysWhatIsMeantOrMissing) {
  for (const auto& [line, hint] : {std::pair("agian 45", "`again`"),
                                   {"at", "at 45"},
                                   {"at x", "no angle"},
                                   {"next", "next bent"},
                                   {"again", "again 45"}}) {
    try {
      ParseWords(line);
      ADD_FAILURE() << line;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(hint), std::string::npos) << error.what();
    }
  }
}

TEST(SentenceOf, TellsWhatIsWrongAndWhatToDo) {
  const json fault = {
      {"event", "fault"}, {"words", "the card is full"}, {"do", "empty it"}, {"needs_hand", false}};
  EXPECT_EQ(SentenceOf(fault), "! the card is full; empty it\n");
  const json ask = {{"event", "ask"}, {"words", "turn the table to 45 degrees"}, {"do", ""}};
  EXPECT_EQ(SentenceOf(ask), "-> turn the table to 45 degrees, then press Enter\n");
  EXPECT_EQ(SentenceOf({{"event", "live"}, {"frame", 3}}), "");
}

}  // namespace keypose::capture::shoot::terminal_conversation_test
