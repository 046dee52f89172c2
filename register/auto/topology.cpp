#include "register/auto/topology.h"

#include <cmath>

#include "core/geometry.h"
#include "register/auto/welding.h"

namespace keypose::registration {

std::optional<int> HandlesOf(const Mesh& mesh) {
  const ClosedReport report = CheckClosed(Weld(mesh, FindSeams(mesh)).mesh);
  if (!report.closed()) return std::nullopt;
  return report.components - report.euler / 2;
}

std::string FusedTemplateProblem(const Mesh& source, const Mesh& target, double off_pose) {
  constexpr double kOff = 0.01;  // of the diagonal: a handle of noise does no harm, a web between
                                 // two limbs lies far off the pose
  const std::optional<int> ours = HandlesOf(source), theirs = HandlesOf(target);
  if (!ours || !theirs || *ours <= *theirs || off_pose <= kOff) return "";
  const int more = *ours - *theirs;
  return "the template has " + std::to_string(more) + (more == 1 ? " handle" : " handles") +
         " that the pose lacks, and the result lies up to " +
         std::to_string(std::lround(1000 * off_pose) / 10.0).substr(0, 4) +
         " % of the diagonal off the pose: parts that touch in the template, such as a hand on the "
         "hip, are one surface there and cannot "
         "come "
         "apart; make a pose in which they are apart the template (`template: NAME` in "
         "pipeline.yaml; --source by hand)";
}

}  // namespace keypose::registration
