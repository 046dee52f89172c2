#include "composite/composite_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "composite/blender/blender_scene.h"
#include "composite/composite_scene_output.h"
#include "composite/layer/linear_light.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/pictures/png_io.h"
#include "core/io/text/files.h"
#include "core/numbers/sha256.h"
#include "core/pictures/undistorted.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "core/values/size_of.h"
#include "views/film/mp4.h"

namespace keypose::composite {
namespace {

namespace fs = std::filesystem;

constexpr const char* kParts[] = {"layers", "compare", "blender", "plates"};

/// Levels of 255 with straight alpha, from premultiplied linear light.
ImageF StraightOf(const ImageF& layer) {
  ImageF straight = layer;
  for (std::size_t i = 0; i < straight.data.size(); i += 4) {
    const float alpha = straight.data[i + 3];
    for (std::size_t c = 0; c < 3; ++c)
      straight.data[i + c] = alpha > 1e-4f ? straight.data[i + c] / alpha : 0;
  }
  ImageF out = LevelsOf(straight);
  for (std::size_t i = 3; i < out.data.size(); i += 4)
    out.data[i] = 255 * std::clamp(layer.data[i], 0.0f, 1.0f);
  return out;
}

/// RGBA. Alpha is `scale` times the given one; colours are multiplied by it if `premultiplied`.
ImageF WithAlpha(const ImageF& colours, const ImageF& alpha, float scale, bool premultiplied) {
  ImageF out(colours.width, colours.height, 4);
  for (std::size_t i = 0; i < alpha.data.size(); ++i) {
    const float factor = premultiplied ? alpha.data[i] : 1;
    for (std::size_t c = 0; c < 3; ++c) out.data[4 * i + c] = factor * colours.data[3 * i + c];
    out.data[4 * i + 3] = scale * alpha.data[i];
  }
  return out;
}

/// As it looks over black; an empty alpha is opaque.
Image8 Shown(ImageF levels, const ImageF& alpha) {
  for (std::size_t i = 0; i < alpha.data.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) levels.data[3 * i + c] *= alpha.data[i];
  return Rounded(levels);
}

Image8 Even(const Image8& picture) {
  const int width = picture.width / 2 * 2, height = picture.height / 2 * 2;
  if (width == picture.width && height == picture.height) return picture;
  Image8 even(width, height, 3);
  for (int y = 0; y < height; ++y) std::copy_n(picture.at(0, y), 3 * width, even.at(0, y));
  return even;
}

class ShotWriter {
 public:
  ShotWriter(const fs::path& folder, const CompositeInput& input, const ShotGeometry& geometry,
             const Film& film, const FilmLessons& lessons, const OutputOptions& options)
      : folder_(folder),
        input_(input),
        geometry_(geometry),
        film_(film),
        lessons_(lessons),
        options_(options),
        camera_(input.shot.camera) {
    for (const char* part : kParts) Make(folder_ / part);
    if (options.video && CanWriteMp4() && camera_.width > 1 && camera_.height > 1)
      video_ = std::make_unique<Mp4Writer>(folder_ / "shot.mp4", camera_.width / 2 * 2,
                                           camera_.height / 2 * 2, input.times.fps, options.sound);
  }

  Written WriteAll(Progress* progress) {
    const int count = SizeOf(input_.plan.pictures);
    WritePlate();
    for (int n = 0; n < count; ++n) {
      if (progress && progress->cancelled()) throw Cancelled();
      ReportProgress(progress, 0.5 + 0.5 * n / count, "pictures");
      WritePicture(n);
    }
    if (video_) video_->Finish();
    if (options_.blender) WriteBlender();
    for (const char* part : kParts)
      if (fs::is_empty(folder_ / part)) fs::remove(folder_ / part);
    return std::move(written_);
  }

 private:
  static void Make(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
      throw DiskError("composite: cannot create " + folder.string() + ": " + error.message());
  }

  /// As the filmed pictures are stored.
  void Write(const fs::path& path, const ImageF& levels) const {
    WriteLevels(path, levels, input_.kind.bits, input_.kind.profile);
  }

