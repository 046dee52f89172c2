// The page as a whole, and report.json.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "report/contents.h"
#include "report/html.h"
#include "report/sections.h"

namespace keypose::report {
namespace {

using nlohmann::json;

const char* ClassOf(Grade grade) {
  switch (grade) {
    case Grade::kGood:
      return "good";
    case Grade::kLook:
      return "look";
    case Grade::kBad:
      return "bad";
    case Grade::kInfo:
      break;
  }
  return "info";
}

std::string Tile(const std::string& value, const std::string& what) {
  return "<div class=tile><b>" + value + "</b><span>" + what + "</span></div>";
}

std::string Tiles(const Contents& contents) {
  double seconds = 0, bytes = 0, images = 0;
  for (const StepRecord& step : contents.run.steps) {
    seconds += step.seconds;
    bytes = std::max(bytes, static_cast<double>(step.peak_bytes));
    if (step.stage == "sfm") images += step.Number("images_placed").value_or(0);
  }
  std::string html =
      "<div class=tiles>" + Tile(Pretty(static_cast<double>(contents.run.poses.size())), contents.run.poses.size() == 1 ? "pose" : "poses");
  if (images > 0) html += Tile(Pretty(images), "photographs placed");
  int faces = 0;
  for (const PosePart& pose : contents.poses) faces = std::max(faces, pose.faces);
  if (faces > 0) html += Tile(Pretty(faces), "faces a mesh");
  if (contents.animation) html += Tile(Pretty(static_cast<double>(contents.animation->frames.size())), "frames");
  html += Tile(PrettySeconds(seconds), "work of all steps");
  return html + Tile(PrettyBytes(bytes), "largest memory of a step") + "</div>";
}

std::string Header(const Contents& contents, const std::vector<Verdict>& verdicts) {
  const auto count = [&](Grade grade) {
    return std::count_if(verdicts.begin(), verdicts.end(), [&](const Verdict& v) { return v.grade == grade; });
  };
  const auto bad = count(Grade::kBad), look = count(Grade::kLook);
  std::string summary = bad > 0 ? std::to_string(bad) + (bad == 1 ? " thing is" : " things are") + " wrong" : "All gates passed";
  if (look > 0) summary += ", " + std::to_string(look) + " to look at";
  const std::string poses = contents.run.poses.size() == 1 ? "a textured, closed mesh from photographs"
                                                           : "photographs of key poses to a textured, closed animation";
  return "<header class=top><div class=wrap><div class=kicker>Keypose report</div><h1>" + Escape(contents.run.project) + "</h1><p>" +
         summary + " \u2014 " + poses + ".</p>" + Tiles(contents) + "</div></header>\n";
}

std::string Navigation(const Contents& contents) {
  std::string html = "<nav><div class=wrap><a href=\"#summary\">Summary</a>";
  for (const PosePart& pose : contents.poses) html += "<a href=\"#pose-" + Escape(pose.name) + "\">Pose " + Escape(pose.name) + "</a>";
  for (const PairPart& pair : contents.pairs)
    html += "<a href=\"#register-" + Escape(pair.step->pose) + "\">Registration " + Escape(pair.step->pose) + "</a>";
  return html + "<a href=\"#animation\">Animation</a><a href=\"#steps\">Steps</a></div></nav>\n";
}

std::string Summary(const Contents& contents, const std::vector<Verdict>& verdicts, const Encoder& encode) {
  static const char* const kWords[] = {"good", "look", "wrong", "note"};
  std::string html = "<section id=summary><h2>Summary</h2>";
  // One picture of each pose at once, before anything is read.
  std::vector<Picture> hero;
  for (const PosePart& pose : contents.poses)
    if (!pose.sides.empty()) hero.push_back({"pose " + pose.name, pose.sides.front().image});
  if (contents.poses.size() == 1 && !contents.poses[0].sides.empty()) hero = contents.poses[0].sides;
  html += Shots(hero, encode) + "<ul class=verdicts>";
  for (const Verdict& v : verdicts)
    html += std::string("<li><span class=\"chip ") + ClassOf(v.grade) + "\">" + kWords[static_cast<int>(v.grade)] + "</span><div><b>" +
            Escape(v.where) + "</b> &ensp;" + v.text + "</div></li>";
  if (verdicts.empty())
    html += "<li><span class=\"chip info\">note</span><div>No step has told a measurement that could be judged.</div></li>";
  return html + "</ul></section>\n";
}

json StepJson(const StepRecord& step) {
  json measurements = json::object();
  for (const auto& [name, number] : step.numbers) measurements[name] = number;
  for (const auto& [name, flag] : step.flags) measurements[name] = flag;
  for (const auto& [name, text] : step.texts) measurements[name] = text;
  for (const auto& [name, list] : step.lists) measurements[name] = json::parse(list);
  json options = json::object();
  for (const auto& [name, value] : step.options) options[name] = json::parse(value);
  return {{"id", step.id},
          {"stage", step.stage},
          {"version", step.version},
          {"pose", step.pose},
          {"source_pose", step.source_pose},
          {"status", step.status},
          {"seconds", step.seconds},
          {"peak_bytes", step.peak_bytes},
          {"cached", step.cached},
          {"fingerprint", step.fingerprint},
          {"options", options},
          {"measurements", measurements},
          {"trouble", step.trouble}};
}

json WayJson(const OneWayDistance& way, double diagonal) {
  return {{"mean_over_diag", way.mean / diagonal},
          {"rms_over_diag", way.rms / diagonal},
          {"p99_over_diag", way.p99 / diagonal},
          {"max_over_diag", way.max / diagonal}};
}

json RowJson(const DistortionRow& row) {
  return {{"frames", row.frames},
          {"linear_mean", row.linear_mean},
          {"linear_deviation", row.linear_deviation},
          {"mean", row.mean},
          {"deviation", row.deviation}};
}

json AnimationJson(const AnimationPart& animation) {
  json frames = json::array();
  for (const FrameDistortion& f : animation.frames)
    frames.push_back({{"t", f.t},
                      {"area", f.area},
                      {"volume", f.volume},
                      {"linear_area", f.linear_area},
                      {"linear_volume", f.linear_volume},
                      {"key", f.key}});
  return {{"frames", frames},
          {"faces", animation.face_count},
          {"table_1_area", RowJson(AreaRow(animation.frames))},
          {"table_2_volume", RowJson(VolumeRow(animation.frames))}};
}

}  // namespace

std::string BuildPage(const Contents& contents, const Encoder& encode) {
  const std::vector<Verdict> verdicts = Judge(contents);
  std::string body = Header(contents, verdicts) + Navigation(contents) + "<div class=wrap>" + Summary(contents, verdicts, encode);
  for (const PosePart& pose : contents.poses) body += PoseSection(contents, pose, encode);
  for (const PairPart& pair : contents.pairs) body += PairSection(pair, encode);
  body += AnimationSection(contents, encode) + StepsSection(contents);
  body +=
      "<footer>All lengths are shares of the bounding-box diagonal unless a unit is named. Everything on this page, and every measurement "
      "it leaves out, is in "
      "<code>report.json</code> beside it.</footer></div>";
  return Page(contents.run.project + " \u2013 Keypose report", body);
}

std::string BuildJson(const Contents& contents) {
  json document = {
      {"schema", 1}, {"project", contents.run.project}, {"template", contents.run.template_pose}, {"poses", contents.run.poses}};
  if (!contents.run.timeline.empty()) document["timeline"] = json::parse(contents.run.timeline);
  document["verdicts"] = json::array();
  for (const Verdict& v : Judge(contents)) {
    std::string plain = v.text;
    for (const std::string tag : {"<b>", "</b>"})
      for (std::size_t at; (at = plain.find(tag)) != std::string::npos;) plain.erase(at, tag.size());
    document["verdicts"].push_back({{"grade", ClassOf(v.grade)}, {"where", v.where}, {"text", plain}});
  }
  document["steps"] = json::array();
  for (const StepRecord& step : contents.run.steps) document["steps"].push_back(StepJson(step));
  document["registrations"] = json::array();
  for (const PairPart& pair : contents.pairs) {
    if (!(pair.diagonal > 0)) continue;
    document["registrations"].push_back({{"pose", pair.step->pose},
                                         {"target_diagonal", pair.diagonal},
                                         {"registered_to_target", WayJson(pair.to_target, pair.diagonal)},
                                         {"target_to_registered", WayJson(pair.from_target, pair.diagonal)},
                                         {"hausdorff_over_diag", std::max(pair.to_target.max, pair.from_target.max) / pair.diagonal}});
  }
  if (contents.animation) document["animation"] = AnimationJson(*contents.animation);
  return document.dump(1) + "\n";
}

}  // namespace keypose::report
