#include "report/verdicts/verdicts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "report/evidence/verdict_limits.h"
#include "report/html/html.h"
#include "report/verdicts/evidence_findings.h"

namespace keypose::report {
namespace {

/// The names in a measurement that is a list of names or of objects with a name.
std::vector<std::string> NamesOf(const StepRecord& s, const char* list) {
  std::vector<std::string> names;
  const auto listed = s.lists.find(list);
  if (listed == s.lists.end()) return names;
  for (const auto& entry : nlohmann::json::parse(listed->second)) {
    if (entry.is_string()) names.push_back(entry);
    if (entry.is_object() && entry.contains("name")) names.push_back(entry.value("name", ""));
  }
  return names;
}

/// With a capital at its start and a full stop at its end, like other findings. File names are not
/// changed.
std::string AsSentence(std::string text) {
  const bool word = text.size() > 1 && std::islower(static_cast<unsigned char>(text[0])) &&
                    text.substr(0, text.find(' ')).find('.') == std::string::npos;
  if (word) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  if (!text.empty() && text.back() != '.') text += '.';
  return text;
}

/// Collects the findings on all steps.
class Findings {
 public:
  explicit Findings(std::vector<Finding>& out) : out_(out) {}

  void Capture(const StepRecord& s) {
    const auto sharp = s.Number("mean_sharpness");
    if (sharp && *sharp < kSharpnessLook)
      Add(Grade::kLook, s,
          "The photographs are soft: sharpness " + Bold(fmt::format("{:.2f}", *sharp)) +
              ", in focus it is 0.52 or more.",
          "use a tripod, fixed focus and a smaller aperture, and shoot this pose again");
    if (const auto blurred = NamesOf(s, "blurred"); !blurred.empty())
      Add(Grade::kLook, s,
          Bold(std::to_string(blurred.size())) + " photographs are blurred: " + Joined(blurred) +
              ".",
          "shoot them again, or take them out of the folder");
    if (const auto others = NamesOf(s, "other_things"); !others.empty())
      Add(Grade::kLook, s,
          "Another thing than the others, or the set without the figure, is shown by " +
              Bold(Joined(others)) + ", left out.",
          "take them out of the folder, or, if they do show the figure, set `other_things: keep`");
    if (const auto empty = NamesOf(s, "empty_masks"); !empty.empty())
      Add(Grade::kLook, s, "No figure was found in " + Bold(Joined(empty)) + ".",
          "look at them: paint their masks, or take them out of the folder");
  }

  void Sfm(const StepRecord& s) {
    const auto total = s.Number("images_total"), placed = s.Number("images_placed"),
               error = s.Number("reprojection_error_px");
    if (total && placed && *total > 0) {
      const bool enough = *placed / *total >= kPlacedGood;
      const auto names = NamesOf(s, "not_placed");
      const Grade otherwise = enough ? Grade::kNote : Grade::kLook;
      Add(*placed == *total ? Grade::kGood : otherwise, s,
          Bold(Pretty(*placed) + " of " + Pretty(*total)) + " photographs were placed" +
              (names.empty() ? "." : ", all but " + Joined(names) + "."),
          enough ? "" : "shoot the places between them again, at most 20 degrees apart and sharp");
    }
    if (error)
      Add(*error < kReprojectionGood ? Grade::kGood : Grade::kLook, s,
          "Mean reprojection error " + Bold(Pretty(*error) + " px") + ".",
          *error < kReprojectionGood ? ""
                                     : "look for blur, zooming between photographs, or a "
                                       "background that turns with the figure");
    CamerasFrom(s);
  }

