#include "export/fbx/fbx_mesh.h"

#include <algorithm>
#include <string>

#include "core/numbers/parallel.h"
#include "core/values/progress.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

constexpr const char* kUvName = "UVMap";
constexpr int kShapesPerRound = 16;

template <class Rows>
std::vector<double> Numbers(const Rows& rows) {
  return {rows.data(), rows.data() + rows.size()};
}

/// The normals of a frame's vertices, with y up; up for a vertex without a face.
PointsX3 NormalsOf(const Scene& scene, int frame) {
  PointsX3 normals(scene.frames[frame].vertex_count(), 3);
  normals.rowwise() = scene.z_up ? Eigen::RowVector3d::UnitZ() : Eigen::RowVector3d::UnitY();
  const std::vector<int>& source = scene.split.source_vertex;
  for (int v = 0; v < SizeOf(source); ++v)
    normals.row(source[v]) = scene.split.normals[frame].row(v);
  return WithYUp(normals, scene.z_up);
}

/// Corners, each face's last as its complement, which marks the end.
std::vector<std::int32_t> Corners(const FaceNet& net) {
  std::vector<std::int32_t> corners(net.vertices.begin(), net.vertices.end());
  int end = 0;
  for (const int size : net.sizes) {
    end += size;
    corners[end - 1] = ~corners[end - 1];
  }
  return corners;
}

FbxRecord Layer(const std::string& type, const std::string& name, const std::string& mapping,
                const std::string& reference, std::vector<FbxRecord> data) {
  FbxRecord layer{type,
                  {0},
                  {{"Version", {101}},
                   {"Name", {name}},
                   {"MappingInformationType", {mapping}},
                   {"ReferenceInformationType", {reference}}}};
  for (FbxRecord& one : data) layer.records.push_back(std::move(one));
  return layer;
}

// One normal per corner is what all readers know.
FbxRecord NormalLayer(const Scene& scene) {
  const PointsX3 normals = NormalsOf(scene, 0);
  std::vector<double> of_corners;
  of_corners.reserve(3 * scene.net.vertices.size());
  for (const int vertex : scene.net.vertices) {
    of_corners.insert(of_corners.end(), normals.row(vertex).begin(), normals.row(vertex).end());
  }
  return Layer("LayerElementNormal", "", "ByPolygonVertex", "Direct", {{"Normals", {of_corners}}});
}

FbxRecord UvLayer(const Mesh& mesh, const FaceNet& net) {
  const std::vector<std::int32_t> corners(net.uvs.begin(), net.uvs.end());
  return Layer("LayerElementUV", kUvName, "ByPolygonVertex", "IndexToDirect",
               {{"UV", {Numbers(mesh.uvs)}}, {"UVIndex", {corners}}});
}

FbxRecord Geometry(const Scene& scene) {
  const Mesh& mesh = scene.frames[0];
  std::vector<FbxRecord> layers{NormalLayer(scene)};
  if (mesh.has_uvs()) layers.push_back(UvLayer(mesh, scene.net));
  const std::vector<std::int32_t> one_group(scene.net.face_count(), 1), one_material{0};
  layers.push_back(
      Layer("LayerElementSmoothing", "", "ByPolygon", "Direct", {{"Smoothing", {one_group}}}));
  layers.push_back(Layer("LayerElementMaterial", "", "AllSame", "IndexToDirect",
                         {{"Materials", {one_material}}}));

  FbxRecord out{"Geometry", {kFbxGeometryId, FbxName(scene.name, "Geometry"), "Mesh"}, {}};
  out.records = {FbxProperties({}),
                 {"GeometryVersion", {124}},
                 {"Vertices", {Numbers(WithYUp(mesh.points, scene.z_up))}},
                 {"PolygonVertexIndex", {Corners(scene.net)}}};
  FbxRecord list{"Layer", {0}, {{"Version", {100}}}};
  for (FbxRecord& layer : layers) {
    list.records.push_back({"LayerElement", {}, {{"Type", {layer.name}}, {"TypedIndex", {0}}}});
    out.records.push_back(std::move(layer));
  }
  out.records.push_back(std::move(list));
  return out;
}

