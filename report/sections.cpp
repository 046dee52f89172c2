#include "report/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "report/html.h"
#include "report/limits.h"
#include "report/pictures.h"

namespace keypose::report {
namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;

/// A measurement's value as text, with the unit from its name.
std::string Value(const StepRecord& step, const std::string& name) {
  if (const auto flag = step.flags.find(name); flag != step.flags.end())
    return flag->second ? "yes" : "no";
  if (const auto text = step.texts.find(name); text != step.texts.end())
    return Escape(text->second);
  const auto number = step.Number(name);
  if (!number) return "";
  const auto ends = [&](const char* suffix) {
    return name.size() >= std::char_traits<char>::length(suffix) && name.ends_with(suffix);
  };
  if (ends("_fraction") || ends("_over_diag")) return Percent(*number);
  if (ends("seconds")) return PrettySeconds(*number);
  if (ends("_bytes")) return PrettyBytes(*number);
  return Pretty(*number);
}

/// Adds those of `names` that the step has measured.
void AddFacts(const StepRecord* step, const std::vector<std::pair<const char*, const char*>>& names,
              Pairs& facts) {
  if (!step) return;
  for (const auto& [label, name] : names)
    if (const std::string value = Value(*step, name); !value.empty())
      facts.emplace_back(label, value);
}

std::string Chip(const StepRecord& step) {
  if (!step.done()) return "<span class=\"chip bad\">" + Escape(step.status) + "</span>";
  return step.cached ? "<span class=\"chip info\">reused</span>"
                     : "<span class=\"chip good\">made</span>";
}

/// A pose from few photographs has other stages than a scanned one.
std::vector<std::string> StagesOf(const RunRecord& run, const std::string& pose) {
  if (run.performance) return {"track", "export"};
  if (run.Find("fit", pose)) return {"capture", "fit", "bake"};
  return {"capture", "sfm", "masks", "dense", "mesh", "refine", "cleanup", "bake"};
}

std::string MissingStages(const Contents& contents, const PosePart& pose) {
  std::string missing;
  for (const std::string& stage : StagesOf(contents.run, pose.name)) {
    if (contents.run.All(stage).empty() || contents.run.Find(stage, pose.name)) continue;
    missing += (missing.empty() ? "" : ", ") + stage;
  }
  return missing.empty() ? "" : "<p class=lead>Not made for this pose: " + missing + ".</p>";
}

/// A fact about a pose: the stage that measured it, its label, and its key in the report.
struct Fact {
  const char *stage, *label, *key;
};
constexpr Fact kCaptureFacts[] = {
    {"capture", "photographs", "images"},
    {"capture", "photographs", "images_total"},
    {"capture", "mean sharpness", "mean_sharpness"},
};
constexpr Fact kPoseFacts[] = {
    {"sfm", "cameras from", "method"},
    {"sfm", "reprojection error (px)", "reprojection_error_px"},
    {"sfm", "sparse points", "points"},
    {"sfm", "mean track length", "mean_track_length"},
    {"masks", "masks' overlap with their hull", "agreement"},
    {"masks", "least of a view", "least_agreement"},
    {"dense", "dense points", "points"},
    {"dense", "dense CPU time", "cpu_seconds"},
    {"dense", "dense completeness", "completeness_mean"},
    {"mesh", "Poisson faces", "faces"},
    {"refine", "shift of the surface by the photographs (pixels, 95 %)", "moved_95_footprints"},
    {"refine", "distance of outlines and masks (px)", "outline_gap_px"},
    {"refine", "surface determined by photographs (share)", "evidence"},
    {"refine", "difference of its brightness to the photographs (share)", "shading_error_after"},
    {"cleanup", "faces", "faces"},
    {"cleanup", "closed 2-manifold", "closed"},
    {"cleanup", "holes filled", "holes_filled"},
    {"cleanup", "self-intersections", "self_intersections"},
    {"cleanup", "genus", "genus"},
    {"cleanup", "repair strategy", "strategy"},
    {"cleanup", "surface that no camera saw, soles left out (share)", "unseen_share"},
    {"cleanup", "distance of the mesh to the scan, 99 %", "distance_to_input_p99_over_diag"},
    {"cleanup", "distance of the scan to the mesh, 99 %", "distance_from_input_p99_over_diag"},
    {"fit", "features matched to the template", "matches"},
    {"fit", "distance of outlines and masks (px)", "outline_gap_px"},
    {"fit", "correlation of grey values", "correlation"},
    {"fit", "volume over the template's", "volume_ratio"},
    {"fit", "surface in no photograph (share)", "unseen"},
    {"track", "frames", "frames"},
    {"track", "cameras", "cameras"},
    {"track", "overlap with the masks, mean (IoU)", "iou_mean"},
    {"track", "overlap with the masks, least (IoU)", "iou_least"},
    {"track", "limbs lost and found again", "limbs_found_again"},
    {"track", "height of the actor (m)", "actor_height_m"},
    {"follow", "overlap with the masks before bending, mean (IoU)", "iou_before_mean"},
    {"follow", "overlap with the masks, mean (IoU)", "iou_mean"},
    {"follow", "overlap with the masks, least (IoU)", "iou_least"},
    {"follow", "faces turned over", "flipped"},
    {"transfer", "marks", "marks"},
    {"transfer", "largest change of volume (share)", "volume_deviation"},
    {"unwrap", "UV charts", "charts"},
    {"unwrap", "L2 stretch", "stretch_l2"},
    {"unwrap", "UV area used", "utilisation"},
    {"unwrap", "flipped in UV", "flipped"},
    {"bake", "texels unseen", "unseen_fraction"},
    {"bake", "views used", "views_used"},
    {"bake", "views a texel", "mean_views_per_texel"},
    {"bake", "PSNR to photographs (dB)", "psnr_gain_db"},
    {"bake", "PSNR to photographs left out (dB)", "held_out_psnr_db"},
    {"bake", "... after one gain per channel (dB)", "held_out_psnr_gain_db"},
    {"bake", "SSIM to photographs left out", "held_out_ssim"},
};

Pairs PoseFacts(const RunRecord& run, const std::string& pose) {
  Pairs facts;
  const auto add = [&](std::span<const Fact> of) {
    for (const Fact& fact : of)
      AddFacts(run.Find(fact.stage, pose), {{fact.label, fact.key}}, facts);
  };
  add(kCaptureFacts);
  if (const StepRecord* sfm = run.Find("sfm", pose); sfm && sfm->Number("images_total"))
    facts.emplace_back("placed by sfm",
                       Value(*sfm, "images_placed") + " of " + Value(*sfm, "images_total"));
  add(kPoseFacts);
  return facts;
}

std::string HowItWasFound(const RunRecord& run, const std::string& pose) {
  if (run.performance)
    return "A shot: the actor in its films was tracked, and the result moves as the actor did.";
  if (pose == run.template_pose)
    return "The template: the other poses use its connectivity and texture layout.";
  if (run.Find("fit", pose))
    return "From few photographs: the template was bent until it agreed with them.";
  return "Its texture is baked on the registered template.";
}

/// The positions of the photographs, with names; orange if the outline does not fit.
std::string CameraChart(const PosePart& pose) {
  if (pose.places.empty()) return pose.cameras ? "<h3>Cameras</h3>" : "";
  std::vector<ChartMark> marks;
  for (const CameraPlace& place : pose.places) {
    const std::string stem = place.name.substr(0, place.name.rfind('.'));
    marks.push_back({stem,
                     place.outline_off > kViewOutlineLook ? "var(--look-edge)" : "var(--ours)",
                     place.azimuth_deg, place.height_deg});
  }
  return "<h3>Cameras</h3>" +
         Figure(DotChart(marks, {"Where the photographs were taken: height above the figure\u2019s "
                                 "middle [\u00b0]",
                                 "angle around the figure [\u00b0]", "", false}),
                "One dot per photograph, with its name; orange if the mesh\u2019s outline does not "
                "fit it.");
}

std::string ViewTable(const PoseEvidence& evidence) {
  Table table({"photograph", "overlap with the mask (IoU)",
               "distance of outlines, of the figure\u2019s size", "correlation of details",
               "outline with a change of colour"});
  for (const ViewEvidence& v : evidence.views)
    table.Add({Escape(v.name), fmt::format("{:.3f}", v.iou), Percent(v.outline_off),
               fmt::format("{:.2f}", v.structure), Percent(v.edges)});
  return "<details><summary>All " + Pretty(static_cast<double>(evidence.views.size())) +
         " photographs</summary>" + table.Html() + "</details>\n";
}

std::string LandmarkResiduals(const StepRecord& step) {
  const auto found = step.lists.find("landmark_residuals");
  if (found == step.lists.end()) return "";
  Pairs facts;
  for (const auto& entry : nlohmann::json::parse(found->second))
    if (entry.is_object())
      facts.emplace_back(Escape(entry.value("name", "")),
                         Percent(entry.value("residual_over_diag", 0.0)));
  return facts.empty() ? "" : "<h3>Landmark residuals, of the diagonal</h3>" + Facts(facts);
}

}  // namespace