  /// The method that estimated the cameras if features alone did not.
  void CamerasFrom(const StepRecord& s) {
    static const std::map<std::string, const char*> kMethods = {
        {"ring", "a model of the turntable, since features alone left photographs out."},
        {"silhouettes", "the outlines alone, since features were too few."},
        {"board", "the printed calibration board."},
        {"poses", "the camera poses that were given."}};
    const auto method = s.texts.find("method");
    const auto known = method == s.texts.end() ? kMethods.end() : kMethods.find(method->second);
    if (known == kMethods.end()) return;
    const bool outlines = known->first == "silhouettes";
    Add(outlines ? Grade::kLook : Grade::kNote, s, "Cameras come from " + Bold(known->second),
        outlines ? "compare photographs and renders below; a newspaper or a calibration board "
                   "under the figure adds features"
                 : "");
  }

  /// Photographs that the others contradict.
  void Masks(const StepRecord& s) {
    if (const auto names = NamesOf(s, "distrusted"); !names.empty())
      Add(Grade::kLook, s,
          "The other photographs contradict " + Bold(Joined(names)) +
              "; they were not used for the shape.",
          "look at them: another object, a moved figure or a hand; take them out of the folder or "
          "shoot them again");
    else if (const auto disagreeing = NamesOf(s, "views_disagreeing"); !disagreeing.empty())
      Add(Grade::kLook, s,
          "The outlines of " + Bold(Joined(disagreeing)) + " do not fit those of the others.",
          std::string("look at their masks and ") + kOwnMasks +
              ", or take the photographs out of the folder");
    if (const auto names = NamesOf(s, "hidden_behind_others"); !names.empty())
      Add(Grade::kNote, s,
          "Something stands before the figure in " + Bold(Joined(names)) +
              "; they were not used for the shape.",
          "");
    if (const auto agreement = s.Number("agreement"))
      Add(Grade::kNote, s,
          "Masks overlap the visual hull of the others by " + Bold(Percent(*agreement)) +
              " on average.");
  }

  void Refine(const StepRecord& s) {
    if (const auto evidence = s.Number("evidence"))
      Add(*evidence < kEvidenceLook ? Grade::kLook : Grade::kNote, s,
          "Photographs or outlines determine " + Bold(Percent(*evidence)) +
              " of the surface; the rest follows its surroundings.",
          *evidence < kEvidenceLook ? "press small marks or speckles into plain clay, or shoot "
                                      "more and closer photographs"
                                    : "");
    if (const auto light = s.Number("shading_error_after"))
      Add(Grade::kNote, s,
          "Shape and lamps explain the brightness of the photographs to within " +
              Bold(Percent(*light)) + ".");
  }

  void Cleanup(const StepRecord& s, const StepRecord* refine) {
    const auto closed = s.Number("closed"), crossings = s.Number("self_intersections");
    if (closed)
      Add(*closed > 0 ? Grade::kGood : Grade::kWrong, s,
          *closed > 0 ? "The mesh is a " + Bold("closed, oriented 2-manifold") + "."
                      : "The mesh is " + Bold("not closed") + ".",
          *closed > 0 ? "" : "keypose log cleanup shows where; add photographs of that side");
    if (crossings && *crossings > 0)
      Add(Grade::kWrong, s, Bold(Pretty(*crossings)) + " faces still intersect others.",
          "try more faces, e.g. --set cleanup.faces=40000, or photograph the gap between the parts "
          "that touch");
    // The distance of soles cut flat at the ground from the scan's caps is at most the depth of the
    // caps below the ground.
    const double soles = s.Number("cut_below_ground_over_diag").value_or(0);
    if (const auto far = s.Number("distance_to_input_p99_over_diag");
        far && *far > std::max(kClosedFarLook, soles))
      Add(Grade::kLook, s,
          "Large holes were closed: 1 % of the surface is more than " + Bold(Percent(*far)) +
              " of the diagonal from the scan.",
          "shoot the sides that no photograph shows");
    if (const auto unseen = s.Number("unseen_share"); unseen && *unseen > kUnseenSurfaceLook)
      Add(Grade::kLook, s,
          Bold(Percent(*unseen)) + " of the surface was seen by no camera: it is closed by guess.",
          "shoot the sides that no photograph shows, also from lower and from above");
    const auto moved = s.Number("undamaged_from_input_p99_over_diag"),
               diagonal = s.Number("diagonal");
    const double footprint = refine ? refine->Number("footprint").value_or(0) : 0;
    if (moved && diagonal && footprint > 0)
      Add(Grade::kNote, s,
          "Clean-up moved undamaged surface by less than " +
              Bold(Pretty(*moved * *diagonal / footprint)) +
              " of a photograph\u2019s pixel (99 %); more faces keep more detail.");
  }

