// A session that a program drives: JSON, one object a line; docs/shoot.md has the fields.
#pragma once

#include <memory>

#include "capture/shoot/session/conversation.h"

namespace keypose::capture::shoot {

/// Commands from `in`, events to `out`. The end of `in` ends the session.
std::unique_ptr<Conversation> MakeJsonLines(int in, int out);

/// @throws InputError  no command; says why
Command ParseJsonCommand(const std::string& line);

}  // namespace keypose::capture::shoot
