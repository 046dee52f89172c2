#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "core/testing_shapes.h"
#include "export/gltf.h"

namespace keypose::exporting {
namespace {

// A unit box whose every face has its own patch of the texture: eight corners become 24 or more split vertices.
Mesh UnwrappedBox() {
  Mesh box = MakeBox(1, 2, 3);
  box.uvs.resize(3 * box.face_count(), 2);
  box.uv_faces.resize(box.face_count(), 3);
  for (int f = 0; f < box.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      box.uv_faces(f, k) = 3 * f + k;
      box.uvs.row(3 * f + k) << (f + (k == 1)) / 13.0, (k == 2) * 0.75;
    }
  }
  return box;
}

std::vector<Mesh> StretchingBox(int count) {
  std::vector<Mesh> frames(count, UnwrappedBox());
  for (int i = 1; i < count; ++i) frames[i].points.col(2) *= 1 + 0.25 * i;
  return frames;
}

std::vector<std::string> Names(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back("frame_000" + std::to_string(i));
  return names;
}

const EncodedImage kTexture{"any bytes at all, only carried", "image/png", "clay"};

// An independent reader of the file layout: header, JSON chunk, binary chunk.
struct Glb {
  nlohmann::json json;
  std::string binary;

  explicit Glb(const std::string& bytes) {
    const auto word = [&](std::size_t at) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + at, 4);
      return value;
    };
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(word(4), 2u);
    EXPECT_EQ(word(8), bytes.size());
    json = nlohmann::json::parse(bytes.substr(20, word(12)));
    const std::size_t at = 20 + word(12);
    binary = bytes.substr(at + 8, word(at));
  }

  Eigen::MatrixXf Read(int accessor) const {
    const auto& a = json["accessors"][accessor];
    const auto& view = json["bufferViews"][a["bufferView"].get<int>()];
    const int columns = a["type"] == "VEC3" ? 3 : a["type"] == "VEC2" ? 2 : 1;
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> out(a["count"].get<int>(), columns);
    std::memcpy(out.data(), binary.data() + view.value("byteOffset", 0), sizeof(float) * out.size());
    return out;
  }
  Eigen::VectorXi ReadIndices(int accessor) const {
    const auto& a = json["accessors"][accessor];
    Eigen::VectorXi out(a["count"].get<int>());
    std::memcpy(out.data(), binary.data() + json["bufferViews"][a["bufferView"].get<int>()].value("byteOffset", 0), 4 * out.size());
    return out;
  }
};

Glb Written(const std::vector<Mesh>& frames, const EncodedImage& texture = kTexture, const GlbOptions& options = {}) {
  return Glb(MakeGlb(MakeAnimatedMesh(frames, Names(frames.size())), Names(frames.size()), texture, options));
}

TEST(MakeAnimatedMesh, EveryCornerKeepsItsPositionAndTextureCoordinate) {
  const auto frames = StretchingBox(2);
  const AnimatedMesh mesh = MakeAnimatedMesh(frames, Names(2));
  EXPECT_EQ(mesh.uvs.rows(), 36);  // all corners of this layout differ
  for (int f = 0; f < frames[0].face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int split = mesh.faces(f, k);
      EXPECT_EQ(mesh.points[1].row(split), frames[1].points.row(frames[1].faces(f, k)));
      EXPECT_EQ(mesh.uvs.row(split), frames[0].uvs.row(frames[0].uv_faces(f, k)));
    }
  }
}

TEST(MakeAnimatedMesh, EqualCoordinatesInDifferentRowsAreNotSplit) {
  Mesh box = UnwrappedBox();
  box.uvs.setConstant(0.5);
  EXPECT_EQ(MakeAnimatedMesh({box}, Names(1)).uvs.rows(), box.vertex_count());
}

TEST(MakeAnimatedMesh, SeamCopiesShareOneNormal) {
  const AnimatedMesh mesh = MakeAnimatedMesh(StretchingBox(1), Names(1));
  for (std::size_t a = 0; a < mesh.source_vertex.size(); ++a) {
    EXPECT_NEAR(mesh.normals[0].row(a).norm(), 1, 1e-12);
    for (std::size_t b = 0; b < a; ++b) {
      if (mesh.source_vertex[a] != mesh.source_vertex[b]) continue;
      EXPECT_EQ(mesh.normals[0].row(a), mesh.normals[0].row(b));
    }
  }
}

