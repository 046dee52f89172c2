// Photographs beside renders of the textured mesh from the same cameras, or renders of the mesh
// from given directions. Makes pictures of docs/.
//
// - compare_views OUT.png WIDTH MESH TEXTURE MODEL IMAGES NAME...
//   One row per photograph: photograph, render.
// - compare_views OUT.png WIDTH MESH TEXTURE AZIMUTH...
//   One row: renders from these directions [deg].
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/pictures/render.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

const View& ViewNamed(const Scene& scene, const std::string& name) {
  for (const View& view : scene.views)
    if (view.name == name) return view;
  throw InputError("the model has no view of '" + name + "'; it places " +
                   std::to_string(scene.views.size()) + " photographs");
}

std::vector<Image8> BesidePhotographs(const Mesh& mesh, const RenderOptions& options, int width,
                                      const std::vector<std::string>& arguments) {
  const Scene scene = ReadColmapModel(arguments[0]);
  const RayScene rays(mesh.points, mesh.faces);
  std::vector<Image8> tiles;
  for (std::size_t i = 2; i < arguments.size(); ++i) {
    View view = ViewNamed(scene, arguments[i]);
    view.camera = view.camera.Scaled(static_cast<double>(width) / view.camera.width);
    const Image8 photo = ReadImage(std::filesystem::path(arguments[1]) / view.name, 3);
    tiles.push_back(Resized(photo, view.camera.width, view.camera.height));
    tiles.push_back(Render(mesh, rays, view, options));
  }
  return tiles;
}

std::vector<Image8> FromAllRound(const Mesh& mesh, const RenderOptions& options, int width,
                                 const std::vector<std::string>& azimuths) {
  const RayScene rays(mesh.points, mesh.faces);
  std::vector<Image8> tiles;
  for (const std::string& azimuth : azimuths)
    tiles.push_back(
        Render(mesh, rays, FitView(mesh.points, std::stod(azimuth), 15, width, width), options));
  return tiles;
}

int Run(const std::vector<std::string>& arguments) {
  if (arguments.size() < 5)
    throw UsageError(
        "compare_views OUT.png WIDTH MESH TEXTURE (MODEL IMAGES NAME... | AZIMUTH...)");
  const int width = std::atoi(arguments[1].c_str());
  const Mesh mesh = ReadMesh(arguments[2]);
  const Image8 texture = ReadImage(arguments[3], 3);
  RenderOptions options;
  options.texture = &texture;
  options.shading = 0;
  const std::vector<std::string> rest(arguments.begin() + 4, arguments.end());
  const bool photographs = std::filesystem::is_directory(rest.front());
  const std::vector<Image8> tiles = photographs ? BesidePhotographs(mesh, options, width, rest)
                                                : FromAllRound(mesh, options, width, rest);
  WriteImage(arguments[0], TileImages(tiles, photographs ? 2 : SizeOf(tiles)), 88);
  return 0;
}

}  // namespace
}  // namespace keypose

int main(int argc, char** argv) {
  try {
    return keypose::Run({argv + 1, argv + argc});
  } catch (const keypose::Error& error) {
    std::fprintf(stderr, "compare_views: error: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}
