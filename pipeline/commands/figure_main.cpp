// The program `keypose figure`. Its own, since it looks into pictures, and loading the libraries
// for that would slow down all other commands.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "pipeline/commands/figure_command.h"

namespace keypose::pipeline {
namespace {

constexpr const char* kExamples =
    "\nX and Y are pixels of the picture as a viewer shows it, from its upper left corner: to the "
    "right and down.\nWithout --at, --not and --clear it prints what is said so far. What is said "
    "stands in pipeline.yaml.\n\n"
    "  keypose figure --pose rest --at IMG_0012.jpg:512,300\n"
    "  keypose figure --pose rest --at IMG_0012.jpg:512,300-530,340 --not IMG_0012.jpg:60,900\n"
    "  keypose figure --shot walk --at cam2/114:640,200\n";

void AddFlags(CLI::App& app, FigureOptions& options) {
  app.add_option("--pose", options.pose, "the pose; default: the only one");
  app.add_option("--shot", options.shot, "of a performance: the shot");
  app.add_option("--at", options.at,
                 "PHOTO:X,Y or a line PHOTO:X,Y-X,Y-...: this is the figure; of a film "
                 "CAMERA/FRAME:X,Y, with frames counted from 0")
      ->allow_extra_args(false);
  app.add_option("--not", options.not_at, "the same: what lies there is not the figure")
      ->allow_extra_args(false);
  app.add_flag("--clear", options.clear, "first take back all that was said before");
  app.add_option("-C,--folder", options.folder,
                 "the project's folder; default: the current folder or the nearest parent with a "
                 "pipeline.yaml");
  app.footer(kExamples);
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Says what the figure is, where the photographs cannot tell: a click or a stroke in one "
      "picture.",
      "keypose figure");
  FigureOptions options;
  AddFlags(app, options);
  try {
    app.parse(argc, argv);
    return static_cast<int>(FigureCommand(options));
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return 0;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "keypose: error: {}; see `keypose figure --help`\n", error.what());
    return static_cast<int>(ExitCode::kUsage);
  } catch (const Error& error) {
    std::fflush(stdout);
    fmt::print(stderr, "keypose: error: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "keypose: a bug: {}\nplease report it, with your command\n", error.what());
    return static_cast<int>(ExitCode::kBug);
  }
}

}  // namespace
}  // namespace keypose::pipeline

int main(int argc, char** argv) { return keypose::pipeline::Main(argc, argv); }