  void Unwrap(const StepRecord& s) {
    const double flips = s.Number("flipped").value_or(0),
                 overlaps = s.Number("overlapping").value_or(0);
    if (flips > 0 || overlaps > 0)
      Add(Grade::kWrong, s,
          Bold(Pretty(flips)) + " flipped and " + Bold(Pretty(overlaps)) +
              " overlapping triangles in the UV layout.",
          "this is a fault of unwrap: please file it with the mesh");
  }

  /// @param fitted  the pose has few photographs
  void Bake(const StepRecord& s, const StepRecord* complete, bool fitted) {
    // Texels that are filled from other poses' photographs are not guessed.
    const bool scan = !s.Input("scan").empty();
    const char* cure = fitted ? kMorePhotographs
                              : "shoot a second ring from lower or higher, and between the limbs";
    if (scan) cure = "scan the sides that are missing, or raise scan_reach";
    if (const auto unseen = (complete ? *complete : s).Number("unseen_fraction"))
      Add(*unseen < kUnseenLook ? Grade::kNote : Grade::kLook, s,
          Bold(Percent(*unseen)) + " of the texture was in no " + (scan ? "scan" : "photograph") +
              (complete ? " of any pose" : "") + " and is filled in from its surroundings.",
          *unseen < kUnseenLook ? "" : cure);
    if (const auto psnr = s.Number("held_out_psnr_gain_db"))
      Add(Grade::kNote, s,
          "A texture of the other photographs predicts those left out at " +
              Bold(Pretty(*psnr) + " dB") + " PSNR.");
  }

  void Register(const StepRecord& s) {
    // In a crease the nearest face may be of the opposite wall: those are no fault to act on.
    const auto flipped = s.Number(s.Number("flipped_clearly") ? "flipped_clearly" : "flipped"),
               rms = s.Number("surface_rms_over_diag"),
               landmark = s.Number("landmark_max_over_diag");
    const std::string more = "add landmarks where the picture below marks them";
    const double faces = s.Number("faces").value_or(20000), few_flips = kFlipsLook * faces,
                 most_flips = kFlipsWrong * faces;
    if (flipped)
      Add(GradeOf(*flipped <= few_flips, *flipped <= most_flips), s,
          *flipped == 0
              ? Bold("No") + " triangle of the registered template is flipped."
              : Bold(Pretty(*flipped)) + " triangles of the registered template are flipped.",
          *flipped <= few_flips ? "" : more);
    if (rms)
      Add(GradeOf(*rms < kRegisteredGood, *rms < kRegisteredWrong), s,
          "The registered surface lies " + Bold(Percent(*rms)) +
              " of the diagonal from the scan (rms).",
          *rms < kRegisteredGood ? "" : more);
    if (landmark && *landmark > kLandmarkLook)
      Add(Grade::kLook, s,
          "The distance to a landmark is " + Bold(Percent(*landmark)) + " of the diagonal.",
          "check its pick; the residuals below name it");
    if (const auto high = s.Number("stretch_high"), low = s.Number("stretch_low");
        high && low && *low > 0)
      if (*high > kStretchLook || *low < 1 / kStretchLook)
        Add(Grade::kLook, s,
            "Parts of the template are stretched to " + Bold(Pretty(*high)) + " or pressed to " +
                Bold(Pretty(*low)) + " of their length.",
            more + "; this is correct where clay was added or removed");
  }

