#include "studio/meshes/frame_colours.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "core/values/same_faces.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"
#include "studio/meshes/frame_order.h"
#include "studio/project/pose_photographs.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kSamePlace = 1e-6;  // of the texture's side

void RequireShot(Snapshot& snapshot, const std::string& shot) {
  if (!snapshot.HasPose(shot)) throw UsageError(fmt::format("there is no shot '{}'", shot));
}

bool IsTexture(const fs::path& file) {
  return file.stem().string().starts_with("frame_") &&
         (file.extension() == ".png" || file.extension() == ".jpg");
}

/// In order; empty before they are painted.
std::vector<fs::path> PaintedTextures(Snapshot& snapshot, const std::string& shot) {
  std::vector<fs::path> textures;
  const auto folder = snapshot.ResultPath("video3d", shot, "textures");
  if (!folder) return textures;
  for (const auto& entry : fs::directory_iterator(*folder))
    if (IsTexture(entry.path())) textures.push_back(entry.path());
  SortByNumber(&textures);
  return textures;
}

/// Whether each corner of each face lies at the same place in both.
bool SameLayout(const Mesh& one, const Mesh& two) {
  if (!one.has_uvs() || !two.has_uvs() || !SameFaces(one.faces, two.faces)) return false;
  for (Eigen::Index f = 0; f < one.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const auto apart = one.uvs.row(one.uv_faces(f, k)) - two.uvs.row(two.uv_faces(f, k));
      if (apart.cwiseAbs().maxCoeff() > kSamePlace) return false;
    }
  return true;
}

/// Whether the textures were painted in the layout that `layout` has made last.
bool IsOfThisLayout(Snapshot& snapshot, const std::string& shot) {
  const auto painted = snapshot.Result("video3d", shot), layout = snapshot.Result("layout", shot);
  if (!painted || !layout) return true;
  const auto made = layout->outputs.find("unwrapped");
  for (const pipeline::RecipeInput& input : painted->recipe.inputs)
    if (input.port == "layout" && made != layout->outputs.end())
      return input.content == made->second.content;
  return true;
}

std::string VideoProblem(Snapshot& snapshot, const std::string& shot, const Mesh& laid_out,
                         std::size_t frames, std::size_t textures) {
  if (!snapshot.FindStep("video3d", shot))
    return "the films are not painted on it: switch on the steps layout and video3d in "
           "pipeline.yaml, as `keypose init --video3d` does";
  if (textures == 0) return fmt::format("not painted yet: run the steps up to video3d/{}", shot);
  if (!laid_out.has_uvs())
    return fmt::format("the frames have no texture coordinates: run layout/{}", shot);
  if (!IsOfThisLayout(snapshot, shot))
    return fmt::format("it was painted in an earlier layout: run video3d/{}", shot);
  if (textures != frames)
    return fmt::format("{} textures were painted, but there are {} frames by now: run video3d/{}",
                       textures, frames, shot);
  return "";
}

json PaintedJson(Snapshot& snapshot, const std::string& shot, const fs::path& first) {
  const ImageInfo info = ReadImageInfo(first);
  return {{"width", info.width},
          {"height", info.height},
          {"version", snapshot.Result("video3d", shot)->fingerprint}};
}

/// "texture", "vertices" or ""; then why.
std::pair<std::string, std::string> OwnColours(Snapshot& snapshot, const std::string& shot,
                                               const Mesh& first, const Mesh& laid_out) {
  std::string problem = "neither a texture nor colours of its vertices come with the mesh";
  if (snapshot.file().Given("texture")) {
    try {
      ReadImageInfo(OwnTexture(snapshot, shot));
      if (SameLayout(first, laid_out)) return {"texture", ""};
      problem = first.has_uvs() ? "its texture lies in another layout than that of the step layout"
                                : "it has a texture, but no texture coordinates";
    } catch (const Error& error) {
      problem = error.what();
    } catch (const NotFound& error) {
      problem = error.what();
    }
  }
  if (first.colors.rows() == first.points.rows()) return {"vertices", ""};
  return {"", problem};
}

}  // namespace

Mesh FrameWithLayout(Snapshot& snapshot, const std::string& shot, Mesh frame) {
  const auto file = snapshot.ResultPath("layout", shot, "unwrapped");
  if (!file) return frame;
  Mesh layout = ReadMesh(*file);
  if (!layout.has_uvs() || !SameFaces(layout.faces, frame.faces)) return frame;
  frame.uvs = std::move(layout.uvs);
  frame.uv_faces = std::move(layout.uv_faces);
  return frame;
}

json FrameColoursJson(Snapshot& snapshot, const std::string& shot, const Mesh& first,
                      std::size_t frames) {
  const Mesh laid_out = FrameWithLayout(snapshot, shot, first);
  const auto textures = PaintedTextures(snapshot, shot);
  const std::string problem = VideoProblem(snapshot, shot, laid_out, frames, textures.size());
  const auto [own, own_problem] = OwnColours(snapshot, shot, first, laid_out);
  return {{"own", own},
          {"own_problem", own_problem},
          {"video", problem.empty() ? PaintedJson(snapshot, shot, textures.front()) : json()},
          {"video_problem", problem}};
}

fs::path FrameTexture(Snapshot& snapshot, const std::string& shot, int frame) {
  RequireShot(snapshot, shot);
  const auto textures = PaintedTextures(snapshot, shot);
  if (frame >= static_cast<int>(textures.size()))
    throw NotFound(fmt::format("shot '{}' has no texture for frame {}", shot, frame));
  return textures[static_cast<std::size_t>(frame)];
}

fs::path OwnTexture(Snapshot& snapshot, const std::string& shot) {
  RequireShot(snapshot, shot);
  const auto* named = snapshot.file().Given("texture");
  if (!named) throw NotFound("pipeline.yaml names no texture");
  const fs::path project = snapshot.project();
  const fs::path file =
      project / pipeline::OnDisk(pipeline::RealDisk(), project, pipeline::WithHome(named->text));
  if (!IsWithin(fs::weakly_canonical(file), fs::canonical(project)))
    throw NotFound(fmt::format(
        "the texture {} is outside of the project; copy it in, and name the copy", named->text));
  if (!fs::is_regular_file(file)) throw NotFound(fmt::format("{} is not there", named->text));
  return file;
}

}  // namespace keypose::studio
