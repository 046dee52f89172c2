#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "report/testing/minimal_report.h"

namespace keypose::report::report_stage_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
constexpr int kViews = 9, kStray = 4, kWidth = 200, kHeight = 180;

Mesh Ellipsoid() {
  Mesh mesh = MakeIcosphere(4);
  mesh.uv_faces = mesh.faces;
  mesh.uvs.resize(mesh.points.rows(), 2);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d p = mesh.points.row(v);
    mesh.uvs.row(v) << std::atan2(p.y(), p.x()) / (2 * M_PI) + 0.5, 0.5 + 0.5 * p.z();
  }
  mesh.points.col(0) *= 0.6;
  return mesh;
}

Image8 Stripes() {
  Image8 texture(256, 128, 3);
  for (int y = 0; y < texture.height; ++y)
    for (int x = 0; x < texture.width; ++x)
      for (int c = 0; c < 3; ++c)
        texture.at(x, y)[c] =
            static_cast<std::uint8_t>(140 + 80 * std::sin(0.3 * y + 0.0015 * x * x + c));
  return texture;
}

class Project : public TestingFolder {
 public:
  explicit Project(bool with_stray) {
    fs::create_directories(folder_ / "images/masks");
    const Mesh mesh = Ellipsoid();
    const Image8 texture = Stripes();
    WriteMesh(folder_ / "mesh.obj", mesh);
    WriteImage(folder_ / "texture.png", texture);
    Photograph(mesh, texture, with_stray);
    Write("bake.json",
          {{"schema", 1}, {"stage", "bake"}, {"version", "1"}, {"measurements", json::object()}});
    const auto step = [](const char* stage, const json& outputs, const json& inputs) {
      return json{{"id", std::string(stage) + "/rest"},
                  {"step", stage},
                  {"stage", stage},
                  {"pose", "rest"},
                  {"status", "done"},
                  {"report", "bake.json"},
                  {"outputs", outputs},
                  {"inputs", inputs}};
    };
    Write("run.json", {{"schema", 1},
                       {"project", {{"name", "egg"}, {"template", "rest"}, {"poses", {"rest"}}}},
                       {"timeline", nullptr},
                       {"steps",
                        {step("capture", {{"images", "images"}}, json::object()),
                         step("bake", {{"texture", "texture.png"}},
                              {{"mesh", {"mesh.obj"}}, {"model", {"model"}}})}}});
  }

  /// First masks hold all of each photograph; the masks step told what the figure is.
  void TakeToRoom(const std::string& told_by) const {
    fs::copy(folder_ / "images", folder_ / "masked", fs::copy_options::recursive);
    for (const auto& mask : fs::directory_iterator(folder_ / "images/masks"))
      WriteImage(mask.path(), Image8(kWidth, kHeight, 1, 255));
    Write("masks.json", {{"schema", 1},
                         {"stage", "masks"},
                         {"version", "1"},
                         {"measurements", {{"figure_by", told_by}}}});
    json run = json::parse(Text("run.json"));
    json step = run["steps"][0];
    step["id"] = "masks/rest";
    step["step"] = step["stage"] = "masks";
    step["report"] = "masks.json";
    step["outputs"] = {{"masked", "masked"}};
    run["steps"].insert(run["steps"].begin() + 1, step);
    Write("run.json", run);
  }

  int Report() const {
    const std::string f = folder_.string();
    return std::system((BinFolder() + "/keypose-report --run " + f + " --report " + f +
                        "/report --report " + f + "/stage.json --compared_px " +
                        std::to_string(kWidth) + " > " + f + "/log 2>&1")
                           .c_str()) >>
           8;
  }
  std::string Text(const char* file) const {
    std::ostringstream text;
    text << std::ifstream(folder_ / file).rdbuf();
    return text.str();
  }

 private:
  void Write(const char* file, const json& content) const {
    std::ofstream(folder_ / file) << content;
  }

  void Photograph(const Mesh& mesh, const Image8& texture, bool with_stray) const {
    const RayScene scene(mesh.points, mesh.faces);
    Scene cameras;
    ImageSet set;
    set.folder = folder_ / "images";
    for (int i = 0; i < kViews; ++i) {
      View view = FitView(mesh.points, i * 360.0 / kViews, 12, kWidth, kHeight);
      view.name = "IMG_" + std::to_string(i) + ".png";
      RenderOptions look;
      look.texture = &texture;
      look.shading = 0;
      look.background = {20, 40, 60};
      Image8 photograph = Render(mesh, scene, view, look), mask(kWidth, kHeight, 1);
      const Raster raster = Rasterize(mesh, scene, view);
      for (std::size_t k = 0; k < mask.data.size(); ++k)
        mask.data[k] = raster.face.data[k] >= 0 ? 255 : 0;
      if (with_stray && i == kStray) {  // something else: a box to the left
        for (int y = 0; y < kHeight; ++y)
          for (int x = 0; x < kWidth; ++x) {
            const bool box = x > 20 && x < 90 && y > 60 && y < 160;
            *mask.at(x, y) = box ? 255 : 0;
            std::fill_n(photograph.at(x, y), 3,
                        static_cast<std::uint8_t>(box ? 90 + (x * 7 + y * 13) % 50 : 20));
          }
      }
      CapturedImage entry;
      entry.name = view.name;
      entry.width = kWidth, entry.height = kHeight;
      entry.mask = "masks/" + view.name + ".png";
      WriteImage(set.folder / entry.name, photograph);
      WriteImage(set.folder / entry.mask, mask);
      set.images.push_back(entry);
      cameras.views.push_back(view);
    }
    WriteImageSet(set);
    fs::create_directories(folder_ / "model");
    WriteColmapModel(folder_ / "model", cameras);
  }
};

