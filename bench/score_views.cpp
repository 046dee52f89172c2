// How well a coloured mesh reproduces photographs with known cameras: compares silhouettes with
// masks, and the render's colours with pixels.
//
//   score_views --mesh MESH [--texture PNG] --model COLMAP_MODEL --photographs FOLDER
//   [--masks FOLDER] [--held-out NAMES] [--json FILE] [--colors auto|all|none] [--samples 2]
//   [--picture OUT.png] [--picture-views NAMES] [--picture-width 480]
//
// MESH: an OBJ whose MTL names one or several textures, any mesh with UVs and --texture, or a PLY
// with vertex colours; in the model's frame. Masks: MASKS/NAME.png for photograph NAME, object
// where >= 128; default: FOLDER/masks. NAMES: a,b,c or a file of names. Silhouettes are compared in
// all views; colours in the held-out views, or in all views if none are held out. See view_score.h
// for the measures. The picture has one row per view of --picture-views (default: the held-out
// views, or four views): photograph, render, silhouettes (grey: both, red: only the mask, blue:
// only the mesh).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "bench/view_score.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/pictures/render.h"
#include "core/values/errors.h"

namespace keypose::bench {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

struct Arguments {
  std::string mesh, texture, model, photographs, masks, held_out, json_file, colors = "auto",
                                                                             picture, picture_views;
  int samples = 2, picture_width = 480;
};

struct ViewScore {
  std::string name;
  bool held_out = false, has_colors = false;
  Silhouette silhouette;
  ColorScore colors;
};

std::vector<std::string> Names(const std::string& list) {
  std::vector<std::string> names;
  std::stringstream words;
  if (fs::is_regular_file(list)) {
    words << std::ifstream(list).rdbuf();
  } else {
    std::string text = list;
    std::replace(text.begin(), text.end(), ',', '\n');
    words << text;
  }
  for (std::string name; std::getline(words, name);)
    if (!name.empty()) names.push_back(name);
  return names;
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void RequireViews(const Scene& scene, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (std::none_of(scene.views.begin(), scene.views.end(),
                     [&](const View& view) { return view.name == name; }))
      throw InputError("the model has no view of '" + name + "'; it places " +
                       std::to_string(scene.views.size()) + " photographs");
}

/// Reads the files of views, and scores them.
class Scorer {
 public:
  explicit Scorer(const Arguments& arguments)
      : arguments_(arguments),
        mesh_(ReadTexturedMesh(arguments.mesh, arguments.texture)),
        scene_(ReadColmapModel(arguments.model)),
        held_out_(Names(arguments.held_out)),
        rays_(mesh_.mesh.points, mesh_.mesh.faces) {
    RequireViews(scene_, held_out_);
    if (arguments.masks.empty())
      arguments_.masks = (fs::path(arguments.photographs) / "masks").string();
  }

  std::vector<ViewScore> ScoreAll() const {
    std::vector<ViewScore> scores;
    for (const View& view : scene_.views) {
      ViewScore score;
      score.name = view.name;
      score.held_out = Contains(held_out_, view.name);
      const Image8 mask = Mask(view);
      score.silhouette = CompareSilhouettes(mask, CoveredPixels(mesh_, rays_, view));
      score.has_colors = WantsColors(score.held_out);
      if (score.has_colors)
        score.colors = CompareColors(Photograph(view), mask,
                                     RenderColors(mesh_, rays_, view, arguments_.samples));
      scores.push_back(std::move(score));
    }
    return scores;
  }

  Image8 Picture() const {
    std::vector<std::string> names =
        arguments_.picture_views.empty() ? held_out_ : Names(arguments_.picture_views);
    RequireViews(scene_, names);
    const std::size_t count = scene_.views.size(), rows = std::min<std::size_t>(4, count);
    if (names.empty())
      for (std::size_t i = 0; i < rows; ++i) names.push_back(scene_.views[i * count / rows].name);
    std::vector<Image8> tiles;
    for (const View& view : scene_.views)
      if (Contains(names, view.name)) AddRow(view, tiles);
    return TileImages(tiles, 3);
  }

 private:
  bool WantsColors(bool held_out) const {
    if (!mesh_.colored() || arguments_.colors == "none") return false;
    return arguments_.colors == "all" || held_out_.empty() || held_out;
  }
  Image8 Photograph(const View& view) const {
    return ReadImage(fs::path(arguments_.photographs) / view.name, 3);
  }
  Image8 Mask(const View& view) const {
    return ReadImage(fs::path(arguments_.masks) / (view.name + ".png"), 1);
  }

  void AddRow(const View& view, std::vector<Image8>& tiles) const {
    const Image8 photograph = Photograph(view), mask = Mask(view),
                 covered = CoveredPixels(mesh_, rays_, view);
    Image8 difference(mask.width, mask.height, 3, 255);
    for (std::size_t i = 0; i < mask.data.size(); ++i) {
      const bool in_mask = mask.data[i] >= 128, in_mesh = covered.data[i] != 0;
      const std::uint8_t colors[4][3] = {
          {255, 255, 255}, {40, 80, 220}, {220, 40, 40}, {205, 205, 205}};
      std::copy_n(colors[2 * in_mask + in_mesh], 3, &difference.data[3 * i]);
    }
    Image8 render = difference;
    if (mesh_.colored())
      render = Composed(RenderColors(mesh_, rays_, view, arguments_.samples),
                        Eigen::Vector3d::Constant(255));
    const int width = arguments_.picture_width,
              height = std::max(1, width * mask.height / mask.width);
    tiles.push_back(Resized(photograph, width, height));
    tiles.push_back(Resized(render, width, height));
    tiles.push_back(Resized(difference, width, height));
  }

  Arguments arguments_;
  TexturedMesh mesh_;
  Scene scene_;
  std::vector<std::string> held_out_;
  RayScene rays_;
};

json ToJson(const ViewScore& score) {
  json row = {{"name", score.name},
              {"held_out", score.held_out},
              {"iou", score.silhouette.Iou()},
              {"precision", score.silhouette.Precision()},
              {"recall", score.silhouette.Recall()}};
  if (score.has_colors && score.colors.pixels > 0) {
    const ColorScore& c = score.colors;
    row.update({{"psnr_db", c.psnr_db},
                {"ssim", c.ssim},
                {"gained_psnr_db", c.gained_psnr_db},
                {"gained_ssim", c.gained_ssim},
                {"filled_psnr_db", c.filled_psnr_db},
                {"gain", {c.gain[0], c.gain[1], c.gain[2]}}});
  }
  return row;
}

constexpr const char* kFigures[] = {"iou",  "precision",      "recall",      "psnr_db",
                                    "ssim", "gained_psnr_db", "gained_ssim", "filled_psnr_db"};

/// Mean of each measure over the rows that have it.
json Means(const json& rows, bool only_held_out) {
  json means = {{"views", 0}};
  for (const char* figure : kFigures) {
    double sum = 0;
    int count = 0;
    for (const json& row : rows)
      if (row.contains(figure) && (!only_held_out || row["held_out"]))
        sum += row[figure].get<double>(), ++count;
    if (count > 0) means[figure] = sum / count;
  }
  means["views"] = std::count_if(rows.begin(), rows.end(), [&](const json& row) {
    return !only_held_out || row["held_out"].get<bool>();
  });
  return means;
}

void PrintRow(const std::string& name, const json& row) {
  std::printf("%-28s", name.c_str());
  for (const char* figure : kFigures) {
    if (row.contains(figure))
      std::printf(" %9.*f", std::string(figure).ends_with("db") ? 2 : 4, row[figure].get<double>());
    else
      std::printf(" %9s", "");
  }
  std::printf("\n");
}

void Run(const Arguments& arguments) {
  const Scorer scorer(arguments);
  json result = {{"mesh", arguments.mesh}, {"views", json::array()}};
  for (const ViewScore& score : scorer.ScoreAll()) result["views"].push_back(ToJson(score));
  result["all"] = Means(result["views"], false);
  if (!arguments.held_out.empty()) result["held_out"] = Means(result["views"], true);
  std::printf("%-28s %9s %9s %9s %9s %9s %9s %9s %9s\n", "view", "IoU", "precision", "recall",
              "PSNR", "SSIM", "PSNR gain", "SSIM gain", "filled");
  for (const json& row : result["views"])
    PrintRow(row["name"].get<std::string>() + (row["held_out"] ? " (held out)" : ""), row);
  PrintRow("mean of " + std::to_string(result["all"]["views"].get<int>()), result["all"]);
  if (result.contains("held_out"))
    PrintRow("mean of " + std::to_string(result["held_out"]["views"].get<int>()) + " held out",
             result["held_out"]);
  if (!arguments.json_file.empty() &&
      !(std::ofstream(arguments.json_file) << result.dump(1) << '\n').flush())
    throw DiskError(arguments.json_file + " cannot be written");
  if (!arguments.picture.empty()) WriteImage(arguments.picture, scorer.Picture());
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("How well a coloured mesh reproduces photographs with known cameras");
  app.add_option("--mesh", arguments.mesh)->required();
  app.add_option("--texture", arguments.texture);
  app.add_option("--model", arguments.model)->required();
  app.add_option("--photographs", arguments.photographs)->required();
  app.add_option("--masks", arguments.masks);
  app.add_option("--held-out", arguments.held_out, "a,b,c or a file of names");
  app.add_option("--colors", arguments.colors)->check(CLI::IsMember({"auto", "all", "none"}));
  app.add_option("--samples", arguments.samples, "rays per pixel and axis")
      ->check(CLI::Range(1, 8));
  app.add_option("--json", arguments.json_file);
  app.add_option("--picture", arguments.picture);
  app.add_option("--picture-views", arguments.picture_views);
  app.add_option("--picture-width", arguments.picture_width)->check(CLI::Range(16, 8192));
  CLI11_PARSE(app, argc, argv);
  Run(arguments);
  return 0;
}

}  // namespace
}  // namespace keypose::bench

int main(int argc, char** argv) {
  try {
    return keypose::bench::Main(argc, argv);
  } catch (const keypose::Error& error) {
    std::fprintf(stderr, "score_views: error: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}
