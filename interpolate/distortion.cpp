#include "interpolate/distortion.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/geometry.h"

namespace keypose::interpolation {

namespace {

constexpr int kBins = 50;

double Ratio(double value, double reference) { return reference != 0 ? value / reference : 1.0; }

DistortionRow RowOf(const std::vector<double>& values, const std::vector<double>& times) {
  DistortionRow row;
  const double first = values.front(), last = values.back();
  row.end_ratio = Ratio(last, first);
  const std::size_t n = values.size() - 2;
  if (n == 0 || first == 0) return row;
  for (std::size_t k = 1; k <= n; ++k) row.mean += (values[k] - first) / first / static_cast<double>(n);
  for (std::size_t k = 1; k <= n; ++k) row.sd += std::pow((values[k] - first) / first - row.mean, 2);
  row.sd = n > 1 ? std::sqrt(row.sd / static_cast<double>(n - 1)) : 0.0;
  for (std::size_t k = 1; k <= n && last / first > 0; ++k)
    row.path_deviation = std::max(row.path_deviation, std::abs(values[k] / first / std::pow(last / first, times[k]) - 1));
  return row;
}

FaceHistogram HistogramOf(const Eigen::VectorXd& areas, const Eigen::VectorXd& reference) {
  FaceHistogram h;
  h.counts.assign(kBins, 0);
  for (Eigen::Index f = 0; f < areas.size(); ++f) {
    if (!(reference[f] > 0)) continue;
    const double at = ((areas[f] - reference[f]) / reference[f] - h.low) / (h.high - h.low) * kBins;
    ++h.counts[static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, kBins - 1.0))];
  }
  return h;
}

/// Quantity of every frame of a segment, both keys included.
template <class F>
DistortionRow SegmentRow(const Sequence& s, int from, int to, F quantity) {
  std::vector<double> values, times;
  for (int k = from; k <= to; ++k) {
    values.push_back(quantity(s.frames[k]));
    times.push_back(static_cast<double>(k - from) / (to - from));
  }
  return RowOf(values, times);
}

nlohmann::ordered_json ToJson(const DistortionRow& row) {
  return {{"mean", row.mean}, {"sd", row.sd}, {"path_deviation", row.path_deviation}, {"end_ratio", row.end_ratio}};
}

}  // namespace

DistortionReport MeasureDistortion(const Sequence& sequence, const FacesX3& faces) {
  DistortionReport report;
  const double area0 = SurfaceArea(sequence.frames[0].points, faces), volume0 = SignedVolume(sequence.frames[0].points, faces);
  for (const Frame& frame : sequence.frames) {
    FrameDistortion d;
    d.t = frame.segment + frame.t;
    d.area = Ratio(SurfaceArea(frame.points, faces), area0);
    d.volume = Ratio(SignedVolume(frame.points, faces), volume0);
    d.linear_area = Ratio(SurfaceArea(frame.linear, faces), area0);
    d.linear_volume = Ratio(SignedVolume(frame.linear, faces), volume0);
    const Eigen::VectorXd reference = FaceAreas(sequence.frames[sequence.key_frames[frame.segment]].points, faces);
    d.faces = HistogramOf(FaceAreas(frame.points, faces), reference);
    d.linear_faces = HistogramOf(FaceAreas(frame.linear, faces), reference);
    report.frames.push_back(d);
  }
  for (std::size_t s = 0; s + 1 < sequence.key_frames.size(); ++s) {
    SegmentDistortion d;
    d.from_frame = sequence.key_frames[s];
    d.to_frame = sequence.key_frames[s + 1];
    d.area = SegmentRow(sequence, d.from_frame, d.to_frame, [&](const Frame& f) { return SurfaceArea(f.points, faces); });
    d.volume = SegmentRow(sequence, d.from_frame, d.to_frame, [&](const Frame& f) { return SignedVolume(f.points, faces); });
    d.linear_area = SegmentRow(sequence, d.from_frame, d.to_frame, [&](const Frame& f) { return SurfaceArea(f.linear, faces); });
    d.linear_volume = SegmentRow(sequence, d.from_frame, d.to_frame, [&](const Frame& f) { return SignedVolume(f.linear, faces); });
    report.segments.push_back(d);
  }
  return report;
}

std::string ToJson(const DistortionReport& report, const Sequence& sequence, const std::string& method) {
  using Json = nlohmann::ordered_json;
  Json frames = Json::array(), counts = Json::array(), segments = Json::array();
  for (const FrameDistortion& f : report.frames) {
    frames.push_back(
        Json{{"t", f.t}, {"area", f.area}, {"volume", f.volume}, {"linear_area", f.linear_area}, {"linear_volume", f.linear_volume}});
    counts.push_back(Json{{"t", f.t}, {"counts", f.faces.counts}, {"linear_counts", f.linear_faces.counts}});
  }
  for (const SegmentDistortion& s : report.segments)
    segments.push_back(Json{{"from_frame", s.from_frame},
                            {"to_frame", s.to_frame},
                            {"in_betweens", s.to_frame - s.from_frame - 1},
                            {"area", ToJson(s.area)},
                            {"volume", ToJson(s.volume)},
                            {"linear_area", ToJson(s.linear_area)},
                            {"linear_volume", ToJson(s.linear_volume)}});
  const Json histograms = {{"low", FaceHistogram().low}, {"high", FaceHistogram().high}, {"frames", counts}};
  const Json json = {{"schema", 1},      {"method", method},     {"key_frames", sequence.key_frames},
                     {"frames", frames}, {"segments", segments}, {"face_area_histograms", histograms}};
  return json.dump(1) + "\n";
}

std::vector<std::string> ToTable(const DistortionReport& report, const std::string& method) {
  std::vector<std::string> lines = {
      "mean relative distortion (sd) over in-betweens, against the segment's first key; largest deviation from the geometric path; end "
      "ratio"};
  const auto add = [&](std::size_t s, const char* what, const std::string& how, const DistortionRow& r) {
    char line[200];
    std::snprintf(line, sizeof line, "  keys %zu-%zu  %-6s %-6s  mean %+.4e  sd %.4e  path %.2e  end %.4f", s, s + 1, what, how.c_str(),
                  r.mean, r.sd, r.path_deviation, r.end_ratio);
    lines.emplace_back(line);
  };
  for (std::size_t s = 0; s < report.segments.size(); ++s) {
    add(s, "area", "linear", report.segments[s].linear_area);
    add(s, "area", method, report.segments[s].area);
    add(s, "volume", "linear", report.segments[s].linear_volume);
    add(s, "volume", method, report.segments[s].volume);
  }
  return lines;
}

}  // namespace keypose::interpolation
