#include "armature/live/page_stream.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

static_assert(std::endian::native == std::endian::little, "pages read little-endian numbers");

template <class T>
void AddBytes(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

std::string WeightBytes(const SkinWeights& weights) {
  std::string bytes;
  for (const auto& of_vertex : weights.bones)
    for (const std::uint16_t bone : of_vertex) AddBytes(bytes, bone);
  for (const auto& of_vertex : weights.weights)
    for (const double weight : of_vertex) AddBytes(bytes, static_cast<float>(weight));
  return bytes;
}

std::array<double, 7> BoneNumbers(const Rigid3& bone) {
  const auto& q = bone.rotation;
  const auto& t = bone.translation;
  return {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
}

std::string BoneBytes(const SkeletonPose& pose) {
  std::string bytes;
  for (const Rigid3& bone : pose.bones)
    for (const double number : BoneNumbers(bone)) AddBytes(bytes, static_cast<float>(number));
  return bytes;
}

json RigidJson(const Rigid3& rigid) {
  const auto numbers = BoneNumbers(rigid);
  return json(numbers);
}

json ViewJson(const PlateView& view) {
  const Camera& camera = view.view.camera;
  const Similarity3& placed = view.world_from_character;
  const Rigid3 turn{Eigen::Quaterniond(placed.rotation), placed.translation};
  return {{"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"k1", camera.k1},
          {"k2", camera.k2},
          {"p1", camera.p1},
          {"p2", camera.p2},
          {"camera_from_world", RigidJson(view.view.camera_from_world)},
          {"world_from_character", RigidJson(turn)},
          {"scale", placed.scale}};
}

struct ShownUnit {
  double size;
  const char* name;
};

/// Degrees of joints that turn, millimetres of those that slide, if the description has a unit.
ShownUnit ShownUnitOf(const Armature& armature, int joint) {
  const int node = armature.joints[static_cast<std::size_t>(joint)];
  if (armature.nodes[static_cast<std::size_t>(node)].kind == NodeKind::kJoint)
    return {kDegree, "°"};
  return armature.metres_per_unit > 0 ? ShownUnit{1e-3, "mm"} : ShownUnit{1, ""};
}

}  // namespace

std::string PoseBytes(const PuppetParts& parts, const std::vector<std::vector<double>>& frames) {
  PuppetMatcher matcher(parts.armature, parts.plan, parts.skeleton, parts.world_from_armature,
                        parts.options);
  std::string bytes;
  for (const std::vector<double>& values : frames) bytes += BoneBytes(matcher.Update(values));
  return bytes;
}

PageStream::PageStream(const PuppetParts& parts, const PlateFiles& plates, bool own_mesh,
                       const fs::path& folder)
    : parts_(parts), folder_(folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw DiskError("cannot make the folder " + PrintableName(folder) + ": " + error.message());
  if (!own_mesh) WriteMesh(folder / "rest.ply", parts.mesh);
  WriteFileAtomically(folder / "weights.bin", WeightBytes(parts.weights));
  WriteFileAtomically(folder / "frames.bin", "");
  WriteFileAtomically(folder / "view.json", ViewText(plates));
}

std::string PageStream::ViewText(const PlateFiles& plates) const {
  json sensors = json::array(), chains = json::array(), pictures = json::array(),
       views = json::array();
  const Armature& armature = parts_.armature;
  for (int j = 0; j < SizeOf(armature.joints); ++j) {
    const int node = armature.joints[static_cast<std::size_t>(j)];
    sensors.push_back({{"name", armature.nodes[static_cast<std::size_t>(node)].name},
                       {"unit", ShownUnitOf(armature, j).name}});
  }
  for (const Chain& chain : parts_.plan.chains)
    chains.push_back({{"name", chain.name}, {"exact", chain.mode == ChainMode::kExact}});
  for (const fs::path& plate : plates.pictures()) pictures.push_back(fs::absolute(plate).string());
  for (const PlateView& view : plates.views()) views.push_back(ViewJson(view));
  const json all = {{"bones", parts_.skeleton.size()},
                    {"vertices", parts_.mesh.vertex_count()},
                    {"sensors", sensors},
                    {"chains", chains},
                    {"plate_count", plates.count()},
                    {"pictures", pictures},
                    {"views", views}};
  return all.dump(-1, ' ', false, json::error_handler_t::replace);
}

void PageStream::TakeUp(const std::vector<std::vector<double>>& frames) {
  WriteFileAtomically(folder_ / "frames.bin", PoseBytes(parts_, frames));
}

void PageStream::Record(int frame, const SkeletonPose& pose) {
  const std::string bytes = BoneBytes(pose);
  const fs::path path = folder_ / "frames.bin";
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(bytes.size()) * frame);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw DiskError("cannot write " + PrintableName(path));
}

std::string PageStream::Line(const PuppetMatcher& matcher, const PageLine& line) {
  std::string text =
      fmt::format(R"({{"pose":{},"time":{:.3f},"fresh":{},"repeats":{},"damaged":{})", number_++,
                  line.time_s, line.fresh, line.repeats, line.damaged);
  const auto add_list = [&](const char* name, const auto& add_all) {
    fmt::format_to(std::back_inserter(text), R"(,"{}":[)", name);
    add_all();
    if (text.back() == ',') text.pop_back();
    text += ']';
  };
  add_list("bones", [&] {
    for (const Rigid3& bone : matcher.pose().bones)
      for (const double number : BoneNumbers(bone))
        fmt::format_to(std::back_inserter(text), "{:.6g},", number);
  });
  add_list("values", [&] {
    for (int j = 0; j < SizeOf(line.values); ++j)
      fmt::format_to(
          std::back_inserter(text), "{:.2f},",
          line.values[static_cast<std::size_t>(j)] / ShownUnitOf(parts_.armature, j).size);
  });
  const auto add_numbers = [&](const char* name, const std::vector<int>& numbers) {
    add_list(name, [&] {
      for (const int number : numbers) fmt::format_to(std::back_inserter(text), "{},", number);
    });
  };
  add_numbers("held", line.held);
  add_numbers("wraps", line.wraps);
  add_list("chains", [&] {
    for (const ChainState& chain : matcher.chains()) {
      const double length = chain.chain_length;
      fmt::format_to(std::back_inserter(text), "[{:.3g},{:.3g},{:.3g}],",
                     chain.match.near_gap / length, chain.match.far_gap / length,
                     chain.match.mean_distance / length);
    }
  });
  return text + '}';
}

}  // namespace keypose::armature
