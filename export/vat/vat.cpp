#include "export/vat/vat.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "export/vat/vat_images.h"
#include "export/vat/vat_layout.h"
#include "export/vat/vat_mesh.h"

namespace keypose::exporting {
namespace {

constexpr float kMost16 = 65535, kMost8 = 255;

/// Bounds in single precision, the numbers that shaders calculate with.
struct Bounds {
  Eigen::RowVector3f minimum = Eigen::RowVector3f::Constant(std::numeric_limits<float>::max());
  Eigen::RowVector3f maximum = Eigen::RowVector3f::Constant(std::numeric_limits<float>::lowest());
  Eigen::RowVector3f extent() const { return maximum - minimum; }
};

Bounds BoundsOf(const Scene& scene, const std::vector<int>& shown) {
  Bounds bounds;
  for (const int frame : shown) {
    const PointsX3 points = WithYUp(scene.split.points[frame], scene.z_up);
    bounds.minimum = bounds.minimum.cwiseMin(points.colwise().minCoeff().cast<float>());
    bounds.maximum = bounds.maximum.cwiseMax(points.colwise().maxCoeff().cast<float>());
  }
  return bounds;
}

/// The code of `value` in 0..most; a range without extent has only the code 0.
template <class Code>
Code Quantized(double value, double minimum, double extent, double most) {
  if (extent <= 0) return 0;
  return static_cast<Code>(std::clamp(std::round((value - minimum) / extent * most), 0.0, most));
}

struct Images {
  ImageT<std::uint16_t> positions;
  ImageF exact_positions;
  Image8 normals;
};

struct Errors {
  double position = 0, exact_position = 0;  ///< largest distance
  double normal_rad = 0;                    ///< largest angle
};

void WritePosition(const Eigen::RowVector3d& point, const Bounds& bounds, std::uint16_t* codes,
                   float* exact, Errors& errors) {
  const Eigen::RowVector3f extent = bounds.extent();
  Eigen::RowVector3f decoded;
  for (int c = 0; c < 3; ++c) {
    codes[c] = Quantized<std::uint16_t>(point[c], bounds.minimum[c], extent[c], kMost16);
    exact[c] = static_cast<float>(point[c]);
    // The arithmetic of the shaders in docs/vertex-animation-textures.md.
    decoded[c] = bounds.minimum[c] + extent[c] * (static_cast<float>(codes[c]) / kMost16);
  }
  const Eigen::RowVector3f kept(exact[0], exact[1], exact[2]);
  errors.position = std::max(errors.position, (decoded.cast<double>() - point).norm());
  errors.exact_position = std::max(errors.exact_position, (kept.cast<double>() - point).norm());
}

void WriteNormal(const Eigen::RowVector3d& normal, std::uint8_t* codes, Errors& errors) {
  Eigen::RowVector3f decoded;
  for (int c = 0; c < 3; ++c) {
    codes[c] = Quantized<std::uint8_t>(normal[c], -1, 2, kMost8);
    decoded[c] = static_cast<float>(codes[c]) / kMost8 * 2 - 1;
  }
  const double along = decoded.cast<double>().normalized().dot(normal);
  errors.normal_rad = std::max(errors.normal_rad, std::acos(std::clamp(along, -1.0, 1.0)));
}

Images MakeImages(const Scene& scene, const std::vector<int>& shown, const VatLayout& layout,
                  const Bounds& bounds, Errors& errors, Progress* progress) {
  Images images{ImageT<std::uint16_t>(layout.columns, layout.rows(), 3),
                ImageF(layout.columns, layout.rows(), 3), Image8(layout.columns, layout.rows(), 3)};
  for (int i = 0; i < layout.frames; ++i) {
    ReportProgress(progress, 0.5 * i / layout.frames, "writing the vertex animation texture");
    const PointsX3 points = WithYUp(scene.split.points[shown[i]], scene.z_up),
                   normals = WithYUp(scene.split.normals[shown[i]], scene.z_up);
    for (int v = 0; v < layout.vertices; ++v) {
      const int x = v % layout.columns, y = i * layout.rows_per_frame + v / layout.columns;
      WritePosition(points.row(v), bounds, images.positions.at(x, y),
                    images.exact_positions.at(x, y), errors);
      WriteNormal(normals.row(v), images.normals.at(x, y), errors);
    }
  }
  return images;
}

nlohmann::json Numbers(const Eigen::RowVector3f& row) { return {row[0], row[1], row[2]}; }

nlohmann::json Description(const Scene& scene, const std::vector<int>& shown,
                           const VatLayout& layout, const Bounds& bounds) {
  const std::string& name = scene.name;
  nlohmann::json out = {{"schema", 1},
                        {"mesh", name + ".glb"},
                        {"fps", scene.playback.fps},
                        {"frames", layout.frames},
                        {"loop", Loops(scene)},
                        {"vertices", layout.vertices},
                        {"columns", layout.columns},
                        {"rows", layout.rows()},
                        {"rows_per_frame", layout.rows_per_frame},
                        {"positions",
                         {{"png", name + "_positions.png"},
                          {"bits", 16},
                          {"minimum", Numbers(bounds.minimum)},
                          {"maximum", Numbers(bounds.maximum)},
                          {"exr", name + "_positions.exr"}}},
                        {"normals",
                         {{"png", name + "_normals.png"},
                          {"bits", 8},
                          {"minimum", {-1, -1, -1}},
                          {"maximum", {1, 1, 1}}}},
                        {"up", "y"},
                        {"metres_per_unit", 1},
                        {"keys", nlohmann::json::array()},
                        {"shown", nlohmann::json::array()}};
  for (const int frame : shown) out["shown"].push_back(scene.frame_names[frame]);
  const std::vector<double> seconds = KeySeconds(scene);
  for (std::size_t i = 0; i < scene.keys.size(); ++i) {
    // A loop's last key shows as the first.
    const long frame = std::lround(seconds[i] * scene.playback.fps) % layout.frames;
    out["keys"].push_back({{"pose", scene.keys[i].pose}, {"frame", frame}});
  }
  return out;
}

/// Tells Godot's texture importer that pixels are numbers: kept without loss, and never filtered,
/// shrunk, or taken for colours. Settings that a version does not have are passed over: `flags` are
/// of Godot 3, `mipmaps`, `roughness` and `detect_3d/compress_to` of Godot 4.
std::string GodotImport() {
  return R"([remap]

importer="texture"

[params]

compress/mode=0
compress/normal_map=2
detect_3d=false
detect_3d/compress_to=0
flags/filter=false
flags/mipmaps=false
flags/repeat=0
flags/srgb=0
mipmaps/generate=false
process/fix_alpha_border=false
process/premult_alpha=false
process/size_limit=0
roughness/mode=1
size_limit=0
)";
}

}  // namespace

