// What the contents are worth: findings, and a verdict for each pose.
#pragma once

#include <string>
#include <vector>

#include "report/evidence/contents.h"
#include "report/verdicts/finding.h"

namespace keypose::report {

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