TEST(MakeAnimatedMesh, MeshWithoutTextureCoordinatesKeepsItsVertices) {
  const AnimatedMesh mesh = MakeAnimatedMesh({MakeIcosphere(2)}, Names(1));
  EXPECT_EQ(mesh.points[0].rows(), MakeIcosphere(2).vertex_count());
  EXPECT_EQ(mesh.uvs.rows(), 0);
}

void ExpectInputError(const std::vector<Mesh>& frames, const std::string& part) {
  try {
    MakeAnimatedMesh(frames, Names(frames.size()));
    FAIL() << "no error; expected one that says '" << part << "'";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(part));
  }
}

TEST(MakeAnimatedMesh, NoFramesThrowInputError) { ExpectInputError({}, "no frames"); }

TEST(MakeAnimatedMesh, OtherVertexCountThrowsInputErrorThatNamesTheFrame) {
  ExpectInputError({MakeIcosphere(1), MakeIcosphere(2)}, "frame_0001 has 162 vertices");
}

TEST(MakeAnimatedMesh, OtherFacesThrowInputErrorThatNamesTheFace) {
  auto frames = StretchingBox(3);
  std::swap(frames[2].faces(7, 0), frames[2].faces(7, 1));
  ExpectInputError(frames, "face 7 of frame_0002");
}

TEST(MakeAnimatedMesh, NanVertexThrowsInputErrorThatNamesTheFrame) {
  auto frames = StretchingBox(3);
  frames[1].points(4, 1) = NAN;
  ExpectInputError(frames, "frame_0001");
}

TEST(MakeGlb, MorphTargetsMoveTheBaseToEachFrameWithYUp) {
  const auto frames = StretchingBox(4);
  const AnimatedMesh mesh = MakeAnimatedMesh(frames, Names(4));
  const Glb glb = Written(frames);
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  ASSERT_EQ(primitive["targets"].size(), 3u);
  const Eigen::MatrixXf base = glb.Read(primitive["attributes"]["POSITION"]);
  for (int i = 1; i < 4; ++i) {
    const Eigen::MatrixXf moved = base + glb.Read(primitive["targets"][i - 1]["POSITION"]);
    for (Eigen::Index v = 0; v < base.rows(); ++v) {
      const Eigen::Vector3d p = mesh.points[i].row(v);
      EXPECT_LT((moved.row(v).transpose() - Eigen::Vector3f(p.x(), p.z(), -p.y())).norm(), 1e-6) << "frame " << i << " vertex " << v;
    }
  }
  EXPECT_EQ(glb.json["meshes"][0]["extras"]["targetNames"], nlohmann::json({"frame_0001", "frame_0002", "frame_0003"}));
}

