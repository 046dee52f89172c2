#include "synth/scores/video_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/image_quality.h"
#include "core/pictures/render.h"
#include "core/values/errors.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;

constexpr int kAround = 8;  // [px] from which the background beside an outline is taken

Image8 Eroded(const Image8& mask) {
  Image8 eroded = mask;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const int px = std::clamp(x + dx, 0, mask.width - 1),
                    py = std::clamp(y + dy, 0, mask.height - 1);
          if (*mask.at(px, py) <= 127) *eroded.at(x, y) = 0;
        }
  return eroded;
}

/// Mean colour of what lies outside of the outline within some pixels; false: there is nothing.
bool Background(const Image8& film, const Image8& outline, int x, int y, double* color) {
  int count = 0;
  std::fill_n(color, 3, 0.0);
  for (int py = std::max(0, y - kAround); py <= std::min(film.height - 1, y + kAround); ++py)
    for (int px = std::max(0, x - kAround); px <= std::min(film.width - 1, x + kAround); ++px) {
      if (*outline.at(px, py) > 127) continue;
      for (int c = 0; c < 3; ++c) color[c] += film.at(px, py)[c];
      ++count;
    }
  for (int c = 0; c < 3; ++c) color[c] /= std::max(1, count);
  return count > 0;
}

Mesh WithUvs(const VideoScoreCommand& command, const fs::path& first) {
  Mesh mesh = ReadMesh(first);
  if (!command.layout.empty()) {
    const Mesh layout = ReadMesh(command.layout);
    if (!SameFaces(layout.faces, mesh.faces))
      throw InputError("synth: the layout has other faces than the frames");
    mesh.uvs = layout.uvs;
    mesh.uv_faces = layout.uv_faces;
  }
  if (!mesh.has_uvs())
    throw InputError("synth: the frames have no texture coordinates; pass --layout");
  return mesh;
}

Image8 TextureOf(const fs::path& folder, int frame) {
  for (const char* extension : {"png", "jpg"})
    if (const fs::path path = folder / fmt::format("frame_{:04}.{}", frame, extension);
        fs::exists(path))
      return ReadImage(path, 3);
  throw InputError(
      fmt::format("synth: {} has no texture of frame {}", PrintableName(folder), frame));
}

Image8 Difference(const Image8& film, const Image8& render, const Image8& outline) {
  Image8 picture(film.width, film.height, 3, 255);
  for (std::size_t i = 0; i < outline.data.size(); ++i) {
    if (outline.data[i] <= 127) continue;
    for (int c = 0; c < 3; ++c)
      picture.data[3 * i + c] = static_cast<std::uint8_t>(
          std::max(0, 255 - 4 * std::abs(film.data[3 * i + c] - render.data[4 * i + c])));
  }
  return picture;
}

/// Film, render on the film's background, and difference, of the part where the actor is.
Image8 SideBySide(const Image8& film, const Image8& render, const Image8& outline) {
  int x0 = film.width, x1 = 0, y0 = film.height, y1 = 0;
  for (int y = 0; y < film.height; ++y)
    for (int x = 0; x < film.width; ++x)
      if (*outline.at(x, y) > 127) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y);
      }
  x0 = std::max(0, x0 - 12);
  y0 = std::max(0, y0 - 12);
  x1 = std::min(film.width - 1, x1 + 12);
  y1 = std::min(film.height - 1, y1 + 12);
  Image8 flat(film.width, film.height, 3);
  for (std::size_t i = 0; i < outline.data.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const int alpha = render.data[4 * i + 3];
      flat.data[3 * i + c] = static_cast<std::uint8_t>(
          (render.data[4 * i + c] * alpha + 246 * (255 - alpha) + 127) / 255);
    }
  std::vector<Image8> tiles;
  for (const Image8& whole : {film, flat, Difference(film, render, outline)}) {
    Image8 part(x1 - x0 + 1, y1 - y0 + 1, 3);
    for (int y = y0; y <= y1; ++y)
      std::copy_n(whole.at(x0, y), 3 * static_cast<std::size_t>(part.width), part.at(0, y - y0));
    tiles.push_back(part);
  }
  return TileImages(tiles, 3);
}

}  // namespace

