// The animation section: film strip, curves, the paper's tables and its Figure 6.
#include <fmt/format.h>

#include <cmath>

#include "report/html/html.h"
#include "report/page/sections.h"

namespace keypose::report {
namespace {

const char* const kOurs = "var(--ours)";      // blue, like ARAP in the paper's figure
const char* const kLinear = "var(--linear)";  // red, like linear in the paper's figure
const char* const kPath = "var(--path)";      // grey

std::string Signed(double value) {
  if (value == 0) return "0";
  const std::string text = std::abs(value) < 1e-3 ? fmt::format("{:.3e}", std::abs(value))
                                                  : fmt::format("{:.4f}", std::abs(value));
  return (value < 0 ? "\u2212" : "") + text;
}

std::vector<std::string> Cells(const std::string& name, const std::string& faces,
                               const std::string& landmarks, const DistortionRow& row) {
  return {name,
          faces,
          landmarks,
          Signed(row.linear_mean),
          Signed(row.linear_deviation),
          Signed(row.mean),
          Signed(row.deviation)};
}

std::string PaperTable(const Contents& contents, const char* caption, const std::string& method,
                       const DistortionRow& ours, DistortionRow PaperRow::*column) {
  Table table(
      {"character", "faces", "landmarks", "linear", "linear \u03c3", method, method + " \u03c3"});
  const StepRecord* registered = contents.run.Find("register");
  const auto landmarks = registered ? registered->Number("landmarks") : std::nullopt;
  table.Add(
      Cells("this project: " + Escape(contents.run.project), Pretty(contents.animation->face_count),
            landmarks ? Pretty(*landmarks) : "\u2013", ours),
      "mark");
  for (const PaperRow& row : PaperTables())
    table.Add(Cells(std::string(row.character) + " (paper)", Pretty(row.faces), row.landmarks,
                    row.*column),
              "past");
  return "<h3>" + std::string(caption) + "</h3>" + table.Html();
}

/// One quantity over time: for straight lines, for the method, and its target path.
std::string Curve(const AnimationPart& animation, const std::string& method, const char* title,
                  double FrameDistortion::*linear, double FrameDistortion::*ours,
                  double FrameDistortion::*path) {
  Series straight{"linear", kLinear, {}, {}, true}, chosen{method, kOurs, {}, {}, false},
      wanted{"path between the keys", kPath, {}, {}, true};
  for (const FrameDistortion& f : animation.frames) {
    straight.x.push_back(f.time_s);
    straight.y.push_back(f.*linear);
    chosen.x.push_back(f.time_s);
    chosen.y.push_back(f.*ours);
    if (std::isfinite(f.*path)) {
      wanted.x.push_back(f.time_s);
      wanted.y.push_back(f.*path);
    }
  }
  std::vector<Series> series = {straight, chosen};
  if (!wanted.x.empty()) series.push_back(wanted);
  return LineChart(series, {title, "time [s]", "", true});
}

std::string Curves(const AnimationPart& animation, const std::string& method) {
  return "<h3>Area and volume over time, relative to the first key</h3><div class=two>" +
         Curve(animation, method, "surface area, change from the first key",
               &FrameDistortion::linear_area, &FrameDistortion::area, &FrameDistortion::area_path) +
         Curve(animation, method, "enclosed volume, change from the first key",
               &FrameDistortion::linear_volume, &FrameDistortion::volume,
               &FrameDistortion::volume_path) +
         "</div>";
}

double Spread(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (const auto* values : {&a, &b})
    for (const double v : *values)
      sum += std::min(v * v, 1.0) / static_cast<double>(values->size());
  // Three standard deviations of the two samples together, rounded up to a round value.
  const double wanted = 3 * std::sqrt(sum / 2);
  for (const double round : {0.01, 0.02, 0.05, 0.1, 0.2, 0.5})
    if (wanted <= round) return round;
  return 1;
}

std::string FigureSix(const AnimationPart& animation, const std::string& method) {
  if (!animation.faces) return "";
  const FaceDistortion& f = *animation.faces;
  const auto chart = [&](const std::vector<double>& linear, const std::vector<double>& ours,
                         const char* title) {
    if (linear.empty() || ours.empty()) return std::string();
    const double reach = Spread(linear, ours);
    return HistogramChart({{"linear", kLinear, Histogram(linear, -reach, reach, 60)},
                           {method, kOurs, Histogram(ours, -reach, reach, 60)}},
                          -reach, reach, {title, "relative distortion", "share of faces", true});
  };
  return fmt::format("<h3>Distortion of each face (the paper\u2019s Figure 6), at t = {:.3g}</h3>",
                     animation.faces_t) +
         "<div class=two>" + chart(f.linear_area, f.area, "area of each face") +
         chart(f.linear_volume, f.volume, "volume of each face\u2019s tetrahedron") +
         "</div><p class=lead>Shares of all faces; the first and last bars include all values "
         "beyond them. The volume of a face is that of the tetrahedron of the face and the "
         "mesh\u2019s centroid; faces with less than a thousandth of the mean are left out.</p>";
}

std::string MethodOf(const StepRecord* step) {
  if (!step) return "ARAP";
  const auto option = step->options.find("method");
  if (option == step->options.end() || option->second == "\"arap\"") return "ARAP";
  if (option->second == "\"paper\"") return "ARAP (paper)";
  if (option->second == "\"volumetric\"") return "ARAP (solid)";
  return "linear (chosen)";
}

}  // namespace

std::string AnimationSection(const Contents& contents, const Encoder& encode) {
  const StepRecord* step = contents.run.Find("interpolate");
  if (contents.run.poses.size() < 2)
    return "<section id=animation><h2>Animation</h2><p class=lead>The project has only one pose, "
           "so its result is a textured mesh; an animation needs two poses.</p></section>\n";
  if (!contents.animation) {
    return "<section id=animation><h2>Animation</h2><p class=lead>There are no frames" +
           std::string(step ? "; see the entry of " + Escape(step->id) + " above."
                            : ": interpolate has not run.") +
           "</p>" + (step ? EverythingMeasured(*step) : "") + "</section>\n";
  }
  const AnimationPart& animation = *contents.animation;
  const std::string method = MethodOf(step);
  std::string html = "<section id=animation><h2>Animation</h2><p class=lead>" +
                     Pretty(static_cast<double>(animation.frames.size())) + " frames between " +
                     Pretty(animation.keys) + " keys, " + Pretty(animation.face_count) +
                     " faces.</p>" + Shots(animation.film, encode) + Curves(animation, method);
  html += "<details><summary>The paper\u2019s tables and its Figure 6</summary>";
  html += PaperTable(contents,
                     "Mean relative area distortion of the in-betweens (the paper\u2019s Table 1)",
                     method, AreaRow(animation.frames), &PaperRow::area);
  html += PaperTable(
      contents, "Mean relative volume distortion of the in-betweens (the paper\u2019s Table 2)",
      method, VolumeRow(animation.frames), &PaperRow::volume);
  html +=
      "<p class=lead>Means and standard deviations (\u03c3) over the in-betweens, relative to the "
      "first key, as defined in the paper. Between keys of different size no interpolation can "
      "reach zero. The paper\u2019s characters are other meshes: its rows show the order of "
      "magnitude and are not a target.</p>";
  html += FigureSix(animation, method) + "</details>\n";
  if (step) html += EverythingMeasured(*step);
  const StepRecord* exported =
      step ? contents.run.ExportOf(step->Output("frames")) : contents.run.Find("export");
  if (exported) html += EverythingMeasured(*exported);
  return html + "</section>\n";
}

}  // namespace keypose::report
