#include "register/auto/fused_template.h"

#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/seams.h"

namespace keypose::registration {

std::optional<int> HandlesOf(const Mesh& mesh) {
  const ClosedReport report = CheckClosed(Weld(mesh, FindSeams(mesh)).mesh);
  if (!report.closed()) return std::nullopt;
  return report.components - report.euler / 2;
}

std::string FusedTemplateProblem(const Mesh& source, const Mesh& target, double off_pose) {
  // Over the diagonal. A handle from noise is small; a web between two limbs is far off the pose.
  constexpr double kOff = 0.01;
  const std::optional<int> ours = HandlesOf(source), theirs = HandlesOf(target);
  if (!ours || !theirs || *ours <= *theirs || off_pose <= kOff) return "";
  const int more = *ours - *theirs;
  return "the template has " + std::to_string(more) + (more == 1 ? " handle" : " handles") +
         " that the pose lacks, and the result lies up to " +
         std::to_string(std::lround(1000 * off_pose) / 10.0).substr(0, 4) +
         " % of the diagonal off the pose: parts that touch in the template, such as a hand on the "
         "hip, are one surface there and cannot "
         "separate; choose a template pose in which these parts do not touch (`template: NAME` in "
         "pipeline.yaml; --source by hand)";
}

}  // namespace keypose::registration
