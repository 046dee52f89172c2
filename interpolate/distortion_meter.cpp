#include "interpolate/distortion_meter.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/surfaces/geometry.h"
#include "interpolate/surface/arap.h"

namespace keypose::interpolation {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kBins = 50;

double Ratio(double value, double reference) { return reference != 0 ? value / reference : 1.0; }

/// One quantity on one segment: its values at the ends and at the in-betweens, and the wanted ones.
struct SegmentValues {
  double first = 0, last = 0;
  std::vector<double> values, path;

  DistortionRow Row() const {
    DistortionRow row;
    row.end_ratio = Ratio(last, first);
    const std::size_t n = values.size();
    if (n == 0 || first == 0) return row;
    for (const double v : values) row.mean += (v - first) / first / static_cast<double>(n);
    for (const double v : values) row.sd += std::pow((v - first) / first - row.mean, 2);
    row.sd = n > 1 ? std::sqrt(row.sd / static_cast<double>(n - 1)) : 0.0;
    for (std::size_t k = 0; k < n; ++k)
      if (path[k] > 0)
        row.path_deviation = std::max(row.path_deviation, std::abs(values[k] / path[k] - 1));
    return row;
  }
};

FaceHistogram HistogramOf(const Eigen::VectorXd& areas, const Eigen::VectorXd& reference) {
  FaceHistogram h;
  h.counts.assign(kBins, 0);
  for (Eigen::Index f = 0; f < areas.size(); ++f) {
    if (!(reference[f] > 0)) continue;
    const double at = ((areas[f] - reference[f]) / reference[f] - h.low) / (h.high - h.low) * kBins;
    ++h.counts[std::clamp(std::floor(at), 0.0, kBins - 1.0)];
  }
  return h;
}

SpanSpline<double> PathOf(const Schedule& schedule, const std::vector<double>& values,
                          bool* all_positive) {
  std::vector<double> logs;
  *all_positive = std::all_of(values.begin(), values.end(), [](double v) { return v > 0; });
  for (const double v : values) logs.push_back(*all_positive ? std::log(v) : 0.0);
  return {schedule, logs};
}

Json RowJson(const DistortionRow& row) {
  return {{"mean", row.mean},
          {"sd", row.sd},
          {"path_deviation", row.path_deviation},
          {"end_ratio", row.end_ratio}};
}

/// Deviation from the path; null where there is no path.
Json DeviationJson(double value, double path) { return path > 0 ? Json(value / path - 1) : Json(); }

Json FrameJson(const FrameDistortion& f) {
  Json json = {{"t", f.t},
               {"time", f.time_s},
               {"area", f.area},
               {"volume", f.volume},
               {"linear_area", f.linear_area},
               {"linear_volume", f.linear_volume},
               {"area_path", f.area_path > 0 ? Json(f.area_path) : Json()},
               {"volume_path", f.volume_path > 0 ? Json(f.volume_path) : Json()},
               {"area_deviation", DeviationJson(f.area, f.area_path)},
               {"volume_deviation", DeviationJson(f.volume, f.volume_path)},
               {"volume_move_over_diag", f.volume_move}};
  if (f.on_table > 0) json["on_table"] = f.on_table;
  if (f.same_as >= 0) json["same_as"] = f.same_as;
  json["stands"] = f.stands;
  return json;
}

Json SegmentJson(const SegmentDistortion& s) {
  return {{"from_frame", s.from_frame},
          {"to_frame", s.to_frame},
          {"in_betweens", s.in_betweens},
          {"area", RowJson(s.area)},
          {"volume", RowJson(s.volume)},
          {"linear_area", RowJson(s.linear_area)},
          {"linear_volume", RowJson(s.linear_volume)}};
}

}  // namespace

DistortionMeter::DistortionMeter(const std::vector<PointsX3>& keys, const FacesX3& faces,
                                 const Schedule& schedule)
    : keys_(keys), faces_(faces), schedule_(schedule), diagonal_(BoundingDiagonal(keys.front())) {
  for (const PointsX3& key : keys) {
    key_face_areas_.push_back(FaceAreas(key, faces));
    key_areas_.push_back(SurfaceArea(key, faces));
    key_volumes_.push_back(SignedVolume(key, faces));
  }
  area_path_ = PathOf(schedule, key_areas_, &has_area_path_);
  volume_path_ = PathOf(schedule, key_volumes_, &has_volume_path_);
}

void DistortionMeter::Add(const FrameView& frame) {
  const PlannedFrame& plan = frame.plan;
  FrameDistortion d;
  if (plan.same_as >= 0) {
    d = frames_[plan.same_as];
    d.faces.counts = d.linear_faces.counts = {};  // stored once only, to keep the report short
    measured_.push_back(measured_[plan.same_as]);
  } else {
    const PointsX3 linear = InterpolateLinearly(keys_[plan.span], keys_[plan.span + 1], plan.way);
    const Eigen::VectorXd areas = FaceAreas(frame.points, faces_),
                          linear_areas = FaceAreas(linear, faces_);
    const Measured m{areas.sum(), SignedVolume(frame.points, faces_), linear_areas.sum(),
                     SignedVolume(linear, faces_)};
    measured_.push_back(m);
    const double area0 = key_areas_[0], volume0 = key_volumes_[0];
    d.area = Ratio(m.area, area0);
    d.volume = Ratio(m.volume, volume0);
    d.linear_area = Ratio(m.linear_area, area0);
    d.linear_volume = Ratio(m.linear_volume, volume0);
    d.area_path = has_area_path_ ? std::exp(area_path_.At(plan.span, plan.way)) / area0 : 0;
    d.volume_path = has_volume_path_ ? std::exp(volume_path_.At(plan.span, plan.way)) / volume0 : 0;
    d.volume_move = diagonal_ > 0 ? frame.volume_move / diagonal_ : 0;
    d.on_table = frame.on_table;
    d.faces = HistogramOf(areas, key_face_areas_[plan.span]);
    d.linear_faces = HistogramOf(linear_areas, key_face_areas_[plan.span]);
  }
  d.t = plan.span + plan.way;
  d.time_s = plan.time_s;
  d.same_as = plan.same_as;
  d.stands = plan.stands;
  frames_.push_back(std::move(d));
}

