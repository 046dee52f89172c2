#include "capture/board/board_words.h"

#include <algorithm>
#include <cctype>

#include "core/values/board_print.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

bool IsOneOf(std::string word, const std::vector<std::string>& words) {
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

bool SaysYes(const std::string& word) { return IsOneOf(word, {"auto", "true", "yes", "on", "1"}); }

bool SaysNo(const std::string& word) { return IsOneOf(word, {"none", "false", "no", "off", "0"}); }

std::vector<std::string> BoardWordProblems(const std::string& word) {
  if (SaysYes(word) || SaysNo(word)) return {};
  try {
    ParseBoard(word);
  } catch (const UsageError& error) {
    return {error.what()};
  }
  return {};
}

}  // namespace keypose::capture