std::string Words(const std::string& name) {
  static const std::pair<const char*, const char*> kUnits[] = {{"_px", " (px)"},
                                                               {"_deg", " (\u00b0)"},
                                                               {"_db", " (dB)"},
                                                               {"_m", " (m)"},
                                                               {"_mrad", " (mrad)"},
                                                               {"_rad", " (rad)"},
                                                               {"_over_diag", " / diagonal"}};
  std::string text = name, unit;
  for (const auto& [suffix, shown] : kUnits)
    if (text.ends_with(suffix)) {
      text.resize(text.size() - std::char_traits<char>::length(suffix));
      unit = shown;
      break;
    }
  std::replace(text.begin(), text.end(), '_', ' ');
  return Escape(text) + unit;
}

std::string Shots(const std::vector<Picture>& pictures, const Encoder& encode) {
  if (pictures.empty()) return "";
  std::string html = "<div class=shots>";
  for (const Picture& picture : pictures)
    html += Figure(Image(encode(picture.image), picture.caption), Escape(picture.caption));
  return html + "</div>\n";
}

std::string WidePictures(const std::vector<Picture>& pictures, const Encoder& encode) {
  std::string html = "<div class=wide>";
  for (const Picture& picture : pictures)
    html += Figure(Image(encode(picture.image), picture.caption), Escape(picture.caption));
  return html + "</div>\n";
}