TEST(ReportStage, FindsTheStrayPhotographAndShowsItFirst) {
  const Project project(true);
  ASSERT_EQ(project.Report(), 0) << project.Text("log");
  const json said = json::parse(project.Text("stage.json"));
  ASSERT_EQ(said["verdicts"].size(), 1u);
  EXPECT_EQ(said["verdicts"][0]["about"], "rest");
  EXPECT_EQ(said["verdicts"][0]["grade"], "look");
  EXPECT_THAT(said["verdicts"][0]["why"].get<std::string>(), HasSubstr("IMG_4.png"));
  const std::string page = project.Text("report/index.html");
  const std::size_t pairs = page.find("Photograph and render from the same camera");
  ASSERT_NE(pairs, std::string::npos);
  const std::size_t caption = page.find("<figcaption>IMG_", pairs);
  EXPECT_EQ(page.compare(caption, 21, "<figcaption>IMG_4.png"), 0);
}

TEST(ReportStage, AnIdealRunIsGoodAndItsPageIsOneSmallFileWithAPlayer) {
  const Project project(false);
  ASSERT_EQ(project.Report(), 0) << project.Text("log");
  EXPECT_EQ(json::parse(project.Text("stage.json"))["verdicts"][0]["grade"], "good");
  const json report = json::parse(project.Text("report/report.json"));
  EXPECT_EQ(report["verdicts"][0]["grade"], "good");
  const json& evidence = report["evidence"]["rest"];
  EXPECT_EQ(evidence["views"].size(), static_cast<std::size_t>(kViews));
  EXPECT_LT(evidence["outline_off"].get<double>(),
            1e-4);  // the masks are the mesh's own; the OBJ keeps 17 digits
  EXPECT_GT(evidence["structure"].get<double>(), 0.9);
  const std::string page = project.Text("report/index.html");
  EXPECT_LT(page.size(), 8'000'000u);
  EXPECT_THAT(page, HasSubstr("id=player-data"));
}

TEST(ReportStage, InARoomMasksThatReplacedTheFirstOnesAreCompared) {
  const Project project(false);
  project.TakeToRoom("depths");
  ASSERT_EQ(project.Report(), 0) << project.Text("log");
  EXPECT_EQ(json::parse(project.Text("stage.json"))["verdicts"][0]["grade"], "good");
  EXPECT_LT(json::parse(project.Text("report/report.json"))["evidence"]["rest"]["outline_off"]
                .get<double>(),
            1e-4);
}

TEST(ReportStage, ElseTheFirstMasksAre) {
  const Project project(false);
  project.TakeToRoom("colours and views");
  ASSERT_EQ(project.Report(), 0) << project.Text("log");
  EXPECT_EQ(json::parse(project.Text("stage.json"))["verdicts"][0]["grade"], "wrong");
}

TEST(ReportStage, WritesAPageForARunWhoseArtifactsAreGone) {
  const TestingFolder own;
  const std::filesystem::path folder = own.path();
  std::filesystem::create_directories(folder / "run");
  std::ofstream(folder / "run/run.json") << kRun;
  const std::string f = folder.string();
  const std::string command = BinFolder() + "/keypose-report --run " + f + "/run --report " + f +
                              "/report --report " + f + "/stage.json > " + f + "/log 2>&1";
  std::ostringstream log;
  const int code = std::system(command.c_str()) >> 8;
  log << std::ifstream(folder / "log").rdbuf();
  ASSERT_EQ(code, 0) << log.str();
  std::ostringstream page;
  page << std::ifstream(folder / "report/index.html").rdbuf();
  EXPECT_THAT(page.str(), HasSubstr("no longer there"));
  EXPECT_TRUE(std::filesystem::exists(folder / "report/report.json"));
  const nlohmann::json said = nlohmann::json::parse(std::ifstream(folder / "stage.json"));
  ASSERT_EQ(said["verdicts"].size(), 2u);
  EXPECT_EQ(said["verdicts"][1]["about"], "up");
  EXPECT_EQ(said["verdicts"][1]["grade"], "wrong");
  EXPECT_THAT(std::string(said["verdicts"][1]["why"]), HasSubstr("keypose log cleanup/up"));
}

}  // namespace keypose::report::report_stage_test