  /// Of a picture of the finished shot.
  std::string Number(int n) const { return fmt::format("{:04}", input_.first_number + n); }
  /// The scene counts its pictures from 0, whatever their numbers are.
  static std::string BlenderFilm(int n) { return fmt::format("film_{:04}.jpg", n); }

  /// The one of a still camera.
  void WritePlate() const {
    if (film_.plate_at) return;
    const ImageF& light = lessons_.plate.light;
    if (input_.scene) return WriteScenePlate(folder_ / "plate.exr", input_, light);
    Write(folder_ / "plate.png", LevelsOf(light));
  }

  /// RGB of 8 bits to look at, over black where it is transparent.
  Image8 FilmShown(int filmed) const {
    return Shown(LevelsIn(film_, film_.read(filmed)), film_.alpha ? film_.alpha(filmed) : ImageF());
  }

  void WritePicture(int n) {
    const PlannedPicture& planned = input_.plan.pictures[n];
    if (planned.kind == PictureKind::kBetween) return WriteBetween(n, planned);
    if (planned.filmed < 0) return;
    const fs::path& from = input_.film[planned.filmed].path;
    const std::string bytes = ReadFile(from);
    const fs::path to = folder_ / (Number(n) + LowerExtension(from));
    WriteFile(to, bytes);
    if (planned.kind == PictureKind::kFilmed && Sha256Of(ReadFile(to)) == Sha256Of(bytes))
      ++written_.filmed_unchanged;
    const Image8 picture = FilmShown(planned.filmed);
    Show(n, picture);
    if (planned.kind == PictureKind::kFilmed) Join(n, planned, picture);
  }

  void WriteBetween(int n, const PlannedPicture& planned) {
    const ComposedPicture composed =
        Compose(geometry_, input_.looks, film_, lessons_, planned.animation, ExposureAt(n),
                options_.compose, static_cast<std::uint64_t>(n) + 1);
    const bool keyed = !composed.alpha.empty();
    const fs::path name = Number(n) + options_.ending;
    if (input_.scene) {
      WriteScenePicture(folder_ / name, input_, composed, planned.animation);
    } else if (options_.ending == ".exr") {
      WriteLinearImage(folder_ / name,
                       keyed ? WithAlpha(composed.light, composed.alpha, 1, true) : composed.light);
      WriteLinearImage(folder_ / "layers" / name, composed.layer);
    } else {
      Write(folder_ / name,
            keyed ? WithAlpha(composed.picture, composed.alpha, 255, false) : composed.picture);
      Write(folder_ / "layers" / (Number(n) + ".png"), StraightOf(composed.layer));
    }
    if (!geometry_.still() && !input_.sequence) WriteMovingPlate(n, composed.moving_plate.picture);
    Show(n, Shown(composed.picture, composed.alpha));
  }

  void WriteMovingPlate(int n, const ImageF& picture) const {
    const fs::path name = folder_ / "plates" / Number(n);
    if (input_.scene)
      WriteScenePlate(name.string() + ".exr", input_, picture);
    else
      Write(name.string() + ".png", picture);
  }

  /// Where a located frame was filmed, it is rendered too, to be compared.
  void Join(int n, const PlannedPicture& planned, const Image8& filmed) {
    const FilmedPicture& picture = film_.pictures[planned.filmed];
    if (picture.anchor < 0 || planned.animation < 0) return;
    ComposeOptions still = options_.compose;
    still.shutter_deg = 0;
    const ComposedPicture composed =
        Compose(geometry_, input_.looks, film_, lessons_, planned.animation,
                lessons_.exposures[planned.filmed], still, static_cast<std::uint64_t>(n) + 1);
    const Image8 rendered = Shown(composed.picture, composed.alpha);
    const Anchor& anchor = geometry_.anchors()[picture.anchor];
    written_.joins.push_back({input_.first_number + n, input_.shot.frames[anchor.shot_frame].pose,
                              MeasureJoin(rendered, filmed, composed.coverage)});
    if (options_.compare)
      WritePng(folder_ / "compare" / (Number(n) + ".png"), SideBySide(filmed, rendered));
  }

