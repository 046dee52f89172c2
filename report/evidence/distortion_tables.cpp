#include "report/evidence/distortion_tables.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::report {
namespace {

using nlohmann::json;

double Finite(const json& frame, const char* name, std::size_t index) {
  const auto found = frame.find(name);
  if (found == frame.end() || !found->is_number() || !std::isfinite(found->get<double>()))
    throw InputError("report: distortion.json: frame " + std::to_string(index) +
                     " has no finite '" + name + "'; interpolate again");
  return found->get<double>();
}

double OrElse(const json& frame, const char* name, double otherwise) {
  const auto found = frame.find(name);
  return found != frame.end() && found->is_number() && std::isfinite(found->get<double>())
             ? found->get<double>()
             : otherwise;
}

/// Mean and standard deviation over the in-betweens.
void MeanAndDeviation(const std::vector<double>& values, double& mean, double& deviation) {
  if (values.empty()) return;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (const double v : values)
    deviation += (v - mean) * (v - mean) / static_cast<double>(values.size());
  deviation = std::sqrt(deviation);
}

DistortionRow Row(const std::vector<FrameDistortion>& frames, double FrameDistortion::*linear,
                  double FrameDistortion::*ours) {
  std::vector<double> a, b;
  for (const FrameDistortion& frame : frames) {
    if (frame.key || frame.stands) continue;
    a.push_back(frame.*linear);
    b.push_back(frame.*ours);
  }
  DistortionRow row;
  row.frames = SizeOf(a);
  MeanAndDeviation(a, row.linear_mean, row.linear_deviation);
  MeanAndDeviation(b, row.mean, row.deviation);
  return row;
}

struct FaceMeasures {
  Eigen::VectorXd area, volume;
};

FaceMeasures Measure(const PointsX3& points, const FacesX3& faces) {
  const Eigen::RowVector3d centroid = points.colwise().mean();
  FaceMeasures m{Eigen::VectorXd(faces.rows()), Eigen::VectorXd(faces.rows())};
  for (int f = 0; f < faces.rows(); ++f) {
    const Eigen::Vector3d a = points.row(faces(f, 0)) - centroid,
                          b = points.row(faces(f, 1)) - centroid,
                          c = points.row(faces(f, 2)) - centroid;
    m.area[f] = 0.5 * (b - a).cross(c - a).norm();
    m.volume[f] = a.dot(b.cross(c)) / 6;
  }
  return m;
}

/// (now - before) / |before|, without faces whose measure is almost zero.
std::vector<double> Relative(const Eigen::VectorXd& now, const Eigen::VectorXd& before) {
  const double least = 1e-3 * before.cwiseAbs().mean();
  std::vector<double> result;
  for (Eigen::Index f = 0; f < now.size(); ++f)
    if (std::abs(before[f]) > least) result.push_back((now[f] - before[f]) / std::abs(before[f]));
  return result;
}

}  // namespace

std::vector<FrameDistortion> ParseDistortion(const std::string& text) {
  std::vector<FrameDistortion> frames;
  try {
    const json document = json::parse(text);
    const std::vector<int> keys = document.value("key_frames", std::vector<int>());
    for (const json& entry : document.at("frames")) {
      const std::size_t i = frames.size();
      FrameDistortion frame{Finite(entry, "t", i),
                            Finite(entry, "area", i),
                            Finite(entry, "volume", i),
                            Finite(entry, "linear_area", i),
                            Finite(entry, "linear_volume", i),
                            std::find(keys.begin(), keys.end(), static_cast<int>(i)) != keys.end()};
      frame.time_s = OrElse(entry, "time", frame.t);
      frame.area_path = OrElse(entry, "area_path", NAN);
      frame.volume_path = OrElse(entry, "volume_path", NAN);
      const double same_as = OrElse(entry, "same_as", -1);
      if (same_as >= 0 && same_as < static_cast<double>(i)) {
        frame.same_as = static_cast<int>(same_as);
        frame.stands = frames[frame.same_as].key;
      }
      frames.push_back(frame);
    }
  } catch (const json::exception& error) {
    throw InputError("report: distortion.json is malformed: " + std::string(error.what()) +
                     "; interpolate again");
  }
  if (frames.empty())
    throw InputError("report: distortion.json has no frames; run `interpolate` again");
  frames.front().key = frames.back().key = true;
  if (std::abs(frames.front().area - 1) < 1e-6)
    for (FrameDistortion& f : frames)
      for (double* ratio :
           {&f.area, &f.volume, &f.linear_area, &f.linear_volume, &f.area_path, &f.volume_path})
        *ratio -= 1;
  return frames;
}

void PlayAt(double fps, std::vector<FrameDistortion>* frames) {
  const double start = frames->front().time_s;
  for (std::size_t i = 0; i < frames->size(); ++i)
    (*frames)[i].time_s = start + static_cast<double>(i) / fps;
}

DistortionRow AreaRow(const std::vector<FrameDistortion>& frames) {
  return Row(frames, &FrameDistortion::linear_area, &FrameDistortion::area);
}
DistortionRow VolumeRow(const std::vector<FrameDistortion>& frames) {
  return Row(frames, &FrameDistortion::linear_volume, &FrameDistortion::volume);
}

FaceDistortion PerFace(const PointsX3& first, const PointsX3& frame, const PointsX3& second,
                       const FacesX3& faces, double t) {
  const FaceMeasures before = Measure(first, faces), now = Measure(frame, faces);
  const FaceMeasures straight = Measure((1 - t) * first + t * second, faces);
  return {Relative(now.area, before.area), Relative(now.volume, before.volume),
          Relative(straight.area, before.area), Relative(straight.volume, before.volume)};
}

std::vector<double> Histogram(const std::vector<double>& values, double low, double high,
                              int bins) {
  std::vector<double> shares(bins, 0.0);
  for (const double v : values) {
    const int bin =
        static_cast<int>(std::floor((std::clamp(v, low, high) - low) / (high - low) * bins));
    shares[std::clamp(bin, 0, bins - 1)] += 1.0 / static_cast<double>(values.size());
  }
  return shares;
}

const std::vector<PaperRow>& PaperTables() {
  static const std::vector<PaperRow> rows = {
      {"Blob Fish",
       3482,
       "12",
       {-0.0537, 0.0245, -0.0208, 0.0157, 0},
       {0.1025, 0.0759, 0.1663, 0.0822, 0}},
      {"Party Onion",
       3600,
       "13",
       {0.0224, 0.0185, 4.6793e-4, 0.0020, 0},
       {-0.0334, 0.0207, 0.0357, 0.0222, 0}},
      {"Party Onion Rigged",
       3600,
       "N/A",
       {-0.0299, 0.0208, 9.2850e-5, 1.3018e-4, 0},
       {-0.0134, 0.0077, 8.7708e-4, 5.6068e-4, 0}},
      {"Tick",
       2750,
       "13",
       {0.0835, 0.0568, -0.0329, 0.0235, 0},
       {0.0674, 0.0454, -0.0542, 0.0402, 0}},
      {"Hellidropter",
       1454,
       "10",
       {0.0202, 0.0196, -0.0206, 0.0142, 0},
       {0.0229, 0.0195, -0.0254, 0.0182, 0}},
  };
  return rows;
}

}  // namespace keypose::report
