#include "motion/films/track_output.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/numbers/rotations.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

std::string Number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", x);
  return text;
}

}  // namespace

std::string AnglesCsv(const std::vector<TrackedFrame>& frames, double fps, double units_per_metre) {
  std::string text = "frame,time_s";
  for (const DofModel& dof : Dofs()) text += "," + dof.name;
  for (const DofModel& dof : Dofs()) text += "," + dof.name + "_variance";
  text += "\n";
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
  for (int f = 0; f < SizeOf(frames); ++f) {
    const TrackedFrame& frame = frames[f];
    const Eigen::Quaterniond root = frame.pose.RootRotation();
    turn = f == 0 ? LogOf(root) : TurnAfter(turn, before, root);
    before = root;
    DofVector q = frame.pose.q, variance = frame.deviations.cwiseAbs2();
    q.segment<3>(3) = turn;
    q.head<3>() *= units_per_metre;
    variance.head<3>() *= units_per_metre * units_per_metre;
    text += std::to_string(f) + "," + Number(f / fps);
    for (int i = 0; i < kDofs; ++i) text += "," + Number(q[i]);
    for (int i = 0; i < kDofs; ++i) text += "," + Number(variance[i]);
    text += "\n";
  }
  return text;
}

std::vector<std::string> UnseenAngles(const std::vector<TrackedFrame>& frames, double most_deg) {
  std::vector<std::string> names;
  for (int i = 3; i < kDofs; ++i) {
    const auto unseen = std::count_if(frames.begin(), frames.end(), [&](const TrackedFrame& frame) {
      return frame.deviations[i] > most_deg * kDegree;
    });
    if (2 * unseen >= SizeOf(frames)) names.push_back(Dofs()[i].name);
  }
  return names;
}

std::string ClocksText(const std::vector<int>& offsets,
                       const std::vector<SilhouetteCamera>& cameras,
                       const std::map<std::string, FilmClock>& films) {
  nlohmann::ordered_json json;
  json["schema"] = 1;
  json["offsets"] = nlohmann::ordered_json::object();
  for (std::size_t c = 0; c < offsets.size(); ++c)
    json["offsets"][cameras[c].view().name] = offsets[c];
  for (const auto& [name, clock] : films)
    json["films"][name] = {{"begin_s", clock.begin_s}, {"rate", clock.rate}};
  return json.dump(1) + "\n";
}

std::string ActorText(const BodyShape& shape) {
  nlohmann::ordered_json json;
  json["schema"] = 1;
  json["height_m"] = shape.height();
  json["lengths_m"] = std::vector<double>(shape.lengths.data(), shape.lengths.data() + kLengths);
  for (int s = 0; s < kSegments; ++s) {
    std::vector<std::vector<double>> rows;
    for (int k = 0; k < kStations; ++k) {
      rows.emplace_back();
      for (int m = 0; m < kHarmonics; ++m) rows.back().push_back(shape.radii[s](k, m));
    }
    json["radii_m"][Segments()[s].name] = rows;
  }
  return json.dump(1) + "\n";
}

BodyShape ParseActor(const std::string& text, const std::string& name) {
  RequireShallowJson(text, name);
  BodyShape shape;
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    const auto lengths = json.at("lengths_m").get<std::vector<double>>();
    if (lengths.size() != kLengths) throw InputError(name + ": lengths_m must hold 23 numbers");
    for (int i = 0; i < kLengths; ++i) shape.lengths[i] = lengths[i];
    for (int s = 0; s < kSegments; ++s) {
      const auto rows =
          json.at("radii_m").at(Segments()[s].name).get<std::vector<std::vector<double>>>();
      for (int k = 0; k < kStations; ++k)
        for (int m = 0; m < kHarmonics; ++m) shape.radii[s](k, m) = rows.at(k).at(m);
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(name + " is not an actor.json that `track` wrote (" + JsonFault(error) + ")");
  } catch (const std::out_of_range&) {
    throw InputError(name + " is not an actor.json that `track` wrote: radii are missing");
  }
  double sum = shape.lengths.sum();
  for (const auto& radii : shape.radii) sum += radii.sum();
  if (!std::isfinite(sum) || shape.height() < 0.1 || shape.height() > 10)
    throw InputError(name + ": its lengths are not those of an actor");
  return shape;
}

Image8 Overlay(const Image8& rgb, const View& view, const PointsX3& points) {
  const Mesh mesh{points, BodyFaces(), {}, {}, {}, {}};
  RenderOptions options;
  options.samples = 2;
  options.face_colors.resize(mesh.faces.rows(), 3);
  Eigen::VectorXd hue(mesh.faces.rows());
  for (Eigen::Index f = 0; f < hue.size(); ++f)
    hue[f] = static_cast<double>((f / SegmentFaces().rows()) * 7 % kSegments);
  options.face_colors = MapColors(hue, 0, kSegments - 1);
  const Image8 body = RenderCutout(mesh, RayScene(mesh.points, mesh.faces), view, options);
  Image8 picture = rgb;
  for (std::size_t i = 0; i < body.data.size() / 4; ++i) {
    const double alpha = 0.6 * body.data[4 * i + 3] / 255.0;
    for (int c = 0; c < 3; ++c)
      picture.data[3 * i + c] = static_cast<std::uint8_t>(
          std::lround((1 - alpha) * picture.data[3 * i + c] + alpha * body.data[4 * i + c]));
  }
  return picture;
}

}  // namespace keypose::motion
