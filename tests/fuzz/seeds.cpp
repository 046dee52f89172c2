// Writes one folder of small valid files per fuzz program: files from Keypose's own writers, and
// files as written by hand.
#include <zlib.h>

#include <iostream>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/color_profile.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/painted_masks.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/project/regions_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/project/shot_io.h"
#include "core/io/project/stiffness_io.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/dng.h"
#include "tests/fuzz/fuzz_folder.h"

namespace {

namespace fs = std::filesystem;
using namespace keypose;

fs::path g_root;

fs::path In(const std::string& target, const std::string& name) {
  fs::create_directories(g_root / target);
  return g_root / target / name;
}

void Meshes() {
  Mesh mesh = MakeIcosphere(0);
  mesh.colors = ColorsX3::Constant(mesh.points.rows(), 3, 77);
  mesh.normals = VertexNormals(mesh.points, mesh.faces);
  WriteMesh(In("mesh", "ico.ply"), mesh);
  mesh.uvs = (mesh.points.leftCols(2).array() * 0.5 + 0.5).matrix();
  mesh.uv_faces = mesh.faces;
  WriteMesh(In("mesh", "uv.ply"), mesh);
  WriteMesh(In("mesh", "uv.obj"), mesh);
  WriteFile(In("mesh", "quad.obj"),
            "v 0 0 0\nv 1 0 0\nv 1 1 \\\n 0\nv 0 1 0\nvt 0 0\nf -4/1 -3/1 -2/1 -1/1\n");
  WriteFile(In("mesh", "t.off"), "OFF\n# a comment\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  WriteFile(In("mesh", "c.off"),
            "STCNOFF\n3 1 0\n0 0 0 0 0 1 255 0 0 255 0 0\n1 0 0 0 0 1 0 255 0 255 1 0\n0 1 0 0 0 1 "
            "0 0 255 255 0 1\n3 0 1 2 9 9 9\n");
  WriteFile(In("mesh", "b.off"), std::string("OFF BINARY\n\0\0\0\3\0\0\0\1\0\0\0\0", 23) +
                                     std::string(36, '\0') +
                                     std::string("\0\0\0\3\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\0", 20));
  WriteFile(In("mesh", "t.stl"),
            "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
            "0\nendloop\nendfacet\nendsolid t\n");
  WriteFile(In("mesh", "b.stl"),
            std::string(80, ' ') + std::string("\1\0\0\0", 4) + std::string(50, '\0'));
  WriteFile(In("mesh", "a.ply"),
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
            "float z\nelement face 1\n"
            "property list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  PointCloud cloud;
  cloud.points = mesh.points;
  cloud.normals = mesh.normals;
  cloud.colors = mesh.colors;
  cloud.confidence = Eigen::VectorXf::Ones(cloud.points.rows());
  WritePointCloud(In("cloud", "cloud.ply"), cloud);
}

void Images() {
  Image8 image(64, 16, 3);  // a size that the library's HEIC writer can take
  for (std::size_t k = 0; k < image.data.size(); ++k)
    image.data[k] = static_cast<std::uint8_t>(7 * k);
  const ExifToWrite exif{35, 52, "Maker", "Box 1", 6};
  for (const char* name : {"a.jpg", "a.png", "a.tif", "a.heic"})
    WriteImage(In("image", name), image, 90, &exif);
  WriteImage(In("image", "grey.png"), Image8(9, 7, 1, 100));
}

void Models() {
  Scene scene;
  View view;
  view.name = "a.jpg";
  view.camera = {640, 480, 500, 501, 320, 240, 0.01, 0, 0, 0};
  scene.views = {view};
  SparsePoint point;
  point.position = {0, 0, 3};
  point.color << 1, 2, 3;
  point.views = {0};
  scene.points = {point};
  WriteColmapModel(fuzz::Folder(), scene);
  std::string whole;
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"})
    whole += (whole.empty() ? "" : "\n=====\n") + ReadFile(fuzz::Folder() / name);
  WriteFile(In("colmap", "binary"), whole);
  WriteFile(In("colmap", "text"),
            "# text\n1 OPENCV 640 480 500 501 320 240 0 0 0 0\n=====\n1 1 0 0 0 0 0 3 1 a.jpg\n1 2 "
            "-1\n=====\n1 0 0 3 9 9 9 0.5 1 0\n");
  WriteFile(
      In("poses", "transforms.json"),
      R"({"fl_x":900,"w":640,"h":480,"k1":0.01,"frames":[{"file_path":"a.jpg","transform_matrix":[[1,0,0,0],[0,0,-1,-2],[0,1,0,0],[0,0,0,1]]}]})");
  WriteFile(
      In("poses", "cameras.xml"),
      "<document version=\"2.0.0\"><chunk><sensors><sensor id=\"0\" type=\"frame\"><resolution "
      "width=\"400\" height=\"300\"/><calibration "
      "class=\"adjusted\"><f>500</f><cx>7</cx><k3>-0.01</k3>"
      "</calibration></sensor></sensors><components><component id=\"0\"><transform><scale>2</scale>"
      "</transform></component></components><cameras><camera sensor_id=\"0\" component_id=\"0\" "
      "label=\"a\"><transform>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 "
      "1</transform></camera></cameras></chunk>"
      "</document>\n");
  WriteFile(In("rig_calibration", "calibration.toml"),
            "[cam_0]\nname = \"a\"\nsize = [1000, 800]\nmatrix = [[900.0, 0.0, 510.0], [0.0, "
            "901.0, 395.0], "
            "[0.0, 0.0, 1.0]]\ndistortions = [0.01, -0.02, 0.001, 0.002, 0.0]\nrotation = [0.1, "
            "0.2, 0.3]\n"
            "translation = [1.0, 2.0, 3.0]\n");
  WriteFile(
      In("rig_calibration", "camchain.yaml"),
      "cam0: {camera_model: pinhole, intrinsics: [900, 901, 510, 395], distortion_model: radtan, "
      "distortion_coeffs: [0.01, 0, 0, 0], resolution: [1000, 800]}\n");
}

void Landmarks() {
  const Mesh mesh = MakeIcosphere(1);
  WriteLandmarks(In("landmarks", "picks.json"), mesh, {{"nose", 3, {0.2, 0.3, 0.5}}});
  WriteLandmarkPairs(In("landmarks", "pairs.json"), mesh, mesh,
                     {{"ear", {"ear", 3, {0.25, 0.25, 0.5}}, {"ear", 30, {1, 0, 0}}, true, 1, ""}});
  WriteFile(In("landmarks", "pairs.txt"), "# two\n3 5\n7 9\n");
  WriteFile(In("landmarks", "picks.pp"),
            "<!DOCTYPE PickedPoints>\n<PickedPoints>\n<point x=\"1\" y=\"0\" z=\"0\" name=\"tip\" "
            "active=\"1\"/>\n</PickedPoints>\n");
  WriteFile(In("stiffness", "bound.json"),
            BoundStiffnessText(mesh, Eigen::VectorXd::Ones(mesh.vertex_count())));
  WriteFile(In("stiffness", "numbers.txt"), "1 2 0.5 # stiff\n1e3\n");
  TimelineRegion tip, ball;
  tip.name = "tip";
  tip.vertices = {0, 1, 2};
  ball.name = "ball";
  ball.radius = 0.5;
  WriteRegions(In("regions", "same.json"), mesh, {tip, ball});
}

void Sets() {
  ImageSet set;
  set.folder = fuzz::Folder();
  set.board = BoardLayout{};
  CapturedImage image;
  image.name = "a.jpg";
  image.width = 4;
  image.height = 3;
  image.board_corners = {{4, Eigen::Vector2d(1, 2)}};
  set.images = {image};
  WriteImageSet(set);
  WriteFile(In("image_set", "capture.json"), ReadFile(fuzz::Folder() / "capture.json"));
  WriteFile(
      In("timeline", "t.json"),
      R"({"schema":2,"fps":24,"loop":true,"volume":[{"time":0.5,"ratio":0.9}],"regions":[{"name":"tip","vertices":[1,2]}],)"
      R"("pins":[{"region":"tip","from":0}],"keys":[{"pose":"a","time":0,"ease":[0,0,1,1]},{"pose":"b","time":1,"turns":{"tip":1}}]})");
}

void Projects() {
  WriteFile(In("pipeline_file", "whole.yaml"),
            "name: hero\nposes:\n  rest: photos/rest\n  bent: {photos: p, masks: m, background: "
            "b.jpg, landmarks: l.json, cameras: c, "
            "options: {dense: {levels: 4}}}\n"
            "template: rest\nfps: 24\noptions: {cleanup: {faces: 9000}}\n"
            "timeline:\n  loop: true\n  regions: [{name: tip, center: [0, 0, 1], radius: .2}]\n"
            "  keys: [{pose: rest, at: 0, ease: in-out, turns: {tip: 1}}, &k {pose: bent, at: 0.5, "
            "hold: .2}, {pose: rest, at: 2}]\n"
            "steps:\n  smooth: {stage: cleanup, for: pose, inputs: {surface: {template: a.b@all, "
            "others: [c.d]}}, options: {faces: 9}, "
            "out: {clean: \"{pose}/s.ply\"},\n"
            "    show: {\"{pose}/s.ply\": it}, cost: {fixed: 1}, enabled: false, program: ./x}\n");
  WriteFile(In("pipeline_file", "short.yaml"),
            "poses: {rest: photos/rest}\ntimeline: [rest, rest]\n");
  const std::string recipe =
      R"({"stage":"mesh","version":"1","tools":{"colmap":"3.8"},"options":{"depth":"9"},)"
      R"("inputs":[{"port":"cloud","origin":"dense/rest.cloud","sha256":"00","files":{"a":"11"}}]})";
  WriteFile(
      In("state", "manifest"),
      R"(m{"schema":2,"fingerprint":"0","recipe":)" + recipe +
          R"(,"outputs":{"text":{"file":"text","folder":true,"sha256":"0","files":{"a":"1"}}},"files":{"text/a":{"sha256":"1","stamp":[1,2,3,4]}},)"
          R"("seconds":1.5,"peak_bytes":1000})");
  WriteFile(
      In("state", "out"),
      R"(o{"a":{"step":"mesh","sha256":"00","next":"","size":1,"mtime_ns":2,"inode":3,"ctime_ns":4}})");
  WriteFile(In("state", "hashes"), R"(h{"a":[1,2,3,4,"00"]})");
  WriteFile(
      In("state", "record"),
      R"(r{"schema":1,"fingerprint":"","recipe":)" + recipe +
          R"(,"seconds":1,"peak_bytes":1,"when":1,"reasons":["new"],"found":false,"failed":false,"exit_code":0,"failed_fingerprint":"",)"
          R"("error":"","steps":[{"fingerprint":"00"}]})");
  WriteFile(
      In("state", "describe"),
      R"(d{"schema":1,"stage":"mesh","version":"1","inputs":[{"name":"cloud","kind":"file"}],)"
      R"("outputs":[{"name":"surface","kind":"file","file":"surface.ply"}],"options":[{"name":"depth","type":"int","default":9,"min":1,"max":12}],)"
      R"("tools":[{"name":"colmap","version":"3.8"}],"resources":{"cores":0,"memory_bytes":1e9}})");
}

void Armatures() {
  WriteFile(
      In("armature", "leg.txt"),
      "dunits mm\nnode {\nname rightKneeBend\n# joint name\naxis\n1 0 0\nsensor 5\nscale "
      "25\nnode { name rightCalve length 4 node { name swivel axis 0 0 1 sensor 6 scale -10 } } "
      "}\n");
  WriteFile(
      In("armature", "rig.txt"),
      "dcounts 4096 rodaxis 0 0 -1 scale_is joint_per_encoder node { name r slide 1 0 0 sensor "
      "0 scale .2 node { name b length 3 rodaxis 1 0 0 } }");
  WriteFile(In("armature", "chains.txt"),
            "canchor x physical a computer A\nanchor y physical c computer C\nchain n from x to y "
            "physical { b } computer { B } mode exact # c\n");
}

void Motions() {
  WriteFile(In("bvh", "leg.bvh"),
            "HIERARCHY\nROOT Hips\n{\n\tOFFSET 0 0 0\n"
            "\tCHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation\n"
            "\tJOINT Knee\n\t{\n\t\tOFFSET 0 -2 0\n\t\tCHANNELS 3 Zrotation Xrotation "
            "Yrotation\n\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0 -1 0\n\t\t}\n\t}\n}\n"
            "MOTION\nFrames: 2\nFrame Time: 0.04\n1 2 3 90 0 0 0 0 0\n0 0 0 0 0 0 0 90 0\n");
  WriteFile(In("bone_weights", "w.mhw"),
            R"({"weights": {"hip": [[0, 1], [1, 0.5]], "knee": [[1, 0.5], [4, 1]]}})");
  WriteFile(In("bone_weights", "w.dmat"), "2 5\n1 0.5 0 0 0\n0 0.5 1 1 1\n");
  WriteFile(In("mesh_texture", "fox.mtl"),
            "newmtl fur\nKd 1 1 1\nNs 8\nd 1\nmap_Kd -s 1 1 1 -blendu on maps\\fur.png\n");
  WriteFile(In("mesh_texture", "own.obj"), "mtllib own.mtl\nusemtl fur\nf 1 1 1\n");
  WriteFile(In("mesh_texture", "own.ply"),
            "ply\nformat ascii 1.0\ncomment TextureFile fur.png\nend_header\n");
  WriteFile(In("notes", "distortion.json"),
            FrameNotesText({{1, 1}, {1.1, 0.9}, {1, 1}}, 24, "arap"));
  WritePaintedMasks(fuzz::Folder(), {{"a.png", {"00", "11"}}});
  WriteFile(In("notes", kPaintedNotes), ReadFile(fuzz::Folder() / kPaintedNotes));
}

void RawFiles() {
  ImageF scene(32, 24, 3);
  for (std::size_t i = 0; i < scene.data.size(); ++i)
    scene.data[i] = static_cast<float>(i % 97) / 96;
  WriteDng(In("raw", "a.dng"), scene, {});
  WriteDng(In("raw", "turned.dng"), scene, {{0.6, 1, 0.8}, 6});
}

/// Two triangles with texture coordinates, colours and a picture, below two nodes.
void Glb() {
  std::string json = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"children":[1],"rotation":[0,0,0,1],"translation":[1,2,3]},{"mesh":0,"scale":[2,2,2]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":3},"indices":2,"material":0}]}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1],"baseColorTexture":{"index":0}}}],
"textures":[{"source":0}],"images":[{"bufferView":4,"mimeType":"image/png"}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
{"bufferView":1,"componentType":5121,"normalized":true,"count":4,"type":"VEC2"},
{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"},
{"bufferView":3,"componentType":5121,"normalized":true,"count":4,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":8},
{"buffer":0,"byteOffset":56,"byteLength":12},{"buffer":0,"byteOffset":68,"byteLength":12},
{"buffer":0,"byteOffset":80,"byteLength":8}],"buffers":[{"byteLength":88}]})";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const float points[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const std::uint16_t corners[6] = {0, 1, 2, 0, 2, 3};
  std::string data(reinterpret_cast<const char*>(points), sizeof points);
  data += std::string("\0\0\xff\0\xff\xff\0\xff", 8);
  data.append(reinterpret_cast<const char*>(corners), sizeof corners);
  data += std::string(12, '\x80') + "\x89PNG...";
  data.resize(88);
  const auto word = [](std::size_t n) {
    const auto value = static_cast<std::uint32_t>(n);
    return std::string(reinterpret_cast<const char*>(&value), 4);
  };
  WriteFile(In("glb", "square.glb"), "glTF" + word(2) + word(28 + json.size() + data.size()) +
                                         word(json.size()) + "JSON" + json + word(data.size()) +
                                         std::string("BIN\0", 4) + data);
}

void Films() {
  View view;
  view.name = "cam1";
  view.camera = {640, 480, 500, 501, 320, 240, 0.01, 0, 0, 0};
  WriteFile(In("rig_calibration", "rig.yaml"), OpenCvYaml({view}));
  WriteFile(
      In("rig_calibration", "qualisys.txt"),
      R"(<calibration><camera serial="7"><transform x="0" y="0" z="9" r11="1" r12="0" r13="0")"
      R"( r21="0" r22="1" r23="0" r31="0" r32="0" r33="1"/><intrinsic sensorMaxU="40000")"
      R"( sensorMaxV="30000" focalLengthU="64000" focalLengthV="64000" centerPointU="20000")"
      R"( centerPointV="15000"/></camera></calibration>)");
  WriteFile(In("rig_calibration", "matrices.txt"),
            "0\n500 0 320\n0 500 240\n0 0 1\n0.01 0\n1 0 0 0\n0 1 0 0\n0 0 1 3\n");
  FilmedShot shot;
  shot.camera = view.camera, shot.focal = "solved", shot.still = true, shot.fps = 12;
  ShotFrame frame;
  frame.picture = "0000.png", frame.pose = "rest", frame.method = "features";
  shot.frames = {frame};
  frame.frame = 4, frame.picture = "0004.png", frame.pose = "";
  shot.frames.push_back(frame);
  WriteFile(In("shot", "shot.json"), ShotText(shot));
  WriteFile(In("yaml_edit", "value"),
            "options dense levels\n4\nname: hero # it\nposes:\n  rest: photos/rest\noptions:\n"
            "  dense:\n    levels: 3  # few\n  cleanup: {faces: 9000, why: \"a:b\"}\n");
  WriteFile(In("yaml_edit", "list"),
            "timeline\n[rest, bent]\ntimeline:\n  - rest\n  # then\n  - pose: bent\n    at: 2\n"
            "  - {pose: rest, at: 3}\nposes: {}\n");
}

std::string LittleEndian(std::uint64_t number, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(number >> (8 * i) & 255);
  return text;
}

/// One file, stored. Source: PKWARE's APPNOTE 6.3.
std::string StoredZip(const std::string& name, const std::string& text) {
  const auto sum =
      ::crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(text.size()));
  const std::string about = LittleEndian(0, 2) + LittleEndian(0, 2) + LittleEndian(0, 4) +
                            LittleEndian(sum, 4) + LittleEndian(text.size(), 4) +
                            LittleEndian(text.size(), 4) + LittleEndian(name.size(), 2) +
                            LittleEndian(0, 2);
  const std::string file = "PK\3\4" + LittleEndian(10, 2) + about + name + text;
  const std::string list =
      "PK\1\2" + LittleEndian(10, 2) + LittleEndian(10, 2) + about + std::string(14, 0) + name;
  return file + list + "PK\5\6" + LittleEndian(0, 4) + LittleEndian(1, 2) + LittleEndian(1, 2) +
         LittleEndian(list.size(), 4) + LittleEndian(file.size(), 4) + LittleEndian(0, 2);
}

void ZipsAndWords() {
  WriteFile(In("zip", "scan.zip"), StoredZip("scan/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  WriteFile(In("words", "film"),
            "8x11:22/16.5mm:DICT_4X4_50:legacy:inverted\nshot_0001.v2\nshot_0003.v2\n");
  WriteFile(In("words", "day"), "11x8\nIMG_20260102_235959\nIMG_20260103_000001\n");
  Image8 mask(8, 8, 1);
  for (int i = 20; i < 44; ++i) mask.data[static_cast<std::size_t>(i)] = 1;
  WriteImage(In("mask", "label.png"), mask);
  WriteFile(In("mask", "p3.icc"), DisplayP3Profile());
}

std::string BigEndian(std::uint64_t number, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(number >> (8 * i) & 255);
  return text;
}

std::string Box(const std::string& kind, const std::string& content) {
  return BigEndian(content.size() + 8, 4) + kind + content;
}

/// The index of a film of 48 pictures, 640 x 360, 24 a second, and a track of sound before it.
void Movies() {
  const std::string kinds = BigEndian(1, 8) + BigEndian(86, 4) + "avc1" + std::string(24, 0) +
                            BigEndian(640, 2) + BigEndian(360, 2) + std::string(50, 0);
  const std::string times = BigEndian(1, 8) + BigEndian(48, 4) + BigEndian(1000, 4);
  const auto track = [&](const std::string& handler) {
    return Box("trak",
               Box("mdia", Box("mdhd", std::string(12, 0) + BigEndian(24000, 4) +
                                           BigEndian(48000, 4) + std::string(4, 0)) +
                               Box("hdlr", std::string(8, 0) + handler) +
                               Box("minf", Box("stbl", Box("stsd", kinds) + Box("stts", times)))));
  };
  const std::string index = Box("moov", track("soun") + track("vide"));
  WriteFile(In("movie", "film.mp4"),
            Box("ftyp", "isom" + BigEndian(0, 4)) + Box("mdat", "pictures") + index);
  WriteFile(In("movie", "wide.mov"),
            BigEndian(1, 4) + "mdat" + BigEndian(24, 8) + "pictures" + index);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "fuzz_seeds FOLDER: writes a folder of seeds for each fuzz program\n";
    return 2;
  }
  g_root = argv[1];
  Meshes();
  Images();
  Models();
  Landmarks();
  Sets();
  Projects();
  Armatures();
  Movies();
  ZipsAndWords();
  Motions();
  RawFiles();
  Glb();
  Films();
}