  /// A pose from few photographs takes the template's lens.
  /// @param own, whole  capture of the pose and of the template; may be null
  void Lens(const StepRecord& s, const StepRecord* own, const StepRecord* whole) {
    const auto focal = [](const StepRecord* capture) {
      const auto of = [&](const char* name) {
        return capture ? capture->Number(name).value_or(0) : 0;
      };
      const double longer = std::max(of("width"), of("height"));
      return longer > 0 ? of("focal_px") / longer : 0;
    };
    const double here = focal(own), there = focal(whole);
    if (here <= 0 || there <= 0 || std::abs(here / there - 1) < kFittedFocalLook) return;
    Add(Grade::kLook, s,
        "By their EXIF its photographs have " + Bold(Percent(here / there)) +
            " of the template\u2019s focal length, but the template\u2019s lens was taken for "
            "them.",
        "shoot the pose again with lens and zoom as for the template, or scan it");
  }

  /// A pose from few photographs: what the template was bent into, and what nothing shows.
  void Fit(const StepRecord& s, const PosePart* pose) {
    if (pose && !pose->evidence.views.empty()) Overlap(s, pose->evidence.views);
    if (const auto flipped = s.Number("flipped"))
      Add(*flipped == 0 ? Grade::kGood : Grade::kLook, s,
          *flipped == 0 ? Bold("No") + " triangle of the bent template is flipped."
                        : Bold(Pretty(*flipped)) + " triangles of the bent template are flipped.",
          *flipped == 0 ? "" : kMorePhotographs);
    if (const auto unseen = s.Number("unseen"))
      Add(*unseen < kFittedUnseenLook ? Grade::kNote : Grade::kLook, s,
          "No photograph shows " + Bold(Percent(*unseen)) +
              " of its surface; there it follows the template.",
          *unseen < kFittedUnseenLook ? "" : kMorePhotographs);
    if (const auto volume = s.Number("volume_ratio");
        volume && std::abs(*volume - 1) > kFittedVolumeLook)
      Add(Grade::kLook, s, "Its volume is " + Bold(Percent(*volume)) + " of the template\u2019s.",
          std::string("if no clay was added or removed: ") + kMorePhotographs);
  }

  void Track(const StepRecord& s) {
    const auto iou = s.Number("iou_mean"), cameras = s.Number("cameras");
    if (!iou) return;
    const bool good = *iou >= kTrackedIouGood;
    const auto least = s.Number("iou_least"), frame = s.Number("iou_least_frame");
    Add(GradeOf(good, *iou >= kTrackedIouWrong), s,
        "The tracked body overlaps the actor in " + Pretty(cameras.value_or(0)) + " cameras by " +
            Bold(Percent(*iou)) + " (mean IoU" +
            (least && frame ? "; least " + Percent(*least) + ", in frame " + Pretty(*frame) : "") +
            ").",
        good ? "" : "look at the masks of the frames that fit worst, and at the calibration");
  }

  void Transfer(const StepRecord& s) {
    if (const auto volume = s.Number("volume_deviation"))
      Add(*volume <= kTransferVolumeLook ? Grade::kNote : Grade::kLook, s,
          "The scan's volume changes by up to " + Bold(Percent(*volume)) + " in its motion.",
          *volume <= kTransferVolumeLook ? "" : "add marks on both sides of the joints that bend");
  }

  void Overlap(const StepRecord& s, const std::vector<ViewEvidence>& views) {
    double sum = 0, least = 1;
    for (const ViewEvidence& view : views) {
      sum += view.iou;
      least = std::min(least, view.iou);
    }
    const double mean = sum / static_cast<double>(views.size());
    const bool good = mean >= kFittedIouGood;
    Add(GradeOf(good, mean >= kFittedIouWrong), s,
        "The template, bent into " + std::to_string(views.size()) +
            " photographs, overlaps the figure in them by " + Bold(Percent(mean)) +
            " (IoU; least " + Percent(least) + ").",
        good ? "" : kMorePhotographs);
  }