std::string EverythingMeasured(const StepRecord& step) {
  Pairs facts;
  for (const auto& [name, number] : step.numbers)
    facts.emplace_back(Words(name), Value(step, name));
  for (const auto& [name, text] : step.texts) facts.emplace_back(Words(name), Escape(text));
  std::string html = "<details><summary>" + Escape(step.id.empty() ? step.stage : step.id) +
                     ": everything measured</summary>" + Facts(facts);
  for (const auto& [name, text] : step.lists) {
    const std::string shown =
        text.size() > 6000 ? text.substr(0, 6000) + " \u2026 (complete in report.json)" : text;
    html += "<details><summary>" + Words(name) +
            "</summary><code style=\"display:block;white-space:pre-wrap;overflow-wrap:anywhere\">" +
            Escape(shown) + "</code></details>";
  }
  return html + "</details>\n";
}

std::string StepsSection(const Contents& contents) {
  double longest = 1e-9, total = 0;
  for (const StepRecord& step : contents.run.steps)
    longest = std::max(longest, step.seconds), total += step.seconds;
  Table table({"step", "stage", "", "time", "", "memory", "fingerprint"});
  for (const StepRecord& step : contents.run.steps) {
    const std::string bar =
        fmt::format("<div class=bar><i{} style=\"width:{:.1f}%\"></i></div>",
                    step.cached ? " class=reused" : "", 100 * step.seconds / longest);
    table.Add(
        {Escape(step.id),
         Escape(step.stage) + (step.version.empty() ? "" : " " + Escape(step.version)), Chip(step),
         PrettySeconds(step.seconds), bar, PrettyBytes(static_cast<double>(step.peak_bytes)),
         step.fingerprint.empty() ? ""
                                  : "<code>" + Escape(step.fingerprint.substr(0, 10)) + "</code>"});
  }
  return "<section id=steps><h2>Steps</h2><p class=lead>" +
         Pretty(static_cast<double>(contents.run.steps.size())) + " steps, " +
         PrettySeconds(total) +
         " of work in all. A cached step shows the time of the run that made it.</p>" +
         table.Html() + "</section>\n";
}

std::string PoseSection(const Contents& contents, const PosePart& pose, const Encoder& encode) {
  std::string html = "<section id=\"pose-" + Escape(pose.name) +
                     (contents.run.performance ? "\"><h2>Shot \u2018" : "\"><h2>Pose \u2018") +
                     Escape(pose.name) + "\u2019</h2><p class=lead>" +
                     HowItWasFound(contents.run, pose.name) + "</p>" +
                     MissingStages(contents, pose);
  if (!pose.sides.empty())
    html += (contents.run.performance ? "<h3>Frames</h3>" : "<h3>Textured, from all round</h3>") +
            Shots(pose.sides, encode);
  if (!pose.worst.empty())
    html += "<h3>Photograph and render from the same camera: the worst of " +
            Pretty(static_cast<double>(pose.evidence.views.size())) +
            "</h3><p class=lead>Left: the photograph. Right: the textured mesh. The orange line in "
            "both is the outline of the photograph\u2019s " +
            std::string(pose.masks_replaced ? "mask" : "first mask") + ".</p>" +
            WidePictures(pose.worst, encode) + ViewTable(pose.evidence);
  std::vector<Picture> made;
  if (pose.cloud) made.push_back({"Dense points: " + pose.cloud->caption, pose.cloud->image});
  made.insert(made.end(), pose.shape.begin(), pose.shape.end());
  if (pose.texture) made.push_back(*pose.texture);
  if (!made.empty()) html += "<h3>How it was made</h3>" + Shots(made, encode);
  html += CameraChart(pose);
  if (pose.cameras)
    html +=
        Figure(Image(encode(pose.cameras->image), "placed cameras"), Escape(pose.cameras->caption));
  if (pose.painted)
    html += "<h3>3D video</h3>" +
            Figure(Image(encode(pose.painted->image), "films beside the painted mesh"),
                   Escape(pose.painted->caption));
  if (pose.masks)
    html += "<h3>Masks</h3>" + Figure(Image(encode(pose.masks->image), "masks over photographs"),
                                      Escape(pose.masks->caption));
  html += "<details><summary>The most important numbers</summary>" +
          Facts(PoseFacts(contents.run, pose.name)) + "</details>";
  for (const StepRecord& step : contents.run.steps)
    if (step.pose == pose.name && step.stage != "register") html += EverythingMeasured(step);
  return html + "</section>\n";
}

