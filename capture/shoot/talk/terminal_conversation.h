// A session with a person at a terminal: sentences out, words in.
#pragma once

#include <memory>
#include <string>

#include "capture/shoot/session/conversation.h"

namespace keypose::capture::shoot {

std::unique_ptr<Conversation> MakeTerminal(int in, int out);

/// "again 45", "skip", "" (only Enter).
/// @throws InputError  none of the words; names the nearest
Command ParseWords(const std::string& line);

/// What a person reads for an event; "" for those that need no words.
std::string SentenceOf(const nlohmann::json& event);

}  // namespace keypose::capture::shoot
