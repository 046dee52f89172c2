// The words of an option that may also say a board.
#pragma once

#include <string>
#include <vector>

namespace keypose::capture {

/// "auto", or as a switch is turned on.
bool SaysYes(const std::string& word);
/// "none", or as a switch is turned off.
bool SaysNo(const std::string& word);
/// One sentence where the word is neither of these nor a board.
std::vector<std::string> BoardWordProblems(const std::string& word);

}  // namespace keypose::capture
