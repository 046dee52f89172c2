// The program `keypose cameras`. Its own, since it reads cameras, and loading what that needs would
// slow down all other commands.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "pipeline/commands/camera_folder.h"
#include "pipeline/commands/cameras_command.h"

namespace keypose::pipeline {
namespace {

constexpr const char* kExamples =
    "\nThe folder has the photographs, their masks, and:\n"
    "  colmap      sparse/0, for COLMAP, 3DGS, gsplat\n"
    "  transforms  transforms.json, for nerfstudio, instant-ngp\n"
    "  metashape   cameras.xml\n\n"
    "  keypose cameras puppet --to colmap\n"
    "  keypose cameras puppet --to transforms --pose wave --output ~/splats/wave\n";

volatile std::sig_atomic_t signalled = 0;
void OnSignal(int) { signalled = 1; }

class UntilSignal final : public Progress {
 public:
  void Update(double, std::string_view) override {}
  bool cancelled() const override { return signalled != 0; }
};

void AddFlags(CLI::App& app, CamerasOptions& options) {
  const char* const kProject =
      "the project's folder; default: the current folder or the nearest parent with a "
      "pipeline.yaml";
  CLI::Option* project = app.add_option("PROJECT", options.folder, kProject);
  app.add_option("-C,--folder", options.folder, kProject)->excludes(project);
  app.add_option("--to", options.format, "the program's format")
      ->required()
      ->check(CLI::IsMember(CameraFormatNames()));
  app.add_option("--pose", options.pose, "the pose; default: the template");
  app.add_option(
      "-o,--output", options.output,
      "a folder that is new or empty; default: PROJECT_POSE_FORMAT in the current folder");
  app.add_flag("--overwrite,--force", options.overwrite,
               "replace the output and all that is in it");
  app.footer(kExamples);
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Writes a pose's cameras, photographs and masks for other programs, such as trainers of "
      "splats and NeRFs.",
      "keypose cameras");
  CamerasOptions options;
  AddFlags(app, options);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, OnSignal);
  UntilSignal progress;
  try {
    app.parse(argc, argv);
    return static_cast<int>(CamerasCommand(options, &progress));
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return 0;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "keypose: error: {}; see `keypose cameras --help`\n", error.what());
    return static_cast<int>(ExitCode::kUsage);
  } catch (const Error& error) {
    std::fflush(stdout);
    fmt::print(stderr, "keypose: {}{}\n",
               error.code() == ExitCode::kInterrupted ? "" : "error: ", error.what());
    return static_cast<int>(error.code());
  } catch (const std::filesystem::filesystem_error& error) {
    fmt::print(stderr, "keypose: error: {}\n", error.what());
    return static_cast<int>(ExitCode::kDisk);
  } catch (const std::exception& error) {
    fmt::print(stderr, "keypose: a bug: {}\nplease report it, with your command\n", error.what());
    return static_cast<int>(ExitCode::kBug);
  }
}

}  // namespace
}  // namespace keypose::pipeline

int main(int argc, char** argv) { return keypose::pipeline::Main(argc, argv); }
