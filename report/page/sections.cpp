#include "report/page/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "report/evidence/verdict_limits.h"
#include "report/html/html.h"
#include "report/page/pictures.h"

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

bool IsGood(const Described& described, double value) {
  return value >= described.good_min.value_or(value) && value <= described.good_max.value_or(value);
}

/// The value with its unit; orange outside of what the stage calls good. Empty if it is missing.
std::string Value(const StepRecord& step, const Described& described) {
  const auto number = step.Number(described.key);
  const bool is_flag = step.flags.contains(described.key);
  std::string text = Value(step, described.key);
  if (text.empty()) return "";
  if (number && !is_flag) {
    const bool of_whole = described.unit == "share" || described.unit == "diagonal";
    if (of_whole) text = Percent(*number);
    if (described.unit == "s") text = PrettySeconds(*number);
    if (!of_whole && described.unit != "s" && !described.unit.empty())
      text += "\u00a0" + Escape(described.unit);
  }
  if (!number || IsGood(described, *number)) return text;
  return "<span class=off title=\"outside of what is usual\">" + text + "</span>";
}

/// What the stage itself calls its most important measurements, as far as this step has them.
Pairs DescribedFacts(const StepRecord& step) {
  Pairs facts;
  for (const Described& described : step.described)
    if (const std::string value = Value(step, described); !value.empty())
      facts.emplace_back(Escape(described.label), value);
  return facts;
}

/// Under the stage's title; empty if it describes nothing.
std::string DescribedPart(const StepRecord& step) {
  const Pairs facts = DescribedFacts(step);
  return facts.empty() ? "" : "<h4>" + Escape(step.title) + "</h4>" + Facts(facts);
}

std::string Chip(const StepRecord& step) {
  if (!step.done()) return "<span class=\"chip bad\">" + Escape(step.status) + "</span>";
  return step.cached ? "<span class=\"chip info\">reused</span>"
                     : "<span class=\"chip good\">made</span>";
}

std::set<std::string> StagesOf(const RunRecord& run, const std::string& pose) {
  std::set<std::string> stages;
  for (const StepRecord& step : run.steps)
    if (step.pose == pose) stages.insert(step.stage);
  return stages;
}

/// Whether this pose may lack the stage: only the template has it, or all but the template.
bool IsOfTemplateAlone(const RunRecord& run, const std::string& stage) {
  const bool has = run.Find(stage, run.template_pose) != nullptr;
  const auto of_other = [&](const StepRecord& step) {
    return step.stage == stage && !step.pose.empty() && step.pose != run.template_pose;
  };
  return has != std::any_of(run.steps.begin(), run.steps.end(), of_other);
}

/// Stages that another pose has which has all of this one's: then both were found in the same way.
std::string MissingStages(const RunRecord& run, const std::string& pose) {
  const std::set<std::string> own = StagesOf(run, pose);
  std::vector<std::string> titles;
  for (const StepRecord& step : run.steps) {
    if (step.pose.empty() || own.contains(step.stage) || IsOfTemplateAlone(run, step.stage))
      continue;
    const std::set<std::string> others = StagesOf(run, step.pose);
    const bool alike = std::includes(others.begin(), others.end(), own.begin(), own.end());
    const bool told = std::find(titles.begin(), titles.end(), step.title) != titles.end();
    if (alike && !told) titles.push_back(step.title);
  }
  if (titles.empty()) return "";
  return fmt::format("<p class=lead>Not made for this pose: {}.</p>",
                     Escape(fmt::format("{}", fmt::join(titles, ", "))));
}

std::string PoseFacts(const RunRecord& run, const std::string& pose) {
  std::string html;
  for (const StepRecord& step : run.steps)
    if (step.pose == pose && step.stage != "register") html += DescribedPart(step);
  return html;
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
  for (const StepRecord& step : contents.run.steps) {
    longest = std::max(longest, step.seconds);
    total += step.seconds;
  }
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
                     MissingStages(contents.run, pose.name);
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
          PoseFacts(contents.run, pose.name) + "</details>";
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
  html += Facts(DescribedFacts(step)) + StartsTable(step);
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

std::string OtherStepsSection(const Contents& contents) {
  std::string html;
  const StepRecord* frames = contents.run.Find("interpolate");
  const StepRecord* exported = frames ? contents.run.ExportOf(frames->Output("frames")) : nullptr;
  for (const StepRecord& step : contents.run.steps) {
    if (!step.pose.empty() || &step == frames || &step == exported) continue;
    html += "<h3>" + Escape(step.title) + "</h3>" + Facts(DescribedFacts(step)) +
            EverythingMeasured(step);
  }
  return html.empty() ? "" : "<section id=others><h2>Other steps</h2>" + html + "</section>\n";
}

}  // namespace keypose::report
