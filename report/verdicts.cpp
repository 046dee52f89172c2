// The rules of Judge in contents.h.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "report/contents.h"
#include "report/html.h"

namespace keypose::report {
namespace {

constexpr std::size_t kNamesShown = 8;

std::string Bold(const std::string& text) { return "<b>" + text + "</b>"; }

/// Collects verdicts on one step after another.
class Judges {
 public:
  explicit Judges(std::vector<Verdict>& out) : out_(out) {}

  void Sfm(const StepRecord& s) {
    const auto total = s.Number("images_total"), placed = s.Number("images_placed"), error = s.Number("reprojection_error_px");
    if (total && placed && *total > 0) {
      const double share = *placed / *total;
      const std::string names = Names(s, "not_placed");
      Add(share > 0.899 ? Grade::kGood : Grade::kLook, s,
          Bold(Pretty(*placed) + " of " + Pretty(*total)) + " photographs placed" + (names.empty() ? "" : ", all but " + names) +
              (share > 0.899 ? "." : ": the others left gaps; the log of sfm says more."));
    }
    if (error)
      Add(*error < 1   ? Grade::kGood
          : *error < 2 ? Grade::kLook
                       : Grade::kBad,
          s,
          "Mean reprojection error " + Bold(Pretty(*error) + " px") +
              (*error < 1 ? "." : ": cameras are vague; look for blur, zooming or a moving background."));
    Rung(s);
    // The masks of before `masks` made them agree: it makes them agree with wrong cameras as well.
    if (const std::string names = Names(s, "views_disagreeing"); !names.empty())
      Add(Grade::kInfo, s,
          "As they were photographed, the silhouettes of these views miss the visual hull of the others, by their mask or their camera: " +
              names + ".");
  }

  /// Which rung of the ladder placed the cameras, where it was not the first.
  void Rung(const StepRecord& s) {
    static const std::map<std::string, std::pair<Grade, const char*>> kRungs = {
        {"ring", {Grade::kInfo, "a model of the turntable, since features alone left photographs out."}},
        {"silhouettes", {Grade::kLook, "the outlines alone, since features were too few: check the picture of the cameras."}},
        {"plate", {Grade::kInfo, "the printed plate."}},
        {"poses", {Grade::kInfo, "the poses that were given."}}};
    const auto method = s.texts.find("method");
    if (method == s.texts.end()) return;
    const auto rung = kRungs.find(method->second);
    if (rung != kRungs.end()) Add(rung->second.first, s, "Cameras come from " + Bold(rung->second.second));
  }

  /// Views whose silhouettes the others contradict: a wrong mask, a turned photograph or a wrong principal point.
  void Masks(const StepRecord& s) {
    const auto agreement = s.Number("agreement");
    if (!agreement || !s.lists.contains("views_disagreeing")) return;
    const std::string names = Names(s, "views_disagreeing");
    Add(names.empty() ? Grade::kGood : Grade::kLook, s,
        "Silhouettes overlap the visual hull of the others by " + Bold(Percent(*agreement)) + " on average" +
            (names.empty() ? "" : "; these disagree, by their mask or their camera: " + names) + ".");
  }

  /// How well the refined surface is held by what the photographs show: outlines, what they agree on, and light.
  void Refine(const StepRecord& s) {
    const auto gap = s.Number("outline_gap_px"), gap_before = s.Number("outline_gap_before_px"), evidence = s.Number("evidence");
    if (gap && gap_before && std::max(*gap, *gap_before) > 0)
      Add(*gap < 1   ? Grade::kGood
          : *gap < 3 ? Grade::kLook
                     : Grade::kBad,
          s,
          "The surface's outlines miss those of the masks by " + Bold(Pretty(*gap) + " px") + " on average (" + Pretty(*gap_before) +
              " before the photographs moved it)" + (*gap < 1 ? "." : ": masks are ragged, or cameras and masks contradict each other."));
    if (evidence)
      Add(*evidence >= 0.2 ? Grade::kGood : Grade::kLook, s,
          "Photographs or outlines tell the place of " + Bold(Percent(*evidence)) + " of the surface; the rest follows its surroundings" +
              (*evidence >= 0.2 ? "." : ": speckles, or more photographs, would hold it better."));
    const auto light = s.Number("shading_error_after"), light_before = s.Number("shading_error_before");
    if (light && light_before && *light_before > 0)
      Add(*light <= *light_before ? Grade::kGood : Grade::kLook, s,
          "Shape and lamps explain the brightness of the photographs to " + Bold(Percent(*light)) + " (" + Percent(*light_before) +
              " before)" +
              (*light <= *light_before ? "." : ": lamps that moved or a shiny surface mislead it; try --set refine.shading=0."));
  }