FormatFiles MakeVat(const Scene& scene, Progress* progress) {
  const std::vector<int> shown = RoundOf(scene);
  const VatLayout layout = MakeVatLayout(SizeOf(scene.split.source_vertex), SizeOf(shown));
  const Bounds bounds = BoundsOf(scene, shown);
  Errors errors;
  const Images images = MakeImages(scene, shown, layout, bounds, errors, progress);
  FormatFiles made;
  const auto add = [&](const std::string& ending, std::string bytes) {
    made.files.push_back({"vat/" + scene.name + ending, std::move(bytes)});
    ReportProgress(progress, 0.5 + 0.1 * SizeOf(made.files), "compressing the textures");
  };
  add(".glb", MakeVatMesh(scene, layout, shown[0]));
  add(".json", Description(scene, shown, layout, bounds).dump(1) + "\n");
  add("_normals.png", PngOf8Bits(images.normals));
  add("_positions.png", PngOf16Bits(images.positions));
  add("_positions.exr", ExrOfFloats(images.exact_positions));
  for (const char* picture : {"_normals.png", "_positions.exr", "_positions.png"})
    made.files.push_back({"vat/" + scene.name + picture + ".import", GodotImport()});
  const double diagonal = SceneDiagonal(scene);
  made.error_over_diagonal = errors.position / diagonal;
  made.measured = {{"quantum_over_diagonal", 0.5 * bounds.extent().norm() / kMost16 / diagonal},
                   {"exr_error_over_diagonal", errors.exact_position / diagonal},
                   {"normal_error_deg", errors.normal_rad * 180 / std::numbers::pi},
                   {"columns", layout.columns},
                   {"rows", layout.rows()}};
  return made;
}

}  // namespace keypose::exporting
