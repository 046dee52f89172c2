#include "report/page/page.h"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "report/html/html.h"
#include "report/page/sections.h"
#include "report/verdicts/verdicts.h"

namespace keypose::report {
namespace {

using nlohmann::json;

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
      "<div class=tiles>" + Tile(Pretty(static_cast<double>(contents.run.poses.size())),
                                 std::string(contents.run.performance ? "shot" : "pose") +
                                     (contents.run.poses.size() == 1 ? "" : "s"));
  if (images > 0) html += Tile(Pretty(images), "photographs placed");
  int faces = 0;
  for (const PosePart& pose : contents.poses) faces = std::max(faces, pose.faces);
  if (faces > 0) html += Tile(Pretty(faces), "faces a mesh");
  if (contents.animation)
    html += Tile(Pretty(static_cast<double>(contents.animation->frames.size())), "frames");
  html += Tile(PrettySeconds(seconds), "work of all steps");
  return html + Tile(PrettyBytes(bytes), "largest memory of a step") + "</div>";
}

/// "2 poses: 1 good, 1 wrong".
std::string InWords(const std::vector<Verdict>& verdicts) {
  std::string words;
  for (const Grade grade : {Grade::kWrong, Grade::kLook, Grade::kGood}) {
    std::string names;
    for (const Verdict& v : verdicts)
      if (v.grade == grade) names += (names.empty() ? "" : ", ") + Escape(v.about);
    if (!names.empty())
      words += (words.empty() ? "" : " \u2014 ") + std::string(WordOf(grade)) + ": " + names;
  }
  return words;
}

std::string Header(const Contents& contents, const std::vector<Verdict>& verdicts) {
  return "<header class=top><div class=wrap><div class=kicker>Keypose report</div><h1>" +
         Escape(contents.run.project) + "</h1><p>" + InWords(verdicts) + "</p>" + Tiles(contents) +
         "</div></header>\n";
}

std::string Navigation(const Contents& contents) {
  std::string html = "<nav><div class=wrap><a href=\"#summary\">Summary</a>";
  for (const PosePart& pose : contents.poses)
    html += "<a href=\"#pose-" + Escape(pose.name) +
            (contents.run.performance ? "\">Shot " : "\">Pose ") + Escape(pose.name) + "</a>";
  for (const PairPart& pair : contents.pairs)
    html += "<a href=\"#register-" + Escape(pair.step->pose) + "\">Registration " +
            Escape(pair.step->pose) + "</a>";
  if (!contents.run.performance) html += "<a href=\"#animation\">Animation</a>";
  return html + "<a href=\"#steps\">Steps</a></div></nav>\n";
}

std::string GradeChip(Grade grade) {
  const std::string word = WordOf(grade);
  return "<span class=\"chip " + word + "\">" + word + "</span>";
}

/// The verdicts: one card per pose with its picture, the deciding findings, and what to do.
std::string Cards(const Contents& contents, const std::vector<Verdict>& verdicts,
                  const Encoder& encode) {
  std::string html = "<div class=cards>";
  for (const Verdict& v : verdicts) {
    html += "<div class=\"card " + std::string(WordOf(v.grade)) + "\">";
    for (const PosePart& pose : contents.poses)
      if (pose.name == v.about && !pose.sides.empty())
        html += Image(encode(pose.sides.front().image), "pose " + pose.name);
    html += "<div><h3>" + Escape(v.about) + " &ensp;" + GradeChip(v.grade) + "</h3><p>" + v.why +
            "</p>";
    if (!v.cure.empty()) html += "<p class=cure><b>What to do:</b> " + Escape(v.cure) + ".</p>";
    html += "</div></div>";
  }
  return html + "</div>\n";
}

std::string FindingList(const std::vector<Finding>& findings,
                        const std::function<bool(Grade)>& shown) {
  std::string html;
  for (const Finding& f : findings) {
    if (!shown(f.grade)) continue;
    html += "<li>" + GradeChip(f.grade) + "<div><b>" +
            Escape(f.pose.empty() || f.where.ends_with("/" + f.pose) ? f.where
                                                                     : f.pose + ", " + f.where) +
            "</b> &ensp;" + f.text +
            (f.cure.empty() ? "" : " <span class=cure>" + Escape(f.cure) + ".</span>") +
            "</div></li>";
  }
  return html.empty() ? "" : "<ul class=verdicts>" + html + "</ul>";
}

std::string Summary(const Contents& contents, const std::vector<Verdict>& verdicts,
                    const std::vector<Finding>& findings, const Encoder& encode) {
  std::string html =
      "<section id=summary><h2>Is it good enough?</h2>" + Cards(contents, verdicts, encode);
  const auto open = [](Grade g) { return g == Grade::kWrong || g == Grade::kLook; };
  html += FindingList(findings, open);
  const std::string rest = FindingList(findings, [&](Grade g) { return !open(g); });
  if (!rest.empty())
    html += "<details><summary>Good findings, and notes</summary>" + rest + "</details>";
  return html + "</section>\n";
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

json EvidenceJson(const PoseEvidence& evidence) {
  json views = json::array();
  for (const ViewEvidence& view : evidence.views)
    views.push_back({{"name", view.name},
                     {"iou", view.iou},
                     {"outline_off", view.outline_off},
                     {"structure", view.structure},
                     {"edges", view.edges}});
  return {{"outline_off", evidence.outline_off},
          {"structure", evidence.structure},
          {"edges", evidence.edges},
          {"missing",
           {{"largest", evidence.missing.largest},
            {"shown_by", evidence.missing.shown_by},
            {"left_out_by", evidence.missing.left_out_by}}},
          {"views", views}};
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
  const std::vector<Finding> findings = FindAll(contents);
  const std::vector<Verdict> verdicts = Judge(contents, findings);
  std::string body = Header(contents, verdicts) + Navigation(contents) + "<div class=wrap>" +
                     Summary(contents, verdicts, findings, encode) +
                     PlayerSection(contents, encode);
  for (const PosePart& pose : contents.poses) body += PoseSection(contents, pose, encode);
  for (const PairPart& pair : contents.pairs) body += PairSection(pair, encode);
  if (!contents.run.performance) body += AnimationSection(contents, encode);
  body += OtherStepsSection(contents) + StepsSection(contents);
  body +=
      "<footer>All lengths are shares of the bounding-box diagonal unless a unit is given. "
      "<code>report.json</code>, beside this page, has everything on it and all other "
      "measurements.</footer></div>" +
      PlayerProgram(contents);
  return Page(contents.run.project + " \u2013 Keypose report", body);
}

std::string BuildJson(const Contents& contents) {
  json document = {{"schema", 1},
                   {"project", contents.run.project},
                   {"template", contents.run.template_pose},
                   {"poses", contents.run.poses}};
  if (!contents.run.timeline.empty()) document["timeline"] = json::parse(contents.run.timeline);
  const std::vector<Finding> findings = FindAll(contents);
  document["verdicts"] = json::array();
  for (const Verdict& v : Judge(contents, findings))
    document["verdicts"].push_back(
        {{"about", v.about}, {"grade", WordOf(v.grade)}, {"why", Plain(v.why)}, {"cure", v.cure}});
  document["findings"] = json::array();
  for (const Finding& f : findings)
    document["findings"].push_back({{"grade", WordOf(f.grade)},
                                    {"pose", f.pose},
                                    {"where", f.where},
                                    {"text", Plain(f.text)},
                                    {"cure", f.cure}});
  document["evidence"] = json::object();
  for (const PosePart& pose : contents.poses)
    if (!pose.evidence.views.empty()) document["evidence"][pose.name] = EvidenceJson(pose.evidence);
  document["steps"] = json::array();
  for (const StepRecord& step : contents.run.steps) document["steps"].push_back(StepJson(step));
  document["registrations"] = json::array();
  for (const PairPart& pair : contents.pairs) {
    if (!(pair.diagonal > 0)) continue;
    document["registrations"].push_back(
        {{"pose", pair.step->pose},
         {"target_diagonal", pair.diagonal},
         {"registered_to_target", WayJson(pair.to_target, pair.diagonal)},
         {"target_to_registered", WayJson(pair.from_target, pair.diagonal)},
         {"hausdorff_over_diag",
          std::max(pair.to_target.max, pair.from_target.max) / pair.diagonal}});
  }
  if (contents.animation) document["animation"] = AnimationJson(*contents.animation);
  return document.dump(1) + "\n";
}

}  // namespace keypose::report