FbxRecord Model(const std::string& name) {
  return {"Model",
          {kFbxModelId, FbxName(name, "Model"), "Mesh"},
          {{"Version", {232}},
           FbxProperties({{"InheritType", "enum", "", "", 1},
                          {"DefaultAttributeIndex", "int", "Integer", "", 0},
                          {"Lcl Translation", "Lcl Translation", "", "A", 0.0, 0.0, 0.0},
                          {"Lcl Rotation", "Lcl Rotation", "", "A", 0.0, 0.0, 0.0},
                          {"Lcl Scaling", "Lcl Scaling", "", "A", 1.0, 1.0, 1.0}}),
           {"Shading", {true}},
           {"Culling", {"CullingOff"}}}};
}

// Matt, as clay is: a shininess of 1 becomes a roughness of 0.9 in Blender, as in the GLB.
FbxRecord Material(bool textured) {
  const double diffuse = textured ? 1 : 0.8;
  return {"Material",
          {kFbxMaterialId, FbxName("clay", "Material"), ""},
          {{"Version", {102}},
           {"ShadingModel", {"phong"}},
           {"MultiLayer", {0}},
           FbxProperties({{"EmissiveColor", "Color", "", "A", 0.0, 0.0, 0.0},
                          {"EmissiveFactor", "Number", "", "A", 0.0},
                          {"AmbientColor", "Color", "", "A", 0.0, 0.0, 0.0},
                          {"DiffuseColor", "Color", "", "A", diffuse, diffuse, diffuse},
                          {"DiffuseFactor", "Number", "", "A", 1.0},
                          {"TransparentColor", "Color", "", "A", 0.0, 0.0, 0.0},
                          {"TransparencyFactor", "Number", "", "A", 0.0},
                          {"Opacity", "Number", "", "A", 1.0},
                          {"SpecularColor", "Color", "", "A", 0.2, 0.2, 0.2},
                          {"SpecularFactor", "Number", "", "A", 0.25},
                          {"Shininess", "Number", "", "A", 1.0},
                          {"ShininessExponent", "Number", "", "A", 1.0},
                          {"ReflectionFactor", "Number", "", "A", 0.0}})}};
}

/// The image itself, and the texture that shows it. The name of the file is where programs find it
/// that do not read embedded images, and what the others call it.
void AddTexture(const Scene& scene, FbxObjects& out) {
  const EncodedImage& image = scene.textures[0];
  const std::string file = "textures/" + FirstTextureFile(scene);
  const std::string name = image.name.empty() ? "texture" : image.name;
  out.objects.push_back({"Video",
                         {kFbxVideoId, FbxName(name, "Video"), "Clip"},
                         {{"Type", {"Clip"}},
                          FbxProperties({{"Path", "KString", "XRefUrl", "", file}}),
                          {"UseMipMap", {0}},
                          {"Filename", {file}},
                          {"RelativeFilename", {file}},
                          {"Content", {FbxValue::Binary(image.bytes)}}}});
  out.objects.push_back({"Texture",
                         {kFbxTextureId, FbxName(name, "Texture"), ""},
                         {{"Type", {"TextureVideoClip"}},
                          {"Version", {202}},
                          {"TextureName", {FbxName(name, "Texture")}},
                          FbxProperties({{"CurrentTextureBlendMode", "enum", "", "", 0},
                                         {"UVSet", "KString", "", "", kUvName},
                                         {"UseMaterial", "bool", "", "", 1}}),
                          {"Media", {FbxName(name, "Video")}},
                          {"FileName", {file}},
                          {"RelativeFilename", {file}},
                          {"ModelUVTranslation", {0.0, 0.0}},
                          {"ModelUVScaling", {1.0, 1.0}},
                          {"Texture_Alpha_Source", {"None"}},
                          {"Cropping", {0, 0, 0, 0}}}});
  out.Connect(kFbxTextureId, kFbxMaterialId, "DiffuseColor");
  out.Connect(kFbxVideoId, kFbxTextureId);
}