  void Put(Finding finding) { out_.push_back(std::move(finding)); }

  /// Steps that read the same input warn of the same: that is one finding.
  void Warning(Finding finding) {
    const auto same = std::find_if(out_.begin(), out_.end(), [&](const Finding& f) {
      return f.pose == finding.pose && f.grade == finding.grade && f.text == finding.text;
    });
    if (same == out_.end())
      Put(std::move(finding));
    else
      same->where += ", " + finding.where;
  }

 private:
  void Add(Grade grade, const StepRecord& s, const std::string& text,
           const std::string& cure = "") {
    Put({grade, s.pose, s.id.empty() ? s.stage : s.id, text, cure});
  }
  std::vector<Finding>& out_;
};

void FindOnAnimation(const AnimationPart& animation, std::vector<Finding>& out) {
  const DistortionRow area = AreaRow(animation.frames), volume = VolumeRow(animation.frames);
  if (area.frames == 0) return;
  out.push_back({Grade::kNote, "", "interpolate",
                 "In-betweens depart from the first key by " + Bold(Percent(area.mean)) +
                     " in area (straight lines: " + Percent(area.linear_mean) + ") and " +
                     Bold(Percent(volume.mean)) +
                     " in volume (straight lines: " + Percent(volume.linear_mean) + ").",
                 ""});
}

const PosePart* PoseOf(const Contents& contents, const std::string& name) {
  const auto part = std::find_if(contents.poses.begin(), contents.poses.end(),
                                 [&](const PosePart& p) { return p.name == name; });
  return part == contents.poses.end() ? nullptr : &*part;
}

void FindOnStep(const StepRecord& step, const Contents& contents, std::vector<Finding>& out) {
  const RunRecord& run = contents.run;
  Findings findings(out);
  const std::string where = step.id.empty() ? step.stage : step.id;
  if (!step.done())
    findings.Put(
        {Grade::kWrong, step.pose, where,
         "This step is " + Bold(Escape(step.status)) + "; what follows from it is missing.",
         "keypose log " + where + " says why"});
  if (!step.trouble.empty())
    findings.Put(
        {Grade::kLook, step.pose, where, Escape(step.trouble) + ".", "keypose run makes it again"});
  // Capture's warnings are predictions, which later results replace; other stages' warnings are
  // about their results.
  for (const std::string& warning : step.warnings)
    findings.Warning({step.stage == "capture" ? Grade::kNote : Grade::kLook, step.pose, where,
                      AsSentence(Escape(warning)), ""});
  if (step.stage == "capture") findings.Capture(step);
  if (step.stage == "sfm") findings.Sfm(step);
  if (step.stage == "masks") findings.Masks(step);
  if (step.stage == "refine") findings.Refine(step);
  if (step.stage == "cleanup") findings.Cleanup(step, run.Find("refine", step.pose));
  if (step.stage == "unwrap") findings.Unwrap(step);
  if (step.stage == "bake")
    findings.Bake(step, run.Find("complete", step.pose), run.Find("fit", step.pose));
  if (step.stage == "register") findings.Register(step);
  if (step.stage == "track") findings.Track(step);
  if (step.stage == "transfer") findings.Transfer(step);
  if (step.stage == "fit") {
    findings.Fit(step, PoseOf(contents, step.pose));
    findings.Lens(step, run.Find("capture", step.pose), run.Find("capture", run.template_pose));
  }
}

/// Maximum number of findings in a verdict; the list below it has all.
constexpr int kFindingsInVerdict = 3;

int Badness(Grade grade) {
  switch (grade) {
    case Grade::kWrong:
      return 0;
    case Grade::kLook:
      return 1;
    case Grade::kGood:
      return 2;
    case Grade::kNote:
      break;
  }
  return 3;
}

/// The verdict from the findings with the worst grade; for a good pose, from the comparison with
/// the photographs.
Verdict VerdictOn(const std::string& about, const std::string& pose,
                  const std::vector<Finding>& findings) {
  Verdict verdict{about, Grade::kNote, "", ""};
  for (const Finding& f : findings)
    if (f.pose == pose && Badness(f.grade) < Badness(verdict.grade)) verdict.grade = f.grade;
  int count = 0;
  for (const Finding& f : findings) {
    const bool decides =
        f.grade == verdict.grade &&
        (f.grade != Grade::kGood || f.where == "compared" || f.where.starts_with("track"));
    if (f.pose != pose || !decides) continue;
    if (++count <= kFindingsInVerdict) verdict.why += (verdict.why.empty() ? "" : " ") + f.text;
    if (!f.cure.empty() && verdict.cure.find(f.cure) == std::string::npos)
      verdict.cure += (verdict.cure.empty() ? "" : "; ") + f.cure;
  }
  if (count > kFindingsInVerdict)
    verdict.why += fmt::format(" The report lists {} more.", count - kFindingsInVerdict);
  return verdict;
}

}  // namespace

const char* WordOf(Grade grade) {
  static const char* const kWords[] = {"good", "look", "wrong", "note"};
  return kWords[static_cast<int>(grade)];
}

std::vector<Finding> FindAll(const Contents& contents) {
  std::vector<Finding> all;
  for (const PosePart& pose : contents.poses)
    FindInEvidence(pose, contents.run.Find("fit", pose.name) != nullptr, all);
  for (const StepRecord& step : contents.run.steps) FindOnStep(step, contents, all);
  if (contents.animation) FindOnAnimation(*contents.animation, all);
  for (const std::string& trouble : contents.troubles)
    all.push_back({Grade::kLook, "", "report", Escape(trouble), ""});
  std::stable_sort(all.begin(), all.end(), [](const Finding& a, const Finding& b) {
    return Badness(a.grade) < Badness(b.grade);
  });
  return all;
}

std::vector<Verdict> Judge(const Contents& contents, const std::vector<Finding>& findings) {
  std::vector<Verdict> verdicts;
  for (const std::string& name : contents.run.poses) {
    verdicts.push_back(VerdictOn(name, name, findings));
    Verdict& verdict = verdicts.back();
    const PosePart* part = PoseOf(contents, name);
    const bool compared = part && !part->evidence.views.empty();
    if (compared || contents.run.performance || verdict.grade == Grade::kWrong) continue;
    if (!contents.run.Find("capture", name)) {  // there is no photograph of it
      if (verdict.grade == Grade::kNote) verdict.grade = Grade::kGood;
      if (verdict.why.empty())
        verdict.why = "Its mesh was made elsewhere; no step found anything against it.";
      continue;
    }
    verdict.grade = Grade::kLook;
    verdict.why = "There is no textured mesh to compare with the photographs. " + verdict.why;
    verdict.cure +=
        (verdict.cure.empty() ? "" : "; ") + std::string("run the project to its end: keypose run");
  }
  const Verdict animation = VerdictOn("animation", "", findings);
  if (animation.grade == Grade::kLook || animation.grade == Grade::kWrong)
    verdicts.push_back(animation);
  return verdicts;
}

std::string Plain(const std::string& html) {
  std::string plain = html;
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"<b>", ""},
                                 {"</b>", ""},
                                 {"&lt;", "<"},
                                 {"&gt;", ">"},
                                 {"&quot;", "\""},
                                 {"&amp;", "&"}})
    for (std::size_t at = 0; (at = plain.find(from, at)) != std::string::npos; at += to.size())
      plain.replace(at, from.size(), to);
  return plain;
}

}  // namespace keypose::report
