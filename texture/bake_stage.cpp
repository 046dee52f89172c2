// keypose-bake: photographs into the texture of a mesh.
#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/blurred_images.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/memory.h"
#include "core/values/percent.h"
#include "core/values/size_of.h"
#include "texture/bake/bake.h"
#include "texture/bake/bake_scan.h"

namespace keypose::texture {
namespace {

StageSpec Spec() {
  StageSpec spec;
  spec.name = "bake";
  spec.version = "12";
  spec.summary =
      "Paints a pose's photographs, or the colours of its scan, into the texture of its mesh.";
  spec.title = "Textures";
  spec.measurements = {{"unseen_fraction", "texels unseen", "share", -kAnyNumber, 0.25},
                       {"views_used", "views used"},
                       {"mean_views_per_texel", "views a texel"},
                       {"psnr_gain_db", "PSNR to photographs", "dB"},
                       {"held_out_psnr_db", "PSNR to photographs left out", "dB"},
                       {"held_out_psnr_gain_db", "... after one gain per channel", "dB"},
                       {"held_out_ssim", "SSIM to photographs left out"}};
  spec.inputs = {
      {"mesh", "file", "mesh with texture coordinates, in the model's frame", ""},
      {"images", "folder", "photographs and masks, as capture makes them", "", true},
      {"model", "folder", "COLMAP model with the cameras", "", true},
      {"scan", "file", "instead of photographs: a mesh in the same place that has the colours", "",
       true},
      {"scan_texture", "file", "the scan's texture; else its vertices have the colours", "", true}};
  spec.outputs = {
      {"texture", "file", "the texture: .png, .tif, or .exr in linear light", "texture.png"},
      {"confidence", "file", "how well photographs show each texel: 255 well, 0 inpainted (.png)",
       "confidence.png", true, false}};
  spec.memory_gib = 3;
  spec.common = {"texture_size", "bits", "common_light"};
  return spec;
}

/// Index in `images` of each view.
std::vector<int> MatchImages(const Scene& scene, const ImageSet& images) {
  std::vector<int> index;
  for (const View& view : scene.views) {
    index.push_back(images.Find(view.name));
    if (index.back() < 0)
      throw InputError("bake: the model has a view '" + view.name + "', but " +
                       images.folder.string() +
                       " has no such image; pass the images that the model was made from");
  }
  return index;
}

Photograph Load(const ImageSet& images, int index) {
  Photograph photograph;
  StoredPicture stored = ReadAsStored(images.ImagePath(index));
  photograph.image = std::move(stored.eight);
  photograph.deep = std::move(stored.sixteen);
  if (!images.images[index].mask.empty()) photograph.mask = ReadImage(images.MaskPath(index), 1);
  photograph.sharpness = images.images[index].sharpness;
  // Nothing is painted from an outlier photograph.
  if (!images.images[index].trusted)
    photograph.mask = Image8(std::max(photograph.image.width, photograph.deep.width),
                             std::max(photograph.image.height, photograph.deep.height), 1, 0);
  return photograph;
}

struct Mean {
  double sum = 0;
  int count = 0;
  void Add(double x) {
    sum += x;
    ++count;
  }
  double value() const { return count > 0 ? sum / count : 0; }
};

nlohmann::json ViewReport(const std::string& name, const ViewQuality& q,
                          const Eigen::Vector3f& gain) {
  nlohmann::json view = {{"name", name},           {"used", q.used},
                         {"held_out", q.held_out}, {"pixels", q.pixels},
                         {"psnr_db", q.psnr_db},   {"psnr_gain_db", q.psnr_gain_db},
                         {"ssim", q.ssim},         {"gain", {gain[0], gain[1], gain[2]}}};
  if (q.held_out) {
    view["held_out_psnr_db"] = q.held_out_psnr_db;
    view["held_out_psnr_gain_db"] = q.held_out_psnr_gain_db;
    view["held_out_ssim"] = q.held_out_ssim;
  }
  return view;
}

void ReportQuality(StageContext& stage, const Scene& scene, const BakeResult& result,
                   bool left_out) {
  Mean psnr, psnr_gain, ssim, held_out, held_out_gain, held_out_ssim;
  int used = 0;
  nlohmann::json views = nlohmann::json::array();
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const ViewQuality& q = result.quality[v];
    used += q.used;
    if (q.held_out) {
      held_out.Add(q.held_out_psnr_db);
      held_out_gain.Add(q.held_out_psnr_gain_db);
      held_out_ssim.Add(q.held_out_ssim);
    }
    if (q.pixels > 0 && !(q.held_out && left_out)) {
      psnr.Add(q.psnr_db);
      psnr_gain.Add(q.psnr_gain_db);
      ssim.Add(q.ssim);
    }
    views.push_back(ViewReport(scene.views[v].name, q, result.gains[v]));
  }
  stage.Report("views_total", SizeOf(scene.views));
  stage.Report("views_used", used);
  stage.Report("mean_views_per_texel", result.mean_views_per_texel);
  stage.Report("psnr_db", psnr.value());
  stage.Report("psnr_gain_db", psnr_gain.value());
  stage.Report("ssim", ssim.value());
  if (held_out.count > 0) {
    stage.Report("held_out_views", held_out.count);
    stage.Report("held_out_psnr_db", held_out.value());
    stage.Report("held_out_psnr_gain_db", held_out_gain.value());
    stage.Report("held_out_ssim", held_out_ssim.value());
  }
  stage.ReportJson("views", views.dump());
}

std::string Names(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// Warns of photographs whose colours are outliers.
/// @param blurred  photographs that are known to be: their edges have other colours
void ReportColors(StageContext& stage, const Scene& scene, const std::vector<ViewColors>& colors,
                  const std::set<std::string>& blurred) {
  nlohmann::json distrusted = nlohmann::json::array(), hidden = nlohmann::json::array(),
                 views = nlohmann::json::object();
  std::vector<std::string> other_light;
  for (std::size_t v = 0; v < colors.size(); ++v) {
    const ViewColors& c = colors[v];
    const std::string& name = scene.views[v].name;
    views[name] = {{"contrary", c.contrary},
                   {"hidden", c.hidden_share},
                   {"light", {c.light.x(), c.light.y()}}};
    if (c.other_light) other_light.push_back(name);
    if (c.distrusted) {
      const std::string why =
          PercentHalfUp(c.contrary) +
          " of what it shows of the figure has other colours than the other photographs show there";
      distrusted.push_back({{"name", name}, {"why", why}});
      stage.Warn(name + " contradicts the other photographs: " + why +
                 "; it was left out of the texture. It shows something else, or its camera is "
                 "wrong: shoot it again, or delete it");
    } else if (!c.hidden.empty()) {
      hidden.push_back({{"name", name}, {"share", c.hidden_share}});
      if (!c.told || blurred.contains(name)) continue;
      stage.Warn("something lies before the figure in " + name +
                 " (a hand, a tool, a lamp's mirror image): " + PercentHalfUp(c.hidden_share) +
                 " of what it shows has other colours than the other photographs show there, and "
                 "was left out of the texture; "
                 "look at it, and shoot it again without");
    }
  }
  if (!other_light.empty())
    stage.Warn("the lamp stood elsewhere for " + Names(other_light) +
               " than for the other photographs; they were painted from only where no others see "
               "the surface. Shoot them again in the same "
               "light, if the texture shows patches");
  stage.ReportJson("distrusted", distrusted.dump());
  stage.ReportJson("hidden_parts", hidden.dump());
  stage.ReportJson("other_light", nlohmann::json(other_light).dump());
  stage.ReportJson("color_fits", views.dump());
}

/// Result: BakeResult or ScanBake.
template <class Result>
void Write(StageContext& stage, const Result& result, int bits) {
  const std::filesystem::path path = stage.Output("texture");
  // The 8-bit picture was measured; pictures with more bits are not rounded to it first.
  if (path.extension() == ".png" && bits != 16)
    WriteImage(path, result.texture);
  else
    WriteLinearImage(path, result.linear, bits);
  if (const auto confidence = stage.Output("confidence"); !confidence.empty())
    WriteImage(confidence, result.confidence);
}

template <class Result>
void ReportTexels(StageContext& stage, const Result& result) {
  stage.Report("texture_size", result.texture.width);
  stage.Report("texture_size_advised", result.advised_size);
  stage.Report("texels", result.texels);
  stage.Report("seen_texels", result.seen_texels);
  stage.Report("unseen_texels", result.texels - result.seen_texels);
  stage.Report("unseen_fraction", static_cast<double>(result.texels - result.seen_texels) /
                                      static_cast<double>(result.texels));
}

void RunScan(StageContext& stage, const Mesh& mesh, const BakeOptions& options) {
  const Mesh scan = ReadMesh(stage.Input("scan"));
  RequireUsable(scan, stage.Input("scan").string());
  Image8 texture;
  if (const auto file = stage.Input("scan_texture"); !file.empty()) texture = ReadTexture(file);
  const ScanBake result =
      BakeScan(mesh, scan, texture, {options.texture_size, options.gutter, options.scan_reach},
               stage.progress());
  ReportTexels(stage, result);
  if (texture.empty() && scan.colors.rows() == 0)
    stage.Warn(PrintableName(stage.Input("scan")) +
               " has no colours of its vertices, and no picture was named as scan_texture: the "
               "texture is grey, except where `complete` has another pose's");
  else if (result.seen_texels == 0)
    stage.Warn(
        "the scan lies nowhere near the mesh, so that it gives no colour: both must be the "
        "same pose in the same place");
  Write(stage, result, options.bits);
}

void RunPhotographs(StageContext& stage, const Mesh& mesh, const BakeOptions& options) {
  const Scene scene = ReadColmapModel(stage.Input("model"));
  const ImageSet images = ReadImageSet(stage.Input("images"));
  const std::vector<int> index = MatchImages(scene, images);
  // One photograph tells of all: to look at each takes time where they are PNG.
  const bool large = !index.empty() && StoredLevelsOf(images.ImagePath(index[0])).bits > 8;
  constexpr double kBytesAPixel = 5;  // measured, of 8 bits
  RequireMemoryForViews("bake", scene.views, 1, large ? 2 * kBytesAPixel : kBytesAPixel);
  std::atomic<bool> deep = false;
  const auto load = [&](int v) {
    Photograph photograph = Load(images, index[v]);
    if (!photograph.deep.empty()) deep = true;
    return photograph;
  };
  const BakeResult result = Bake(mesh, scene.views, load, options, stage.progress());
  ReportTexels(stage, result);
  ReportQuality(stage, scene, result, options.leave_out);
  ReportColors(stage, scene, result.colors, BlurredImages(images));
  const bool png = stage.Output("texture").extension() == ".png";
  Write(stage, result, options.bits == 0 && deep && png ? 16 : options.bits);
}

void Run(StageContext& stage, const BakeOptions& options) {
  const std::filesystem::path path = stage.Output("texture");
  if (!CanWriteLinear(path, options.bits))
    throw UsageError("bake: a texture '" + path.filename().string() + "' with bits " +
                     std::to_string(options.bits) +
                     " cannot be written: .png and .tif hold 8 or 16 bits, .exr holds 16 or 32");
  const bool images = !stage.Input("images").empty(), model = !stage.Input("model").empty(),
             scan = !stage.Input("scan").empty();
  if (images != model || images == scan)
    throw UsageError(
        "bake: pass either --images and --model (photographs), or --scan (a mesh that has "
        "colours)");
  const Mesh mesh = ReadMesh(stage.Input("mesh"));
  RequireUsable(mesh, stage.Input("mesh").string());
  scan ? RunScan(stage, mesh, options) : RunPhotographs(stage, mesh, options);
}

}  // namespace
}  // namespace keypose::texture

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::texture::BakeOptions>(argc, argv, keypose::texture::Spec(),
                                                          keypose::texture::Run);
}