TEST(MakeGlb, NormalTargetsLeadToTheNormalsOfTheFrame) {
  const auto frames = StretchingBox(2);
  const AnimatedMesh mesh = MakeAnimatedMesh(frames, Names(2));
  GlbOptions options;
  options.z_up = false;
  const Glb glb = Written(frames, kTexture, options);
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  const Eigen::MatrixXf normals = glb.Read(primitive["attributes"]["NORMAL"]) + glb.Read(primitive["targets"][0]["NORMAL"]);
  EXPECT_LT((normals - mesh.normals[1].cast<float>()).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(MakeGlb, TurningTheAxesKeepsOutsideOutside) {
  const Glb glb = Written(StretchingBox(1));
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  const PointsX3 points = glb.Read(primitive["attributes"]["POSITION"]).cast<double>();
  const Eigen::VectorXi indices = glb.ReadIndices(primitive["indices"]);
  FacesX3 faces(indices.size() / 3, 3);
  std::copy(indices.begin(), indices.end(), faces.data());
  EXPECT_NEAR(SignedVolume(points, faces), 6, 1e-6);
}

TEST(MakeGlb, BoundsAreThoseOfTheWrittenValues) {
  const Glb glb = Written(StretchingBox(3));
  int with_bounds = 0;
  for (std::size_t a = 0; a < glb.json["accessors"].size(); ++a) {
    const auto& accessor = glb.json["accessors"][a];
    if (!accessor.contains("min")) continue;
    ++with_bounds;
    const Eigen::MatrixXf values = glb.Read(static_cast<int>(a));
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
      EXPECT_EQ(accessor["min"][c].get<float>(), values.col(c).minCoeff());
      EXPECT_EQ(accessor["max"][c].get<float>(), values.col(c).maxCoeff());
    }
  }
  EXPECT_EQ(with_bounds, 4);  // base, two targets, times
}

TEST(MakeGlb, TextureBytesAreCarriedAndVPointsDown) {
  const auto frames = StretchingBox(1);
  const AnimatedMesh mesh = MakeAnimatedMesh(frames, Names(1));
  const Glb glb = Written(frames);
  const auto& image = glb.json["images"][0];
  const auto& view = glb.json["bufferViews"][image["bufferView"].get<int>()];
  EXPECT_EQ(glb.binary.substr(view["byteOffset"], view["byteLength"]), kTexture.bytes);
  EXPECT_EQ(image["mimeType"], "image/png");
  const Eigen::MatrixXf uvs = glb.Read(glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"]);
  EXPECT_LT((uvs.col(1).array() - (1 - mesh.uvs.col(1).cast<float>().array())).abs().maxCoeff(), 1e-7);
}

TEST(MakeGlb, EachMomentShowsExactlyItsFrame) {
  GlbOptions options;
  options.playback = {10, 2, "pingpong"};
  const Glb glb = Written(StretchingBox(3), kTexture, options);
  const auto& sampler = glb.json["animations"][0]["samplers"][0];
  const Eigen::MatrixXf times = glb.Read(sampler["input"]), flat = glb.Read(sampler["output"]);
  // 0 0' 1 2 2' 1 0 with two held frames at both ends
  const std::vector<double> expected_times{0, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8};
  const std::vector<int> expected_frames{0, 0, 1, 2, 2, 1, 0};
  ASSERT_EQ(times.rows(), 7);
  ASSERT_EQ(flat.rows(), 14);
  for (int i = 0; i < 7; ++i) {
    EXPECT_NEAR(times(i, 0), expected_times[i], 1e-6);
    EXPECT_EQ(flat(2 * i, 0), expected_frames[i] == 1 ? 1 : 0);
    EXPECT_EQ(flat(2 * i + 1, 0), expected_frames[i] == 2 ? 1 : 0);
  }
}

TEST(MakeGlb, OneFrameHasNeitherTargetsNorAnimation) {
  const Glb glb = Written(StretchingBox(1));
  EXPECT_FALSE(glb.json.contains("animations"));
  EXPECT_FALSE(glb.json["meshes"][0]["primitives"][0].contains("targets"));
}

TEST(MakeGlb, TextureWithoutCoordinatesThrowsInputError) {
  const AnimatedMesh mesh = MakeAnimatedMesh({MakeIcosphere(1)}, Names(1));
  EXPECT_THROW(MakeGlb(mesh, Names(1), kTexture, {}), InputError);
  EXPECT_NO_THROW(MakeGlb(mesh, Names(1), {}, {}));
}

TEST(MakeGlb, SameBytesForAnyThreadCount) {
  SetThreadCount(1);
  const auto one = MakeGlb(MakeAnimatedMesh(StretchingBox(5), Names(5)), Names(5), kTexture, {});
  SetThreadCount(4);
  const auto four = MakeGlb(MakeAnimatedMesh(StretchingBox(5), Names(5)), Names(5), kTexture, {});
  SetThreadCount(0);
  EXPECT_EQ(one, four);
}

TEST(PlaybackMoments, LastFrameComesAtFramesMinusOneOverFps) {
  const auto moments = PlaybackMoments(25, {24, 0, "none"});
  ASSERT_EQ(moments.size(), 25u);
  EXPECT_DOUBLE_EQ(moments.back().seconds, 1.0);
}

}  // namespace
}  // namespace keypose::exporting