  void Cleanup(const StepRecord& s, const StepRecord* refine) {
    const auto closed = s.Number("closed"), crossings = s.Number("self_intersections");
    if (closed)
      Add(*closed > 0 ? Grade::kGood : Grade::kBad, s,
          *closed > 0 ? "Mesh is a " + Bold("closed, oriented 2-manifold") + "." : "Mesh is " + Bold("not closed") + ".");
    if (crossings && *crossings > 0) Add(Grade::kBad, s, Bold(Pretty(*crossings)) + " self-intersecting faces remain.");
    const auto far = s.Number("distance_to_input_p99_over_diag");
    if (far && *far > 0.02)
      Add(Grade::kLook, s,
          "1 % of the cleaned surface is more than " + Bold(Percent(*far)) + " of the diagonal from the scan: large holes were closed.");
    const auto moved = s.Number("undamaged_from_input_p99_over_diag"), diagonal = s.Number("diagonal"), share = s.Number("undamaged_share");
    const double footprint = refine ? refine->Number("footprint").value_or(0) : 0;
    if (!moved || !diagonal || !share || !(footprint > 0) || *share < 0.01) return;
    const double footprints = *moved * *diagonal / footprint;
    Add(footprints <= 0.5 ? Grade::kGood
        : footprints <= 1 ? Grade::kInfo
                          : Grade::kLook,
        s,
        "99 % of the surface that needed no repair (" + Percent(*share) + ") moved by less than " + Bold(Pretty(footprints)) +
            " of a photograph's pixel" + (footprints <= 1 ? "." : ": more faces keep more detail, e.g. --set cleanup.faces=40000."));
  }

  void Unwrap(const StepRecord& s) {
    const double flips = s.Number("flipped").value_or(0), overlaps = s.Number("overlaps").value_or(s.Number("overlapping").value_or(0));
    if (flips > 0 || overlaps > 0)
      Add(Grade::kBad, s, Bold(Pretty(flips)) + " flipped and " + Bold(Pretty(overlaps)) + " overlapping triangles in the UV layout.");
  }

  void Bake(const StepRecord& s) {
    if (const auto unseen = s.Number("unseen_fraction"))
      Add(*unseen < 0.06  ? Grade::kGood
          : *unseen < 0.2 ? Grade::kLook
                          : Grade::kBad,
          s,
          Bold(Percent(*unseen)) + " of the texture was in no photograph and is inpainted" +
              (*unseen < 0.06 ? "." : ": photograph from below or between the limbs."));
    const auto left_out = s.Number("held_out_psnr_gain_db"), left_out_ssim = s.Number("held_out_ssim");
    if (left_out && left_out_ssim)
      Add(*left_out > 24   ? Grade::kGood
          : *left_out > 19 ? Grade::kLook
                           : Grade::kBad,
          s,
          "A texture of the other photographs predicts those left out at " + Bold(Pretty(*left_out) + " dB") + " PSNR, SSIM " +
              Bold(Pretty(*left_out_ssim)) + ".");
    if (const auto psnr = s.Number("psnr_gain_db"))
      Add(*psnr > 28   ? Grade::kGood
          : *psnr > 22 ? Grade::kLook
                       : Grade::kBad,
          s, "The textured mesh repeats the photographs at " + Bold(Pretty(*psnr) + " dB") + " PSNR.");
  }