namespace {

/// The starts of the registration, and the chosen one.
std::string StartsTable(const StepRecord& step) {
  const auto list = step.lists.find("starts");
  if (list == step.lists.end()) return {};
  const nlohmann::json starts = nlohmann::json::parse(list->second, nullptr, false);
  if (!starts.is_array() || starts.empty()) return {};
  const auto chosen = step.texts.find("start_chosen");
  Table table({"start", "gap, of the diagonal", "strain", "score (smaller is better)", ""});
  for (const nlohmann::json& start : starts) {
    const std::string name = start.value("start", "");
    table.Add({Escape(name), Percent(start.value("gap_over_diag", 0.0)),
               Pretty(start.value("strain", 0.0)), Pretty(start.value("score", 0.0)),
               Escape(start.value("words", "")) +
                   (chosen != step.texts.end() && chosen->second == name ? " <b>chosen</b>" : "")});
  }
  return table.Html();
}

/// How far registered template and target are apart, in numbers and colours.
std::string PairDistances(const PairPart& pair, const Encoder& encode) {
  const double d = pair.diagonal;
  Table table({"distance, of the target's diagonal", "mean", "rms", "99 %", "largest (Hausdorff)"});
  const auto add = [&](const char* name, const OneWayDistance& way) {
    table.Add({name, Percent(way.mean / d), Percent(way.rms / d), Percent(way.p99 / d),
               Percent(way.max / d)});
  };
  add("registered \u2192 target", pair.to_target);
  add("target \u2192 registered", pair.from_target);
  std::string html =
      table.Html() + "<p class=lead>Two-sided Hausdorff distance: <b>" +
      Percent(std::max(pair.to_target.max, pair.from_target.max) / d) + "</b> of the diagonal (" +
      Pretty(std::max(pair.to_target.max, pair.from_target.max)) + " in the target's units).</p>";
  const std::string scale =
      ColorScale(HeatStops(), "distance: 0", Percent(pair.scale_top) + " of the diagonal or more");
  html += "<h3>Registered template, coloured by its distance to the target</h3>" +
          Shots(pair.registered, encode);
  html += "<h3>Target, coloured by its distance to the registered template</h3>" +
          Shots(pair.target, encode) + scale;
  return html;
}

}  // namespace

std::string PairSection(const PairPart& pair, const Encoder& encode) {
  const StepRecord& step = *pair.step;
  std::string html = "<section id=\"register-" + Escape(step.pose) +
                     "\"><h2>Registration of the template onto \u2018" + Escape(step.pose) +
                     "\u2019</h2>";
  Pairs facts;
  AddFacts(&step,
           {{"flipped triangles", "flipped"},
            {"clearly flipped triangles", "flipped_clearly"},
            {"degenerate triangles", "degenerate"},
            {"iterations", "iterations"},
            {"landmarks", "landmarks"},
            {"landmark residual, mean", "landmark_mean_over_diag"},
            {"landmark residual, largest", "landmark_max_over_diag"},
            {"surface rms / diagonal", "surface_rms_over_diag"},
            {"target covered", "target_coverage"},
            {"self-intersections gained", "self_intersections_gained"},
            {"stretch, 1 %", "stretch_low"},
            {"stretch, 99 %", "stretch_high"}},
           facts);
  html += Facts(facts) + StartsTable(step);
  if (!pair.advice.empty())
    html += "<h3>Where one more landmark would help most</h3>" + WidePictures(pair.advice, encode);
  if (!pair.carried.empty())
    html +=
        "<h3>Correspondence: template, registered, target with the template\u2019s pattern, "
        "distance</h3>" +
        Shots(pair.carried, encode);
  if (pair.diagonal > 0) html += PairDistances(pair, encode);
  return html + LandmarkResiduals(step) + EverythingMeasured(step) + "</section>\n";
}

}  // namespace keypose::report
