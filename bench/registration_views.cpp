// Registrations side by side: the template, the target, and the results of programs. Makes pictures
// of docs/.
//
//   registration_views OUT.jpg WIDTH AZIMUTH ELEVATION SOURCE TARGET MESH... [-- SOURCE TARGET
//   MESH...]
//
// One row per group; all rows have the same length. SOURCE and every MESH, which has SOURCE's
// faces, carry one checker pattern, painted in SOURCE's space. Flipped faces of MESH are red; they
// are judged by the nearest face of TARGET, as in the report's `flipped`. TARGET is plain. All but
// SOURCE share TARGET's view. AZIMUTH and ELEVATION are in degrees.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/numbers/kd_tree.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/same_faces.h"

namespace keypose {
namespace {

PointsX3 FaceCenters(const Mesh& mesh) {
  PointsX3 centers(mesh.faces.rows(), 3);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    centers.row(f) = (mesh.points.row(mesh.faces(f, 0)) + mesh.points.row(mesh.faces(f, 1)) +
                      mesh.points.row(mesh.faces(f, 2))) /
                     3;
  return centers;
}

// The hue changes along the longest side of the box and shows the correspondence; the squares show
// stretch.
ColorsX3 Checker(const Mesh& source) {
  const PointsX3 centers = FaceCenters(source);
  const Eigen::RowVector3d low = source.points.colwise().minCoeff(),
                           size = source.points.colwise().maxCoeff() - low;
  int along = 0;
  size.maxCoeff(&along);
  const double square = size[along] / 14;
  ColorsX3 colors = MapColors((centers.col(along).array() - low[along]) / size[along], 0, 1);
  for (Eigen::Index f = 0; f < centers.rows(); ++f) {
    const int steps =
        static_cast<int>(std::floor((centers(f, along) - low[along]) / square)) +
        static_cast<int>(std::floor((centers(f, (along + 1) % 3) - low[(along + 1) % 3]) / square));
    for (int c = 0; c < 3; ++c)
      colors(f, c) =
          static_cast<std::uint8_t>(steps % 2 == 0 ? colors(f, c) : 128 + colors(f, c) / 2);
  }
  return colors;
}

int PaintFlipped(const Mesh& mesh, const Mesh& target, ColorsX3* colors) {
  const KdTree tree(FaceCenters(target));
  const PointsX3 normals = FaceNormals(mesh.points, mesh.faces),
                 target_normals = FaceNormals(target.points, target.faces),
                 centers = FaceCenters(mesh);
  int flipped = 0;
  for (Eigen::Index f = 0; f < centers.rows(); ++f)
    if (normals.row(f).dot(target_normals.row(tree.Nearest(centers.row(f).transpose()).index)) <
        0) {
      colors->row(f) << 214, 30, 40;
      ++flipped;
    }
  return flipped;
}

struct Direction {
  int width;
  double azimuth_deg, elevation_deg;

  View Of(const Mesh& mesh) const {
    return FitView(mesh.points, azimuth_deg, elevation_deg, width, width);
  }
};

// @param paths  source, target, registered meshes
std::vector<Image8> Row(const Direction& direction, const std::vector<std::string>& paths) {
  if (paths.size() < 3) throw UsageError("registration_views: a row needs SOURCE TARGET MESH...");
  const Mesh source = ReadMesh(paths[0]), target = ReadMesh(paths[1]);
  const View of_target = direction.Of(target);
  RenderOptions painted, plain;
  painted.smooth = false;
  painted.face_colors = Checker(source);
  plain.plain = true;
  std::vector<Image8> tiles = {Render(source, direction.Of(source), painted),
                               Render(target, of_target, plain)};
  for (std::size_t i = 2; i < paths.size(); ++i) {
    const Mesh mesh = ReadMesh(paths[i]);
    if (!SameFaces(mesh.faces, source.faces))
      throw InputError(paths[i] + " does not have the faces of " + paths[0] +
                       "; register it first");
    RenderOptions options = painted;
    std::printf("%s: %d of %d faces flipped\n", paths[i].c_str(),
                PaintFlipped(mesh, target, &options.face_colors), mesh.face_count());
    tiles.push_back(Render(mesh, of_target, options));
  }
  return tiles;
}

int Run(const std::vector<std::string>& arguments) {
  if (arguments.size() < 7)
    throw UsageError(
        "registration_views OUT.jpg WIDTH AZIMUTH ELEVATION SOURCE TARGET MESH... [-- ...]");
  const Direction direction{std::atoi(arguments[1].c_str()), std::atof(arguments[2].c_str()),
                            std::atof(arguments[3].c_str())};
  std::vector<Image8> tiles;
  std::size_t columns = 0;
  for (auto from = arguments.begin() + 4; from <= arguments.end();) {
    const auto to = std::find(from, arguments.end(), "--");
    const std::vector<Image8> row = Row(direction, {from, to});
    if (columns != 0 && row.size() != columns)
      throw UsageError("registration_views: every row needs as many meshes as the first");
    columns = row.size();
    tiles.insert(tiles.end(), row.begin(), row.end());
    if (to == arguments.end()) break;
    from = to + 1;
  }
  WriteImage(arguments[0], TileImages(tiles, static_cast<int>(columns)), 88);
  return 0;
}

}  // namespace
}  // namespace keypose

int main(int argc, char** argv) {
  try {
    return keypose::Run({argv + 1, argv + argc});
  } catch (const keypose::Error& error) {
    std::fprintf(stderr, "registration_views: error: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}
