#include "armature/recording/flipbook.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace keypose::armature {
namespace {

using nlohmann::json;

/// Places of the nodes, a frame a matrix of nodes x 3.
std::vector<Eigen::MatrixX3d> Places(const Armature& armature, const JointCurves& curves) {
  std::vector<Eigen::MatrixX3d> places;
  std::vector<Rigid3> frames;
  for (int f = 0; f < curves.frame_count(); ++f) {
    const Eigen::RowVectorXd row = curves.values.row(f);
    ForwardKinematics(armature, {row.data(), row.data() + row.size()}, &frames);
    places.emplace_back(static_cast<Eigen::Index>(frames.size()), 3);
    for (std::size_t n = 0; n < frames.size(); ++n)
      places.back().row(static_cast<Eigen::Index>(n)) = frames[n].translation;
  }
  return places;
}

/// Rods lead from their parent's place to their own.
std::vector<std::pair<int, int>> Sticks(const Armature& armature) {
  std::vector<std::pair<int, int>> sticks;
  for (std::size_t n = 0; n < armature.nodes.size(); ++n) {
    const ArmatureNode& node = armature.nodes[n];
    if (node.parent >= 0 && node.kind == NodeKind::kRod)
      sticks.emplace_back(node.parent, static_cast<int>(n));
  }
  return sticks;
}

/// From the world to the picture: y to the right, z up.
struct SideView {
  double scale = 1, left = 0, top = 0;
  double X(const Eigen::Vector3d& p) const { return 20 + scale * (p.y() - left); }
  double Y(const Eigen::Vector3d& p) const { return 20 + scale * (top - p.z()); }
};

SideView FitView(const std::vector<Eigen::MatrixX3d>& places, double width, double height) {
  Eigen::RowVector3d low = places[0].colwise().minCoeff(), high = places[0].colwise().maxCoeff();
  for (const Eigen::MatrixX3d& frame : places) {
    low = low.cwiseMin(frame.colwise().minCoeff());
    high = high.cwiseMax(frame.colwise().maxCoeff());
  }
  const double wide = std::max(1e-9, high.y() - low.y()), tall = std::max(1e-9, high.z() - low.z());
  return {std::min((width - 40) / wide, (height - 40) / tall), low.y(), high.z()};
}

std::string FigureSvg(const Armature& armature, const Eigen::MatrixX3d& places,
                      const SideView& view) {
  std::string path;
  for (const auto& [a, b] : Sticks(armature))
    path += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", view.X(places.row(a)),
                        view.Y(places.row(a)), view.X(places.row(b)), view.Y(places.row(b)));
  std::string figure = fmt::format("<path d=\"{}\"/>", path);
  for (const int n : armature.joints)
    figure += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.5\"/>", view.X(places.row(n)),
                          view.Y(places.row(n)));
  return figure;
}

}  // namespace

std::string FlipbookJson(const Armature& armature, const JointCurves& curves) {
  json sticks = json::array(), frames = json::array();
  for (const auto& [a, b] : Sticks(armature)) sticks.push_back({a, b});
  for (const Eigen::MatrixX3d& places : Places(armature, curves)) {
    json frame = json::array();
    for (Eigen::Index n = 0; n < places.rows(); ++n)
      frame.push_back({places(n, 0), places(n, 1), places(n, 2)});
    frames.push_back(std::move(frame));
  }
  return json{{"schema", 1},
              {"fps", curves.fps},
              {"step", curves.step},
              {"sticks", std::move(sticks)},
              {"frames", std::move(frames)}}
             .dump() +
         "\n";
}

std::string FlipbookSvg(const Armature& armature, const JointCurves& curves) {
  constexpr double kWidth = 900, kHeight = 520;
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#f7f5f0\"/>\n"
      "<g stroke-width=\"3\" stroke-linecap=\"round\" fill=\"none\">\n",
      kWidth, kHeight);
  const std::vector<Eigen::MatrixX3d> places = Places(armature, curves);
  if (!places.empty()) {
    const SideView view = FitView(places, kWidth, kHeight);
    const double hold_s = curves.step / curves.fps;
    const auto count = static_cast<double>(places.size());
    text += fmt::format("<g stroke=\"#c9c4b8\">{}</g>\n", FigureSvg(armature, places.back(), view));
    for (std::size_t f = 0; f < places.size(); ++f) {
      // Each frame is seen in its own part of the round.
      const double from = static_cast<double>(f) / count, to = (static_cast<double>(f) + 1) / count;
      text += fmt::format(
          "<g stroke=\"#2b3a4a\" visibility=\"hidden\">{}<animate attributeName=\"visibility\" "
          "calcMode=\"discrete\" values=\"hidden;visible;hidden\" keyTimes=\"0;{:.6f};{:.6f}\" "
          "dur=\"{:.6f}s\" repeatCount=\"indefinite\"/></g>\n",
          FigureSvg(armature, places[f], view), from, std::min(to, 0.999999), count * hold_s);
    }
  }
  return text + "</g>\n</svg>\n";
}

}  // namespace keypose::armature