  void Register(const StepRecord& s) {
    const auto flipped = s.Number("flipped"), rms = s.Number("surface_rms_over_diag"), landmark = s.Number("landmark_max_over_diag");
    if (flipped)
      Add(*flipped == 0    ? Grade::kGood
          : *flipped <= 20 ? Grade::kLook
                           : Grade::kBad,
          s,
          *flipped == 0 ? Bold("No flipped") + " triangle in the registered template."
                        : Bold(Pretty(*flipped)) + " triangles of the registered template are flipped.");
    if (rms)
      Add(*rms < 0.004   ? Grade::kGood
          : *rms < 0.015 ? Grade::kLook
                         : Grade::kBad,
          s, "Registered surface lies " + Bold(Percent(*rms)) + " of the diagonal from the scan (rms).");
    if (landmark && *landmark > 0.03)
      Add(Grade::kLook, s, "A landmark is missed by " + Bold(Percent(*landmark)) + " of the diagonal: check its pick.");
  }

 private:
  /// "a.jpg, b.jpg and 3 more" from a measurement that is a list; empty when there is none.
  static std::string Names(const StepRecord& s, const char* list) {
    const auto listed = s.lists.find(list);
    if (listed == s.lists.end()) return "";
    std::vector<std::string> names;
    for (const auto& name : nlohmann::json::parse(listed->second))
      if (name.is_string()) names.push_back(name);
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kNamesShown); ++i) text += (i ? ", " : "") + Escape(names[i]);
    if (names.size() > kNamesShown) text += " and " + std::to_string(names.size() - kNamesShown) + " more";
    return text;
  }

  void Add(Grade grade, const StepRecord& s, const std::string& text) { out_.push_back({grade, s.id.empty() ? s.stage : s.id, text}); }
  std::vector<Verdict>& out_;
};

void JudgeAnimation(const AnimationPart& animation, std::vector<Verdict>& out) {
  const DistortionRow area = AreaRow(animation.frames), volume = VolumeRow(animation.frames);
  if (area.frames == 0) return;
  const auto better = [](double ours, double linear) { return std::abs(ours) <= std::abs(linear) ? "less than" : "more than"; };
  out.push_back({Grade::kInfo, "interpolate",
                 "In-betweens depart from the first key by " + Bold(Percent(area.mean)) + " in area (" +
                     better(area.mean, area.linear_mean) + " straight lines: " + Percent(area.linear_mean) + ") and " +
                     Bold(Percent(volume.mean)) + " in volume (" + better(volume.mean, volume.linear_mean) +
                     " straight lines: " + Percent(volume.linear_mean) + ")."});
}

}  // namespace

std::vector<Verdict> Judge(const Contents& contents) {
  std::vector<Verdict> verdicts;
  Judges judges(verdicts);
  for (const StepRecord& step : contents.run.steps) {
    if (!step.done())
      verdicts.push_back({Grade::kBad, step.id, "This step is " + Bold(Escape(step.status)) + "; what follows from it is missing below."});
    if (!step.trouble.empty()) verdicts.push_back({Grade::kLook, step.id, Escape(step.trouble)});
    if (step.stage == "sfm") judges.Sfm(step);
    if (step.stage == "masks") judges.Masks(step);
    if (step.stage == "refine") judges.Refine(step);
    if (step.stage == "cleanup") judges.Cleanup(step, contents.run.Find("refine", step.pose));
    if (step.stage == "unwrap") judges.Unwrap(step);
    if (step.stage == "bake") judges.Bake(step);
    if (step.stage == "register") judges.Register(step);
  }
  if (contents.animation) JudgeAnimation(*contents.animation, verdicts);
  for (const std::string& trouble : contents.troubles) verdicts.push_back({Grade::kLook, "report", Escape(trouble)});
  const auto rank = [](Grade grade) { return grade == Grade::kBad ? 0 : grade == Grade::kLook ? 1 : grade == Grade::kGood ? 2 : 3; };
  std::stable_sort(verdicts.begin(), verdicts.end(), [&](const Verdict& a, const Verdict& b) { return rank(a.grade) < rank(b.grade); });
  return verdicts;
}

}  // namespace keypose::report