/// The difference as readers keep it. Single precision is finer than any scan, and halves the file.
PointsX3 Difference(const PointsX3& to, const PointsX3& from) {
  return (to - from).cast<float>().cast<double>();
}

/// What all shapes are relative to.
struct Base {
  PointsX3 points, normals;
};

FbxRecord Shape(const Scene& scene, const Base& base, int frame, std::int64_t id) {
  const PointsX3 moves = Difference(WithYUp(scene.frames[frame].points, scene.z_up), base.points);
  const PointsX3 turns = Difference(NormalsOf(scene, frame), base.normals);
  std::vector<std::int32_t> changed;
  for (int v = 0; v < moves.rows(); ++v)
    if (!moves.row(v).isZero(0) || !turns.row(v).isZero(0)) changed.push_back(v);
  if (changed.empty()) changed.push_back(0);  // Blender takes no shape without vertices
  return {"Geometry",
          {id, FbxName(scene.frame_names[frame], "Geometry"), "Shape"},
          {FbxProperties({}),
           {"Version", {100}},
           {"Indexes", {changed}},
           {"Vertices", {Numbers(PointsX3(moves(changed, Eigen::all)))}},
           {"Normals", {Numbers(PointsX3(turns(changed, Eigen::all)))}}}};
}

FbxRecord Channel(const std::string& name, std::int64_t id) {
  return {"Deformer",
          {id, FbxName(name, "SubDeformer"), "BlendShapeChannel"},
          {{"Version", {100}},
           FbxProperties({{"DeformPercent", "Number", "", "A", 0.0}}),
           {"DeformPercent", {0.0}},
           {"FullWeights", {std::vector<double>{100}}}}};
}

}  // namespace

FbxShapeIds::FbxShapeIds(int shape_number)
    : shape(10000 + 4 * static_cast<std::int64_t>(shape_number)),
      channel(shape + 1),
      curve_node(shape + 2),
      curve(shape + 3) {}

std::vector<int> FbxShapeFrames(const Clip& clip) {
  std::vector<int> frames;
  for (int i = 1; i < clip.frame_count(); ++i)
    if (clip.picture[i] == i) frames.push_back(i);
  return frames;
}

void AddFbxMesh(const Scene& scene, FbxObjects& out) {
  out.objects.push_back(Geometry(scene));
  out.objects.push_back(Model(scene.name));
  out.objects.push_back(Material(!scene.textures.empty()));
  out.Connect(kFbxModelId, 0);
  out.Connect(kFbxGeometryId, kFbxModelId);
  out.Connect(kFbxMaterialId, kFbxModelId);
  if (!scene.textures.empty()) AddTexture(scene, out);
}

void AddFbxShapes(const Scene& scene, const std::vector<int>& frames, FbxObjects& out,
                  Progress* progress) {
  if (frames.empty()) return;
  const Base base{WithYUp(scene.frames[0].points, scene.z_up), NormalsOf(scene, 0)};
  out.objects.push_back({"Deformer",
                         {kFbxBlendShapeId, FbxName(scene.name, "Deformer"), "BlendShape"},
                         {{"Version", {100}}, FbxProperties({})}});
  out.Connect(kFbxBlendShapeId, kFbxGeometryId);
  const int count = SizeOf(frames);
  std::vector<FbxRecord> shapes(count);
  for (int begin = 0; begin < count; begin += kShapesPerRound) {
    ReportProgress(progress, static_cast<double>(begin) / count, "FBX: shapes");
    ParallelFor(std::min(kShapesPerRound, count - begin), [&](std::int64_t i) {
      const int k = begin + static_cast<int>(i);
      shapes[k] = Shape(scene, base, frames[k], FbxShapeIds(k).shape);
    });
  }
  for (int k = 0; k < count; ++k) {
    const FbxShapeIds ids(k);
    out.objects.push_back(std::move(shapes[k]));
    out.objects.push_back(Channel(scene.frame_names[frames[k]], ids.channel));
    out.Connect(ids.channel, kFbxBlendShapeId);
    out.Connect(ids.shape, ids.channel);
  }
}

}  // namespace keypose::exporting