SegmentDistortion DistortionMeter::SegmentOf(int span) const {
  SegmentDistortion segment;
  segment.from_frame = schedule_.key_frames[span];
  segment.to_frame = schedule_.key_frames[span + 1];
  SegmentValues area, volume, linear_area, linear_volume;
  for (SegmentValues* v : {&area, &linear_area}) {
    v->first = key_areas_[span];
    v->last = key_areas_[span + 1];
  }
  for (SegmentValues* v : {&volume, &linear_volume}) {
    v->first = key_volumes_[span];
    v->last = key_volumes_[span + 1];
  }
  for (int f = segment.from_frame + 1; f < segment.to_frame; ++f) {
    if (schedule_.frames[f].key >= 0) continue;  // a held key is no in-between
    ++segment.in_betweens;
    const double area_path = frames_[f].area_path * key_areas_[0],
                 volume_path = frames_[f].volume_path * key_volumes_[0];
    area.values.push_back(measured_[f].area);
    linear_area.values.push_back(measured_[f].linear_area);
    volume.values.push_back(measured_[f].volume);
    linear_volume.values.push_back(measured_[f].linear_volume);
    for (SegmentValues* v : {&area, &linear_area}) v->path.push_back(area_path);
    for (SegmentValues* v : {&volume, &linear_volume}) v->path.push_back(volume_path);
  }
  segment.area = area.Row();
  segment.volume = volume.Row();
  segment.linear_area = linear_area.Row();
  segment.linear_volume = linear_volume.Row();
  return segment;
}

DistortionReport DistortionMeter::Finish() const {
  DistortionReport report;
  report.frames = frames_;
  for (std::size_t s = 0; s < schedule_.spans.size(); ++s)
    report.segments.push_back(SegmentOf(static_cast<int>(s)));
  return report;
}

std::string ToJson(const DistortionReport& report, const Schedule& schedule,
                   const SourceReport& source, const std::string& method) {
  // Each frame's line is made by itself: one JSON document of thousands of frames would need more
  // memory than the meshes.
  const auto lines = [&](const auto& items, const auto& line) {
    std::string text;
    for (const auto& item : items)
      if (const std::string one = line(item); !one.empty())
        text += (text.empty() ? "\n  " : ",\n  ") + one;
    return "[" + text + "\n ]";
  };
  const Json turns = {{"largest_turn_rad", source.largest_turn},
                      {"largest_remainder_rad", source.largest_remainder},
                      {"torn_edges", source.torn_edges},
                      {"loops_that_do_not_close", source.loops_that_do_not_close},
                      {"differential", source.differential}};
  std::string text =
      "{\n \"schema\": 2,\n \"method\": " + Json(method).dump() +
      ",\n \"fps\": " + Json(schedule.fps).dump() + ",\n \"loop\": " + Json(schedule.loop).dump() +
      ",\n \"key_frames\": " + Json(schedule.key_frames).dump() + ",\n \"turns\": " + turns.dump() +
      ",\n \"notes\": " + Json(source.notes).dump();
  text += ",\n \"frames\": " +
          lines(report.frames, [](const FrameDistortion& f) { return FrameJson(f).dump(); });
  text += ",\n \"segments\": " +
          lines(report.segments, [](const SegmentDistortion& s) { return SegmentJson(s).dump(); });
  text += ",\n \"face_area_histograms\": {\"low\": " + Json(FaceHistogram().low).dump() +
          ", \"high\": " + Json(FaceHistogram().high).dump() +
          ", \"frames\": " + lines(report.frames, [](const FrameDistortion& f) {
            return f.same_as >= 0 ? ""
                                  : Json{{"t", f.t},
                                         {"counts", f.faces.counts},
                                         {"linear_counts", f.linear_faces.counts}}
                                        .dump();
          });
  return text + "}\n}\n";
}

std::vector<std::string> ToTable(const DistortionReport& report, const std::string& method) {
  std::vector<std::string> lines = {
      "mean relative distortion (sd) over in-betweens, against the segment's first key; largest "
      "deviation from the geometric path; end "
      "ratio"};
  const auto add = [&](std::size_t s, const char* what, const std::string& how,
                       const DistortionRow& r) {
    char line[200];
    std::snprintf(line, sizeof line,
                  "  keys %zu-%zu  %-6s %-10s  mean %+.4e  sd %.4e  path %.2e  end %.4f", s, s + 1,
                  what, how.c_str(), r.mean, r.sd, r.path_deviation, r.end_ratio);
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
