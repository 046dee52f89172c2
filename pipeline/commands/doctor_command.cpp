// `keypose doctor` and `keypose --version`: the programs and libraries of this machine and build.
#include <CGAL/version.h>
#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdio>
#include <opencv2/core/version.hpp>
#include <sstream>

#include "pipeline/commands/keypose_commands.h"
#include "pipeline/run/opened_project.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

std::string FirstLine(const std::string& text) {
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.find_first_not_of(" \t\r-") != std::string::npos) return line;
  }
  return "";
}

std::string ColmapText(ProcessRunner& processes) {
  const auto path = processes.FindTool("colmap");
  if (!path) return "missing (Debian: apt-get install colmap)";
  const auto answer = processes.Ask({{path->string(), "help"}}).front();
  if (answer.exit_code != 0)
    return fmt::format("{} does not run (exit code {})", path->string(), answer.exit_code);
  return FirstLine(answer.output);
}

/// The BLAS library that the stages load, found by the same rules as their loader.
std::string BlasText() {
  void* library = dlopen("libopenblas.so.0", RTLD_NOW | RTLD_LOCAL);
  if (!library) return "OpenBLAS is missing (Debian: apt-get install libopenblas0-pthread)";
  using ConfigFunction = char* (*)();
  const auto config = reinterpret_cast<ConfigFunction>(dlsym(library, "openblas_get_config"));
  std::string text = config ? config() : "OpenBLAS";
  if (void* blas = dlopen("libblas.so.3", RTLD_NOW | RTLD_LOCAL)) {
    Dl_info info{};
    void* symbol = dlsym(blas, "dgemm_");
    if (symbol && dladdr(symbol, &info) && info.dli_fname)
      text += fmt::format("; the system's BLAS is {}", fs::canonical(info.dli_fname).string());
  }
  return text;
}

/// The camera library that `keypose shoot` loads.
std::string CameraLibraryText() {
  void* library = dlopen("libgphoto2.so.6", RTLD_NOW | RTLD_LOCAL);
  if (!library)
    return "libgphoto2 is missing, `keypose shoot` cannot start (Debian: apt-get install "
           "libgphoto2-6)";
  using VersionFunction = const char** (*)(int);
  const auto version = reinterpret_cast<VersionFunction>(dlsym(library, "gp_library_version"));
  const char** const lines = version ? version(0) : nullptr;
  return std::string("libgphoto2 ") + (lines && lines[0] ? lines[0] : "");
}

std::string CpuText() {
  __builtin_cpu_init();
  std::vector<std::string> features;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("sse4.2")) features.push_back("sse4.2");
  if (__builtin_cpu_supports("avx")) features.push_back("avx");
  if (__builtin_cpu_supports("avx2")) features.push_back("avx2");
  if (__builtin_cpu_supports("fma")) features.push_back("fma");
  if (__builtin_cpu_supports("avx512f")) features.push_back("avx512f");
#endif
  return fmt::format("{}", fmt::join(features, " "));
}

/// One step of each stage that a default pipeline has.
std::vector<StepRule> StepsOfAllKinds() {
  std::vector<StepRule> steps;
  for (const ProjectKind kind : {ProjectKind::kPoses, ProjectKind::kPerformance}) {
    const std::string text = RealDisk().Read(DefaultPipelineFile(kind));
    for (const StepRule& rule : ParsePipelineFile(text, "the default pipeline").steps) {
      const auto same = [&](const StepRule& known) {
        return known.stage->text == rule.stage->text;
      };
      if (std::none_of(steps.begin(), steps.end(), same)) steps.push_back(rule);
    }
  }
  return steps;
}

bool CheckStages(ProcessRunner& processes) {
  const std::vector<StepRule> steps = StepsOfAllKinds();
  std::vector<std::vector<std::string>> questions;
  for (const StepRule& rule : steps)
    questions.push_back(
        {(ProgramFolder() / ("keypose-" + rule.stage->text)).string(), "--describe"});
  const auto answers = processes.Ask(questions);
  bool well = true;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    std::string verdict;
    try {
      if (answers[i].exit_code != 0)
        throw ToolError(answers[i].exit_code == 127 ? "missing" : FirstLine(answers[i].error));
      const StageInfo info = ParseStageInfo(answers[i].output, questions[i][0]);
      verdict = "version " + info.version;
      for (const auto& [tool, version] : info.tools) {
        verdict += fmt::format(", {}: {}", tool, version);
        well = well && version != "missing";
      }
    } catch (const ToolError& error) {
      verdict = std::string("FAULT: ") + error.what();
      well = false;
    }
    fmt::print("stage {:<12} {}\n", steps[i].name, verdict);
  }
  return well;
}

}  // namespace

ExitCode VersionCommand() {
  RealProcessRunner processes;
  fmt::print("keypose {}\n", KEYPOSE_VERSION);
  fmt::print("COLMAP: {}\n", ColmapText(processes));
  fmt::print("OpenCV: {}\nCGAL: {}\nEigen: {}.{}.{}\n", CV_VERSION, CGAL_VERSION_STR,
             EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
  fmt::print("BLAS: {}\nCPU features: {}\n", BlasText(), CpuText());
  return ExitCode::kOk;
}

ExitCode DoctorCommand() {
  RealProcessRunner processes;
  VersionCommand();
  const bool stages_well = CheckStages(processes);
  const bool colmap_well = processes.FindTool("colmap").has_value();
  fmt::print("cameras: {}\n", CameraLibraryText());
  const auto space = fs::space(fs::current_path());
  fmt::print("free on this disk: {:.1f} GB\n", static_cast<double>(space.available) / 1e9);
  const bool well = stages_well && colmap_well;
  fmt::print("{}\n", well ? "all is well" : "something is missing: see above");
  return well ? ExitCode::kOk : ExitCode::kTool;
}

}  // namespace keypose::pipeline
