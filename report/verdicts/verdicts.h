// What the contents are worth: findings, and a verdict for each pose.
#pragma once

#include <string>
#include <vector>

#include "report/evidence/contents.h"

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
/// All findings, worst first. The limits are in verdict_limits.h.
std::vector<Finding> FindAll(const Contents& contents);

/// Whether a pose (or "animation") is good enough.
struct Verdict {
  std::string about;
  Grade grade;
  std::string why;   ///< HTML: the findings that decided
  std::string cure;  ///< what to do about them; empty if good
};
/// One verdict per pose in the project's order, with the grade of its worst finding; then one for
/// the animation if it is not good.
std::vector<Verdict> Judge(const Contents& contents, const std::vector<Finding>& findings);
/// The text without HTML.
std::string Plain(const std::string& html);

}  // namespace keypose::report
