#include "report/verdicts/evidence_findings.h"

#include <fmt/format.h>

#include "report/evidence/verdict_limits.h"
#include "report/html/html.h"

namespace keypose::report {
namespace {

/// @param fitted  the pose has few photographs
const char* CureOf(bool good, bool fitted, const char* cure) {
  if (good) return "";
  return fitted ? kMorePhotographs : cure;
}

void FindInOutlines(const std::string& pose, const PoseEvidence& e, bool fitted,
                    std::vector<Finding>& out) {
  const bool good = e.outline_off<kOutlineGood, wrong = e.outline_off> kOutlineWrong;
  const std::string count = std::to_string(e.views.size());
  out.push_back(
      {GradeOf(good, !wrong), pose, "compared",
       "In the median of " + count + " photographs the mesh\u2019s outline is " +
           Bold(Percent(e.outline_off)) + " of the figure\u2019s size from that of the photograph.",
       CureOf(good, fitted,
              "look at the pairs below: wrong cameras need photographs at most 20 degrees apart, "
              "wrong masks a plainer backdrop")});
  std::vector<std::string> off;
  for (const ViewEvidence& view : e.views)
    if (view.outline_off > kViewOutlineLook) off.push_back(view.name);
  if (off.empty() || wrong) return;
  out.push_back(
      {Grade::kLook, pose, "compared",
       "The mesh\u2019s outline does not fit " + Bold(Joined(off)) + ".",
       "look at these photographs and their masks: moved, another object, a hand, or a bad "
       "mask"});
}

void FindMissing(const std::string& pose, const MissingPart& missing, bool fitted,
                 std::vector<Finding>& out) {
  if (missing.shown_by.empty()) return;
  std::string text = "The mesh lacks a part of the figure that the masks of " +
                     Bold(Joined(missing.shown_by)) + " show, up to " +
                     Bold(Percent(missing.largest)) + " of it in a picture.";
  if (!missing.left_out_by.empty())
    text += " The masks of " + Bold(Joined(missing.left_out_by)) + " leave it out.";
  const char* cure =
      missing.left_out_by.empty()
          ? "shoot that part from more sides, and look at the mesh and the dense points there"
          : "look at these masks: a dark side before a dark backdrop, a shadow? paint the part in "
            "with the studio\u2019s brush, or light it evenly and shoot again";
  out.push_back({Grade::kLook, pose, "compared", text, fitted ? kMorePhotographs : cure});
}

void FindInDetails(const std::string& pose, const PoseEvidence& e, bool fitted,
                   std::vector<Finding>& out) {
  const bool good = e.structure >= kStructureGood, wrong = e.structure < kStructureWrong;
  out.push_back(
      {GradeOf(good, !wrong), pose, "compared",
       "Rendered from the same cameras, the textured mesh repeats the details of the photographs "
       "to " +
           Bold(fmt::format("{:.2f}", e.structure)) + " of 1.",
       CureOf(good, fitted,
              "look at the pairs below; a figure that moved, blur and wrong cameras smear the "
              "texture")});
  std::vector<std::string> unlike;
  for (const ViewEvidence& view : e.views)
    if (view.structure < kViewStructureLook) unlike.push_back(view.name);
  if (unlike.empty() || wrong) return;
  out.push_back(
      {Grade::kLook, pose, "compared",
       "The render repeats hardly any details of " + Bold(Joined(unlike)) + ".",
       "look at these photographs: blur, a lamp\u2019s reflection, or a figure that moved"});
}

}  // namespace

void FindInEvidence(const PosePart& pose, bool fitted, std::vector<Finding>& out) {
  const PoseEvidence& e = pose.evidence;
  if (e.views.empty()) return;
  FindInOutlines(pose.name, e, fitted, out);
  FindMissing(pose.name, e.missing, fitted, out);
  FindInDetails(pose.name, e, fitted, out);
  if (e.edges < kEdgesGood)
    out.push_back(
        {Grade::kLook, pose.name, "compared",
         "Along " + Bold(Percent(1 - e.edges)) +
             " of the mesh\u2019s outline the photographs show no change of colour: masks may "
             "cut into the figure, or clay and backdrop have similar colours.",
         std::string(
             "put the figure before a backdrop of another colour; or look at the masks and ") +
             kOwnMasks});
}

}  // namespace keypose::report
