// A judgement of a step's result.
#pragma once

#include <string>

namespace keypose::report {

enum class Grade { kGood, kLook, kWrong, kNote };
/// "good", "look", "wrong", "note".
const char* WordOf(Grade grade);
inline Grade GradeOf(bool good, bool usable) {
  if (good) return Grade::kGood;
  return usable ? Grade::kLook : Grade::kWrong;
}

/// One judgement of a step's result.
struct Finding {
  Grade grade;
  std::string pose;   ///< empty: the animation or the whole project
  std::string where;  ///< step
  std::string text;   ///< HTML
  std::string cure;   ///< what to do, as plain text; empty if nothing
};

}  // namespace keypose::report