void VideoErrors::Add(const VideoErrors& other) {
  squares += other.squares;
  values += other.values;
  rim_squares += other.rim_squares;
  rim_values += other.rim_values;
  halo += other.halo;
  halo_scale += other.halo_scale;
  covered += other.covered;
  inside += other.inside;
}

VideoErrors ComparePictures(const Image8& film, const Image8& render, const Image8& outline) {
  const Image8 inside = Eroded(outline);
  Image8 core = inside;
  for (int i = 0; i < kRimPixels; ++i) core = Eroded(core);
  VideoErrors errors;
  for (int y = 0; y < film.height; ++y)
    for (int x = 0; x < film.width; ++x) {
      if (*inside.at(x, y) <= 127) continue;
      ++errors.inside;
      if (render.at(x, y)[3] < 255) continue;
      ++errors.covered;
      double back[3];
      const bool rim = *core.at(x, y) <= 127, leans = rim && Background(film, outline, x, y, back);
      for (int c = 0; c < 3; ++c) {
        const double truth = film.at(x, y)[c], off = render.at(x, y)[c] - truth;
        errors.squares += off * off;
        ++errors.values;
        if (rim) {
          errors.rim_squares += off * off;
          ++errors.rim_values;
        }
        if (leans) {
          errors.halo += off * (back[c] - truth);
          errors.halo_scale += (back[c] - truth) * (back[c] - truth);
        }
      }
    }
  return errors;
}

VideoScore ScoreVideo(const VideoScoreCommand& command) {
  const std::vector<fs::path> frames = NumberedFrames(command.frames, "synth");
  const Mesh mesh = WithUvs(command, frames.front());
  const View view =
      ReadRigCalibration(command.performance / "held_out" / "calibration.yml").views.front();
  std::vector<int> scored;
  for (int f = 0; f < SizeOf(frames); f += std::max(1, command.every)) scored.push_back(f);
  std::vector<VideoErrors> errors(scored.size());
  ParallelFor(SizeOf(scored), [&](std::int64_t i) {
    const int f = scored[i];
    Mesh moved = mesh;
    moved.points = ReadMesh(frames[f]).points;
    const Image8 texture = TextureOf(command.textures, f);
    RenderOptions look;
    look.shading = 0;
    look.texture = &texture;
    const Image8 render = RenderCutout(moved, RayScene(moved.points, moved.faces), view, look);
    const std::string number = fmt::format("{:03}", f);
    const Image8 film =
        ReadImage(command.performance / "held_out" / view.name / (number + ".jpg"), 3);
    const Image8 outline =
        ReadImage(command.performance / "truth" / "masks" / view.name / (number + ".png"), 1);
    errors[i] = ComparePictures(film, render, outline);
    if (!command.picture.empty() && i == SizeOf(scored) / 2)
      WriteImage(command.picture, SideBySide(film, render, outline), 90);
  });
  VideoScore score;
  score.frames = SizeOf(scored);
  VideoErrors all;
  for (const VideoErrors& one : errors) {
    all.Add(one);
    score.frame_psnr_db.push_back(Psnr(one.squares, one.values));
  }
  score.psnr_db = Psnr(all.squares, all.values);
  score.rim_psnr_db = Psnr(all.rim_squares, all.rim_values);
  score.rim_halo = all.halo_scale > 0 ? all.halo / all.halo_scale : 0;
  score.covered = all.inside > 0 ? all.covered / all.inside : 0;
  return score;
}

std::string ToJson(const VideoScore& score) {
  nlohmann::ordered_json json;
  json["frames"] = score.frames;
  json["psnr_db"] = score.psnr_db;
  json["rim_psnr_db"] = score.rim_psnr_db;
  json["rim_halo"] = score.rim_halo;
  json["covered"] = score.covered;
  json["frame_psnr_db"] = nlohmann::json::array();
  for (const double psnr : score.frame_psnr_db)
    json["frame_psnr_db"].push_back(std::round(100 * psnr) / 100);
  return json.dump(1) + "\n";
}

}  // namespace keypose::synth