  /// Between the filmed frames on both sides.
  Eigen::Vector3d ExposureAt(int n) const {
    int before = n, after = n;
    const auto filmed = [&](int k) {
      return k >= 0 && k < SizeOf(input_.plan.pictures) &&
             input_.plan.pictures[k].kind == PictureKind::kFilmed;
    };
    while (before >= 0 && !filmed(before)) --before;
    while (after < SizeOf(input_.plan.pictures) && !filmed(after)) ++after;
    const bool has_before = before >= 0, has_after = after < SizeOf(input_.plan.pictures);
    const auto of = [&](int k) { return lessons_.exposures[input_.plan.pictures[k].filmed]; };
    if (!has_before && !has_after) return Eigen::Vector3d::Ones();
    if (!has_before) return of(after);
    if (!has_after) return of(before);
    const double share = static_cast<double>(n - before) / (after - before);
    return (1 - share) * of(before) + share * of(after);
  }

  void Show(int n, const Image8& picture) {
    if (video_) video_->Add(Even(picture));
    if (!options_.blender) return;
    const Image8 flat = camera_.distorted() ? Undistorted(picture, camera_) : picture;
    WriteImage(folder_ / "blender" / BlenderFilm(n), flat, 95);
  }

  /// Of a still camera.
  Image8 PlateShown() const {
    if (!film_.shown) return SrgbOf(lessons_.plate.light);
    return Rounded(film_.shown(film_.plate_at ? film_.plate_at(0).picture : lessons_.plate.light));
  }

  BlenderLight LightForBlender() const {
    const Ground table = geometry_.Table();
    const ShadowStrength& strength = lessons_.shadow.strength;
    BlenderLight light{lessons_.light.harmonics,
                       strength.sky,
                       strength.lamp,
                       strength.light.direction,
                       strength.light.radius_rad,
                       table.origin,
                       table.right,
                       table.up,
                       table.diagonal};
    if (!options_.compose.shadow) light.sky = light.lamp = 0;
    return light;
  }

  void WriteBlender() {
    const fs::path folder = folder_ / "blender";
    BlenderShot shot{geometry_.ViewAt(0),
                     {},
                     input_.times.fps,
                     input_.plan.start,
                     SizeOf(input_.plan.pictures),
                     {},
                     "",
                     BlenderFilm(0),
                     LightForBlender()};
    if (geometry_.still()) {
      shot.plate = "plate.png";
      const Image8 plate = PlateShown();
      WritePng(folder / shot.plate, camera_.distorted() ? Undistorted(plate, camera_) : plate);
    }
    for (int n = 0; !geometry_.still() && n < shot.pictures; ++n)
      shot.path.push_back(geometry_.ViewAt(n - shot.first_picture));
    for (int i = 0; i < SizeOf(input_.looks.textures); ++i) {
      shot.textures.push_back(fmt::format("texture_{}.png", i));
      WritePng(folder / shot.textures.back(),
               SrgbOf(TextureInRec709(input_, input_.looks.textures[i])));
    }
    std::vector<PointsX3> frames;
    for (int f = 0; f < SizeOf(input_.frames); ++f) frames.push_back(geometry_.Points(f));
    const Looks& looks = input_.looks;
    for (const BlenderFile& file :
         BlenderFiles(shot, looks.faces, looks.uvs, looks.uv_faces, frames))
      WriteFile(folder / file.name, file.bytes);
  }

  fs::path folder_;
  const CompositeInput& input_;
  const ShotGeometry& geometry_;
  const Film& film_;
  const FilmLessons& lessons_;
  const OutputOptions& options_;
  Camera camera_;
  std::unique_ptr<Mp4Writer> video_;
  Written written_;
};

}  // namespace

Written WriteShot(const fs::path& folder, const CompositeInput& input, const ShotGeometry& geometry,
                  const Film& film, const FilmLessons& lessons, const OutputOptions& options,
                  Progress* progress) {
  return ShotWriter(folder, input, geometry, film, lessons, options).WriteAll(progress);
}

}  // namespace keypose::composite
