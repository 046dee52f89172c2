// Damaged files (../shared/data/mutants), through the programs that read them: each program ends
// with a documented exit code, in bounded time and memory; if it fails, the message names the file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "tests/run_program.h"

namespace keypose::tests::mutants_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kSeconds = 60;
// limit of address space [kB]; the libraries alone map a fifth of it
constexpr const char* kKilobytes = "4000000";

fs::path Data() { return DataFolder() / "mutants"; }

class Mutants : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!fs::is_directory(Data())) return;
    world_ = std::make_unique<TestingFolder>();
    const RunResult made =
        RunProgram({"keypose-synth", "photos", "--output", world_->path(), "--poses", "rest",
                    "--views", "10", "--width", "320", "--height", "240", "--spacing", "0.004"},
                   world_->path());
    ASSERT_EQ(made.exit_code, 0) << made.output;
    const RunResult captured = RunProgram({"keypose-capture", "--photos", Photos(), "--masks",
                                           Truth() / "masks", "--images", Images()},
                                          world_->path());
    ASSERT_EQ(captured.exit_code, 0) << captured.output;
    Mesh sphere = MakeIcosphere(3);
    WriteMesh(Good(), sphere);
    sphere.uvs = (sphere.points.leftCols(2).array() * 0.5 + 0.5).matrix();
    sphere.uv_faces = sphere.faces;
    WriteMesh(Unwrapped(), sphere);
  }
  static void TearDownTestSuite() { world_.reset(); }

  static fs::path Photos() { return world_->path() / "photos" / "rest"; }
  static fs::path Truth() { return world_->path() / "truth" / "rest"; }
  static fs::path Images() { return world_->path() / "images"; }
  static fs::path Unwrapped() { return world_->path() / "unwrapped.obj"; }
  static fs::path Good() { return world_->path() / "good.ply"; }

  void SetUp() override {
    if (!fs::is_directory(Data()))
      GTEST_SKIP() << "no files at " << Data()
                   << ": set KEYPOSE_DATA to the folder that holds mutants/";
  }

  std::vector<fs::path> FilesThatBegin(const std::string& prefix) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(Data()))
      if (entry.path().filename().string().starts_with(prefix)) files.push_back(entry.path());
    EXPECT_FALSE(files.empty()) << "no " << prefix << "* in " << Data();
    return files;
  }

  /// What a command line begins with. A sanitizer reserves terabytes of addresses, so that a
  /// program under it gets no limit.
  static std::vector<std::string> WithLimitedMemory() {
#if defined(KEYPOSE_SANITIZED)
    return {};
#else
    return {"/bin/bash", "-c", std::string("ulimit -v ") + kKilobytes + "; exec \"$@\"", "bash"};
#endif
  }

  /// @param name  name of the file that a message must contain
  void Expect(const std::vector<std::string>& arguments, const std::string& name,
              const std::set<int>& codes) {
    std::vector<std::string> command = WithLimitedMemory();
    command.push_back(BinFolder() + "/" + arguments[0]);
    command.insert(command.end(), arguments.begin() + 1, arguments.end());
    const RunResult result = RunProgram(command, folder_.path(), {}, kSeconds);
    EXPECT_TRUE(codes.count(result.exit_code))
        << arguments[0] << " on " << name << " ended with " << result.exit_code << "\n"
        << result.output;
    EXPECT_THAT(result.output, Not(HasSubstr("this is a bug")));
    if (result.exit_code == 0) return;
    EXPECT_THAT(result.output, HasSubstr(name));
  }

  /// A copy of the true cameras with one file replaced.
  fs::path ModelWith(const fs::path& mutant, const std::string& as) {
    const fs::path model = folder_.path() / mutant.stem();
    fs::create_directories(model);
    for (const auto& entry : fs::directory_iterator(Truth() / "cameras"))
      if (as.ends_with(".bin")) fs::copy(entry.path(), model / entry.path().filename());
    fs::copy_file(mutant, model / as, fs::copy_options::overwrite_existing);
    return model;
  }

  TestingFolder folder_;
  static std::unique_ptr<TestingFolder> world_;
};
std::unique_ptr<TestingFolder> Mutants::world_;

const std::set<int> kRefused{3}, kAnyDocumented{0, 3, 6};

TEST_F(Mutants, MeshesThroughCleanup) {
  for (const char* prefix : {"off_binary", "sanitizer_mesh"})
    for (const fs::path& file : FilesThatBegin(prefix))
      Expect({"keypose-cleanup", "--surface", file, "--clean", "clean.ply"}, file.filename(),
             kRefused);
  for (const char* prefix : {"ply_binary", "geo_cleanup", "nc.obj", "poly300.obj"})
    for (const fs::path& file : FilesThatBegin(prefix))
      Expect({"keypose-cleanup", "--surface", file, "--clean", "clean.ply"}, file.filename(),
             kAnyDocumented);
}

TEST_F(Mutants, MeshesThroughRegisterOnBothSides) {
  for (const fs::path& file : FilesThatBegin("geo_register")) {
    Expect({"keypose-register", "--source", file, "--target", Good(), "--registered", "out.ply"},
           "", kAnyDocumented);
    Expect({"keypose-register", "--source", Good(), "--target", file, "--registered", "out.ply"},
           "", kAnyDocumented);
  }
}

TEST_F(Mutants, PicksThroughRegister) {
  for (const char* prefix : {"foo.pp", "lm_pp", "sanitizer_landmarks"})
    for (const fs::path& file : FilesThatBegin(prefix))
      Expect({"keypose-register", "--source", Good(), "--target", Good(), "--landmarks", file,
              "--landmarks", file, "--registered", "out.ply"},
             file.filename(), kRefused);
}

TEST_F(Mutants, CamerasThroughBakeAndSfm) {
  for (const char* as : {"cameras.bin", "images.bin"})
    for (const fs::path& file : FilesThatBegin(std::string("colmap_bin_") + as)) {
      const fs::path model = ModelWith(file, as);
      Expect({"keypose-bake", "--mesh", Unwrapped(), "--images", Images(), "--model", model,
              "--texture", "texture.png"},
             as, kRefused);
      Expect({"keypose-sfm", "--images", Images(), "--poses", model, "--model", "model"}, as,
             kRefused);
    }
}

TEST_F(Mutants, TextureUnderAPhotographsNameThroughCapture) {
  for (const fs::path& file : FilesThatBegin("vol")) {
    fs::copy(Photos(), folder_.path() / "photos");
    fs::copy_file(file, folder_.path() / "photos" / "IMG_0003.jpg",
                  fs::copy_options::overwrite_existing);
    Expect({"keypose-capture", "--photos", "photos", "--images", "images"}, "IMG_0003.jpg",
           kRefused);
  }
}

}  // namespace keypose::tests::mutants_test
